"""What the names of targets suggest: where a rotation pays, which shape corrects another."""

from __future__ import annotations

import re
from collections.abc import Sequence

from elastomorph.rig.performance.naming import ARKIT, shape_of, wholes

__all__ = ["arkit_names", "correctives", "missing_arkit", "slider_groups", "turning"]

_TURNING = re.compile(r"jawOpen|eyeBlink|eyeLook|blink|look")
_TURNING_WORDS = re.compile(
    r"jaw[._ -]?(open|drop|down)|mouth[._ -]?open|blink|lid[._ -]?clos", re.I
)
_PARTS = ("brow", "eye", "cheek", "nose", "jaw", "mouth", "tongue")


def arkit_names(names: Sequence[str]) -> dict[str, str]:
    """The names that stand for one of ARKit's 52 shapes, and which."""
    found = {name: shape_of(name) for name in names}
    return {name: shape for name, shape in found.items() if shape in ARKIT}


def missing_arkit(names: Sequence[str]) -> list[str]:
    """The shapes of ARKit that no name stands for, nor two halves, in ARKit's order."""
    known = {shape_of(name) for name in names}
    known |= {whole.name for whole in wholes() if known.issuperset(whole.parts)}
    return [shape for shape in ARKIT if shape not in known]


def turning(names: Sequence[str]) -> list[str]:
    """Targets that turn by their names: jaws that open, lids that close, eyes that look."""
    return [
        name
        for name in names
        if _TURNING.match(shape_of(name) or "") or _TURNING_WORDS.search(name)
    ]


def correctives(names: Sequence[str]) -> dict[str, list[str]]:
    """Shapes that by their names belong on top of others, and what drives them.

    ARKit's mouthClose closes the lips of an open jaw; a name of other names, such as
    ``jawOpen_mouthFunnel``, corrects their sum.
    """
    by_shape = {shape: name for name, shape in arkit_names(names).items()}
    found: dict[str, list[str]] = {}
    if "mouthClose" in by_shape and "jawOpen" in by_shape:
        found[by_shape["mouthClose"]] = [by_shape["jawOpen"], by_shape["mouthClose"]]
    for name in names:
        parts = _joined(name, set(names) - {name})
        if parts:
            found[name] = parts
    return {
        name: drivers
        for name, drivers in found.items()
        if not any(own in found for own in drivers if own != name)
    }


def slider_groups(names: Sequence[str]) -> dict[str, list[str]]:
    """Sliders of one part of the face, or a pattern for just these, where there are two or more."""
    shapes = {name: shape_of(name) or name for name in names}
    found: dict[str, list[str]] = {}
    for part in _PARTS:
        own = [name for name, shape in shapes.items() if shape.startswith(part)]
        begin = own[0][: len(part)] if own else part
        if len(own) > 1:
            pattern = own == [name for name in names if name.startswith(begin)]
            found[part] = [f"{begin}*"] if pattern else own
    return found


def _joined(name: str, others: set[str]) -> list[str]:
    """The names that underscores join into this one; empty where it is not such."""
    words = name.split("_")
    parts: list[str] = []
    start = 0
    while start < len(words):
        # The longest first, so that mouthSmile_L is one name.
        for stop in range(len(words), start, -1):
            part = "_".join(words[start:stop])
            if part in others:
                parts.append(part)
                start = stop
                break
        else:
            return []
    return parts if len(parts) > 1 and len(set(parts)) == len(parts) else []
