"""Archives made to harm are refused before they do, and the message names them."""

from __future__ import annotations

import io
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastomorph.errors import FormatError
from elastomorph.io.npz import read_npz, read_npz_sequence
from elastomorph.io.npz.members import open_npz
from elastomorph.io.npz.rig import read_rig_npz, write_rig_npz
from elastomorph.io.sequences import read_recording
from elastomorph.io.untrusted import allowed_memory
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

pytestmark = pytest.mark.hostile

TRIANGLE = np.eye(3)


def packed(path: Path, method: int = zipfile.ZIP_DEFLATED, **arrays: Any) -> Path:
    """An archive of arrays, or of raw members where bytes are given."""
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, array in arrays.items():
            if not isinstance(array, bytes):
                file = io.BytesIO()
                np.save(file, array)
                array = file.getvalue()
            archive.writestr(f"{name}.npy", array)
    return path


def member(descr: str, shape: tuple[int, ...], body: bytes = b"") -> bytes:
    """A member with a header of its own."""
    file = io.BytesIO()
    fields = {"descr": descr, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, fields)
    return file.getvalue() + body


def texts(*codes: int) -> bytes:
    """One text a character, whether the character exists or not."""
    return member("<U1", (len(codes),), np.array(codes, dtype="<u4").tobytes())


@pytest.mark.parametrize("code", [0xD800, 0xDFFF, 0x110000, 0xFFFFFFFF])
@pytest.mark.parametrize("order", ["<", ">"])
def test_characters_that_do_not_exist_are_refused(tmp_path: Path, code: int, order: str) -> None:
    """NumPy reads them; the first str made of them fails, or cannot be printed."""
    body = np.array([65, code], dtype=f"{order}u4").tobytes()
    path = packed(
        tmp_path / "a.npz", names=member(f"{order}U1", (2,), body), stab=np.zeros((2, 2, 3))
    )
    with pytest.raises(FormatError, match="'names' holds text with characters that do not exist"):
        read_recording(path)


def test_characters_of_any_plane_are_text(tmp_path: Path) -> None:
    path = packed(tmp_path / "a.npz", names=texts(0x10FFFF, 0xD7FF), stab=np.zeros((2, 2, 3)))
    assert read_recording(path).names == ("\U0010ffff", "\ud7ff")


def test_texts_of_no_characters_are_refused(tmp_path: Path) -> None:
    """They take no bytes in the file, and NumPy makes room for a billion of them."""
    path = packed(tmp_path / "a.npz", names=member("<U0", (10**9,)), stab=np.zeros((2, 4, 3)))
    with open_npz(path) as members, pytest.raises(FormatError, match="has the type <U0"):
        members.array("names", "U", (None,))


@pytest.mark.parametrize("number", ["1", "1e4000"])
def test_floats_of_more_than_64_bits_are_refused(tmp_path: Path, number: str) -> None:
    """They may be beyond what a float64 can hold."""
    wide = TRIANGLE.astype(np.longdouble) * np.longdouble(number)
    if wide.dtype.itemsize <= 8:
        pytest.skip("this machine has none")
    with pytest.raises(FormatError, match="'vertices' has the type"):
        read_npz(packed(tmp_path / "a.npz", vertices=wide))


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_members_packed_as_numpy_never_packs_are_refused(tmp_path: Path, method: int) -> None:
    """Python unpacks these without bounds: four kilobytes may become a hundred megabytes."""
    bomb = packed(tmp_path / "a.npz", method, vertices=np.zeros((4_000_000, 3)))
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="packed in a way that NumPy does not write"):
            read_npz(bomb)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("arrays", "read"),
    [
        ({"vertices": np.zeros((10_000_000, 3), "i1")}, read_npz),
        ({"vertices": np.zeros((3_000_000, 3), "f2")}, read_npz),
        ({"frames": np.zeros((2, 3_000_000, 3), "i1")}, read_npz_sequence),
        ({"stab": np.zeros((2, 3_000_000, 3), "f2"), "names": np.array("a")}, read_recording),
        (
            {
                "frames": np.zeros((2, 3, 3)),
                "missing": member("<U1", (1_000_000,), b"a\0\0\0" * 1_000_000),
            },
            read_npz_sequence,
        ),
    ],
)
def test_what_is_small_in_the_archive_and_large_when_read_is_refused(
    tmp_path: Path, arrays: dict[str, Any], read: Any
) -> None:
    """One byte a number becomes eight, and four bytes of text a Python object of sixty."""
    path = packed(tmp_path / "a.npz", **arrays)
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="would take more memory than"):
            read(path)
        assert tracemalloc.get_traced_memory()[1] < allowed_memory(path.stat().st_size)
    finally:
        tracemalloc.stop()


def test_all_members_together_count(tmp_path: Path) -> None:
    each = np.zeros((400_000, 3))
    arrays = {f"m{i}": each for i in range(10)}
    with open_npz(packed(tmp_path / "a.npz", **arrays)) as members:
        members.array("m0", "f", (None, 3))
        with pytest.raises(FormatError, match="would take more memory than"):
            [members.array(name, "f", (None, 3)) for name in arrays]


