"""Tables of numbers are read strictly, and a complaint names the line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastomorph.errors import FileError, FormatError
from elastomorph.io.performance import numbers, read_table


def write(folder: Path, content: str | bytes) -> Path:
    path = folder / "table.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def all_numbers(path: Path) -> np.ndarray:
    table = read_table(path)
    return numbers(table, range(len(table.header)), range(len(table.rows)))


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_lines_marks_quotes_and_blanks(tmp_path: Path, end: str, mark: bytes) -> None:
    text = end.join(['a, b ,"c,d"', '1, -2.5e3,"3"', "", ".5,0,+7", ""])
    table = read_table(write(tmp_path, mark + text.encode()))
    assert table.header == ("a", "b", "c,d")
    assert table.lines == (2, 4)
    assert numbers(table, [2, 0, 1], [0, 1]).tolist() == [[3, 1, -2500], [7, 0.5, 0]]


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_columns_of_spreadsheets_of_other_countries(
    tmp_path: Path, separator: str, decimal: str
) -> None:
    rows = [["a", '"b,c"', "d"], ["1", "-2.5e3", ".25"], ["0", "7", "-0.5"]]
    text = "\n".join(separator.join(row) for row in rows).replace(".", decimal)
    table = read_table(write(tmp_path, text))
    assert table.header == ("a", "b,c", "d")
    assert (table.separator, table.decimal_comma) == (separator, decimal == ",")
    assert numbers(table, [0, 1, 2], [0, 1]).tolist() == [[1, -2500, 0.25], [0, 7, -0.5]]


def test_zero_bytes_at_the_end_are_padding(tmp_path: Path) -> None:
    assert all_numbers(write(tmp_path, b"a,b\n1,2\0\0")).tolist() == [[1, 2]]


@given(st.lists(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=3, max_size=3)))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_numbers_come_back_bit_for_bit(tmp_path: Path, rows: list[list[float]]) -> None:
    text = "\n".join(["x,y,z", *(",".join(map(repr, row)) for row in rows)])
    found = numbers(read_table(write(tmp_path, text)), [0, 1, 2], range(len(rows)))
    assert found.shape == (len(rows), 3)
    assert found.tolist() == rows


@pytest.mark.parametrize(
    ("content", "line", "message"),
    [
        (b"", None, "the file is empty"),
        (b"\xef\xbb\xbf\n\n", None, "the file is empty"),
        ("a,b\n1,2".encode("utf-16"), 1, "UTF-16"),
        (b"a,b\n1,2\n3,\xff", 3, "not UTF-8"),
        (b"a,b\n1,\0\n", 2, "zero byte"),
        (b"a;b\n0,5;0.5", 2, "b is '0.5', expected a finite number with a decimal comma"),
        (b"a;b\n1.000,5;1", 2, "a is '1.000,5', expected"),
        (b"a;b\n0,5;1,000,000", 2, "b is '1,000,000', expected"),
        (b"a,,c\n1,2,3", 1, "column 2 of the header has no name"),
        (b"a,b, a\n1,2,3", 1, "'a' twice"),
        (b'a,b\n1,"2', 2, "not comma-separated"),
        (b"a,b\n1,2\n3\n", 3, "expected 2 columns as in the header, found 1"),
        (b"a,b\n1,2,3\n", 2, "expected 2 columns as in the header, found 3"),
        (b"a,b\n1,2\n\n1,x\n", 4, "b is 'x', expected a finite number"),
        (b"a,b\n1,\n", 2, "b is ''"),
        (b"a,b\nnan,1\n", 2, "a is 'nan'"),
        (b"a,b\n1,inf\n", 2, "b is 'inf'"),
        (b"a,b\n1_0,1\n", 2, "a is '1_0'"),
        ("a,b\n١,1\n".encode(), 2, "a is '١'"),
        (b"a,b\n1,0x10\n", 2, "b is '0x10'"),
    ],
)
def test_mistakes(tmp_path: Path, content: bytes, line: int | None, message: str) -> None:
    path = write(tmp_path, content)
    with pytest.raises(FormatError) as caught:
        all_numbers(path)
    assert message in str(caught.value)
    assert caught.value.path == path
    assert caught.value.line == line


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such file"):
        read_table(tmp_path / "none.csv")


@given(st.binary(max_size=200))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_are_a_table_or_an_error_of_ours(tmp_path: Path, content: bytes) -> None:
    try:
        found = all_numbers(write(tmp_path, content))
    except FormatError:
        return
    assert found.ndim == 2
    assert np.isfinite(found).all()
