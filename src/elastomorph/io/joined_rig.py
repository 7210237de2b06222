"""Several meshes of a file as one rig: in order, in place, targets of one name moving together.

Vertices are neither merged nor reordered: the first mesh has the first of them. A mesh without
blend shapes is part of the neutral, and nothing moves it.

A shape is sculpted in the space of its mesh, so positions of the main mesh stay the numbers stored
there, bit for bit, or are only *turned*: by the rotation of its node, and by the axes of the file,
until up is +Y and the front is +Z. Scale and place of its node are not applied, so that what is
made here lies exactly on the mesh it came from. Further meshes go where they stand relative to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import FaceLabels, Material, Mesh, Source, UVMap
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons

_ROUNDING = 1e-9


class HasPlace(Protocol):
    """Anything with a transform."""

    @property
    def matrix(self) -> NDArray[np.float64]:
        """(4, 3) to the world: what x, y and z become, and the origin."""
        ...


@dataclass(frozen=True, eq=False)
class Placing:
    """An affine map from the space of one mesh to that of the rig.

    Attributes:
        linear: (3, 3), for offsets.
        shift: (3,), added to positions.
    """

    linear: NDArray[np.float64]
    shift: NDArray[np.float64]

    @property
    def mirrors(self) -> bool:
        """Whether it turns polygons inside out."""
        return bool(np.linalg.det(self.linear) < 0)

    @property
    def is_identity(self) -> bool:
        """Whether it leaves everything as it is."""
        return np.array_equal(self.linear, np.eye(3)) and not self.shift.any()

    @property
    def scale(self) -> float:
        """The most that it lengthens a vector."""
        return float(np.linalg.norm(self.linear, 2))

    def offsets(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 3) vectors in the space of the rig; exact for turns by right angles."""
        columns = np.abs(self.linear).argmax(axis=1)
        signs = self.linear[np.arange(3), columns]
        exchange = np.zeros((3, 3))
        exchange[np.arange(3), columns] = signs
        if np.array_equal(exchange, self.linear) and set(np.abs(signs).tolist()) == {1.0}:
            return np.asarray(vectors[..., columns] * signs)
        return np.asarray(vectors @ self.linear.T)

    def positions(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) positions in the space of the rig."""
        placed = self.offsets(points)
        return placed + self.shift if self.shift.any() else placed


def placings(
    axes: NDArray[np.float64] | None, parts: Sequence[HasPlace], main: int = 0
) -> list[Placing]:
    """How to place each mesh beside the main one, which gives unit and origin.

    The rows of ``axes`` (3, 3) are right, up and front of the file; None leaves the main mesh as it
    is turned.
    """
    whole = parts[main].matrix
    linear, origin = whole[:3].T, whole[3]
    placed = []
    try:
        scales = np.linalg.svd(linear, compute_uv=False)
        if not scales[-1] > _ROUNDING * scales[0]:
            linear = np.eye(3)
        turn = np.eye(3)
        if axes is not None:  # the rotation and mirroring in it without scale: its polar factor
            left, _, right = np.linalg.svd(axes @ linear)
            turn = _rounded(left @ right)
        for part in parts:
            if np.array_equal(part.matrix, whole):
                placed.append(Placing(turn, np.zeros(3)))
                continue
            beside = np.column_stack([part.matrix[:3].T, part.matrix[3] - origin])
            relative = np.linalg.solve(linear, beside)
            placed.append(Placing(_rounded(turn @ relative[:, :3]), turn @ relative[:, 3]))
    except np.linalg.LinAlgError:
        raise MeshError("its meshes stand at no place: their transforms are too large") from None
    return placed


def _rounded(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Without the rounding of sines and cosines, where it is all that differs from right angles."""
    whole = np.round(linear) + 0.0
    return whole if np.abs(whole - linear).max() < _ROUNDING else linear


@dataclass(frozen=True, eq=False)
class RigPart:
    """A mesh with its own morphs by name, in the space it was made in, and where it goes."""

    name: str
    mesh: Mesh
    morphs: Mapping[str, Morph]
    place: Placing


def joined_rig(parts: Sequence[RigPart], source: str) -> tuple[Mesh, dict[str, Morph]]:
    """The meshes one after another, and their morphs by name in order of first use.

    Groups name the mesh of each polygon where there are several; of one mesh that stays where it
    is, everything is kept as it is. Polygons of a mesh that is mirrored are turned around.
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
    """(C,) the corners of each polygon the other way around, from the same first one."""
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
    names = [
        (FaceLabels((part.name,), np.zeros(len(own), dtype=np.int32)), len(own))
        for part, own in zip(parts, faces, strict=True)
    ]
    return Mesh(
        np.concatenate([part.place.positions(part.mesh.vertices) for part in parts]),
        Polygons(np.concatenate(indices), np.concatenate([[0], *offsets])),
        uv=_joined_texture(meshes, orders),
        materials=_joined_labels([(mesh.materials, len(mesh.faces)) for mesh in meshes]),
        groups=meshes[0].groups if len(parts) == 1 else _joined_labels(names),
        material_library=next((m.material_library for m in meshes if m.material_library), None),
        source=Source(source, split=any(m.source is not None and m.source.split for m in meshes)),
        appearance=_joined_appearance(meshes),
        copyright="; ".join(dict.fromkeys(m.copyright for m in meshes if m.copyright)),
    )


def _joined_appearance(meshes: Sequence[Mesh]) -> dict[str, Material] | None:
    """What the materials of all meshes look like, as far as any of them says so."""
    said = [mesh.appearance for mesh in meshes if mesh.appearance is not None]
    return {name: each for own in said for name, each in own.items()} if said else None


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
    """What the morphs of one name do together; bends with the same curve are one."""
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