def test_a_message_lists_no_endless_names(tmp_path: Path) -> None:
    names = {f"{i}ä" + "n" * 1000: TRIANGLE for i in range(200)}
    with pytest.raises(FormatError, match=r"no array 'vertices'; found 0.*, 188 more$") as why:
        read_npz(packed(tmp_path / "a.npz", **names))
    assert len(str(why.value)) < 1000


@pytest.mark.parametrize("times", [[-1e308, 1e308], [0.0, np.inf], [np.nan, 1.0]])
def test_times_too_far_apart_are_refused(tmp_path: Path, times: list[float]) -> None:
    """Their difference is beyond all numbers."""
    path = packed(tmp_path / "a.npz", frames=np.zeros((2, 3, 3)), times=np.array(times))
    with pytest.raises(FormatError, match="times are not finite numbers, or too far apart"):
        read_npz_sequence(path)


@pytest.mark.parametrize("frames", [0, 1])
def test_a_take_of_no_motion_is_refused(tmp_path: Path, frames: int) -> None:
    markers = packed(tmp_path / "a.npz", stab=np.zeros((frames, 2, 3)), names=texts(65, 66))
    with pytest.raises(FormatError, match=r"2 frames, found 1|no positions of markers: 0 "):
        read_recording(markers)
    with pytest.raises(FormatError, match=f"at least 2 frames, found {frames}"):
        read_npz_sequence(packed(tmp_path / "b.npz", frames=np.zeros((frames, 2, 3))))


def rig_archive(path: Path, **changes: Any) -> Path:
    """A rig of a triangle without morphs, with arrays replaced."""
    write_rig_npz(path, Rig(Mesh(TRIANGLE, [[0, 1, 2]]), {}))
    with np.load(path) as found:
        arrays = dict(found) | changes
    return packed(path, **arrays)


def test_morphs_that_hold_nothing_still_cost(tmp_path: Path) -> None:
    """Ten thousand morphs are a few kilobytes in the file, and seconds and megabytes to build."""
    count = 10_000
    path = rig_archive(
        tmp_path / "a.npz",
        morph_names=np.arange(count).astype("U"),
        methods=np.zeros(count, "U1"),
        bake_errors=np.zeros(count),
        choices=np.zeros(count, "U1"),
        bend_counts=np.zeros(count, "i1"),
        field_sizes=np.zeros(count, "i1"),
        curve_of_limit_law=np.zeros(count, "i1"),
        curve_shapes=np.ones((1, 2), "i1"),
        curve_breaks=np.array([0.0, 1.0]),
        curve_coefficients=np.zeros(1),
    )
    with pytest.raises(FormatError, match="would take more memory than"):
        read_rig_npz(path)


def test_curves_that_hold_nothing_still_cost(tmp_path: Path) -> None:
    count = 100_000
    path = rig_archive(
        tmp_path / "a.npz",
        curve_shapes=np.ones((count, 2), "i1"),
        curve_breaks=np.tile([0.0, 1.0], count),
        curve_coefficients=np.zeros(count),
    )
    with pytest.raises(FormatError, match="would take more memory than"):
        read_rig_npz(path)


def test_a_polynomial_of_absurd_degree_is_refused(tmp_path: Path) -> None:
    path = rig_archive(
        tmp_path / "a.npz",
        curve_shapes=np.array([[1, 1000]]),
        curve_breaks=np.array([0.0, 1.0]),
        curve_coefficients=np.zeros(1000),
    )
    with pytest.raises(FormatError, match="more than 256 coefficients a piece"):
        read_rig_npz(path)


@pytest.mark.parametrize("error", [np.nan, np.inf, -1.0])
def test_bake_errors_are_numbers_from_0(tmp_path: Path, error: float) -> None:
    path = rig_archive(
        tmp_path / "a.npz",
        morph_names=np.array(["a"]),
        methods=np.array(["linear"]),
        bake_errors=np.array([error]),
        choices=np.zeros(1, "U1"),
        bend_counts=np.zeros(1, "i1"),
        field_sizes=np.zeros(1, "i1"),
        curve_of_limit_law=np.zeros(1, "i1"),
        curve_shapes=np.ones((1, 2), "i1"),
        curve_breaks=np.array([0.0, 1.0]),
        curve_coefficients=np.zeros(1),
    )
    with pytest.raises(FormatError, match="a bake error is no number from 0"):
        read_rig_npz(path)
    with np.load(path) as found:
        whole = dict(found) | {"bake_errors": np.array([0.25])}
    assert read_rig_npz(packed(path, **whole)).morphs["a"].bake_error == 0.25


def test_headers_of_the_second_version_are_read_and_of_later_ones_refused(tmp_path: Path) -> None:
    """NumPy writes the second for very long descriptions, and the third for names in Unicode."""
    file = io.BytesIO()
    np.lib.format.write_array(file, TRIANGLE, version=(2, 0))
    second = file.getvalue()
    assert np.array_equal(read_npz(packed(tmp_path / "a.npz", vertices=second)).vertices, TRIANGLE)
    third = second.replace(b"\x93NUMPY\x02", b"\x93NUMPY\x03")
    with pytest.raises(FormatError, match=r"unknown version \(3, 0\) of the array format"):
        read_npz(packed(tmp_path / "b.npz", vertices=third))
