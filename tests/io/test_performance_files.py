"""Performances that are no text: arrays of NumPy, and clips of glTF files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io.takes import write_take

TIMES = np.arange(7) / 30
WEIGHTS = np.stack([np.linspace(0, 1, 7), np.linspace(0.5, 0, 7)], axis=1)


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_arrays(tmp_path: Path, save: object) -> None:
    path = tmp_path / "take.npz"
    assert callable(save)
    save(path, names=["jawOpen", "smile"], times=TIMES, weights=WEIGHTS)
    take = em.read_performance(path)
    assert (take.names, take.rate, take.source) == (("jawOpen", "smile"), 30, str(path))
    np.testing.assert_array_equal(take.times, TIMES)
    np.testing.assert_array_equal(take.weights, WEIGHTS)
    save(path, names=["a", "b"], times=TIMES, weights=WEIGHTS.astype("f4"), rate=29.97)
    assert em.read_performance(path).rate == 29.97


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"names": ["a"], "times": TIMES}, "no array 'weights': a performance has names"),
        ({"names": ["a"], "times": TIMES, "weights": WEIGHTS}, "has the shape"),
        ({"names": [1], "times": TIMES, "weights": WEIGHTS}, "has the type"),
        ({"names": ["a", "a"], "times": TIMES, "weights": WEIGHTS}, "'a' is there twice"),
        ({"names": ["a", "b"], "times": -TIMES, "weights": WEIGHTS}, "times must rise"),
        ({"names": ["a", "b"], "times": TIMES, "weights": WEIGHTS * np.nan}, "finite"),
        ({"names": ["a", "b"], "times": [], "weights": np.zeros((0, 2))}, "T ≥ 1"),
    ],
)
def test_arrays_that_are_none(tmp_path: Path, arrays: dict[str, object], message: str) -> None:
    path = tmp_path / "take.npz"
    np.savez(path, **arrays)  # type: ignore[arg-type]
    with pytest.raises(em.FormatError, match=message):
        em.read_performance(path)


def test_what_is_written_comes_back(tmp_path: Path) -> None:
    take = em.Performance(["jawOpen", "smile"], TIMES, WEIGHTS, 29.5)
    for name in ("take.npz", "take.csv"):
        em.write_performance(tmp_path / name, take)
        found = em.read_performance(tmp_path / name)
        assert found.names == take.names
        np.testing.assert_array_equal(found.times, TIMES)
        np.testing.assert_array_equal(found.weights, WEIGHTS)
        assert found.rate == (29.5 if name == "take.npz" else 30)
    with pytest.raises(em.FormatError, match=r"into \.csv or \.npz, found \.glb"):
        em.write_performance(tmp_path / "take.glb", take)


def test_a_clip_of_a_rig_file(tmp_path: Path) -> None:
    """What `animate` wrote is a take again, of the sliders that it moves."""
    neutral = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    raised = [neutral.with_vertices(neutral.vertices + [0, 0, h]) for h in (1, 2, 3)]
    rig = em.Rig(neutral, dict(zip(("jawOpen", "smile", "still"), raised, strict=True)))
    path = tmp_path / "take.glb"
    write_take(path, rig, em.Performance(["jawOpen", "smile"], TIMES, WEIGHTS, 30, source="walk"))
    take = em.read_performance(path)
    assert (take.names, take.rate) == (("jawOpen", "smile"), 30)
    np.testing.assert_allclose(take.at(TIMES), WEIGHTS, atol=1e-6)
    assert em.read_performance(path, clip="walk").names == take.names
    with pytest.raises(em.ParameterError, match="no clip 'run'; it has walk"):
        em.read_performance(path, clip="run")
    em.write(tmp_path / "rig.glb", rig, clips=True)
    with pytest.raises(em.ParameterError, match="3 clips, say which one is meant: jawOpen, smile"):
        em.read_performance(tmp_path / "rig.glb")
    assert em.read_performance(tmp_path / "rig.glb", clip="smile").names == ("smile",)


def test_a_take_among_the_clips_of_sliders(tmp_path: Path) -> None:
    """As the page saves it: a clip a slider, which plays it alone, and the take."""
    neutral = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    raised = [neutral.with_vertices(neutral.vertices + [0, 0, h]) for h in (1, 2)]
    rig = em.Rig(neutral, dict(zip(("jawOpen", "smile"), raised, strict=True)))
    alone = [
        (TIMES, np.outer(np.linspace(0, 1, 7), row), n)
        for n, row in zip(rig.names, np.eye(2), strict=True)
    ]
    walk, run = (TIMES, WEIGHTS, "walk"), (TIMES, WEIGHTS / 2, "run")
    path = tmp_path / "saved.glb"
    em.write(path, rig, animation=[*alone, walk])
    np.testing.assert_allclose(em.read_performance(path).weights, WEIGHTS, atol=1e-6)
    em.write(path, rig, animation=[*alone, walk, run])
    with pytest.warns(em.ElastomorphWarning, match="run"):
        found = em.read_performance(path)
    np.testing.assert_allclose(found.weights, WEIGHTS, atol=1e-6)
    for named in (path.with_name("run.glb"), path):
        em.write(named, rig, animation=[*alone, walk, run])
    found = em.read_performance(tmp_path / "run.glb")
    np.testing.assert_allclose(found.weights, WEIGHTS / 2, atol=1e-6)
    for name, expected in (("walk", WEIGHTS), ("run", WEIGHTS / 2)):
        found = em.read_performance(f"{path}#{name}")
        np.testing.assert_allclose(found.weights, expected, atol=1e-6)
    assert em.read_performance(f"{path}#smile").names == ("smile",)
    with pytest.raises(em.ParameterError):
        em.read_performance(f"{path}#hop")
    (tmp_path / "a#b.glb").write_bytes(path.read_bytes())
    assert em.read_performance(tmp_path / "a#b.glb", clip="run").names == ("jawOpen", "smile")
