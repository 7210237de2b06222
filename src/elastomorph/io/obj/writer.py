"""Writes Wavefront OBJ text: every number as the shortest decimal that reads back bit for bit."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.atomic import replacing
from elastomorph.io.obj.statements import is_continued, name_in, without_comment
from elastomorph.model.mesh import Mesh

__all__ = ["write_obj"]


def write_obj(path: str | Path, mesh: Mesh) -> None:
    """Write a mesh as OBJ: vertices, polygons, texture coordinates, materials and groups.

    Reading the file gives back the same mesh, coordinates bit for bit. Names stand in it as in the
    file that the mesh was read from, if that was OBJ, and in UTF-8 otherwise.
    """
    lines: list[str] = []
    encoding = _encoding(mesh)
    if mesh.material_library is not None:
        lines.append(_naming(path, "mtllib", mesh.material_library, encoding))
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    if mesh.uv is not None:
        if not np.isfinite(mesh.uv.coordinates).all():
            raise FormatError(path, "texture coordinates that are not finite cannot be written")
        lines += ["vt " + " ".join(map(repr, row)) for row in mesh.uv.coordinates.tolist()]
    switches = _switches(path, mesh, encoding)
    for face, statement in enumerate(_faces(mesh)):
        if face in switches:
            lines += switches[face]
        lines.append(statement)
    content = "\n".join([*lines, ""]).encode(encoding)
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
    for start, stop in pairwise(mesh.faces.offsets.tolist()):
        yield "f " + " ".join(corners[start:stop])


def _switches(path: str | Path, mesh: Mesh, encoding: str) -> dict[int, list[str]]:
    """The ``g`` and ``usemtl`` statements that go before a polygon, by polygon."""
    switches: dict[int, list[str]] = {}
    for keyword, labels in (("g", mesh.groups), ("usemtl", mesh.materials)):
        if labels is None:
            continue
        used: NDArray[np.int32] = np.unique(labels.of_face[labels.of_face >= 0])
        statements = {-1: keyword}
        for name in used.tolist():
            statements[name] = _naming(path, keyword, labels.names[name], encoding)
        # where the label is not that of the polygon before; none comes before the first
        for face in np.flatnonzero(np.diff(labels.of_face, prepend=np.int32(-1))).tolist():
            switches.setdefault(face, []).append(statements[int(labels.of_face[face])])
    return switches


def _encoding(mesh: Mesh) -> str:
    """That of the file the mesh came from, unless a name has been added that it cannot hold."""
    names = [name for labels in (mesh.materials, mesh.groups) if labels for name in labels.names]
    encoding = mesh.source.encoding if mesh.source else "utf-8"
    try:
        "\n".join([*names, mesh.material_library or ""]).encode(encoding)
    except UnicodeEncodeError:
        return "utf-8"
    return encoding


def _naming(path: str | Path, keyword: str, name: str, encoding: str) -> str:
    """The statement, if a reader of OBJ would get back just that name."""
    try:
        statement = f"{keyword} {name}".encode(encoding)
        lines = statement.replace(b"\r", b"\n").split(b"\n")
        kept = name_in(without_comment(lines[0], keyword.encode())) == name.encode(encoding)
    except UnicodeEncodeError:
        kept = False
    if not (name and kept) or b"\0" in statement or is_continued(statement, keyword.encode()):
        raise FormatError(
            path,
            f"the name {name!r} cannot be written as '{keyword}' of an OBJ file: it must be one "
            "line of text without blanks at its ends, a lone # or a final backslash",
        )
    return f"{keyword} {name}"
