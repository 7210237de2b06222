"""What a camera writes about a photograph: the EXIF segment of a JPEG.

CIPA DC-008, Exif 2.32: a TIFF of two folders, the second found through tag 0x8769.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from math import hypot

__all__ = ["Exif", "equivalent"]

_ASCII, _SHORT, _LONG, _RATIONAL = 2, 3, 4, 5
_SIZES = {_ASCII: 1, _SHORT: 2, _LONG: 4, _RATIONAL: 8}
_FILM_DIAGONAL = hypot(36, 24)  # mm


def equivalent(focal: float, size: tuple[int, int]) -> float:
    """The focal length in mm that has the same field of view on 35 mm film, by the diagonal."""
    return _FILM_DIAGONAL * focal / hypot(*size)


@dataclass(frozen=True)
class Exif:
    """What is written.

    Attributes:
        make: Who made the camera.
        model: Its model.
        focal: Focal length in mm.
        equivalent: On 35 mm film, in whole mm as cameras write it.
        size: Width and height of the photograph as stored.
        orientation: 1 as stored; 3, 6, 8 where it must be turned by 180°, 90° and -90° clockwise.
        taken: Date and time as ``YYYY:MM:DD HH:MM:SS``.
    """

    make: str
    model: str
    focal: float
    equivalent: int
    size: tuple[int, int]
    orientation: int = 1
    taken: str = "2026:01:01 12:00:00"

    def into(self, jpeg: bytes) -> bytes:
        """The JPEG with this segment in front, in place of the JFIF header of the encoder."""
        if not jpeg.startswith(b"\xff\xd8"):
            raise ValueError("a JPEG starts with the bytes FF D8")
        rest = jpeg[2:]
        if rest[:2] == b"\xff\xe0":
            rest = rest[2 + struct.unpack(">H", rest[2:4])[0] :]
        content = b"Exif\x00\x00" + self._tiff()
        return b"\xff\xd8\xff\xe1" + struct.pack(">H", len(content) + 2) + content + rest

    def _tiff(self) -> bytes:
        width, height = self.size
        first = [
            (0x010F, _ASCII, self.make),
            (0x0110, _ASCII, self.model),
            (0x0112, _SHORT, self.orientation),
            (0x8769, _LONG, 0),
        ]
        second = [
            (0x9003, _ASCII, self.taken),
            (0x920A, _RATIONAL, (round(self.focal * 1000), 1000)),
            (0xA002, _LONG, width),
            (0xA003, _LONG, height),
            (0xA405, _SHORT, self.equivalent),
        ]
        start = 8
        after = start + len(_folder(first, start))
        first[-1] = (0x8769, _LONG, after)
        return (
            b"MM\x00\x2a"
            + struct.pack(">I", start)
            + _folder(first, start)
            + _folder(second, after)
        )


def _folder(entries: list[tuple[int, int, object]], start: int) -> bytes:
    """A folder that begins at this byte: its entries, then what is too long for them."""
    entry, long = b"", b""
    place = start + 2 + 12 * len(entries) + 4
    for tag, kind, value in entries:
        content = _content(kind, value)
        entry += struct.pack(">HHI", tag, kind, len(content) // _SIZES[kind])
        if len(content) > 4:
            entry += struct.pack(">I", place + len(long))
            long += content + b"\x00" * (len(content) % 2)
        else:
            entry += content.ljust(4, b"\x00")
    return struct.pack(">H", len(entries)) + entry + b"\x00" * 4 + long


def _content(kind: int, value: object) -> bytes:
    if kind == _ASCII:
        return str(value).encode("ascii") + b"\x00"
    if kind == _RATIONAL:
        return struct.pack(">II", *value)  # type: ignore[misc]
    return struct.pack(">H" if kind == _SHORT else ">I", value)
