"""Lists of vertices that people keep in files: curves, and regions.

Curves, drawn by artists or extracted, are JSON in one of two forms. The full form names what it
holds::

    {"vertex_count": 26719,
     "curves": [{"vertices": [4, 8, 15], "closed": true, "name": "upper lip"}]}

The bare form is a list of vertex lists, ``[[4, 8, 15, 4], [16, 23]]``, in which a curve is closed
when its last vertex repeats its first. Vertices are indices from 0, or the names of markers.

A region is a JSON list of indices, ``[3, 4, 5]`` or ``{"vertices": [3, 4, 5]}``, or a text of
ranges, ``0-9408,11248``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import read_bytes, replacing
from elastomorph.io.untrusted import shortened

_EXPECTED = (
    'expected {"curves": [{"vertices": [0, 1, 2], "closed": false, "name": "brow"}, ...]} '
    "or a list of vertex lists [[0, 1, 2], ...]"
)
_SHOWN = 40
_INDEX = re.compile("[0-9]{1,9}")
# No mesh is as large; a mistyped range must not fill the memory.
_MOST_VERTICES = 1 << 24


def read_curves(
    path: str | Path, vertex_count: int, vertex_names: Sequence[str] | None = None
) -> tuple[Curve, ...]:
    """The curves in a file, checked against the mesh they are for."""
    content = _parsed(path)
    entries = content
    if isinstance(content, dict):
        entries = content.get("curves")
        meant = content.get("vertex_count", vertex_count)
        if meant != vertex_count or isinstance(meant, bool):
            raise FormatError(
                path,
                f"these curves are for a mesh of {_shown(meant)} vertices, this mesh has "
                f"{vertex_count}; extract or draw the curves on this mesh",
            )
    if not isinstance(entries, list):
        raise FormatError(path, f"this is no list of curves: {_EXPECTED}")
    if not entries:
        raise FormatError(path, f"the file holds no curves: {_EXPECTED}")
    indices: dict[str, int] = {}
    for vertex, name in enumerate(vertex_names or ()):
        indices[name] = -1 if name in indices else vertex  # -1: several have this name
    curves: list[Curve] = []
    curve_of: dict[int, str] = {}
    for number, entry in enumerate(entries):
        reader = _EntryReader(path, number, entry, vertex_count, indices)
        curve = reader.curve()
        for vertex in curve.vertices.tolist():
            if vertex in curve_of:
                reader.refuse(
                    f"vertex {reader.named(vertex)} lies on {curve_of[vertex]} already; a vertex "
                    "can lie on one curve only"
                )
            curve_of[vertex] = reader.title
        curves.append(curve)
    return tuple(curves)


def write_curves(path: str | Path, network: CurveNetwork) -> None:
    """Write curves in the full form, one to a line."""
    lines = []
    for curve in network:
        entry: dict[str, Any] = {"vertices": curve.vertices.tolist(), "closed": curve.closed}
        if curve.name:
            entry["name"] = curve.name
        lines.append(json.dumps(entry, ensure_ascii=False))
    text = (
        f'{{"vertex_count": {network.vertex_count},\n "curves": [\n' + ",\n".join(lines) + "\n]}\n"
    )
    with replacing(path) as file:
        file.write(text.encode("utf-8", "surrogatepass"))


def _parsed(path: str | Path) -> Any:
    raw = read_bytes(path)
    if not raw.strip():
        raise FormatError(path, f"the file is empty: {_EXPECTED}")

    def refuse_constant(name: str) -> NoReturn:
        raise FormatError(path, f"found {name}; vertices are whole numbers from 0")

    try:
        return json.loads(raw, parse_constant=refuse_constant)
    except json.JSONDecodeError as error:
        raise FormatError(path, f"not JSON: {error.msg}", line=error.lineno) from None
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise FormatError(path, "not JSON: the text is not UTF-8", line=line) from None
    except RecursionError:
        raise FormatError(path, f"lists are nested too deeply: {_EXPECTED}") from None
    except ValueError:
        raise FormatError(path, "a number in the file has too many digits") from None


class _EntryReader:
    """Reads one curve, and knows how to name it in a complaint."""

    def __init__(
        self, path: str | Path, number: int, entry: Any, count: int, indices: Mapping[str, int]
    ) -> None:
        self.path = path
        self.title = f"curve {number}"
        self.vertex_count = count
        self.indices = indices
        self.fields: dict[str, Any] = entry if isinstance(entry, dict) else {"vertices": entry}
        name = self.fields.get("name", "")
        if not isinstance(name, str):
            self.refuse(f"its name must be text, found {_shown(name)}")
        if name:
            self.title += f" ({_shown(name)})"

    def refuse(self, problem: str) -> NoReturn:
        raise FormatError(self.path, f"{self.title}: {problem}")

    def named(self, vertex: int) -> str:
        """A vertex as the file may have written it."""
        for name, index in self.indices.items():
            if index == vertex:
                return f"{vertex} ({_shown(name)})"
        return str(vertex)

    def curve(self) -> Curve:
        for key in self.fields:
            if key not in ("vertices", "closed", "name"):
                self.refuse(f"unknown key {_shown(key)}; a curve has vertices, closed and name")
        given = self.fields.get("vertices")
        if not isinstance(given, list):
            self.refuse(f"its vertices must be a list of indices, found {_shown(given)}")
        vertices = [self._vertex(item) for item in given]
        closed = self.fields.get("closed")
        if closed is None:
            closed = len(vertices) > 1 and vertices[0] == vertices[-1]
            vertices = vertices[:-1] if closed else vertices
        if not isinstance(closed, bool):
            self.refuse(f'"closed" must be true or false, found {_shown(closed)}')
        if not vertices:
            self.refuse("it has no vertices; a curve needs at least one")
        seen: set[int] = set()
        for vertex in vertices:
            if vertex in seen:
                self.refuse(f"it passes through vertex {self.named(vertex)} twice")
            seen.add(vertex)
        if closed and len(vertices) < 3:
            self.refuse(f"it is closed but has {len(vertices)} vertices; it needs at least 3")
        return Curve(vertices, closed, self.fields.get("name", ""))

    def _vertex(self, item: Any) -> int:
        if isinstance(item, str):
            if not self.indices:
                self.refuse(
                    f"vertex {_shown(item)} is a name, but the vertices of this mesh have none; "
                    f"use indices from 0 to {self.vertex_count - 1}"
                )
            if item not in self.indices:
                self.refuse(f"vertex {_shown(item)} does not exist among the names of this mesh")
            if self.indices[item] < 0:
                self.refuse(f"vertex {_shown(item)} is the name of several vertices; use indices")
            return self.indices[item]
        if isinstance(item, bool) or not isinstance(item, int):
            self.refuse(f"vertex {_shown(item)} is not a whole number")
        if not 0 <= item < self.vertex_count:
            self.refuse(
                f"vertex {_shown(item)} does not exist; the mesh has {self.vertex_count} "
                f"vertices (0 to {self.vertex_count - 1})"
            )
        return item


def _shown(value: Any) -> str:
    """A value from the file, short enough for a message."""
    if isinstance(value, int) and abs(value) >= 10**_SHOWN:
        return "a number too large to show"
    if isinstance(value, list | dict):
        return "a list" if isinstance(value, list) else "an object"
    text = json.dumps(value, ensure_ascii=True)
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "…"


def read_region(region: str | Path) -> NDArray[np.int64]:
    """(N,) vertex indices: from a JSON file, or of at most 16,777,216 vertices in ranges."""
    text = str(region)
    if not text.lower().endswith(".json"):
        return _ranges(text)
    try:
        content = json.loads(read_bytes(region))
    except (ValueError, RecursionError) as error:
        raise FormatError(region, f"not JSON: {shortened(error)}") from None
    if isinstance(content, dict):
        content = content.get("vertices")
    if not isinstance(content, list) or not all(
        isinstance(i, int) and not isinstance(i, bool) and 0 <= i < 2**31 for i in content
    ):
        raise FormatError(region, "expected a list of vertex indices, such as [3, 4, 5]")
    return np.array(content, dtype=np.int64)


def _ranges(text: str) -> NDArray[np.int64]:
    parts: list[NDArray[np.int64]] = []
    count = 0
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not all(_INDEX.fullmatch(number) for number in ([first, last] if dash else [first])):
            raise ParameterError(
                f"region {_cited(text)}: expected a .json file or ranges such as 0-9408,11248"
            )
        start, stop = int(first), int(last) if dash else int(first)
        count += stop + 1 - start
        if stop < start or count > _MOST_VERTICES:
            raise ParameterError(
                f"region {_cited(text)}: the range {_cited(part.strip())} is empty or too large"
            )
        parts.append(np.arange(start, stop + 1))
    return np.concatenate(parts)


def _cited(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:60] + "…")
