"""NumPy archives give meshes and motion back complete, and never run or unpack what is harmful."""

from __future__ import annotations

import io
import pickle
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_samples import assert_same_mesh, house, meshes, same_bits

from elastomorph.errors import FormatError
from elastomorph.io.npz import read_npz, read_npz_sequence, write_npz, write_npz_sequence
from elastomorph.io.sequences import holds_markers, read_marker_file, read_recording
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence


def motion() -> MeshSequence:
    frames = [house().vertices * (1 + i) for i in range(3)]
    return MeshSequence(house(), frames, [0, 0.3, 1], ["a", "ß", "c"], ["b"])


def arrays_of(path: Path) -> dict[str, Any]:
    with np.load(path, allow_pickle=False) as archive:
        return dict(archive)


@given(mesh=meshes(), count=st.integers(2, 4), seed=st.integers(0, 99))
@settings(max_examples=60, deadline=None)
def test_motion_is_read_back_complete(
    tmp_path_factory: pytest.TempPathFactory, mesh: Mesh, count: int, seed: int
) -> None:
    path = tmp_path_factory.getbasetemp() / "motion.npz"
    random = np.random.default_rng(seed)
    frames = random.normal(size=(count, *mesh.vertices.shape))
    times = np.concatenate([[0], np.cumsum(random.uniform(0.1, 1, size=count - 1))])
    before = MeshSequence(mesh, frames, times, [f"frame {i}" for i in range(count)], ["x", "yy"])
    write_npz_sequence(path, before)
    after = read_npz_sequence(path)
    assert_same_mesh(after.mesh, before.mesh)
    assert same_bits(after.frames, before.frames)
    assert same_bits(after.times, before.times)
    assert after.names == before.names
    assert after.missing == before.missing


def test_numpy_itself_reads_the_arrays(tmp_path: Path) -> None:
    write_npz(tmp_path / "a.npz", house())
    arrays = arrays_of(tmp_path / "a.npz")
    assert same_bits(arrays["vertices"], house().vertices)
    assert arrays["face_offsets"].tolist() == [0, 4, 7]
    assert arrays["material_names"].tolist() == ["wall", "roof"]


def test_archives_that_numpy_wrote_are_read(tmp_path: Path) -> None:
    """Compressed or not, of any number type and byte order; polygons and names may be missing."""
    points = np.arange(12).reshape(4, 3)
    for save in (np.savez, np.savez_compressed):
        for kind in ("<f4", ">f8", "i2", "<u8"):
            save(tmp_path / "a.npz", vertices=points.astype(kind))
            assert read_npz(tmp_path / "a.npz").vertices.tolist() == points.tolist()
        save(tmp_path / "b.npz", frames=np.asfortranarray([points, points + 1]), other=1)
        sequence = read_npz_sequence(tmp_path / "b.npz")
        assert sequence.frames.tolist() == [points.tolist(), (points + 1).tolist()]
        assert sequence.names == ("0", "1")


