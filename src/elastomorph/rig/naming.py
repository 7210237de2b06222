"""What the weights of a face are called: the ARKit shapes and their kin, in all spellings.

Nothing is guessed. A name is known if it stands in a table here, in any capitals; every other name
means only itself. Left and right are the sides of the person.
"""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from typing import NamedTuple


class Whole(NamedTuple):
    """A shape that others make up together, most often its left and its right half."""

    name: str
    parts: tuple[str, ...]


ARKIT = (
    "eyeBlinkLeft", "eyeLookDownLeft", "eyeLookInLeft", "eyeLookOutLeft", "eyeLookUpLeft",
    "eyeSquintLeft", "eyeWideLeft", "eyeBlinkRight", "eyeLookDownRight", "eyeLookInRight",
    "eyeLookOutRight", "eyeLookUpRight", "eyeSquintRight", "eyeWideRight", "jawForward",
    "jawRight", "jawLeft", "jawOpen", "mouthClose", "mouthFunnel", "mouthPucker", "mouthRight",
    "mouthLeft", "mouthSmileLeft", "mouthSmileRight", "mouthFrownLeft", "mouthFrownRight",
    "mouthDimpleLeft", "mouthDimpleRight", "mouthStretchLeft", "mouthStretchRight",
    "mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper", "mouthPressLeft",
    "mouthPressRight", "mouthLowerDownLeft", "mouthLowerDownRight", "mouthUpperUpLeft",
    "mouthUpperUpRight", "browDownLeft", "browDownRight", "browInnerUp", "browOuterUpLeft",
    "browOuterUpRight", "cheekPuff", "cheekSquintLeft", "cheekSquintRight", "noseSneerLeft",
    "noseSneerRight", "tongueOut",
)  # fmt: skip
"""The 52 shapes of ARKit in the order of Live Link Face.

So they are called by ARKit, MediaPipe and VRM 1.0 with "Perfect Sync", with a capital by Live Link
Face and VRM 0, and with _L and _R for the sides by ICT-FaceKit, FaceCap and many modelled rigs.
"""

_DIRECTIONS = {"jawLeft", "jawRight", "mouthLeft", "mouthRight"}
_SIDED = ("browInnerUp", "cheekPuff") + tuple(
    shape.removesuffix("Left")
    for shape in ARKIT
    if shape.endswith("Left") and shape not in _DIRECTIONS
)
"""What has a left and a right half: the first two on rigs, though not with ARKit."""

_WHOLES = (
    *(Whole(shape, (f"{shape}Left", f"{shape}Right")) for shape in _SIDED),
    Whole("blink", ("eyeBlinkLeft", "eyeBlinkRight")),
    Whole("blinkLeft", ("eyeBlinkLeft",)),
    Whole("blinkRight", ("eyeBlinkRight",)),
    Whole("lookUp", ("eyeLookUpLeft", "eyeLookUpRight")),
    Whole("lookDown", ("eyeLookDownLeft", "eyeLookDownRight")),
    Whole("lookLeft", ("eyeLookOutLeft", "eyeLookInRight")),
    Whole("lookRight", ("eyeLookInLeft", "eyeLookOutRight")),
)
"""Both sides as one, and presets of VRM that are shapes of ARKit under another name."""

_VRM = {
    "blink": "Blink", "blinkLeft": "Blink_L", "blinkRight": "Blink_R", "lookUp": "LookUp",
    "lookDown": "LookDown", "lookLeft": "LookLeft", "lookRight": "LookRight", "aa": "A", "ih": "I",
    "ou": "U", "ee": "E", "oh": "O", "happy": "Joy", "angry": "Angry", "sad": "Sorrow",
    "relaxed": "Fun", "surprised": "Surprised", "neutral": "Neutral",
}  # fmt: skip
"""Preset expressions of VRM 1.0 and what VRM 0 calls them.

Vowels and moods are whole faces: no one way to make them of ARKit shapes is agreed on, so they
drive nothing but themselves.
"""

_SHAPES = {shape.casefold(): shape for shape in (*ARKIT, *_SIDED)}
for _shape in _SIDED:
    for _side in ("Left", "Right"):
        _SHAPES[f"{_shape}{_side}".casefold()] = f"{_shape}{_side}"
        _SHAPES[f"{_shape}_{_side[0]}".casefold()] = f"{_shape}{_side}"
for _preset, _old in _VRM.items():
    _SHAPES[_preset.casefold()] = _SHAPES[_old.casefold()] = _preset

_ROTATIONS = {
    f"{of}{axis}".casefold()
    for of in ("head", "leftEye", "rightEye")
    for axis in ("Yaw", "Pitch", "Roll")
}


def shape_of(name: str) -> str | None:
    """The shape that a name stands for, in ARKit's spelling; None where no table has it.

    A node or namespace in front is ignored: ``shapes.jawOpen``, ``head:jawOpen``.
    """
    bare = name.rpartition(":")[2].rpartition(".")[2]
    return _SHAPES.get(name.casefold()) or _SHAPES.get(bare.casefold())


def nearest_name(name: str, known: Sequence[str]) -> str | None:
    """What a wrong name probably means: the one for the same shape, else that of nearest spelling.

    ``eyeBlink_L`` and ``EyeBlinkLeft`` are the same shape; None where no name is near.
    """
    shape = shape_of(name)
    same = (each for each in known if shape is not None and shape_of(each) == shape)
    return next(iter((*same, *get_close_matches(name, known, n=1, cutoff=0.5))), None)


def is_rotation(name: str) -> bool:
    """Whether a name is an angle of the head or an eye, as Live Link Face records them."""
    return name.casefold() in _ROTATIONS


def wholes() -> tuple[Whole, ...]:
    """Shapes that others make up together, those of two halves before the presets of VRM."""
    return _WHOLES


_HALVES = {f"{whole}{side}": (whole, side) for whole in _SIDED for side in ("Left", "Right")}


def side_pairs(names: Sequence[str]) -> list[tuple[int, int]]:
    """Places of the names that are the left and the right half of one shape, on one node.

    Halves that no table has are those whose names differ only in a last ``_L`` and ``_R``.
    """
    halves: dict[tuple[str, str], int] = {}
    for place, name in enumerate(names):
        shape = shape_of(name)
        if shape in _HALVES:
            node = name[: max(name.rfind(":"), name.rfind(".")) + 1]
            whole, side = _HALVES[shape]
            halves.setdefault((node + whole, side), place)
        elif shape is None and name.endswith(("_L", "_R")):
            halves.setdefault((name[:-2], "Left" if name.endswith("L") else "Right"), place)
    return [
        (place, halves[whole, "Right"])
        for (whole, side), place in halves.items()
        if side == "Left" and (whole, "Right") in halves
    ]
