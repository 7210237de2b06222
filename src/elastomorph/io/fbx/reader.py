"""Reads the rig in an FBX file: its meshes with blend shapes as one face, its channels as sliders.

What a technical animator would otherwise do by hand:

- meshes that have shapes and can be seen (the first level of detail only) become one mesh, in the
  order of the file: control points keep their order within each, and a channel that several of
  them have, such as ``jawOpen`` of head and teeth, is one slider. Groups name the mesh of each
  polygon. Meshes without shapes are left out unless they are asked for by name;
- a channel with in-between shapes becomes a path through them, straight from one to the next as in
  the program it comes from;
- positions are those stored, turned upright (see `elastomorph.io.fbx.placing`). Skinning, poses and
  animation are not applied.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.bend_curve import BendCurve
from elastomorph.errors import (
    ElastomorphWarning,
    FormatError,
    MissingExtraError,
    ParameterError,
)
from elastomorph.io.checked import naming_file
from elastomorph.io.fbx.part import Channel, FbxPart, read_axes, read_parts
from elastomorph.io.fbx.placing import Placing, placings
from elastomorph.io.fbx.surface import joined
from elastomorph.io.fbx.worker import ADVICE
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.mesh import Mesh
from elastomorph.morph import Morph
from elastomorph.rig import Rig

__all__ = ["read_fbx"]

_READER = IsolatedReader("elastomorph.io.fbx.worker", "the reader of FBX files", ADVICE)


def read_fbx(path: str | Path, *, meshes: Sequence[str] | None = None) -> Rig:
    """The rig in an FBX file, binary or text.

    Args:
        path: The file.
        meshes: Names of the meshes to take, in that order, with or without shapes; the first gives
            unit and origin. By default those that have shapes and are shown, the one with most
            channels giving unit and origin.

    Returns:
        The rig. At weight 1 of a slider its last shape is reached, whatever full weight the file
        gives it.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is not FBX, is damaged, has no blend shapes, or broke its reader.
        MissingExtraError: ufbx is not installed.
        ParameterError: There is no mesh of a name.
    """
    if find_spec("ufbx") is None:
        raise MissingExtraError("ufbx", "fbx")
    with extracted(_READER, path) as members:
        axes = read_axes(members)
        parts = _chosen(path, read_parts(path, members), meshes)
    # the one with most channels first, as unit and origin, but in the order of the file
    main = parts[0] if meshes is not None else max(parts, key=lambda part: len(part.channels))
    with naming_file(path):
        places = placings(axes, [main, *parts])[1:]
    vertices = sum(len(part.vertices) for part in parts)
    shapes = sum(len(c.weights) for part in parts for c in part.channels.values())
    members.budget.spend_fields(vertices, shapes, copies=2)
    with naming_file(path):
        neutral = joined(parts, places, str(path))
        names = dict.fromkeys(name for part in parts for name in part.channels)
        return Rig(neutral, {name: _morph(path, neutral, name, parts, places) for name in names})


def _chosen(path: str | Path, parts: list[FbxPart], meshes: Sequence[str] | None) -> list[FbxPart]:
    if meshes is not None:
        by_name = {part.name: part for part in reversed(parts)}
        for name in meshes:
            if name not in by_name:
                raise ParameterError(f"{path} has no mesh '{name}': {_listed(parts)}")
        if not meshes:
            raise ParameterError("name at least one mesh, or leave 'meshes' out")
        return [by_name[name] for name in dict.fromkeys(meshes)]
    moving = [part for part in parts if part.channels]
    if not moving:
        raise FormatError(
            path,
            f"none of its meshes has blend shapes ({_listed(parts)}); switch on blend shapes "
            "(shape keys, morpher) when exporting",
        )
    return [part for part in moving if part.shown] or moving


def _listed(parts: list[FbxPart]) -> str:
    names = [f"'{part.name[:60]}' ({len(part.channels)} shapes)" for part in parts[:8]]
    return f"there are {', '.join(names) or 'no meshes'}" + (", …" if len(parts) > 8 else "")


def _morph(
    path: str | Path,
    neutral: Mesh,
    name: str,
    parts: Sequence[FbxPart],
    places: Sequence[Placing],
) -> Morph:
    """One slider: what its channels do to all meshes that have it."""
    target = neutral.vertices.copy()
    bends: dict[tuple[float, ...], NDArray[np.float64]] = {}
    start = 0
    for part, place in zip(parts, places, strict=True):
        own = slice(start, start + len(part.vertices))
        start = own.stop
        if name not in part.channels:
            continue
        times, offsets = _path(path, name, part.channels[name], len(part.vertices))
        moved = [place.offsets(offset) for offset in offsets]
        target[own] += moved[-1]
        stops = [0.0, *times]
        for key, (time, offset) in enumerate(zip(times[:-1], moved[:-1], strict=True), start=1):
            away = offset - time * moved[-1]
            if away.any():
                around = tuple(stops[key - 1 : key + 2])
                bend = bends.setdefault(around, np.zeros_like(target))
                bend[own] += away
    return Morph(
        neutral,
        neutral.with_vertices(target),
        np.array(list(bends.values())).reshape(-1, *target.shape),
        tuple(_hat(*around) for around in bends),
        method="in-betweens" if bends else "linear",
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
            stacklevel=5,
        )
    shapes = []
    for key in by_time.values():
        dense = np.zeros((count, 3))
        np.add.at(dense, channel.vertices[key], channel.offsets[key])
        shapes.append(dense)
    return list(by_time), shapes


def _hat(before: float, top: float, after: float) -> BendCurve:
    """1 at one time, 0 up to the time before and from the time after, straight between."""
    rise, fall = 1 / (top - before), -1 / (after - top)
    pieces = [(before, [0.0, rise]), (top, [1.0, fall])]
    if before > 0:
        pieces.insert(0, (0.0, [0.0, 0.0]))
    if after < 1:
        pieces.append((after, [0.0, 0.0]))
    return BendCurve(
        np.array([start for start, _ in pieces] + [1.0]), np.array([row for _, row in pieces])
    )
