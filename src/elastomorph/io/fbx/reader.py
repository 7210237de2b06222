"""Reads the rig in an FBX file: its meshes as one face, its blend shape channels as sliders.

What a technical animator would otherwise do by hand:

- the meshes that can be seen (the first level of detail only) become one, in the order of the file:
  control points keep their order within each, and a channel that several of them have, such as
  ``jawOpen`` of head and teeth, is one slider. Meshes without shapes are part of the neutral;
- a channel with in-between shapes becomes a path through them, straight from one to the next as in
  the program it comes from;
- positions are those stored, turned upright (see `elastomorph.io.joined_rig`). Skinning, poses and
  animation are not applied.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import (
    FormatError,
    MissingExtraError,
    ParameterError,
    warn,
)
from elastomorph.io.blend_shapes import different_names, hats
from elastomorph.io.choices import ListedMesh, chosen_meshes, wanted_names
from elastomorph.io.fbx.worker import ADVICE
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.joined_rig import RigPart, joined_rig, placings
from elastomorph.io.npz.members import NpzMembers
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons
from elastomorph.rig import Rig

_OBJECTS_OF_MESH = 20  # so many arrays the worker wrote of it
_READER = IsolatedReader("elastomorph.io.fbx.worker", "the reader of FBX files", ADVICE)


@dataclass(frozen=True, eq=False)
class Channel:
    """A blend shape channel: what one slider does to one mesh."""

    weights: tuple[float, ...]  # (K,) at which each shape is reached in full; 1 is 100 %
    vertices: tuple[NDArray[np.int64], ...]  # K arrays (N,) of the vertices that each shape moves
    offsets: tuple[NDArray[np.float64], ...]  # K arrays (N, 3) of how far, from the neutral


@dataclass(frozen=True, eq=False)
class FbxMesh:
    """A mesh as the file stores it."""

    name: str  # Name of its node, which is what people see in an outliner
    shown: bool  # Whether its author sees it
    matrix: NDArray[np.float64]  # (4, 3) to the world: what x, y and z become, and the origin
    vertices: NDArray[np.float64]  # (V, 3) control points in the order of the file
    indices: NDArray[np.int64]  # (C,) control point of each polygon corner
    offsets: NDArray[np.int64]  # (F + 1,) where each polygon starts
    # (T, 2) texture coordinates and (C,) which one each corner uses, if any
    uv: tuple[NDArray[np.float64], NDArray[np.int64]] | None
    # Names of the materials, and (F,) which one each polygon has, if any
    materials: tuple[list[str], NDArray[np.int64]] | None
    channels: dict[str, Channel]  # Blend shape channels by the names of their sliders


def read_fbx(
    path: str | Path, *, mesh: str | Sequence[str] | None = None, still: bool = False
) -> Rig:
    """The rig in an FBX file, binary or text.

    Args:
        path: The file.
        mesh: Name of the mesh to read, or names of several, with or without shapes. By default
            all that are shown.
        still: Read meshes without any shapes too, as a rig without morphs.

    Returns:
        The rig, in the order of the file; the mesh with most channels gives unit and origin. At
        weight 1 of a slider its last shape is reached, whatever full weight the file gives it.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is not FBX, is damaged, has no blend shapes or no mesh of a name, or broke
            its reader.
        MissingExtraError: ufbx is not installed.
        ParameterError: An empty list of names.
    """
    wanted = wanted_names(mesh)
    if find_spec("ufbx") is None:
        raise MissingExtraError("ufbx", "fbx")
    with extracted(_READER, path) as members:
        # rows: the directions that the file calls right, up and front; one may not say
        axes = members.array("axes", "f", (3, 3))
        if not np.array_equal(axes @ axes.T, np.eye(3)):
            axes = np.eye(3)
        meshes = _chosen(path, read_meshes(path, members), wanted, still=still)
    main = max(range(len(meshes)), key=lambda number: len(meshes[number].channels))
    vertices = sum(len(own.vertices) for own in meshes)
    shapes = sum(len(c.weights) for own in meshes for c in own.channels.values())
    members.budget.spend_fields(vertices, shapes, copies=2)
    with naming_file(path):
        parts = []
        for own, place in zip(meshes, placings(axes, meshes, main), strict=True):
            neutral = mesh_of(own, str(path))
            morphs = {n: _morph(path, neutral, n, channel) for n, channel in own.channels.items()}
            parts.append(RigPart(own.name, neutral, morphs, place))
        return Rig(*joined_rig(parts, str(path)))


def _chosen(
    path: str | Path, meshes: list[FbxMesh], wanted: Sequence[str], *, still: bool
) -> list[FbxMesh]:
    listed = [ListedMesh((own.name,), len(own.channels), own.shown) for own in meshes]
    try:
        chosen = [meshes[number] for number in chosen_meshes(listed, wanted, need_shapes=not still)]
    except ParameterError as problem:
        raise FormatError(path, str(problem)) from None
    # Objects without points show nothing; exporters leave them where something was.
    return [own for own in chosen if len(own.vertices) or own.channels] or chosen


def _morph(path: str | Path, neutral: Mesh, name: str, channel: Channel) -> Morph:
    """What a slider does to one mesh."""
    times, offsets = _path(path, name, channel, len(neutral.vertices))
    between = np.array(times[:-1])
    bends = [own - time * offsets[-1] for time, own in zip(between, offsets[:-1], strict=True)]
    curved = [(bend, curve) for bend, curve in zip(bends, hats(between), strict=True) if bend.any()]
    return Morph(
        neutral,
        neutral.with_vertices(neutral.vertices + offsets[-1]),
        np.array([bend for bend, _ in curved]).reshape(-1, *neutral.vertices.shape),
        tuple(curve for _, curve in curved),
        method="in-betweens" if curved else "linear",
        bare=not curved,
    )


def _path(
    path: str | Path, name: str, channel: Channel, count: int
) -> tuple[list[float], list[NDArray[np.float64]]]:
    """Rising times up to 1 at which a channel reaches its shapes, and (V, 3) of each."""
    keys = sorted(range(len(channel.weights)), key=lambda key: channel.weights[key])
    forward = [key for key in keys if channel.weights[key] > 0]
    if not forward:
        forward = keys[-1:]  # a full weight of 0 means nothing; the shape still does
    last = channel.weights[forward[-1]] or 1.0
    times = ((channel.weights[key] / last, key) for key in forward)
    by_time = {time: key for time, key in times if 0 < time < 1}
    by_time[1.0] = forward[-1]
    if len(by_time) < len(keys):
        warn(
            f"{path}: the channel '{name[:60]}' has {len(keys)} shapes, of which {len(by_time)} "
            "are kept: those at weights of 0 or below, or at one weight with another, lie on no "
            "path from 0 to 1"
        )
    shapes = []
    for key in by_time.values():
        dense = np.zeros((count, 3))
        np.add.at(dense, channel.vertices[key], channel.offsets[key])
        shapes.append(dense)
    return list(by_time), shapes


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
