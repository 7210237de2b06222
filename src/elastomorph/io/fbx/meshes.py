"""The meshes of an FBX file with their blend shapes, as the worker took them from it, checked."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.blend_shapes import different_names
from elastomorph.io.npz.members import NpzMembers
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.polygons import Polygons

_OBJECTS_OF_MESH = 20  # so many arrays the worker wrote of it


@dataclass(frozen=True, eq=False)
class Channel:
    """A blend shape channel: what one slider does to one mesh."""

    # (K,) weight at which each shape is reached in full; 1 is a slider at 100 %
    weights: tuple[float, ...]
    vertices: tuple[NDArray[np.int64], ...]  # K arrays (N,) of the vertices that each shape moves
    offsets: tuple[NDArray[np.float64], ...]  # K arrays (N, 3) of how far, from the neutral


@dataclass(frozen=True, eq=False)
class FbxMesh:
    """A mesh as the file stores it."""

    name: str  # Name of its node, which is what people see in an outliner
    shown: bool  # Whether its author sees it
    # (4, 3) from geometry to world: what x, y and z become, and the origin
    matrix: NDArray[np.float64]
    vertices: NDArray[np.float64]  # (V, 3) control points in the order of the file
    indices: NDArray[np.int64]  # (C,) control point of each polygon corner
    offsets: NDArray[np.int64]  # (F + 1,) where each polygon starts
    # (T, 2) texture coordinates and (C,) which one each corner uses, if any
    uv: tuple[NDArray[np.float64], NDArray[np.int64]] | None
    # Names of the materials, and (F,) which one each polygon has, if any
    materials: tuple[list[str], NDArray[np.int64]] | None
    channels: dict[str, Channel]  # Blend shape channels by the names of their sliders


def read_axes(members: NpzMembers) -> NDArray[np.float64]:
    """(3, 3) rows: the directions that the file calls right, up and front.

    A file that does not say gets +X, +Y and +Z.
    """
    axes: NDArray[np.float64] = members.array("axes", "f", (3, 3))
    proper = np.array_equal(axes @ axes.T, np.eye(3))
    return axes if proper else np.eye(3)


def read_meshes(path: str | Path, members: NpzMembers) -> list[FbxMesh]:
    """The meshes in what the worker took from a file."""
    names = members.texts("mesh_names")
    members.budget.spend_objects(_OBJECTS_OF_MESH * len(names))
    shown = members.array("mesh_shown", "i", (len(names),)).tolist()
    return [
        _read_mesh(path, members, number, name, bool(own))
        for number, (name, own) in enumerate(zip(names, shown, strict=True))
    ]


def _read_mesh(
    path: str | Path, members: NpzMembers, number: int, name: str, shown: bool
) -> FbxMesh:
    def array(key: str, kinds: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
        return members.array(f"{number}_{key}", kinds, shape)

    def require(holds: bool, problem: str) -> None:
        if not holds:
            raise FormatError(path, f"the mesh '{name[:60]}' {problem}; the file is damaged")

    vertices = array("vertices", "f", (None, 3))
    offsets = array("face_offsets", "i", (None,))
    indices = array("face_indices", "i", (None,))
    require(_within(indices, 0, len(vertices)), "has polygons of points that do not exist")
    matrix = array("matrix", "f", (4, 3))
    require(bool(np.isfinite(matrix).all()), "stands at no place: its transform is not finite")
    uv = None
    if f"{number}_uv_corners" in members.names:
        coordinates = array("uv_coordinates", "f", (None, 2))
        corners = array("uv_corners", "i", (len(indices),))
        # Texture coordinates are dispensable: a face should not be lost for them.
        if _within(corners, 0, len(coordinates)) and np.isfinite(coordinates).all():
            uv = (coordinates, corners)
    materials = None
    if f"{number}_material_of_face" in members.names:
        labels = members.texts(f"{number}_material_names")
        of_face = array("material_of_face", "i", (len(offsets) - 1,))
        if _within(of_face, -1, len(labels)):
            materials = (labels, of_face)
    channel_names = members.texts(f"{number}_channel_names")
    counts = array("key_counts", "i", (len(channel_names),)).tolist()
    weights = array("key_weights", "f", (sum(counts),)).tolist()
    sizes = array("key_sizes", "i", (sum(counts),)).tolist()
    moved = array("key_vertices", "i", (sum(sizes),))
    by = array("key_offsets", "f", (sum(sizes), 3))
    require(_within(moved, 0, len(vertices)), "has shapes of points that do not exist")
    ends = np.cumsum(sizes, dtype=np.int64)[:-1] if sizes else np.empty(0, dtype=np.int64)
    vertices_of = np.split(moved, ends)
    offsets_of = np.split(by, ends)
    starts = np.cumsum([0, *counts])
    channels = {
        channel: Channel(*(tuple(own[start:stop]) for own in (weights, vertices_of, offsets_of)))
        for channel, start, stop in zip(
            different_names(channel_names), starts, starts[1:], strict=False
        )
    }
    return FbxMesh(name, shown, matrix, vertices, indices, offsets, uv, materials, channels)


def _within(indices: NDArray[np.int64], lowest: int, count: int) -> bool:
    return not indices.size or (int(indices.min()) >= lowest and int(indices.max()) < count)


def mesh_of(stored: FbxMesh, source: str) -> Mesh:
    """The mesh in its own space, control points in the order of the file."""
    labels = None
    if stored.materials is not None:
        names, of_face = stored.materials
        known = {name: place for place, name in enumerate(dict.fromkeys(names))}
        places = np.array([*(known[name] for name in names), -1], dtype=np.int32)
        labels = FaceLabels(tuple(known), places[of_face])  # the last stands for -1
    return Mesh(
        stored.vertices,
        Polygons(stored.indices, stored.offsets),
        uv=None if stored.uv is None else UVMap(stored.uv[0], stored.uv[1].astype(np.int32)),
        materials=labels,
        source=Source(source),
    )
