"""What the weights of a face are called: one explicit table of the ARKit shapes and their kin.

Nothing is guessed. A name is known if it stands in a table here, in any capitals; every other name
means only itself. Left and right are the sides of the person.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple

from elastomorph.errors import ParameterError

__all__ = ["ARKIT", "Spelling", "Style", "Whole", "is_rotation", "shape_of", "spelled", "wholes"]

Style = Literal["arkit", "livelink", "sided", "lower"]


class Spelling(NamedTuple):
    """One shape in the spellings that rigs and recordings use.

    Attributes:
        arkit: ARKit, MediaPipe, VRM 1.0 with "Perfect Sync"; the name of the shape here.
        livelink: Live Link Face, VRM 0 with "Perfect Sync".
        sided: ICT-FaceKit, FaceCap and many modelled rigs.
    """

    arkit: str
    livelink: str
    sided: str


class Whole(NamedTuple):
    """A shape that others make up together.

    Attributes:
        name: The whole.
        parts: What it is made of, most often its left and its right half.
    """

    name: str
    parts: tuple[str, ...]


ARKIT: tuple[Spelling, ...] = (
    Spelling("eyeBlinkLeft", "EyeBlinkLeft", "eyeBlink_L"),
    Spelling("eyeLookDownLeft", "EyeLookDownLeft", "eyeLookDown_L"),
    Spelling("eyeLookInLeft", "EyeLookInLeft", "eyeLookIn_L"),
    Spelling("eyeLookOutLeft", "EyeLookOutLeft", "eyeLookOut_L"),
    Spelling("eyeLookUpLeft", "EyeLookUpLeft", "eyeLookUp_L"),
    Spelling("eyeSquintLeft", "EyeSquintLeft", "eyeSquint_L"),
    Spelling("eyeWideLeft", "EyeWideLeft", "eyeWide_L"),
    Spelling("eyeBlinkRight", "EyeBlinkRight", "eyeBlink_R"),
    Spelling("eyeLookDownRight", "EyeLookDownRight", "eyeLookDown_R"),
    Spelling("eyeLookInRight", "EyeLookInRight", "eyeLookIn_R"),
    Spelling("eyeLookOutRight", "EyeLookOutRight", "eyeLookOut_R"),
    Spelling("eyeLookUpRight", "EyeLookUpRight", "eyeLookUp_R"),
    Spelling("eyeSquintRight", "EyeSquintRight", "eyeSquint_R"),
    Spelling("eyeWideRight", "EyeWideRight", "eyeWide_R"),
    Spelling("jawForward", "JawForward", "jawForward"),
    Spelling("jawRight", "JawRight", "jawRight"),
    Spelling("jawLeft", "JawLeft", "jawLeft"),
    Spelling("jawOpen", "JawOpen", "jawOpen"),
    Spelling("mouthClose", "MouthClose", "mouthClose"),
    Spelling("mouthFunnel", "MouthFunnel", "mouthFunnel"),
    Spelling("mouthPucker", "MouthPucker", "mouthPucker"),
    Spelling("mouthRight", "MouthRight", "mouthRight"),
    Spelling("mouthLeft", "MouthLeft", "mouthLeft"),
    Spelling("mouthSmileLeft", "MouthSmileLeft", "mouthSmile_L"),
    Spelling("mouthSmileRight", "MouthSmileRight", "mouthSmile_R"),
    Spelling("mouthFrownLeft", "MouthFrownLeft", "mouthFrown_L"),
    Spelling("mouthFrownRight", "MouthFrownRight", "mouthFrown_R"),
    Spelling("mouthDimpleLeft", "MouthDimpleLeft", "mouthDimple_L"),
    Spelling("mouthDimpleRight", "MouthDimpleRight", "mouthDimple_R"),
    Spelling("mouthStretchLeft", "MouthStretchLeft", "mouthStretch_L"),
    Spelling("mouthStretchRight", "MouthStretchRight", "mouthStretch_R"),
    Spelling("mouthRollLower", "MouthRollLower", "mouthRollLower"),
    Spelling("mouthRollUpper", "MouthRollUpper", "mouthRollUpper"),
    Spelling("mouthShrugLower", "MouthShrugLower", "mouthShrugLower"),
    Spelling("mouthShrugUpper", "MouthShrugUpper", "mouthShrugUpper"),
    Spelling("mouthPressLeft", "MouthPressLeft", "mouthPress_L"),
    Spelling("mouthPressRight", "MouthPressRight", "mouthPress_R"),
    Spelling("mouthLowerDownLeft", "MouthLowerDownLeft", "mouthLowerDown_L"),
    Spelling("mouthLowerDownRight", "MouthLowerDownRight", "mouthLowerDown_R"),
    Spelling("mouthUpperUpLeft", "MouthUpperUpLeft", "mouthUpperUp_L"),
    Spelling("mouthUpperUpRight", "MouthUpperUpRight", "mouthUpperUp_R"),
    Spelling("browDownLeft", "BrowDownLeft", "browDown_L"),
    Spelling("browDownRight", "BrowDownRight", "browDown_R"),
    Spelling("browInnerUp", "BrowInnerUp", "browInnerUp"),
    Spelling("browOuterUpLeft", "BrowOuterUpLeft", "browOuterUp_L"),
    Spelling("browOuterUpRight", "BrowOuterUpRight", "browOuterUp_R"),
    Spelling("cheekPuff", "CheekPuff", "cheekPuff"),
    Spelling("cheekSquintLeft", "CheekSquintLeft", "cheekSquint_L"),
    Spelling("cheekSquintRight", "CheekSquintRight", "cheekSquint_R"),
    Spelling("noseSneerLeft", "NoseSneerLeft", "noseSneer_L"),
    Spelling("noseSneerRight", "NoseSneerRight", "noseSneer_R"),
    Spelling("tongueOut", "TongueOut", "tongueOut"),
)
"""The 52 shapes of ARKit in the order of Live Link Face."""

_HALVES: tuple[Spelling, ...] = (
    Spelling("browInnerUpLeft", "BrowInnerUpLeft", "browInnerUp_L"),
    Spelling("browInnerUpRight", "BrowInnerUpRight", "browInnerUp_R"),
    Spelling("cheekPuffLeft", "CheekPuffLeft", "cheekPuff_L"),
    Spelling("cheekPuffRight", "CheekPuffRight", "cheekPuff_R"),
)
"""Halves that rigs have and ARKit has not."""

_WHOLES: tuple[Whole, ...] = (
    Whole("browInnerUp", ("browInnerUpLeft", "browInnerUpRight")),
    Whole("cheekPuff", ("cheekPuffLeft", "cheekPuffRight")),
    Whole("browDown", ("browDownLeft", "browDownRight")),
    Whole("browOuterUp", ("browOuterUpLeft", "browOuterUpRight")),
    Whole("cheekSquint", ("cheekSquintLeft", "cheekSquintRight")),
    Whole("eyeBlink", ("eyeBlinkLeft", "eyeBlinkRight")),
    Whole("eyeLookDown", ("eyeLookDownLeft", "eyeLookDownRight")),
    Whole("eyeLookIn", ("eyeLookInLeft", "eyeLookInRight")),
    Whole("eyeLookOut", ("eyeLookOutLeft", "eyeLookOutRight")),
    Whole("eyeLookUp", ("eyeLookUpLeft", "eyeLookUpRight")),
    Whole("eyeSquint", ("eyeSquintLeft", "eyeSquintRight")),
    Whole("eyeWide", ("eyeWideLeft", "eyeWideRight")),
    Whole("mouthDimple", ("mouthDimpleLeft", "mouthDimpleRight")),
    Whole("mouthFrown", ("mouthFrownLeft", "mouthFrownRight")),
    Whole("mouthLowerDown", ("mouthLowerDownLeft", "mouthLowerDownRight")),
    Whole("mouthPress", ("mouthPressLeft", "mouthPressRight")),
    Whole("mouthSmile", ("mouthSmileLeft", "mouthSmileRight")),
    Whole("mouthStretch", ("mouthStretchLeft", "mouthStretchRight")),
    Whole("mouthUpperUp", ("mouthUpperUpLeft", "mouthUpperUpRight")),
    Whole("noseSneer", ("noseSneerLeft", "noseSneerRight")),
)
"""Both sides as one. jawLeft, jawRight, mouthLeft and mouthRight are directions, not sides."""

_VRM_WHOLES: tuple[Whole, ...] = (
    Whole("blink", ("eyeBlinkLeft", "eyeBlinkRight")),
    Whole("blinkLeft", ("eyeBlinkLeft",)),
    Whole("blinkRight", ("eyeBlinkRight",)),
    Whole("lookUp", ("eyeLookUpLeft", "eyeLookUpRight")),
    Whole("lookDown", ("eyeLookDownLeft", "eyeLookDownRight")),
    Whole("lookLeft", ("eyeLookOutLeft", "eyeLookInRight")),
    Whole("lookRight", ("eyeLookInLeft", "eyeLookOutRight")),
)
"""Preset expressions of VRM that are shapes of ARKit under another name."""

_VRM: tuple[tuple[str, str], ...] = (
    ("blink", "Blink"),
    ("blinkLeft", "Blink_L"),
    ("blinkRight", "Blink_R"),
    ("lookUp", "LookUp"),
    ("lookDown", "LookDown"),
    ("lookLeft", "LookLeft"),
    ("lookRight", "LookRight"),
    ("aa", "A"),
    ("ih", "I"),
    ("ou", "U"),
    ("ee", "E"),
    ("oh", "O"),
    ("happy", "Joy"),
    ("angry", "Angry"),
    ("sad", "Sorrow"),
    ("relaxed", "Fun"),
    ("surprised", "Surprised"),
    ("neutral", "Neutral"),
)
"""Preset expressions of VRM 1.0 and what VRM 0 calls them.

