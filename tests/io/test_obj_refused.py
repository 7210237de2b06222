"""What an OBJ file may not hold is refused, and the message names line, cause and remedy."""

from __future__ import annotations

from pathlib import Path

import pytest

from elastomorph.errors import FormatError
from elastomorph.io.obj import read_obj
from elastomorph.model.mesh import Mesh

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read_text(folder: Path, text: str) -> Mesh:
    (folder / "face.obj").write_text(text)
    return read_obj(folder / "face.obj")


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        # vertices
        ("", None, "no vertices"),
        ("# only a comment\nvt 0 0\n", None, "no vertices"),
        ("v\n", 1, "v x y z"),
        ("v 1 2\n", 1, "found 2 numbers"),
        ("v 1 2 3 4 5\n", 1, "found 5 numbers"),
        ("v 1 2 3 4 5 6 7 8\n", 1, "found 8 numbers"),
        ("v 1 2 three\n", 1, "finite decimal number, found 'three'"),
        ("\n\nv 1 2 nan\n", 3, "found 'nan'"),
        ("v 1 inf 3\n", 1, "found 'inf'"),
        ("v 1 2 1e999\n", 1, "larger than"),
        ("v 1,5 2 3\n", 1, "write decimals with a point"),
        ("v 1_0 2 3\n", 1, "found '1_0'"),
        ("v 0x1p3 2 3\n", 1, "found '0x1p3'"),
        ("v 1 2 3e\n", 1, "found '3e'"),
        ("v 1 2 .\n", 1, r"found '\.'"),
        ("v 1 2 3 nan\n", 1, "found 'nan'"),
        ("v 1 2 \\ \n3\n", 1, "found"),
        ("v 0 0 0\nv 1e308 0 0\n", None, "vertex 1 has .* the file is damaged"),
        # texture coordinates
        (SQUARE + "vt\n", 5, "found 0 numbers"),
        (SQUARE + "vt 1 2 3 4\n", 5, "found 4 numbers"),
        (SQUARE + "vt 1 NaN\n", 5, "found 'NaN'"),
        # polygons
        (SQUARE + "f\n", 5, "at least 3 vertices, found 0"),
        (SQUARE + "f 1\n", 5, "at least 3 vertices, found 1"),
        (SQUARE + "f 1 2 3\nf 1 \\", 6, "at least 3 vertices, found 1"),
        (SQUARE + "f 1 2x\n", 5, "whole numbers, found '2x'"),
        (SQUARE + "f 1 2 0\n", 5, "counted from 1"),
        (SQUARE + "f 1 2 5\n", 5, "names vertex 5, but the file has 4 vertices"),
        (SQUARE + "f 1 2 3\nf 1 2 -5\n", 6, "counts back beyond the first of the 4 vertices"),
        ("v 0 0 0\nf -1 -1 -2\n" + SQUARE, 2, "counts back beyond the first of the 1 vertices"),
        (SQUARE + "f 1 2 99999999999999999999999\n", 5, "far beyond"),
        (SQUARE + "f 1 2 1.5\n", 5, r"whole numbers, found '1\.5'"),
        (SQUARE + "f 1 2 3/1/1/1\n", 5, "found '3/1/1/1'"),
        (SQUARE + "f 1 2 /1\n", 5, "found '/1'"),
        (SQUARE + "f 1 2 3//x\n", 5, "found '3//x'"),
        (SQUARE + "vt 0 0\nf 1/1 2/1 3/2\n", 6, "names vt 2, but the file has 1 vt lines"),
        (SQUARE + "f 1/1 2/1 3/-1\nvt 0 0\n", 5, "beyond the first of the 0 vt lines"),
        (SQUARE + "vt 0 0\nf 1/1 2/1 3/0\n", 6, "vt lines are counted from 1"),
        (SQUARE + "vt 0 0\nf 1/1 2/1 3/-2\n", 6, "beyond the first of the 1 vt lines"),
        # keywords and names
        (SQUARE + "face 1 2 3\n", 5, "unknown keyword 'face'"),
        (SQUARE + "V 1 2 3\n", 5, "unknown keyword 'V'"),
        (SQUARE + "v1 2 3\n", 5, "unknown keyword 'v1'"),
        (SQUARE + "call part.obj\n", 5, "draws in other files"),
        (SQUARE + "\x1b[31m 1 2 3\n", 5, r"unknown keyword '\\x1b\[31m'"),
        (SQUARE + "a" * 500 + "\n", 5, r"unknown keyword 'a{37}\.\.\.'"),
    ],
)
def test_wrong_statements_are_refused_by_line(
    tmp_path: Path, text: str, line: int | None, words: str
) -> None:
    with pytest.raises(FormatError, match=words) as caught:
        read_text(tmp_path, text)
    assert caught.value.line == line
    assert str(caught.value).startswith(str(tmp_path / "face.obj"))


def test_a_continued_statement_is_reported_where_it_begins(tmp_path: Path) -> None:
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, "v 0 0 0\nf 1 \\\n1 \\\n9\n")
    assert caught.value.line == 2


def test_a_backslash_before_a_comment_continues_nothing(tmp_path: Path) -> None:
    text = "v 0 0 0\nvn 0 0 \\# 1\nv 1 1 1\nl 1 \\\n2 # comment \\\nv 2 2 2\n"
    assert read_text(tmp_path, text).vertices.tolist() == [[0, 0, 0], [1, 1, 1], [2, 2, 2]]


def test_the_first_polygon_that_is_wrong_is_named(tmp_path: Path) -> None:
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, SQUARE + "f 1 2 3\n\nf 1 2 7\nf 1 2 8\n")
    assert caught.value.line == 7
    assert "vertex 7" in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "v 0 0 0\nf 1 2 x\nv 1 2\nvt\nwhat\n",
        "v 0 0 0\nv 1 2\nf 1 2 x\nvt\nwhat\n",
        "v 0 0 0\nvt\nf 1 2 x\nv 1 2\nwhat\n",
        "v 0 0 0\nwhat\nvt\nf 1 2 x\nv 1 2\n",
    ],
)
def test_of_several_wrong_statements_the_first_is_named(tmp_path: Path, text: str) -> None:
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, text)
    assert caught.value.line == 2
