"""Every shape of ARKit in every spelling."""

from __future__ import annotations

from typing import get_args

import pytest

from elastomorph.errors import ParameterError
from elastomorph.rig.performance.naming import (
    ARKIT,
    Style,
    is_rotation,
    shape_of,
    spelled,
    wholes,
)

STYLES = get_args(Style)
DIRECTIONS = {"jawLeft", "jawRight", "mouthLeft", "mouthRight"}


def test_there_are_52_shapes() -> None:
    """24 pairs of sides, less the four directions: 20 pairs, 4 directions and 12 more."""
    names = [row.arkit for row in ARKIT]
    assert len(set(names)) == len(names) == 52
    lefts = {name.removesuffix("Left") for name in names if name.endswith("Left")}
    rights = {name.removesuffix("Right") for name in names if name.endswith("Right")}
    assert lefts == rights
    assert len(lefts) == 20


@pytest.mark.parametrize("row", ARKIT, ids=lambda row: row.arkit)
def test_every_shape_in_every_spelling_and_back(row: object) -> None:
    """Each spelling stands for one shape, also behind a node, and the shape gives it back."""
    shape = row.arkit  # type: ignore[attr-defined]
    for style in STYLES:
        name = spelled(shape, style)
        assert shape_of(name) == shape
        assert shape_of(f"head|mesh.blends.{name}") == shape
        assert shape_of(f"face:{name}") == shape
    assert len({shape_of(spelled(shape, style)) for style in STYLES}) == 1


def test_the_spellings_follow_their_rules() -> None:
    """The table is written out; what it must say can be derived for all rows but the directions."""
    for row in ARKIT:
        assert row.livelink == row.arkit[0].upper() + row.arkit[1:]
        expected = row.arkit
        if row.arkit not in DIRECTIONS:
            for side in ("Left", "Right"):
                if row.arkit.endswith(side):
                    expected = f"{row.arkit.removesuffix(side)}_{side[0]}"
        assert row.sided == expected


def test_no_spelling_stands_for_two_shapes() -> None:
    names = [{spelled(row.arkit, style).casefold() for style in STYLES} for row in ARKIT]
    assert len(set.union(*names)) == sum(map(len, names))


def test_every_side_has_its_whole_and_directions_have_none() -> None:
    parts = {part for whole in wholes() if not whole.name.startswith(("look", "blink"))
             for part in whole.parts}  # fmt: skip
    sides = {row.arkit for row in ARKIT if row.arkit.endswith(("Left", "Right"))} - DIRECTIONS
    halves = {"browInnerUpLeft", "browInnerUpRight", "cheekPuffLeft", "cheekPuffRight"}
    assert parts == sides | halves
    for whole, own in wholes():
        if len(own) == 2 and not whole.startswith(("look", "blink")):
            assert own == (f"{whole}Left", f"{whole}Right")


def test_looking_left_turns_the_left_eye_out_and_the_right_eye_in() -> None:
    table = dict(wholes())
    assert table["lookLeft"] == ("eyeLookOutLeft", "eyeLookInRight")
    assert table["lookRight"] == ("eyeLookInLeft", "eyeLookOutRight")


@pytest.mark.parametrize(
    ("old", "new"), [("A", "aa"), ("Joy", "happy"), ("Blink_L", "blinkLeft"), ("LOOKUP", "lookUp")]
)
def test_vrm_0_and_1_agree(old: str, new: str) -> None:
    assert shape_of(old) == shape_of(new) == new


@pytest.mark.parametrize(
    "name",
    ["", "jaw_Open", "jaw", "eyeBlink_", "eyeBlinkLeftRight", "mouthSmile.L", "mouth_L", "jaw_L",
     "PupilDilate_L", "HeadYaw", "jawOpen.", "ｊawOpen", "jawopen2"],
)  # fmt: skip
def test_what_no_table_has_is_no_shape(name: str) -> None:
    assert shape_of(name) is None


def test_rotations() -> None:
    assert is_rotation("HeadYaw")
    assert is_rotation("leftEyePitch")
    assert not is_rotation("eyeLookUpLeft")
    assert not is_rotation("head.HeadYaw")


def test_unknown_shapes_and_styles_are_refused() -> None:
    with pytest.raises(ParameterError, match="eyeBlinkLeft"):
        spelled("eyeBlink_L", "arkit")
    with pytest.raises(ParameterError, match="livelink"):
        spelled("jawOpen", "maya")  # type: ignore[arg-type]
