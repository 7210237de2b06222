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

import warnings
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import (
    ElastomorphWarning,
    FormatError,
    MissingExtraError,
    ParameterError,
)
from elastomorph.io.blend_shapes import hats
from elastomorph.io.choices import ListedMesh, chosen_meshes, wanted_names
from elastomorph.io.fbx.meshes import Channel, FbxMesh, mesh_of, read_axes, read_meshes
from elastomorph.io.fbx.worker import ADVICE
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.joined_rig import Placing, RigPart, joined_rig, placings
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig

__all__ = ["read_fbx"]

_READER = IsolatedReader("elastomorph.io.fbx.worker", "the reader of FBX files", ADVICE)


def read_fbx(path: str | Path, *, mesh: str | Sequence[str] | None = None) -> Rig:
    """The rig in an FBX file, binary or text.

    Args:
        path: The file.
        mesh: Name of the mesh to read, or names of several, with or without shapes. By default
            all that are shown.

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
        axes = read_axes(members)
        meshes = _chosen(path, read_meshes(path, members), wanted)
    main = max(range(len(meshes)), key=lambda number: len(meshes[number].channels))
    vertices = sum(len(own.vertices) for own in meshes)
    shapes = sum(len(c.weights) for own in meshes for c in own.channels.values())
    members.budget.spend_fields(vertices, shapes, copies=2)
    with naming_file(path):
        neutral, morphs = joined_rig(
            [
                _rig_part(path, own, place)
                for own, place in zip(meshes, placings(axes, meshes, main), strict=True)
            ],
            str(path),
        )
        return Rig(neutral, morphs)


def _chosen(path: str | Path, meshes: list[FbxMesh], wanted: Sequence[str]) -> list[FbxMesh]:
    listed = [ListedMesh((own.name,), len(own.channels), own.shown) for own in meshes]
    try:
        chosen = [meshes[number] for number in chosen_meshes(listed, wanted)]
    except ParameterError as problem:
        raise FormatError(path, str(problem)) from None
    # Objects without points show nothing; exporters leave them where something was.
    return [own for own in chosen if len(own.vertices) or own.channels] or chosen


def _rig_part(path: str | Path, stored: FbxMesh, place: Placing) -> RigPart:
    mesh = mesh_of(stored, str(path))
    channels = stored.channels.items()
    morphs = {name: _morph(path, mesh, name, channel) for name, channel in channels}
    return RigPart(stored.name, mesh, morphs, place)


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
        warnings.warn(
            f"{path}: the channel '{name[:60]}' has {len(keys)} shapes, of which {len(by_time)} "
            "are kept: those at weights of 0 or below, or at one weight with another, lie on no "
            "path from 0 to 1",
            ElastomorphWarning,
            stacklevel=6,
        )
    shapes = []
    for key in by_time.values():
        dense = np.zeros((count, 3))
        np.add.at(dense, channel.vertices[key], channel.offsets[key])
        shapes.append(dense)
    return list(by_time), shapes
