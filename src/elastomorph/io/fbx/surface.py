"""Several meshes of an FBX file as one: polygons, texture coordinates, materials and groups."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.fbx.part import FbxPart
from elastomorph.io.fbx.placing import Placing
from elastomorph.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.polygons import Polygons

__all__ = ["joined"]


def joined(parts: Sequence[FbxPart], places: Sequence[Placing], source: str) -> Mesh:
    """The meshes one after another, each with its control points in the order of the file.

    Args:
        parts: At least one mesh.
        places: Where each of them goes; polygons of one that is mirrored are turned around.
        source: The file they come from.

    Raises:
        MeshError: They do not form a mesh.
    """
    orders = [
        _mirrored_corners(part.offsets) if place.mirrors else np.arange(len(part.indices))
        for part, place in zip(parts, places, strict=True)
    ]
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    corners = np.cumsum([0, *(len(part.indices) for part in parts)])
    return Mesh(
        np.concatenate([p.positions(part.vertices) for part, p in zip(parts, places, strict=True)]),
        Polygons(
            np.concatenate(
                [p.indices[o] + s for p, o, s in zip(parts, orders, starts, strict=False)]
            ),
            np.concatenate(
                [[0], *(p.offsets[1:] + c for p, c in zip(parts, corners, strict=False))]
            ),
        ),
        uv=_texture(parts, orders),
        materials=_materials(parts),
        groups=_groups(parts),
        source=Source(source),
    )


def _mirrored_corners(offsets: NDArray[np.int64]) -> NDArray[np.int64]:
    """The corners of each polygon the other way around, from the same first one."""
    sizes = np.diff(offsets)
    within = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes)
    size = np.repeat(sizes, sizes)
    turned: NDArray[np.int64] = np.repeat(offsets[:-1], sizes) + (size - within) % size
    return turned


def _texture(parts: Sequence[FbxPart], orders: Sequence[NDArray[np.int64]]) -> UVMap | None:
    coordinates, corners, count = [], [], 0
    for part, order in zip(parts, orders, strict=True):
        if part.uv is None:
            corners.append(np.full(len(part.indices), -1))
        else:
            coordinates.append(part.uv[0])
            corners.append(part.uv[1][order] + count)
            count += len(part.uv[0])
    if not coordinates:
        return None
    return UVMap(np.concatenate(coordinates), np.concatenate(corners).astype(np.int32))


def _materials(parts: Sequence[FbxPart]) -> FaceLabels | None:
    names: dict[str, int] = {}
    of_face = []
    for part in parts:
        if part.materials is None:
            of_face.append(np.full(len(part.offsets) - 1, -1))
            continue
        own = [names.setdefault(name, len(names)) for name in part.materials[0]]
        of_face.append(np.array([*own, -1])[part.materials[1]])  # the last stands for -1
    return FaceLabels(tuple(names), np.concatenate(of_face).astype(np.int32)) if names else None


def _groups(parts: Sequence[FbxPart]) -> FaceLabels | None:
    names: dict[str, int] = {}
    of_face = [
        np.full(len(part.offsets) - 1, names.setdefault(part.name, len(names))) for part in parts
    ]
    return FaceLabels(tuple(names), np.concatenate(of_face).astype(np.int32))