Vowels and moods are whole faces: no one way to make them of ARKit shapes is agreed on, so they
drive nothing but themselves.
"""

_ROTATIONS = (
    "headYaw",
    "headPitch",
    "headRoll",
    "leftEyeYaw",
    "leftEyePitch",
    "leftEyeRoll",
    "rightEyeYaw",
    "rightEyePitch",
    "rightEyeRoll",
)


def _spellings() -> Iterator[tuple[str, Iterable[str]]]:
    for row in (*ARKIT, *_HALVES):
        yield row.arkit, row
    known = {row.arkit for row in ARKIT}
    yield from ((whole.name, [whole.name]) for whole in _WHOLES if whole.name not in known)
    yield from ((preset, [preset, old]) for preset, old in _VRM)


def _index() -> dict[str, str]:
    index: dict[str, str] = {}
    for shape, spellings in _spellings():
        for key in {spelling.casefold() for spelling in spellings}:
            if key in index:
                raise RuntimeError(f"{key!r} stands for both {index[key]!r} and {shape!r}")
            index[key] = shape
    return index


_SHAPES = _index()
_BY_ARKIT = {row.arkit: row for row in (*ARKIT, *_HALVES)}
_ROTATION_KEYS = frozenset(name.casefold() for name in _ROTATIONS)


def shape_of(name: str) -> str | None:
    """The shape that a name stands for, in ARKit's spelling; None where no table has it.

    A node or namespace in front is ignored: ``shapes.jawOpen``, ``head:jawOpen``.

    Args:
        name: As a rig or a recording has it, in any of the spellings and any capitals.
    """
    found = _SHAPES.get(name.casefold())
    return found if found is not None else _SHAPES.get(_bare(name).casefold())


def spelled(shape: str, style: Style) -> str:
    """The name of an ARKit shape in another spelling.

    Args:
        shape: In ARKit's spelling, such as ``eyeBlinkLeft``.
        style: ``arkit``, ``livelink`` (EyeBlinkLeft), ``sided`` (eyeBlink_L) or ``lower``.

    Raises:
        ParameterError: There is no such shape or style.
    """
    row = _BY_ARKIT.get(shape)
    if row is None:
        raise ParameterError(f"{shape!r} is no shape of ARKit; expected for example 'eyeBlinkLeft'")
    if style == "lower":
        return row.arkit.lower()
    if style not in Spelling._fields:
        raise ParameterError(
            f"unknown spelling {style!r}; expected {', '.join(Spelling._fields)} or lower"
        )
    return str(getattr(row, style))


def is_rotation(name: str) -> bool:
    """Whether a name is an angle of the head or an eye, as Live Link Face records them."""
    return name.casefold() in _ROTATION_KEYS


def wholes() -> tuple[Whole, ...]:
    """Shapes that others make up together, those of two halves before the presets of VRM."""
    return (*_WHOLES, *_VRM_WHOLES)


def _bare(name: str) -> str:
    """A name without the node or namespace in front of it."""
    return name.rpartition(":")[2].rpartition(".")[2]
