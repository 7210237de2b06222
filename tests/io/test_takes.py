"""Takes as files: what is read back is the rig, posed frame by frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io import takes
from elastomorph.io.npz.mesh import write_npz_take
from elastomorph.io.sequences import read_mdd, read_pc2
from elastomorph.io.takes import holds_positions, write_take
from elastomorph.model.bend_curve import BendCurve
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance, slider_weights
from foreign_files import chunks_of
from needs import extra


def rig() -> Rig:
    neutral = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    bent = neutral.with_vertices(neutral.vertices + [0, 0, 1.0])
    wide = neutral.with_vertices(neutral.vertices * 2)
    return Rig(
        neutral,
        {
            "jawOpen": em.interpolate(neutral, bent, "ease:2"),
            "jawLeft": em.interpolate(neutral, wide, "linear"),
        },
    )


def take(count: int = 5) -> Performance:
    weights = np.linspace(0, 1, 2 * count).reshape(count, 2)
    return Performance(
        ["JawLeft", "JawOpen"], 3 + np.arange(count) / 25, weights, 25, source="in/rom.csv"
    )


def by_hand(performance: Performance) -> np.ndarray:
    return np.stack(
        [rig().pose({"jawLeft": left, "jawOpen": down}) for left, down in performance.weights]
    )


@pytest.mark.parametrize("name", ["frame.####.obj", "frame.##.ply"])
def test_numbered_files(tmp_path: Path, name: str) -> None:
    write_take(tmp_path / name, rig(), take())
    assert len(list(tmp_path.iterdir())) == 5
    found = em.read_sequence(tmp_path / name)
    np.testing.assert_allclose(found.frames, by_hand(take()), atol=1e-12)
    assert (tmp_path / name.replace("####", "0001").replace("##", "01")).is_file()


def test_a_folder_is_made_and_filled(tmp_path: Path) -> None:
    write_take(f"{tmp_path}/new/", rig(), take())
    assert sorted(file.name for file in (tmp_path / "new").iterdir()) == [
        f"frame.000{i}.obj" for i in range(1, 6)
    ]
    write_take(tmp_path / "new", rig(), take())  # the same take again replaces itself
    with pytest.raises(FileError, match=r"frame\.0003\.obj is already there.*3 such files"):
        write_take(tmp_path / "new", rig(), take(2))
    with pytest.raises(FileError, match="cannot be made"):
        write_take(f"{tmp_path}/none/new/", rig(), take())
    with pytest.raises(FileError, match="does not exist"):
        write_take(tmp_path / "none" / "x.#.obj", rig(), take())


def test_numpy_archive(tmp_path: Path) -> None:
    """Read as a sequence it is the take, read as a mesh the neutral."""
    write_take(tmp_path / "take.npz", rig(), take())
    found = em.read_sequence(tmp_path / "take.npz")
    np.testing.assert_allclose(found.frames, by_hand(take()), atol=1e-6)
    np.testing.assert_allclose(found.times, np.linspace(0, 1, 5), atol=1e-12)
    assert em.read(tmp_path / "take.npz").vertices.tolist() == rig().neutral.vertices.tolist()
    with np.load(tmp_path / "take.npz") as archive:
        np.testing.assert_allclose(archive["times"], np.arange(5) / 25, atol=1e-12)


def test_an_archive_is_the_same_whenever_it_is_written(tmp_path: Path) -> None:
    write_take(tmp_path / "a.npz", rig(), take())
    write_take(tmp_path / "b.npz", rig(), take())
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_what_fails_leaves_the_old_file(tmp_path: Path) -> None:
    """An archive with too few frames, and a take that is interrupted."""
    path = tmp_path / "take.npz"
    path.write_bytes(b"old")
    mesh = rig().neutral
    for frames in ([mesh.vertices], [mesh.vertices] * 3, [mesh.vertices[:1]] * 2):
        with pytest.raises(ParameterError):
            write_npz_take(path, mesh, frames, [0.0, 1.0])

    def interrupted(frames: Iterator[Any]) -> Iterable[Any]:
        yield next(frames)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_take(path, rig(), take(), watch=interrupted)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(KeyboardInterrupt):
        write_take(tmp_path / "f.#.obj", rig(), take(), watch=interrupted)
    assert em.read(tmp_path / "f.1.obj").vertices.tolist() == by_hand(take())[0].tolist()


def test_memory_holds_no_take(tmp_path: Path) -> None:
    """Frames are asked for one after another, each written before the next."""
    mesh, asked = rig().neutral, []

    def frames() -> Iterator[np.ndarray]:
        buffer = np.empty_like(mesh.vertices)
        for i in range(3):
            asked.append(i)
            buffer[:] = i
            yield buffer
            buffer[:] = np.nan

    write_npz_take(tmp_path / "x.npz", mesh, frames(), [0, 1, 2])
    assert asked == [0, 1, 2]
    assert em.read_sequence(tmp_path / "x.npz").frames[:, 0, 0].tolist() == [0, 1, 2]


def test_point_caches(tmp_path: Path) -> None:
    """MDD knows seconds; PC2 counts frames, one sample each."""
    write_take(tmp_path / "take.mdd", rig(), take())
    write_take(tmp_path / "take.pc2", rig(), take())
    mdd, pc2 = read_mdd(tmp_path / "take.mdd"), read_pc2(tmp_path / "take.pc2")
    for cache in (mdd, pc2):
        np.testing.assert_allclose(cache.frames, by_hand(take()), atol=1e-6)
    np.testing.assert_allclose(mdd.times, np.arange(5) / 25, atol=1e-6)
    np.testing.assert_allclose(pc2.times, np.arange(5), atol=1e-6)


@pytest.mark.parametrize("suffix", ["glb", "usd", "usda", "usdc"])
def test_animated_rigs_get_the_weights(
    tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Times from 0, a column a slider in the order of the rig, and the name of the take."""
    seen: dict[str, Any] = {}

    def writer(path: Path, rig: Rig, *, animation: tuple[Any, Any, str], **more: Any) -> None:
        seen.update(path=path, rig=rig, animation=animation, **more)

    monkeypatch.setattr(takes, "write", writer)
    write_take(tmp_path / f"take.{suffix}", rig(), take(), clip=True)
    times, weights, title = seen["animation"]
    np.testing.assert_allclose(times, np.arange(5) / 25, atol=1e-12)
    np.testing.assert_array_equal(weights, slider_weights(rig(), take()))
    assert weights[2].tolist() == take().weights[2, ::-1].tolist()
    assert title == "rom"
    if suffix != "glb":
        assert seen["fps"] == 25


