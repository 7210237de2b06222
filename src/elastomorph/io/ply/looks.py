"""Images on the polygons of a PLY, as programs of photogrammetry write them.

PLY itself knows of none. By common use the header names them in lines ``comment TextureFile``, the
polygons have a list ``texcoord`` of u and v for each corner and ``texnumber``, which image they
show; or the vertices have ``s`` and ``t``, also called ``u`` and ``v``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.atomic import is_file, read_bytes
from elastomorph.io.images_beside import image_beside
from elastomorph.io.ply.header import PlyHeader, read_header
from elastomorph.io.ply.mesh import Column, columns_of, require_surface
from elastomorph.model.appearance import Material
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap

__all__ = ["with_ply_looks"]

_OF_VERTICES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


def with_ply_looks(mesh: Mesh) -> Mesh:
    """A mesh with the images that its PLY names; any other is returned as it is.

    An image that cannot be had is a `Texture` without content, which says why.

    Raises:
        FileError: The file cannot be read.
        FormatError: It is damaged, or its coordinates are not two for each corner.
    """
    if mesh.source is None or not is_file(mesh.source.path):
        return mesh
    path = Path(mesh.source.path)
    content = read_bytes(path)
    header = read_header(path, content)
    require_surface(path, header)
    uv = _coordinates(path, content, header, mesh) if header.images else None
    if uv is None:
        return mesh
    used = _used(path, content, header, mesh)
    textures = {name: image_beside(path.parent, name) for name in header.images}
    names = tuple(textures)
    of_image = np.array([names.index(name) for name in header.images], dtype=np.int32)
    within = (used >= 0) & (used < len(of_image))
    labels = np.where(within, of_image[np.where(within, used, 0)], -1).astype(np.int32)
    looks = {name: Material(texture=texture) for name, texture in textures.items()}
    return Mesh(
        mesh.vertices,
        mesh.faces,
        uv,
        FaceLabels(names, labels),
        source=mesh.source,
        appearance=looks,
    )


def _coordinates(path: Path, content: bytes, header: PlyHeader, mesh: Mesh) -> UVMap | None:
    """Those of corners, or of vertices; None where there are neither."""
    faces = next((own for own in header.elements if own.name == "face"), None)
    if faces is not None and faces.place("texcoord") is not None:
        column = columns_of(path, content, header, {"face": ("texcoord",)})["texcoord"]
        if not np.array_equal(column.sizes, 2 * mesh.faces.sizes):
            raise FormatError(path, "'texcoord' needs two numbers for each corner of a polygon")
        return UVMap(
            column.values.reshape(-1, 2).astype(np.float64),
            np.arange(len(mesh.faces.indices), dtype=np.int32),
        )
    vertices = next(own for own in header.elements if own.name == "vertex")
    for pair in _OF_VERTICES:
        if all(vertices.place(name) is not None for name in pair):
            found = columns_of(path, content, header, {"vertex": pair})
            values = np.stack([_one(path, found[name]) for name in pair], axis=1)
            return UVMap(values.astype(np.float64), mesh.faces.indices.astype(np.int32))
    return None


def _used(path: Path, content: bytes, header: PlyHeader, mesh: Mesh) -> NDArray[np.int64]:
    """(F,) which image each polygon shows."""
    faces = next((own for own in header.elements if own.name == "face"), None)
    if faces is None or faces.place("texnumber") is None:
        return np.zeros(len(mesh.faces), dtype=np.int64)
    column = columns_of(path, content, header, {"face": ("texnumber",)})["texnumber"]
    return _one(path, column).astype(np.int64)


def _one(path: Path, column: Column) -> NDArray[Any]:
    """The numbers of a property that is no list."""
    if not (column.sizes == 1).all():
        raise FormatError(path, "texture coordinates of vertices are numbers, found lists")
    return column.values