def test_a_mesh_and_a_motion_are_told_apart(tmp_path: Path) -> None:
    write_npz(tmp_path / "mesh.npz", house())
    write_npz_sequence(tmp_path / "motion.npz", motion())
    with pytest.raises(FormatError, match="name it where a recording"):
        read_npz(tmp_path / "motion.npz")
    with pytest.raises(FormatError, match="name it as a mesh"):
        read_npz_sequence(tmp_path / "mesh.npz")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("vertices", None, "no array 'vertices'; found face_indices"),
        ("vertices", np.zeros((5, 2)), r"shape \(5, 2\), expected \(any, 3\)"),
        ("vertices", np.zeros(3), r"shape \(3,\)"),
        ("vertices", np.zeros((0, 3)), "V ≥ 1|expected 0 to -1"),
        ("vertices", np.full((5, 3), np.nan), "vertex 0 has the coordinates"),
        ("vertices", np.zeros((5, 3), dtype=complex), "type complex128"),
        ("vertices", np.zeros((5, 3), dtype="S1"), "type |S1"),
        ("face_indices", np.array([0, 1, 2, 3, 3, 2, 5]), "from 0 to 5, expected 0 to 4"),
        ("face_indices", np.array([0, 1, 2, 3, 3, 2, -1]), "from -1 to 3"),
        ("face_indices", np.array([0, 1, 2, 3, 3, 2, 2**32], dtype=np.uint64), "expected 0 to 4"),
        ("face_indices", np.zeros(7), "type float64"),
        ("face_indices", None, "no array 'face_indices'"),
        ("face_offsets", np.array([0, 4, 6]), "offsets must start at 0"),
        ("face_offsets", np.array([0, 5, 7]), "polygon 1 has 2 vertices"),
        ("face_offsets", np.array([0, 7, 4, 7]), "polygon 1 has -3 vertices"),
        ("face_offsets", np.array([], dtype=int), "offsets must start at 0"),
        ("uv_corners", np.zeros(6, dtype=int), r"shape \(6,\), expected \(7,\)"),
        ("uv_corners", np.full(7, 4), "expected -1 to 3"),
        ("uv_coordinates", np.zeros((4, 4)), r"must be \(T, 2\) or \(T, 3\)"),
        ("uv_coordinates", np.full((4, 2), np.inf), "finite"),
        ("material_of_face", np.array([0, 2]), "expected -1 to 1"),
        ("material_of_face", np.array([0, 1, 0]), r"shape \(3,\), expected \(2,\)"),
        ("group_names", np.array([1, 2]), "type int64"),
        ("material_library", np.array(["a", "b"]), r"shape \(2,\), expected \(\)"),
    ],
)
def test_members_that_do_not_form_a_mesh_are_refused(
    tmp_path: Path, name: str, value: Any, words: str
) -> None:
    path = tmp_path / "house.npz"
    write_npz(path, house())
    arrays = arrays_of(path)
    arrays.pop(name)
    np.savez(path, **arrays, **({} if value is None else {name: value}))
    with pytest.raises(FormatError, match=words) as caught:
        read_npz(path)
    assert "house.npz" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("frames", np.zeros((1, 5, 3)), "at least 2 frames"),
        ("frames", np.zeros((0, 5, 3)), "at least 2 frames"),
        ("frames", np.zeros((2, 15)), r"expected \(any, any, 3\)"),
        ("frames", np.full((3, 5, 3), np.inf), "finite"),
        ("frames", np.zeros((3, 4, 3)), "expected 0 to 3"),
        ("times", np.array([0, 2, 1]), "times must be 3 finite numbers that rise"),
        ("times", np.array([0, 1]), r"shape \(2,\), expected \(3,\)"),
        ("names", np.array(["a"]), r"shape \(1,\), expected \(3,\)"),
        ("missing", np.array([1]), "type int64"),
    ],
)
def test_members_that_do_not_form_a_motion_are_refused(
    tmp_path: Path, name: str, value: Any, words: str
) -> None:
    path = tmp_path / "motion.npz"
    write_npz_sequence(path, motion())
    np.savez(path, **(arrays_of(path) | {name: value}))
    with pytest.raises(FormatError, match=words) as caught:
        read_npz_sequence(path)
    assert "motion.npz" in str(caught.value)


