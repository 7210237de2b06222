"""Writes Wavefront OBJ text: every number as the shortest decimal that reads back bit for bit."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.atomic import replacing
from elastomorph.io.obj_statements import name_in, without_comment
from elastomorph.mesh import FaceLabels, Mesh

__all__ = ["write_obj"]


def write_obj(path: str | Path, mesh: Mesh) -> None:
    """Write a mesh as OBJ: vertices, polygons, texture coordinates, materials and groups.

    Reading the file gives back the same mesh, coordinates bit for bit.

    Args:
        path: The file; its folder must exist. A file that is there is replaced at once.
        mesh: The mesh.

    Raises:
        FileError: The file cannot be written.
        FormatError: A name or a texture coordinate is nothing that OBJ text can hold.
    """
    lines: list[str] = []
    if mesh.material_library is not None:
        lines.append(f"mtllib {_writable(path, mesh.material_library, 'mtllib')}")
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    if mesh.uv is not None:
        if not np.isfinite(mesh.uv.coordinates).all():
            raise FormatError(path, "texture coordinates that are not finite cannot be written")
        lines += ["vt " + " ".join(map(repr, row)) for row in mesh.uv.coordinates.tolist()]
    switches = _switches(path, mesh)
    for face, statement in enumerate(_faces(mesh)):
        if face in switches:
            lines += switches[face]
        lines.append(statement)
    content = "\n".join([*lines, ""]).encode("utf-8")
    with replacing(path) as file:
        file.write(content)


def _faces(mesh: Mesh) -> Iterator[str]:
    """One ``f`` statement a polygon."""
    corners = list(map(str, (mesh.faces.indices + 1).tolist()))
    if mesh.uv is not None:
        coordinates = (mesh.uv.corners + 1).tolist()
        corners = [
            f"{corner}/{coordinate}" if coordinate else corner
            for corner, coordinate in zip(corners, coordinates, strict=True)
        ]
    offsets = mesh.faces.offsets.tolist()
    for start, stop in pairwise(offsets):
        yield "f " + " ".join(corners[start:stop])


def _switches(path: str | Path, mesh: Mesh) -> dict[int, list[str]]:
    """The ``g`` and ``usemtl`` statements that go before a polygon, by polygon."""
    switches: dict[int, list[str]] = {}
    for keyword, labels in (("g", mesh.groups), ("usemtl", mesh.materials)):
        if labels is None:
            continue
        used: NDArray[np.int32] = np.unique(labels.of_face[labels.of_face >= 0])
        statements = {-1: keyword}
        for name in used.tolist():
            statements[name] = f"{keyword} {_writable(path, labels.names[name], keyword)}"
        for face in _changes(labels):
            switches.setdefault(face, []).append(statements[int(labels.of_face[face])])
    return switches


def _changes(labels: FaceLabels) -> list[int]:
    """The polygons whose label is not that of the one before; none comes before the first."""
    faces: list[int] = np.flatnonzero(np.diff(labels.of_face, prepend=np.int32(-1))).tolist()
    return faces


def _writable(path: str | Path, name: str, keyword: str) -> str:
    """The name, if a reader of OBJ would get back just that."""
    try:
        statement = f"{keyword} {name}".encode()
        lines = statement.replace(b"\r", b"\n").split(b"\n")
        read_back = name_in(without_comment(lines[0], keyword.encode()))
    except UnicodeEncodeError:
        read_back = ""
    if not name or read_back != name or b"\0" in statement or statement.endswith(b"\\"):
        raise FormatError(
            path,
            f"the name {name!r} cannot be written as '{keyword}' of an OBJ file: it must be one "
            "line of text without blanks at its ends, a lone # or a final backslash",
        )
    return name
