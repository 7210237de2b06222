"""A mesh with its vertices, polygons and corners in the order of another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.relabelling import turned_corners
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.polygons import Polygons

__all__ = ["reordered", "turned"]


def turned(mesh: Mesh, wrong: NDArray[np.bool_]) -> Mesh:
    """A mesh with some polygons run the other way round; every corner keeps its texture.

    Args:
        mesh: The mesh.
        wrong: (F,) which polygons.
    """
    corners = turned_corners(mesh.faces, wrong)
    return Mesh(
        mesh.vertices,
        Polygons(mesh.faces.indices[corners], mesh.faces.offsets),
        uv=mesh.uv and UVMap(mesh.uv.coordinates, mesh.uv.corners[corners]),
        materials=mesh.materials,
        groups=mesh.groups,
        material_library=mesh.material_library,
        source=mesh.source,
    )


def reordered(
    neutral: Mesh, target: Mesh, new_index: NDArray[np.int64], corners: NDArray[np.int64]
) -> Mesh:
    """The target in the order of the neutral, with labels and texture of its own.

    Args:
        neutral: The neutral.
        target: A target with as many vertices and polygon corners.
        new_index: (V,) number in the neutral of each vertex of the target.
        corners: (C,) corner of the target for each corner of the neutral.
    """
    vertices = np.empty_like(target.vertices)
    vertices[new_index] = target.vertices
    faces = target.faces.corner_faces[corners[neutral.faces.offsets[:-1]]]
    source = target.source
    if source is not None and source.face_lines is not None:
        source = replace(source, face_lines=source.face_lines[faces])
    return Mesh(
        vertices,
        neutral.faces,
        uv=target.uv and UVMap(target.uv.coordinates, target.uv.corners[corners]),
        materials=_moved(target.materials, faces),
        groups=_moved(target.groups, faces),
        material_library=target.material_library,
        source=source,
    )


def _moved(labels: FaceLabels | None, faces: NDArray[np.int32]) -> FaceLabels | None:
    """Labels in another order of polygons; their names stay in order of first use."""
    if labels is None:
        return None
    of_face = labels.of_face[faces]
    used, firsts = np.unique(of_face[of_face >= 0], return_index=True)
    order = used[np.argsort(firsts)]
    number = np.full(len(labels.names) + 1, -1, dtype=np.int32)
    number[order] = np.arange(len(order), dtype=np.int32)
    return FaceLabels(tuple(labels.names[i] for i in order.tolist()), number[of_face])