class Harmful:
    """Marks a file when it is unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.mark,)


def test_nothing_is_ever_unpickled(tmp_path: Path) -> None:
    mark = tmp_path / "it ran"
    harmful: Any = np.array([[Harmful(mark)] * 3] * 2, dtype=object)
    np.savez(tmp_path / "a.npz", allow_pickle=True, vertices=harmful)
    with pytest.raises(FormatError, match="type object"):
        read_npz(tmp_path / "a.npz")
    (tmp_path / "b.npz").write_bytes(pickle.dumps(Harmful(mark)))
    with pytest.raises(FormatError, match="not an intact archive"):
        read_npz(tmp_path / "b.npz")
    assert not mark.exists()


def archive_of(path: Path, name: str, chunks: Any) -> None:
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open(f"{name}.npy", "w", force_zip64=True) as member,
    ):
        for chunk in chunks:
            member.write(chunk)


def header_of(shape: tuple[int, ...], kind: str = "<f8") -> bytes:
    header = io.BytesIO()
    fields = {"descr": kind, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(header, fields)
    return header.getvalue()


def test_an_archive_that_unpacks_to_far_more_than_its_size_is_refused_at_once(
    tmp_path: Path,
) -> None:
    count = 128 * 2**20 // 24
    zeros = (bytes(24 * (count // 16)) for _ in range(16))
    archive_of(tmp_path / "bomb.npz", "vertices", [header_of((count // 16 * 16, 3)), *zeros])
    assert (tmp_path / "bomb.npz").stat().st_size < 200_000
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="would take more memory than"):
            read_npz(tmp_path / "bomb.npz")
        assert tracemalloc.get_traced_memory()[1] < 4 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "shape", [(10**15, 3), (2**62, 3), (10**30, 3), (-1, 3), (3, 3), (0, 3), (True, 3)]
)
def test_a_header_that_announces_another_size_is_refused_before_anything_is_allocated(
    tmp_path: Path, shape: tuple[int, ...]
) -> None:
    archive_of(tmp_path / "a.npz", "vertices", [header_of(shape), bytes(48)])
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match=r"shorter or longer|not an intact"):
            read_npz(tmp_path / "a.npz")
        assert tracemalloc.get_traced_memory()[1] < 4 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "content",
    [b"", b"PK", b"not an archive at all", b"\x93NUMPY\x01\x00", b"PK\x05\x06" + bytes(18)],
)
def test_files_that_are_no_archive_are_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.npz").write_bytes(content)
    for read in (read_npz, read_npz_sequence):
        with pytest.raises(FormatError, match=r"a\.npz: "):
            read(tmp_path / "a.npz")


@pytest.mark.parametrize("content", [b"", b"text", b"\x93NUMPY\x09\x00", header_of((2, 3))[:-20]])
def test_members_that_are_no_arrays_are_refused(tmp_path: Path, content: bytes) -> None:
    archive_of(tmp_path / "a.npz", "vertices", [content])
    with pytest.raises(FormatError, match="not an intact archive"):
        read_npz(tmp_path / "a.npz")


FRAMES = np.random.default_rng(0).normal(size=(5, 4, 3))
NAMES = np.array(["chin", "lip", "brow", "nose"])


@pytest.mark.parametrize("called", ["positions", "markers", "stab"])
def test_markers_and_their_names_are_read(called: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "take.npz", names=NAMES, **{called: FRAMES})
    assert holds_markers(tmp_path / "take.npz")
    take = read_recording(tmp_path / "take.npz")
    np.testing.assert_array_equal(take.motion.frames, FRAMES)
    assert take.names == tuple(NAMES)
    assert len(take.motion.mesh.faces) == 0


def test_other_archives_hold_no_markers(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", frames=FRAMES)
    assert not holds_markers(tmp_path / "other.npz")
    assert not holds_markers(tmp_path / "missing.npz")
    assert not holds_markers("scan.####.obj")
    with pytest.raises(FormatError, match="positions or markers or stab"):
        read_marker_file(tmp_path / "other.npz")


def test_names_of_markers_must_fit_and_numbers_be_finite(tmp_path: Path) -> None:
    np.savez(tmp_path / "few.npz", names=NAMES[:3], stab=FRAMES)
    with pytest.raises(FormatError, match="names"):
        read_recording(tmp_path / "few.npz")
    np.savez(tmp_path / "bad.npz", names=NAMES, stab=FRAMES * np.nan)
    with pytest.raises(FormatError, match="finite"):
        read_recording(tmp_path / "bad.npz")
