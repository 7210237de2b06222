"""The quick reader of OBJ text equals the strict one, or leaves the text to it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from elastomorph.errors import FormatError
from elastomorph.io.obj_lines import read_lines
from elastomorph.io.obj_statements import ObjStatements
from elastomorph.io.obj_table import read_table

BLANK = st.sampled_from([" ", "  ", "\t", " \t "])
DECIMALS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.integers(-999, 999).map(str),
    st.sampled_from(["+1", ".5", "-.5", "1.", "1e3", "1E-3", "007", "1.5e+05", "-0"]),
)
ODD_DECIMALS = st.sampled_from(["nan", "inf", "1e999", "1_0", "1,5", "e", ".", "-", "1e", "x", "#"])
CORNER_STYLES = ["{v}", "{v}/{t}", "{v}//{n}", "{v}/{t}/{n}"]
ODD_CORNERS = ["{v}/", "{v}//", "-{v}", "+{v}", "/{t}", "{v}/{t}/", "{v}///{n}", "0", "{v}.0", "-"]
OTHERS = [
    "# comment", "#", "", " ", "\t# indented comment", "s off", "s 1", "vn 0 0 1", "vn x", "vn",
    "usemtl skin", "usemtl", "g left cheek", "g", "o Head # main", "usemtl Material #25",
    "mtllib a.mtl", "mtllib", "l 1 2", "usemtl \u00df", "g\ttab",
]  # fmt: skip
ODD_OTHERS = [
    " v 1 2 3", "v", "vt", "f", "v\x0b1 2 3", "fo 1 1 1", "foo", "call a.obj", "g a \\", "# \\",
    "f 1 1 \\", "usemtl\\", "v 1 2 3 # c", "f 1 1 1 1 1#", "g#a", "\x0c", "vt 1 2 3 4", "f 1 1",
]  # fmt: skip


@st.composite
def obj_texts(draw: st.DrawFn, odd: bool) -> bytes:
    """OBJ text; without ``odd`` only what exporters usually write, so that it must be quick."""
    columns = draw(st.sampled_from([3, 4, 6, 7]))
    texture_columns = draw(st.sampled_from([1, 2, 3]))
    vertices, coordinates = draw(st.integers(1, 5)), draw(st.integers(1, 4))
    style = draw(st.sampled_from(CORNER_STYLES))
    numbers = DECIMALS | ODD_DECIMALS if odd and draw(st.booleans()) else DECIMALS

    def row(keyword: str, words: list[str]) -> str:
        return "".join(keyword if i < 0 else draw(BLANK) + words[i] for i in range(-1, len(words)))

    def some_numbers(count: int) -> list[str]:
        count += draw(st.integers(-1, 1)) if odd and draw(st.integers(0, 9)) == 0 else 0
        return [draw(numbers) for _ in range(count)]

    def corner() -> str:
        styles = CORNER_STYLES + ODD_CORNERS if odd and draw(st.integers(0, 9)) == 0 else [style]
        beyond = 1 if odd and draw(st.integers(0, 19)) == 0 else 0
        return draw(st.sampled_from(styles)).format(
            v=draw(st.integers(1, vertices + beyond)),
            t=draw(st.integers(1, coordinates + beyond)),
            n=draw(st.integers(0, 99)),
        )

    lines = [row("v", some_numbers(columns)) for _ in range(vertices)]
    lines += [row("vt", some_numbers(texture_columns)) for _ in range(coordinates)]
    for _ in range(draw(st.integers(0, 5))):
        lines.append(row("f", [corner() for _ in range(draw(st.integers(3, 5)))]))
    lines += draw(st.lists(st.sampled_from(OTHERS + ODD_OTHERS if odd else OTHERS), max_size=6))
    lines = draw(st.permutations(lines)) if draw(st.booleans()) else lines
    return "".join(line + "\n" for line in lines).encode()


def assert_same(one: ObjStatements, other: ObjStatements) -> None:
    for field in dataclasses.fields(ObjStatements):
        mine, theirs = getattr(one, field.name), getattr(other, field.name)
        if isinstance(mine, np.ndarray) and len(mine) + len(theirs):
            assert mine.dtype == theirs.dtype, field.name
            assert mine.shape == theirs.shape, field.name
            assert mine.tobytes() == theirs.tobytes(), field.name
        elif not isinstance(mine, np.ndarray):
            assert mine == theirs, field.name


def assert_agreement(text: bytes) -> None:
    """What the quick reader accepts, the strict one accepts, with the same result."""
    quick = read_table(text)
    if quick is not None:
        assert_same(quick, read_lines("face.obj", text))


@given(text=obj_texts(odd=False))
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_ordinary_text_is_read_quickly_and_as_the_strict_reader_does(text: bytes) -> None:
    assert read_table(text) is not None
    assert_agreement(text)


@given(text=obj_texts(odd=True))
@example(b"v 1 2 3\nv 1 2 3 4\n")
@example(b"v 1 2 3 4 5\n")
@example(b"v 1 2\nv 3 4 5 6\n")
@example(b"v 1 2 3\nf 1 1 1\nf 1/1 1/1 1/1\n")
@example(b"v 1 2 3\nvt 1\nf 1/1 1/1/1 1\n")
@example(b"v 1 2 3\nf 1//1 1//1 1///\n")
@example(b"v 1 2 3\nf 1 1 00000000000000000000000000001\n")
@example(b"v 1 2 3\nf 1//1 1//1 1//99999999999999999999\n")
@example(b"v 1 2 3\nf 1 1 9223372036854775808\n")
@example(b"v 1 2 3\nf " + b"1 " * 300 + b"\n")
@example(b"v 1 2 3\nvt 1\nf 1/0 1/1 1/1\n")
@example(b"v 1 2 3\nvt 1\nf 1//1 1/1/1 1//1\n")
@example(b"v 1 2 3\nvt 1\nf 1//1 1/1/1 1/1/1\nf 1//1 1//1 1//1\n")
@example(b"v 1 2 3\ng a \\\nv 1 2 3\nf 1 1 1\n")
@example(b"v 1 2 3\ns 1 \\\nv 1 2 3\n")
@example(b"v 1 2 3\nvn 1 \\# comment\nf 1 1 1\n")
@example(b"v1 2 3\n")
@example(b"f 1 1 1\n")
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_unusual_text_is_never_read_differently(text: bytes) -> None:
    assert_agreement(text)


ORDINARY = [
    b"mtllib a.mtl\nv 0 0 0\nv 1.5 0 0\nv 1 1 -2e-3\nvt 0 0\nvt 1 .5\ng a b\nusemtl m\n"
    b"f 1/1 2/2 3/1\nf 1/1 2/2 3/1 3/2\ns 1\n# c\n",
    b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nvn 0 0 1\nf 1 3 2\n",
    b"v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nvt 1\nvn 1 1 1\nf 1/1/1 2/1/1 1/1/1\n",
    b"v 0 0 0\nf 1//1 1//2 1//3\no x\n",
]


@pytest.mark.parametrize("text", ORDINARY)
def test_text_with_random_characters_changed_is_never_read_differently(text: bytes) -> None:
    characters = b"0123456789 \t\n\\/#-+.eEvtnfgo_,\x0b\x0c\x01\xff\x1c\x85\xa0"
    random = Random(20240101)
    accepted = 0
    for _ in range(5000):
        changed = bytearray(text)
        for _ in range(random.randint(1, 4)):
            place = random.randrange(len(changed) + 1)
            new = random.choices(characters, k=random.randint(0, 2))
            changed[place : place + random.randint(0, 2)] = bytes(new)
        changed += b"\n"
        assert_agreement(bytes(changed))
        accepted += read_table(bytes(changed)) is not None
    assert accepted > 200


@pytest.mark.realdata
def test_both_readers_agree_on_a_production_mesh(data_dir: Path) -> None:
    text = (data_dir / "ict-facekit" / "generic_neutral_mesh.obj").read_bytes() + b"\n"
    quick = read_table(text)
    assert quick is not None
    assert_same(quick, read_lines("face.obj", text))


@pytest.mark.realdata
def test_both_readers_agree_on_damaged_files(data_dir: Path) -> None:
    """Also with the characters taken out that no text may have, so that more of each is read."""
    accepted = 0
    for file in sorted((data_dir / "malformed" / "obj").iterdir()):
        whole = file.read_bytes().replace(b"\r", b"\n") + b"\n"
        lines = []
        for line in whole.replace(b"\0", b"").split(b"\n"):
            try:  # each line on its own, to leave out the ones that alone are already wrong
                read_lines("face.obj", b"v 0 0 0\n" * 9 + b"vt 0 0\n" * 20 + line + b"\n")
            except FormatError:
                continue
            lines.append(line + b"\n")
        for text in (whole.replace(b"\0", b""), b"v 0 0 0\n" * 9 + b"".join(lines)):
            assert_agreement(text)
            accepted += read_table(text) is not None
    assert accepted > 20
