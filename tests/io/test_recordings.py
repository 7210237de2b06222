"""One door for what was recorded: whatever the file, the same frames at the same times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io.sequences import read_markers, read_recording, write_mdd, write_pc2
from foreign_files import chunks_of, glb
from small_meshes import grid

SECONDS = np.array([0.0, 0.1, 0.125, 0.225])  # keys at most a thirtieth apart, and farther


@pytest.fixture(scope="module")
def rig() -> em.Rig:
    """A grid with a bent path and a straight one."""
    neutral = grid(4, 3)
    way, bend = np.sin(neutral.vertices), np.cos(neutral.vertices[:, [1, 2, 0]])
    bent = em.through(
        neutral,
        neutral.with_vertices(neutral.vertices + way),
        {0.5: neutral.with_vertices(neutral.vertices + way / 2 + 0.2 * bend)},
    )
    straight = em.interpolate(
        neutral, neutral.with_vertices(neutral.vertices + bend), method="linear"
    )
    return em.Rig(neutral, {"open": bent, "wide": straight})


@pytest.fixture(scope="module")
def animated(rig: em.Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    weights = np.array([[0, 0], [0.4, 0.1], [0.4, 0.2], [1, 0.3]])
    path = tmp_path_factory.mktemp("animated") / "take.glb"
    em.write(path, rig, animation=(SECONDS, weights, "take"))
    return path


def test_an_animation_is_sampled_as_the_rig_plays_it(rig: em.Rig, animated: Path) -> None:
    """At its keys, and three times between keys a tenth of a second apart."""
    motion = em.read_sequence(animated, clip="take")
    seconds = np.concatenate([[0, 1 / 30, 2 / 30], [0.1], 0.125 + np.array([0, 1, 2, 3]) / 30])
    np.testing.assert_allclose(motion.times, seconds / 0.225, atol=1e-6)
    weights = np.stack(
        [np.interp(seconds, SECONDS, own) for own in ([0, 0.4, 0.4, 1], [0, 0.1, 0.2, 0.3])], 1
    )
    np.testing.assert_allclose(motion.frames, rig.batch(weights, dtype=np.float64), atol=1e-5)
    assert len(motion.mesh.faces) == len(rig.neutral.faces)


def test_the_path_of_an_animation_is_learned(animated: Path) -> None:
    assert em.learn(animated, 2).gain > 3


def test_which_animation_is_meant_must_be_said(rig: em.Rig, tmp_path: Path) -> None:
    """A rig that is exported with clips has one for each slider."""
    em.write(tmp_path / "rig.glb", rig, clips=True)
    with pytest.raises(em.ParameterError, match="2 clips, say which one is meant: open, wide"):
        em.read_sequence(tmp_path / "rig.glb")
    with pytest.raises(em.ParameterError, match="no clip 'smile'; it has open, wide"):
        em.read_sequence(tmp_path / "rig.glb", clip="smile")
    with pytest.raises(em.ParameterError, match="no clip 'smile'"):
        em.read_sequence(f"{tmp_path / 'rig.glb'}#smile")
    found = em.read_sequence(tmp_path / "rig.glb", clip="open")
    same = em.read_sequence(f"{tmp_path / 'rig.glb'}#open")
    np.testing.assert_array_equal(same.frames, found.frames)
    np.testing.assert_allclose(found.frames[-1], rig.pose({"open": 1.0}), atol=1e-5)
    with pytest.raises(em.ParameterError, match=r"only \.glb, \.gltf, \.vrm have animations"):
        em.read_sequence(tmp_path / "take.npz", clip="open")


def test_a_recording_is_the_take_that_a_performance_is(animated: Path, tmp_path: Path) -> None:
    """The one named like the file, or the first that is not named like a slider."""
    document, content = chunks_of(animated)
    (take,) = document["animations"]
    other = {**take, "samplers": [{**own, "interpolation": "STEP"} for own in take["samplers"]]}
    path = tmp_path / "second.glb"
    expected = em.read_sequence(animated)
    for names in (["open", "first", "second"], ["open", "take"]):
        others = [other | {"name": name} for name in names[:-1]]
        document["animations"] = [*others, take | {"name": names[-1]}]
        path.write_bytes(glb(document, content))
        np.testing.assert_array_equal(em.read_sequence(path).frames, expected.frames)
        assert len(em.read_performance(path)) == len(SECONDS)
        stepped = em.read_sequence(f"{path}#{names[0]}")
        assert np.abs(em.read_sequence(path, clip=names[0]).frames - stepped.frames).max() == 0
        assert len(stepped.frames) > len(expected.frames)
        assert read_markers(f"{path}#{names[0]}").frames.shape == stepped.frames.shape


def test_what_does_not_move_is_no_recording(rig: em.Rig, tmp_path: Path) -> None:
    em.write(tmp_path / "still.glb", em.Rig(rig.neutral, {}))
    with pytest.raises(em.FormatError, match="no animation in it moves morph targets"):
        em.read_sequence(tmp_path / "still.glb")
    (tmp_path / "take.fbx").write_bytes(b"")
    with pytest.raises(em.FormatError, match=r"animations in \.fbx are not read; write the motion"):
        em.read_sequence(tmp_path / "take.fbx")


@pytest.mark.parametrize(("suffix", "write"), [(".mdd", write_mdd), (".pc2", write_pc2)])
def test_a_point_cache_moves_the_mesh_beside_it(
    suffix: str, write: object, rig: em.Rig, tmp_path: Path
) -> None:
    path = tmp_path / f"take{suffix}"
    frames = rig.batch(np.array([[0, 0], [0.5, 0], [1, 0.5]]))
    write(path, frames)  # type: ignore[operator]
    with pytest.raises(em.FileError, match=r"one of take\.obj, take\.ply, take\.npz \(found none"):
        em.read_sequence(path)
    em.write(tmp_path / "take.obj", rig.neutral)
    motion = em.read_sequence(path)
    np.testing.assert_array_equal(motion.frames, frames)
    np.testing.assert_allclose(motion.times, [0, 0.5, 1], atol=1e-6)
    assert len(motion.mesh.faces) == len(rig.neutral.faces)
    em.write(tmp_path / "take.obj", grid(3, 3))
    with pytest.raises(em.FormatError, match=r"it moves 12 points, but take\.obj has 9 vertices"):
        em.read_sequence(path)


NAMES = np.array(["chin", "lip", "brow", "nose"])


def gappy() -> np.ndarray:
    """Markers that go even ways, one missing between, one at the start, and one always."""
    frames = np.linspace(0, 1, 6)[:, None, None] * [[1, 0, 0], [0, 2, 0], [0, 0, 3], [1, 1, 1]]
    frames = frames + np.arange(12).reshape(4, 3)
    frames[2:4, 0] = np.nan
    frames[0, 1, 2] = np.nan
    frames[:, 3] = np.nan
    return frames


def test_gaps_are_closed_and_known(tmp_path: Path) -> None:
    """On the line between what is seen, held before it; who is never seen is left out."""
    path = tmp_path / "take.npz"
    np.savez(path, names=NAMES, markers=gappy())
    with pytest.warns(em.ElastomorphWarning, match="never seen, and left out: nose"):
        found = read_recording(path)
    assert found.names == ("chin", "lip", "brow")
    assert found.seen is not None
    assert np.argwhere(~found.seen).tolist() == [[0, 1], [2, 0], [3, 0]]
    ways = np.linspace(0, 1, 6)
    np.testing.assert_allclose(found.motion.frames[:, 0, 0], ways)
    np.testing.assert_array_equal(found.motion.frames[0, 1], found.motion.frames[1, 1])
    with (
        pytest.warns(em.ElastomorphWarning, match="never seen"),
        pytest.raises(em.FormatError, match=r"marker lip is missing in frame 0, and 16\.7% of all"),
    ):
        em.read_sequence(path)


def test_times_of_markers_are_theirs(tmp_path: Path) -> None:
    times = np.array([3.0, 4, 5, 6, 8, 13]) / 30  # seconds
    frames = np.random.default_rng(1).normal(size=(6, 4, 3))
    frames[4, 1] = np.nan
    np.savez(tmp_path / "take.npz", names=NAMES, markers=frames, times=times)
    found = read_recording(tmp_path / "take.npz").motion
    np.testing.assert_allclose(found.times, [0, 0.1, 0.2, 0.3, 0.5, 1])
    share = 2 / 7  # from 6 to 8 thirtieths on the way to 13
    between = frames[3, 1] + share * (frames[5, 1] - frames[3, 1])
    np.testing.assert_allclose(found.frames[4, 1], between)
