"""Every shape of ARKit in every spelling."""

from __future__ import annotations

import pytest
from spellings import DIRECTIONS, STYLES, spelled

from elastomorph.rig.naming import ARKIT, is_rotation, shape_of, side_pairs, wholes


def test_there_are_52_shapes() -> None:
    """24 pairs of sides, less the four directions: 20 pairs, 4 directions and 12 more."""
    names = list(ARKIT)
    assert len(set(names)) == len(names) == 52
    lefts = {name.removesuffix("Left") for name in names if name.endswith("Left")}
    rights = {name.removesuffix("Right") for name in names if name.endswith("Right")}
    assert lefts == rights
    assert len(lefts) == 20


@pytest.mark.parametrize("shape", ARKIT)
def test_every_shape_in_every_spelling(shape: str) -> None:
    """Each spelling stands for one shape, also behind a node."""
    for style in STYLES:
        name = spelled(shape, style)
        assert shape_of(name) == shape
        assert shape_of(f"head|mesh.blends.{name}") == shape
        assert shape_of(f"face:{name}") == shape


def test_no_spelling_stands_for_two_shapes() -> None:
    names = [{spelled(shape, style).casefold() for style in STYLES} for shape in ARKIT]
    assert len(set.union(*names)) == sum(map(len, names))


def test_every_side_has_its_whole_and_directions_have_none() -> None:
    parts = {part for whole in wholes() if not whole.name.startswith(("look", "blink"))
             for part in whole.parts}  # fmt: skip
    sides = {shape for shape in ARKIT if shape.endswith(("Left", "Right"))} - DIRECTIONS
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


def test_pairs_of_sides() -> None:
    pairs = side_pairs(ARKIT)
    assert len(pairs) == 18
    for left, right in pairs:
        assert ARKIT[left].replace("Left", "Right") == ARKIT[right]
    assert not {ARKIT[place] for pair in pairs for place in pair} & DIRECTIONS


def test_pairs_of_sides_in_other_spellings() -> None:
    """On one node each; wholes and directions are no halves, halves without the other no pairs."""
    names = ["face.mouthSmile_L", "teeth.mouthSmileRight", "face.MouthSmileRight", "cheekRaiser_R"]
    names += ["browInnerUp", "browInnerUp_L", "cheekRaiser_L", "ear_L", "nose_R", "a.jawLeft"]
    assert side_pairs([*names, "a.jawRight"]) == [(0, 2), (6, 3)]