def test_which_files_hold_positions(tmp_path: Path) -> None:
    for name in ("x.npz", "x.mdd", "X.PC2", "x.#.obj", "x.####.ply", "folder/"):
        assert holds_positions(name)
    assert holds_positions(tmp_path)
    assert not holds_positions("x.GLB")
    for name in ("x", "x.obj", "x.mp4", "x.#.glb", "x.gltf", "x.#.xyz"):
        with pytest.raises(FormatError, match="a take goes into"):
            holds_positions(name)


def test_a_glb_plays_the_take(tmp_path: Path) -> None:
    """Read without any library: keys at the times, Δ by the weight w, a bend (turned) by w - w².

    A bend that is Δ itself is no target of its own: Δ plays by w².
    """
    morphs = rig().morphs
    parabola = BendCurve.polynomial([0.0, -1.0, 1.0])
    straight = morphs["jawLeft"]
    bent = em.Morph(straight.neutral, straight.target, np.ones((1, 3, 3)), (parabola,))
    own = Rig(straight.neutral, {"jawOpen": morphs["jawOpen"], "jawLeft": bent})
    write_take(tmp_path / "take.glb", own, take())
    document, blob = chunks_of(tmp_path / "take.glb")
    animation = next(own for own in document["animations"] if own["name"] == "rom")
    sampler = animation["samplers"][animation["channels"][0]["sampler"]]
    assert animation["channels"][0]["target"]["path"] == "weights"
    times, weights = (_numbers_in(document, blob, sampler[k]) for k in ("input", "output"))
    np.testing.assert_allclose(times, np.arange(5) / 25, atol=1e-6)
    left, down = take().weights.T
    expected = [down**2, left, left - left**2]
    for column in expected:
        gaps = np.abs(weights.reshape(5, -1) - column[:, None]).max(axis=0)
        assert gaps.min() < 1e-6
    assert weights.size == 5 * len(expected)


def _numbers_in(document: dict[str, Any], blob: bytes, index: int) -> np.ndarray:
    """The numbers of an accessor of float scalars."""
    accessor = document["accessors"][index]
    assert (accessor["componentType"], accessor["type"]) == (5126, "SCALAR")
    start = document["bufferViews"][accessor["bufferView"]]["byteOffset"] + accessor["byteOffset"]
    return np.frombuffer(blob, "<f4", accessor["count"], start)


def test_a_usd_file_plays_the_take(tmp_path: Path) -> None:
    """By USD itself: at 25 time codes a second, one key a frame from 0."""
    usd = extra("pxr.Usd", "usd")
    skel = extra("pxr.UsdSkel", "usd")
    write_take(tmp_path / "take.usda", rig(), take())
    stage = usd.Stage.Open(str(tmp_path / "take.usda"))
    assert stage.GetTimeCodesPerSecond() == 25
    prim = next(own for own in stage.Traverse() if own.IsA(skel.Animation))
    animation = skel.Animation(prim)
    names = list(animation.GetBlendShapesAttr().Get())
    keys = animation.GetBlendShapeWeightsAttr()
    np.testing.assert_allclose(keys.GetTimeSamples(), np.arange(5), atol=1e-9)
    found = np.array([keys.Get(code) for code in keys.GetTimeSamples()])
    order = [names.index(name) for name in ("jawLeft", "jawOpen")]
    np.testing.assert_allclose(found[:, order], take().weights, atol=1e-6)
