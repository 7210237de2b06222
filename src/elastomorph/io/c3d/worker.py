"""Takes the markers out of a C3D file, in a process that may crash."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from itertools import count, takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.isolated import RefusedError, serve

ADVICE = "export it again from the program that recorded it, with Intel byte order"

_KEY = 0x50  # second byte of a header that stands at the start of the file


def content_of(source: str) -> dict[str, NDArray[Any]]:
    """Markers of a file; a RefusedError where it is no C3D file, or a damaged one."""
    import ezc3d

    try:
        taken = ezc3d.c3d(source)
    except MemoryError:
        raise
    except Exception as error:  # its own, of the standard library of C++ and of Python
        said = str(error).partition(",")[0][:200]
        raise RefusedError(
            f"it cannot be read as C3D ({said}): it is damaged, cut off or another format; {ADVICE}"
        ) from error
    points = taken["parameters"]["POINT"]
    positions = taken["data"]["points"][:3]
    rate = _first(points, "RATE") or taken["header"]["points"]["frame_rate"]
    return {
        "positions": positions.transpose(2, 1, 0).astype(np.float64),
        "names": np.array(_names(points, positions.shape[1]), dtype=np.str_),
        "announced": np.array(_announced(source)),
        "rate": np.array(float(rate)),
        "unit": np.array(_text(_first(points, "UNITS") or ""), dtype=np.str_),
    }


def _names(points: Mapping[str, Any], size: int) -> list[str]:
    """One for each marker, its number where it has none; beyond 255 there are further lists."""
    lists = takewhile(points.__contains__, (f"LABELS{n}" if n > 1 else "LABELS" for n in count(1)))
    names = [_text(name) for called in lists for name in points[called]["value"]]
    return [name or str(number) for number, name in enumerate((names + [""] * size)[:size])]


def _announced(source: str) -> int:
    """Frames that the header says there are; the library forgets that of a file cut off."""
    with Path(source).open("rb") as file:
        key, first, last = struct.unpack("<xB4xHH", file.read(10))
    return max(0, last - first + 1) if key == _KEY else 0


def _first(points: Mapping[str, Any], name: str) -> Any:
    """The first value of a parameter; units, for one, may be said of each marker."""
    values = list(points[name]["value"]) if name in points else []
    return values[0] if values else None


def _text(found: str) -> str:
    """Names of old programs are Latin-1, which the library hands on byte by byte."""
    raw = found.encode("utf-8", "surrogateescape").strip(b" \0")
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def _prepare() -> None:
    import ezc3d  # noqa: F401


if __name__ == "__main__":
    serve(_prepare, content_of)
