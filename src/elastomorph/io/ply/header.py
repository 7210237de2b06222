"""The header of a PLY file: which elements follow, how many, and what each is made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from elastomorph.errors import FormatError

__all__ = ["ENCODINGS", "Element", "PlyHeader", "read_header"]

ENCODINGS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
"""Name of each encoding, and the byte order NumPy knows it by."""

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_LONGEST_HEADER = 1 << 20
_MOST_PROPERTIES = 1000
_LONGEST_NAME = 100


class Property(NamedTuple):
    """A number, or where it has the type of a length, a list of numbers with its length before it.

    The types have the byte order of the file.
    """

    name: str
    kind: np.dtype[np.generic]
    length: np.dtype[np.generic] | None = None


@dataclass(frozen=True)
class Element:
    """A table of the file: ``length`` rows, each with the same properties."""

    name: str
    length: int
    properties: list[Property] = field(default_factory=list)

    def place(self, *names: str) -> int | None:
        """The place of the first property of the first of the names that there is."""
        own = [p.name for p in self.properties]
        return next((own.index(name) for name in names if name in own), None)


class PlyHeader(NamedTuple):
    """The header: byte order (a value of `ENCODINGS`), elements, its bytes and lines, images."""

    order: str
    elements: list[Element]
    size: int
    lines: int
    images: tuple[str, ...]


def read_header(path: str | Path, content: bytes) -> PlyHeader:
    """The header of a PLY file."""
    newline = next((n for n in (b"\r\n", b"\n", b"\r") if content.startswith(b"ply" + n)), None)
    if newline is None:
        raise FormatError(path, "this is not a PLY file: it does not begin with the line 'ply'")
    order: str | None = None
    elements: list[Element] = []
    images: list[str] = []
    line, position = 1, len(b"ply" + newline)
    while True:
        line += 1
        end = content.find(newline, position, _LONGEST_HEADER)
        if end < 0:
            raise FormatError(path, "the header has no line 'end_header'; the file was cut off")
        row = content[position:end]
        words = row.decode("ascii", "backslashreplace").split()
        position = end + len(newline)
        if words == ["end_header"]:
            break
        try:
            if not words or words[0] in ("comment", "obj_info"):
                if words[:2] == ["comment", "TextureFile"]:
                    images.append(row.decode("utf-8", "replace").split(None, 2)[-1].strip())
                continue
            if words[0] == "format":
                order = _order(words)
            elif words[0] == "element":
                elements.append(_element(words))
            elif words[0] == "property" and elements and order is not None:
                elements[-1].properties.append(_property(words, order))
                if len(elements[-1].properties) > _MOST_PROPERTIES:
                    raise ValueError(f"expected at most {_MOST_PROPERTIES:,} properties")
            else:
                raise ValueError("expected format, then element and property, then end_header")
        except ValueError as expected:
            shown = " ".join(words)[:80]
            raise FormatError(path, f"{expected}, found '{shown}'", line=line) from None
    if order is None:
        raise FormatError(path, "the header has no line 'format'")
    return PlyHeader(order, elements, position, line, tuple(images))


def _order(words: list[str]) -> str:
    if len(words) != 3 or words[1] not in ENCODINGS or words[2] != "1.0":
        raise ValueError(f"expected 'format', one of {', '.join(ENCODINGS)}, and version 1.0")
    return ENCODINGS[words[1]]


def _element(words: list[str]) -> Element:
    if (
        len(words) != 3
        or not words[2].isdecimal()
        or len(words[2]) > 18
        or len(words[1]) > _LONGEST_NAME
    ):
        raise ValueError("expected 'element', a name and how many there are")
    return Element(words[1], int(words[2]))


def _property(words: list[str], order: str) -> Property:
    if len(words[-1]) > _LONGEST_NAME:
        raise ValueError(f"expected a name of at most {_LONGEST_NAME} characters")
    if len(words) == 3 and words[1] in _TYPES:
        return Property(words[2], np.dtype(order + _TYPES[words[1]]))
    if len(words) == 5 and words[1] == "list" and words[2] in _TYPES and words[3] in _TYPES:
        count, kind = (np.dtype(order + _TYPES[word]) for word in words[2:4])
        if count.kind in "iu":
            return Property(words[4], kind, count)
    raise ValueError(
        "expected 'property TYPE NAME' or 'property list INTEGER-TYPE TYPE NAME' with types out "
        f"of {', '.join(_TYPES)}"
    )
