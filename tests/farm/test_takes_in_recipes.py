"""Recorded takes as a mixture: every face is a moment of one, or lies between two."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from farm_rigs import RIG, column
from scipy import stats

import elastomorph as em
from elastomorph.io.performance import read_performance, write_performance_csv
from elastomorph.rig.performance import Performance, slider_weights

TIMES = np.array([0.0, 0.1, 0.4, 1.0])
"""Uneven, so that what counts is time and not frames."""


def write_take(path: Path, jaw: list[float], blink: list[float]) -> Performance:
    """A take of two weights in other spellings than those of the rig."""
    take = Performance(("JawOpen", "eyeBlink_L"), TIMES, np.stack([jaw, blink], axis=1), 30)
    write_performance_csv(path, take)
    return take


@pytest.fixture
def take(tmp_path: Path) -> Performance:
    return write_take(tmp_path / "one.csv", [0, 0.2, 0.9, 0.1], [1, 0, 0.5, 1])


def recipe_in(folder: Path, **keys: object) -> Path:
    lines = [f"{name} = {value}" for name, value in keys.items()]
    file = folder / "recipe.toml"
    file.write_text("\n".join(["[[mixture]]", 'kind = "take"', *lines]), encoding="utf-8")
    return file


def test_a_face_is_a_moment_of_the_take(tmp_path: Path, take: Performance) -> None:
    sampler = em.FaceSampler(RIG, recipe_in(tmp_path, files='["one.csv"]'), seed=3)
    values = sampler.values(0, 20_000)
    own = values[:, [column("jawOpen"), column("eyeBlinkLeft")]]
    assert np.delete(values, [column("jawOpen"), column("eyeBlinkLeft")], axis=1).max() == 0
    # The moment of each face is where the take, finely cut, is nearest to it.
    fine = np.linspace(0, 1, 20_001)
    path = np.stack([np.interp(fine, TIMES, weights) for weights in take.weights.T], axis=1)
    found = np.array([np.abs(path - face).sum(axis=1).argmin() for face in own[:300]])
    assert np.abs(path[found] - own[:300]).max() < 3e-4
    assert stats.kstest(found / 20_000, "uniform").pvalue > 1e-3


def test_takes_are_as_likely_as_they_are_long(tmp_path: Path, take: Performance) -> None:
    write_take(tmp_path / "two.csv", [1, 1, 1, 1], [0, 0, 0, 0])
    sampler = em.FaceSampler(RIG, recipe_in(tmp_path, files='["*.csv"]'), seed=3)
    jaw = sampler.values(0, 20_000)[:, column("jawOpen")]
    assert (jaw == 1).mean() == pytest.approx(0.5, abs=4.5 * np.sqrt(0.25 / 20_000))
    # None lies between the end of one take and the beginning of the next.
    assert not ((jaw > 0.9 + 1e-4) & (jaw < 1)).any()


def test_faces_between_two_takes(tmp_path: Path) -> None:
    write_take(tmp_path / "one.csv", [1] * 4, [0] * 4)
    write_take(tmp_path / "two.csv", [0] * 4, [1] * 4)
    file = recipe_in(tmp_path, files='["one.csv", "two.csv"]', mixed=0.6)
    own = em.FaceSampler(RIG, file, seed=8).values(0, 20_000)
    own = own[:, [column("jawOpen"), column("eyeBlinkLeft")]]
    assert own.sum(axis=1) == pytest.approx(1, abs=2 / 65535)
    between = (own[:, 0] > 0) & (own[:, 0] < 1)
    # Half of those that mix two moments mix two of the same take.
    assert between.mean() == pytest.approx(0.3, abs=0.02)
    assert stats.kstest(own[between, 0], "uniform").pvalue > 1e-3


def test_faces_are_made_again_without_the_files(tmp_path: Path, take: Performance) -> None:
    file = recipe_in(tmp_path, files='["one.csv"]', sliders='["jaw*", "eye*"]')
    sampler = em.FaceSampler(RIG, file, seed=9)
    assert {name: own.shape[0] for name, own in sampler.tables.items()} == {
        "mixture-0-clock": 4,
        "mixture-0-frames": 4,
    }
    (tmp_path / "one.csv").unlink()
    again = em.FaceSampler.restored(RIG, sampler.recipe.text(), sampler.tables)
    assert (again.codes(3, 2000) == sampler.codes(3, 2000)).all()
    for damaged in ({}, {**sampler.tables, "mixture-0-clock": np.zeros(4)}):
        with pytest.raises(em.ParameterError, match="takes kept with the faces are damaged"):
            em.FaceSampler.restored(RIG, sampler.recipe.text(), damaged)


def test_takes_in_archives_and_animations(tmp_path: Path, take: Performance) -> None:
    np.savez(tmp_path / "one.npz", names=list(take.names), times=TIMES, weights=take.weights)
    weights = slider_weights(RIG, take)
    em.write(tmp_path / "one.glb", RIG, animation=(TIMES, weights, "one"), keys_tolerance=1e-9)
    csv = em.FaceSampler(RIG, recipe_in(tmp_path, files='["one.csv"]'))
    for name in ("one.npz", "one.glb"):
        same = em.FaceSampler(RIG, recipe_in(tmp_path, files=f'["{name}"]'))
        assert same.values(0, 500) == pytest.approx(csv.values(0, 500), abs=2e-5)


@pytest.mark.realdata
def test_a_recorded_take(data_dir: Path) -> None:
    """Within the range of the recording, frame by frame."""
    source = data_dir / "livelink" / "rom_3.csv"
    sampler = em.FaceSampler(RIG, {"mixture": [{"kind": "take", "files": [str(source)]}]})
    values = sampler.values(0, 5000)
    frames = np.clip(slider_weights(RIG, read_performance(source)), 0, 1)
    assert (values.max(axis=0) <= frames.max(axis=0) + 1e-5).all()
    assert values.mean(axis=0) == pytest.approx(frames.mean(axis=0), abs=0.03)
