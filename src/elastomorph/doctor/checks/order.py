"""Are the vertices and polygons of a target those of the neutral, in the same order?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.frames import frame_between
from elastomorph.doctor.relabelling import (
    Mismatch,
    Parts,
    Relabelling,
    corresponding_corners,
    find_relabelling,
    reversed_polygons,
)
from elastomorph.mesh import FaceLabels, Mesh, Source, UVMap

__all__ = ["InOrder", "NeutralOrder"]

# Polygons up to this size are compared with triangles they may have been split into.
_LARGEST_SPLIT = 16
# If at most this part of the polygons differs, naming the first helps more than anything else.
_FEW = 0.1


@dataclass(frozen=True, eq=False)
class InOrder:
    """What became of one target.

    Attributes:
        mesh: The target with vertices and polygons in the order of the neutral, or None.
        findings: What was wrong.
        repair: What was done, in a few words; empty where nothing was wrong, or nothing helped.
    """

    mesh: Mesh | None
    findings: tuple[Finding, ...] = ()
    repair: str = ""


class NeutralOrder:
    """The order that all targets are compared with; prepared once.

    Attributes:
        neutral: The neutral.
        seeds: Pairs (vertex of the neutral, vertex of a target in another order) that are known.
        scale: Factor from which on sizes are another unit.
    """

    def __init__(
        self, neutral: Mesh, seeds: Sequence[tuple[int, int]] = (), scale: float = 1.2
    ) -> None:
        """Take the neutral as the measure."""
        self.neutral, self.seeds, self.scale = neutral, tuple(seeds), scale

    @cached_property
    def _parts(self) -> Parts:
        return Parts(self.neutral, seeds=[pair[0] for pair in self.seeds])

    def examine(self, target: Mesh, file: str) -> InOrder:
        """Compare a target with the neutral, and put it into its order where that is possible."""
        neutral = self.neutral
        if target.faces == neutral.faces and len(target.vertices) == len(neutral.vertices):
            return InOrder(target)
        if len(target.vertices) == len(neutral.vertices) and _splits(neutral, target):
            message = (
                f"its {len(target.faces):,} triangles are the {len(neutral.faces):,} polygons of "
                "the neutral, split"
            )
            mesh = neutral.with_vertices(target.vertices)
            return InOrder(
                mesh, (finding("triangulated", file, message),), "polygons of the neutral put back"
            )
        if len(target.vertices) != len(neutral.vertices) or len(target.faces) != len(neutral.faces):
            return InOrder(None, (finding("different-counts", file, self._counts(target)),))
        corners = corresponding_corners(neutral.faces, target.faces)
        if corners is not None:
            here = np.arange(len(target.vertices))
            message = "the polygons are the same, but in another order or from another first vertex"
            found = finding("polygon-order", file, message, line=self._first_line(target))
            mesh = _reordered(neutral, target, here, corners)
            return InOrder(mesh, (found,), "polygons reordered")
        if corresponding_corners(neutral.faces, reversed_polygons(target.faces)) is not None:
            message = "every polygon runs the other way round: its normals point inwards"
            return InOrder(
                neutral.with_vertices(target.vertices),
                (finding("reversed-winding", file, message),),
            )
        return self._relabelled(target, file)

    def _relabelled(self, target: Mesh, file: str) -> InOrder:
        found = self._search(target)
        turned = isinstance(found, Relabelling) and not self._upright(found, target)
        if turned or isinstance(found, Mismatch):
            backwards = self._search(target, backwards=True)
            if isinstance(backwards, Relabelling) and (
                isinstance(found, Mismatch) or self._upright(backwards, target)
            ):
                message = (
                    "vertices are in another order, and every polygon runs the other way round; "
                    "no order of vertices alone makes it the neutral"
                )
                return InOrder(None, (finding("reversed-winding", file, message),))
        if isinstance(found, Mismatch):
            if found.seeds:
                return InOrder(None, (finding("wrong-seed", file, found.reason),))
            line, message = self._polygons(target, found)
            return InOrder(None, (finding("different-polygons", file, message, line=line),))
        moved = int((found.new_index != np.arange(len(found.new_index))).sum())
        message = (
            f"{moved:,} vertices have another number than in the neutral; connectivity tells "
            "which is which"
        )
        if found.chosen:
            message += (
                f", and positions for {found.chosen:,} symmetric or like pieces "
                f"({found.chosen_vertices:,} vertices)"
            )
        mesh = _reordered(self.neutral, target, found.new_index, found.corners)
        return InOrder(mesh, (finding("vertex-order", file, message),), "vertices reordered")

    def _search(self, target: Mesh, backwards: bool = False) -> Relabelling | Mismatch:
        missing = [pair for pair in self.seeds if pair[1] >= len(target.vertices)]
        if missing:
            names = ", ".join(f"{a}={b}" for a, b in missing)
            return Mismatch(
                f"{names}: the target has no such vertex, only 0 to {len(target.vertices) - 1:,}",
                True,
            )
        faces = reversed_polygons(target.faces) if backwards else target.faces
        seeds = [pair[1] for pair in self.seeds]
        rounds = self._parts.colouring.rounds
        parts = Parts(target, faces=faces, seeds=seeds, rounds=rounds)
        return find_relabelling(self._parts, parts, scale=self.scale)

    def _upright(self, found: Relabelling, target: Mesh) -> bool:
        """Whether left stays left: a symmetric mesh fits on its mirror image just as well."""
        here = self.neutral.vertices[found.new_index]
        return frame_between(here, target.vertices, self.scale).same_axes

    def _counts(self, target: Mesh) -> str:
        neutral = self.neutral
        message = (
            f"{len(target.vertices):,} vertices and {len(target.faces):,} polygons instead of "
            f"{len(neutral.vertices):,} and {len(neutral.faces):,}"
        )
        if len(target.vertices) > len(neutral.vertices) and (
            _positions(target) <= _positions(neutral)
        ):
            return f"{message}; vertices were split where texture or normals have seams"
        if set(target.faces.sizes.tolist()) == {3} != set(neutral.faces.sizes.tolist()):
            return f"{message}; all polygons are triangles, so it was triangulated"
        return message

    def _polygons(self, target: Mesh, mismatch: Mismatch) -> tuple[int | None, str]:
        """Line and words for polygons that are not those of the neutral."""
        ours, theirs = self.neutral.faces, target.faces
        if not np.array_equal(ours.offsets, theirs.offsets):
            return None, mismatch.reason
        differ = np.add.reduceat(ours.indices != theirs.indices, ours.offsets[:-1]) > 0
        if differ.mean() > _FEW:
            return None, mismatch.reason
        first = int(np.argmax(differ))
        return self._first_line(target), (
            f"{int(differ.sum()):,} polygons differ, the first is {first:,}: "
            f"{theirs[first].tolist()} instead of {ours[first].tolist()}"
        )

    def _first_line(self, target: Mesh) -> int | None:
        """Line of the first polygon that is not the one of the neutral."""
        if target.source is None or target.source.face_lines is None:
            return None
        pairs = zip(self.neutral.faces, target.faces, strict=False)
        for line, (ours, theirs) in zip(target.source.face_lines.tolist(), pairs, strict=False):
            if not np.array_equal(ours, theirs):
                return int(line)
        return None


def _reordered(
    neutral: Mesh, target: Mesh, new_index: NDArray[np.int64], corners: NDArray[np.int64]
) -> Mesh:
    """The target in the order of the neutral, with labels and texture of its own."""
    vertices = np.empty_like(target.vertices)
    vertices[new_index] = target.vertices
    faces = target.faces.corner_faces[corners[neutral.faces.offsets[:-1]]]
    source = target.source
    if source is not None and source.face_lines is not None:
        source = Source(source.path, source.face_lines[faces])
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


def _positions(mesh: Mesh) -> int:
    return len(np.unique(mesh.vertices, axis=0))


def _splits(neutral: Mesh, target: Mesh) -> bool:
    """Whether all polygons of the target are triangles inside polygons of the neutral."""
    sizes = neutral.faces.sizes
    if not len(target.faces) or (target.faces.sizes != 3).any() or sizes.max(initial=0) == 3:
        return False
    if int((sizes - 2).sum()) != len(target.faces) or sizes.max() > _LARGEST_SPLIT:
        return False
    allowed = []
    for size in np.unique(sizes).tolist():
        starts = neutral.faces.offsets[:-1][sizes == size]
        rows = neutral.faces.indices[starts[:, None] + np.arange(size)].astype(np.int64)
        allowed += [rows[:, list(three)] for three in combinations(range(size), 3)]
    count = len(neutral.vertices)
    wanted = _keys(target.faces.indices.reshape(-1, 3).astype(np.int64), count)
    return bool(np.isin(wanted, _keys(np.concatenate(allowed), count)).all())


def _keys(triangles: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """(T,) one number for each triangle and direction, whichever vertex comes first."""
    first = triangles.argmin(axis=1)[:, None]
    turned = np.take_along_axis(triangles, (first + np.arange(3)) % 3, axis=1)
    return np.asarray((turned[:, 0] * count + turned[:, 1]) * count + turned[:, 2])
