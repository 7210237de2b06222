"""A mesh of an FBX file as one of ours: polygons, texture coordinates and materials."""

from __future__ import annotations

import numpy as np

from elastomorph.io.fbx.part import FbxPart
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.polygons import Polygons

__all__ = ["mesh_of"]


def mesh_of(part: FbxPart, source: str) -> Mesh:
    """The mesh in its own space, control points in the order of the file.

    Args:
        part: The mesh as the file stores it.
        source: The file it comes from.

    Raises:
        MeshError: It is none.
    """
    labels = None
    if part.materials is not None:
        names, of_face = part.materials
        known = {name: place for place, name in enumerate(dict.fromkeys(names))}
        places = np.array([*(known[name] for name in names), -1], dtype=np.int32)
        labels = FaceLabels(tuple(known), places[of_face])  # the last stands for -1
    return Mesh(
        part.vertices,
        Polygons(part.indices, part.offsets),
        uv=None if part.uv is None else UVMap(part.uv[0], part.uv[1].astype(np.int32)),
        materials=labels,
        source=Source(source),
    )
