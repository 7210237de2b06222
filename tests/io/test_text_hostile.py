"""OBJ, PLY, CSV and regions made to harm are refused soon, in a line that can be read."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.obj import read_obj
from elastomorph.io.performance import read_performance
from elastomorph.io.ply import read_ply
from elastomorph.io.vertex_lists import read_region

pytestmark = pytest.mark.hostile

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
XYZ = "property float x\nproperty float y\nproperty float z\n"


@contextmanager
def soon() -> Iterator[None]:
    """In some seconds of processor time, where a search of all for each took minutes."""
    start = time.process_time()
    yield
    assert time.process_time() - start < 5


def file_of(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def message_of(path: Path, error: BaseException) -> str:
    """The message without its file; short enough to be read."""
    text = str(error)
    assert text.startswith(str(path))
    assert len(text) - len(str(path)) < 600
    return text


# OBJ


@pytest.mark.parametrize("corner", ["{}", "{}/1", "-{}", "1/{}", "1//{}", "1/1/-{}"])
def test_an_index_of_five_thousand_digits(tmp_path: Path, corner: str) -> None:
    """Python refuses to make a whole number of them, be they nines or leading zeros."""
    text = f"{TRIANGLE}vt 0 0\nf 1 2 {corner}\n"
    small = read_obj(file_of(tmp_path, "a.obj", text.format("0" * 5000 + "1")))
    assert len(small.faces) == 1
    path = file_of(tmp_path, "b.obj", text.format("9" * 5000))
    if corner in ("1//{}", "1/1/-{}"):
        assert len(read_obj(path).faces) == 1  # a normal is not kept and may be any
        return
    with pytest.raises(FormatError, match=r"line 5: the index '-?9+.* is far beyond") as why:
        read_obj(path)
    message_of(path, why.value)


@pytest.mark.parametrize("beginning", ["", "0.", "1e", "-.", "+1.5e-"])
def test_a_word_of_a_megabyte_that_is_no_number(tmp_path: Path, beginning: str) -> None:
    """It is looked through once, not once for every digit."""
    path = file_of(tmp_path, "a.obj", f"v {beginning}{'1' * 900_000}x 0 0\n")
    with soon(), pytest.raises(FormatError, match="line 1: expected a finite decimal") as why:
        read_obj(path)
    message_of(path, why.value)


# PLY


def test_a_property_named_twice_is_the_first(tmp_path: Path) -> None:
    """The checks and the rows must mean the same one."""
    header = (
        f"ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar float x\n{XYZ}end_header\n"
    )
    path = file_of(tmp_path, "a.ply", f"{header}2 7 7 1 2 3\n")
    with pytest.raises(FormatError, match="no property 'x' that is a number"):
        read_ply(path)
    header = (
        f"ply\nformat ascii 1.0\nelement vertex 1\n{XYZ}property list uchar float x\nend_header\n"
    )
    mesh = read_ply(file_of(tmp_path, "b.ply", f"{header}1 2 3 2 7 7\n"))
    assert mesh.vertices.tolist() == [[1, 2, 3]]


def test_corners_named_twice_are_the_first(tmp_path: Path) -> None:
    header = (
        f"ply\nformat ascii 1.0\nelement vertex 1\n{XYZ}element face 1\n"
        "property float vertex_indices\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path = file_of(tmp_path, "a.ply", f"{header}0 0 0\nnan 3 0 0 0\n")
    with pytest.raises(FormatError, match="no list of whole numbers called 'vertex_indices'"):
        read_ply(path)


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_more_properties_than_any_program_writes(tmp_path: Path, encoding: str) -> None:
    """Fifty thousand took many seconds, as each list of them was copied for the next."""
    many = "".join(f"property int p{i}\n" for i in range(50_000))
    text = f"ply\nformat {encoding} 1.0\nelement vertex 1\n{XYZ}{many}end_header\n"
    path = file_of(tmp_path, "a.ply", text)
    with soon(), pytest.raises(FormatError, match="line 1004: expected at most 1,000 properties"):
        read_ply(path)


def test_a_row_of_many_properties_is_described_in_short(tmp_path: Path) -> None:
    many = "".join(f"property int p{i}\n" for i in range(900))
    text = f"ply\nformat ascii 1.0\nelement vertex 1\n{XYZ}{many}end_header\n1 2 3\n"
    path = file_of(tmp_path, "a.ply", text)
    with pytest.raises(FormatError, match="expected the numbers of one 'vertex'") as why:
        read_ply(path)
    message_of(path, why.value)


@pytest.mark.parametrize(
    "line", ["element {} 1", "property int {}", "property list uchar int {}", "comment {}"]
)
def test_a_name_of_a_megabyte(tmp_path: Path, line: str) -> None:
    long = line.format("n" * 900_000)
    text = f"ply\nformat ascii 1.0\nelement vertex 1\n{XYZ}{long}\nend_header\n1 2 3\n"
    path = file_of(tmp_path, "a.ply", text)
    if line.startswith("comment"):
        assert len(read_ply(path).vertices) == 1
        return
    with pytest.raises(FormatError, match="line 7: expected") as why:
        read_ply(path)
    message_of(path, why.value)


# CSV


def test_a_hundred_thousand_columns(tmp_path: Path) -> None:
    """Each name is compared with those before it at once."""
    names = [f"c{i}" for i in range(100_000)]
    path = file_of(tmp_path, "a.csv", f"time,{','.join(names)}\n0{',1' * len(names)}\n")
    with soon():
        assert read_performance(path).weights.shape == (1, 100_000)
    path = file_of(tmp_path, "b.csv", f"time,{','.join(names)},c0\n")
    with soon(), pytest.raises(FormatError, match="line 1: the header names 'c0' twice"):
        read_performance(path)


def test_a_wrong_cell_behind_a_hundred_thousand_right_ones(tmp_path: Path) -> None:
    rows = "".join(f"{i},0\n" for i in range(100_000))
    path = file_of(tmp_path, "a.csv", f"time,a\n{rows}100000,x\n")
    with soon(), pytest.raises(FormatError, match="line 100002: a is 'x', expected a finite"):
        read_performance(path)


def test_a_column_with_an_endless_name(tmp_path: Path) -> None:
    path = file_of(tmp_path, "a.csv", f"time,{'n' * 100_000}\n0,x\n")
    with pytest.raises(FormatError, match=r"line 2: n+… is 'x', expected a finite") as why:
        read_performance(path)
    message_of(path, why.value)


@pytest.mark.parametrize(
    ("times", "line"), [(["-1e308", "1e308"], 2), (["0", "1.7e308"], 3), (["0", "1e16"], 3)]
)
def test_times_that_cannot_be_seconds(tmp_path: Path, times: list[str], line: int) -> None:
    """Their differences or their mean would be beyond all numbers."""
    path = file_of(tmp_path, "a.csv", "time,a\n" + "".join(f"{t},0\n" for t in times))
    with pytest.raises(FormatError, match=f"line {line}: the time .* cannot be seconds"):
        read_performance(path)


def test_times_that_are_almost_the_same(tmp_path: Path) -> None:
    path = file_of(tmp_path, "a.csv", "time,a\n0,0\n5e-324,0\n")
    with pytest.raises(FormatError, match="the rate must be a finite number above 0, found inf"):
        read_performance(path)


# Regions


@pytest.mark.parametrize(
    "text",
    ["0-2147483646", "9" * 5000, "0-" + "9" * 5000, "1-\u0663", "\u0661", "0-40000000,0-40000000"],
)
def test_ranges_that_would_fill_the_memory_or_are_no_numbers(text: str) -> None:
    with pytest.raises(ParameterError, match="range") as why:
        read_region(text)
    assert len(str(why.value)) < 300


def test_a_range_of_a_million_is_fine() -> None:
    assert np.array_equal(read_region("0-999999"), np.arange(1_000_000))
