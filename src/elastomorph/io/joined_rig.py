"""Several meshes of a file as one rig: in order, in place, targets of one name moving together.

Vertices are neither merged nor reordered: the first mesh has the first of them. A mesh without
blend shapes is part of the neutral, and nothing moves it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.placing import Placing
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons

__all__ = ["RigPart", "joined_rig", "turned_corners"]


@dataclass(frozen=True, eq=False)
class RigPart:
    """A mesh with its own morphs, in the space it was made in.

    Attributes:
        name: What people call it.
        mesh: The mesh.
        morphs: Its morphs by name.
        place: Where it goes.
    """

    name: str
    mesh: Mesh
    morphs: Mapping[str, Morph]
    place: Placing


def joined_rig(parts: Sequence[RigPart], source: str) -> tuple[Mesh, dict[str, Morph]]:
    """The meshes one after another, and their morphs by name in order of first use.

    Groups name the mesh of each polygon where there are several; of one mesh that stays where it
    is, everything is kept as it is. Polygons of a mesh that is mirrored are turned around.

    Args:
        parts: At least one.
        source: The file they come from.

    Raises:
        MeshError: They do not form a mesh.
    """
    if len(parts) == 1 and parts[0].place.is_identity:
        return parts[0].mesh, dict(parts[0].morphs)
    neutral = _joined_mesh(parts, source)
    moving: dict[str, list[tuple[slice, RigPart]]] = {}
    start = 0
    for part in parts:
        own = slice(start, start + len(part.mesh.vertices))
        start = own.stop
        for name in part.morphs:
            moving.setdefault(name, []).append((own, part))
    return neutral, {name: _joined_morph(neutral, name, at) for name, at in moving.items()}


def turned_corners(offsets: NDArray[np.int64]) -> NDArray[np.int64]:
    """(C,) the corners of each polygon the other way around, from the same first one.

    Args:
        offsets: (F + 1,) where each polygon starts.
    """
    sizes = np.diff(offsets)
    within = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes)
    size = np.repeat(sizes, sizes)
    turned: NDArray[np.int64] = np.repeat(offsets[:-1], sizes) + (size - within) % size
    return turned


def _joined_mesh(parts: Sequence[RigPart], source: str) -> Mesh:
    faces = [part.mesh.faces for part in parts]
    orders = [
        turned_corners(own.offsets) if part.place.mirrors else np.arange(len(own.indices))
        for part, own in zip(parts, faces, strict=True)
    ]
    starts = np.cumsum([0, *(len(part.mesh.vertices) for part in parts)])
    corners = np.cumsum([0, *(len(own.indices) for own in faces)])
    indices = [
        own.indices[order] + start
        for own, order, start in zip(faces, orders, starts[:-1], strict=True)
    ]
    offsets = [own.offsets[1:] + start for own, start in zip(faces, corners[:-1], strict=True)]
    meshes = [part.mesh for part in parts]
    return Mesh(
        np.concatenate([part.place.positions(part.mesh.vertices) for part in parts]),
        Polygons(np.concatenate(indices), np.concatenate([[0], *offsets])),
        uv=_joined_texture(meshes, orders),
        materials=_joined_labels([(mesh.materials, len(mesh.faces)) for mesh in meshes]),
        groups=meshes[0].groups if len(parts) == 1 else _mesh_names(parts),
        material_library=next((m.material_library for m in meshes if m.material_library), None),
        source=Source(source),
    )


def _mesh_names(parts: Sequence[RigPart]) -> FaceLabels | None:
    counts = [len(part.mesh.faces) for part in parts]
    return _joined_labels(
        (FaceLabels((part.name,), np.zeros(count, dtype=np.int32)), count)
        for part, count in zip(parts, counts, strict=True)
    )


def _joined_texture(meshes: Sequence[Mesh], orders: Sequence[NDArray[np.int64]]) -> UVMap | None:
    maps = [mesh.uv for mesh in meshes if mesh.uv is not None]
    if not maps:
        return None
    columns = max(uv.coordinates.shape[1] for uv in maps)
    coordinates, corners, count = [], [], 0
    for mesh, order in zip(meshes, orders, strict=True):
        if mesh.uv is None:
            corners.append(np.full(len(order), -1, dtype=np.int32))
            continue
        own = mesh.uv.corners[order]
        corners.append(np.where(own < 0, -1, own + count).astype(np.int32))
        narrow = mesh.uv.coordinates
        coordinates.append(np.pad(narrow, ((0, 0), (0, columns - narrow.shape[1]))))
        count += len(narrow)
    return UVMap(np.concatenate(coordinates), np.concatenate(corners))


def _joined_labels(labels: Iterable[tuple[FaceLabels | None, int]]) -> FaceLabels | None:
    """Labels of meshes with so many polygons each; those of one name are one."""
    names: dict[str, int] = {}
    of_face = []
    for own, count in labels:
        if own is None:
            of_face.append(np.full(count, -1))
            continue
        places = [names.setdefault(name, len(names)) for name in own.names]
        of_face.append(np.array([*places, -1])[own.of_face])  # the last stands for -1
    return FaceLabels(tuple(names), np.concatenate(of_face).astype(np.int32)) if names else None


def _joined_morph(neutral: Mesh, name: str, moving: Sequence[tuple[slice, RigPart]]) -> Morph:
    """What the morphs of one name do together; bends with the same curve are one.

    Args:
        neutral: All meshes.
        name: The name.
        moving: The parts with such a morph, and where their vertices are.
    """
    target = neutral.vertices.copy()
    bends: dict[tuple[bytes, bytes], tuple[BendCurve, NDArray[np.float64]]] = {}
    used: list[Morph] = []
    farthest = 0.0
    for own, part in moving:
        morph = part.morphs[name]
        used.append(morph)
        if morph.bake_error:
            farthest = max(farthest, morph.bake_error * part.mesh.diameter * part.place.scale)
        target[own] = part.place.positions(morph.target.vertices)
        for curve, bend in zip(morph.bend_curves, morph.bends, strict=True):
            key = (curve.breaks.tobytes(), curve.coefficients.tobytes())
            _, field = bends.setdefault(key, (curve, np.zeros_like(target)))
            field[own] = part.place.offsets(bend)
    methods = dict.fromkeys(morph.method for morph in used if len(morph.bends) or len(used) == 1)
    return Morph(
        neutral,
        neutral.with_vertices(target),
        np.array([field for _, field in bends.values()]).reshape(-1, *target.shape),
        tuple(curve for curve, _ in bends.values()),
        method=" and ".join(methods) or "linear",
        limit_law=used[0].limit_law,
        bake_error=farthest / neutral.diameter if farthest else 0.0,
        choice=used[0].choice if len(used) == 1 else None,
        bare=all(morph.bare for morph in used),
    )
