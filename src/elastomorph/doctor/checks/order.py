"""Are the vertices and polygons of a target those of the neutral, in the same order?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks.vertex_counts import rejoined
from elastomorph.doctor.checks.winding import reversed_finding
from elastomorph.doctor.findings import Outcome, finding
from elastomorph.doctor.isomorphism import (
    Mismatch,
    Parts,
    Plausibility,
    Relabelling,
    corners_either_way,
    corresponding_corners,
    find_relabelling,
    plausibility,
    reversed_corners,
    reversed_polygons,
    triangles_of,
)
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap

__all__ = ["NeutralOrder"]

# If at most this part of the polygons differs, naming the first helps more than anything else.
_FEW = 0.1

_BACKWARDS = (
    "vertices are in another order, and every polygon runs the other way round; no order of "
    "vertices alone makes it the neutral"
)
_TAKEN_AWAY = (
    "its polygons are those of the neutral in another order of the vertices, but that order would "
    "take them away from where they are"
)


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
        self.neutral, self.seeds, self.scale = neutral, tuple(seeds), scale

    @cached_property
    def _parts(self) -> Parts:
        return Parts(self.neutral, seeds=[pair[0] for pair in self.seeds])

    def examine(self, target: Mesh, file: str) -> Outcome:
        """Compare a target with the neutral, and put it into its order where that is possible.

        A numbering with which the polygons are those of the neutral is never touched, however they
        are listed, split or wound.
        """
        neutral = self.neutral
        if len(target.vertices) == len(neutral.vertices):
            if target.faces == neutral.faces:
                return Outcome(target)
            found = self._triangulated(target, file) or self._same_numbers(target, file)
        else:
            found = rejoined(neutral, target, file, 1e-6 * target.diameter)
        if found is not None:
            return found
        if len(target.vertices) != len(neutral.vertices) or len(target.faces) != len(neutral.faces):
            return Outcome(None, (finding("different-counts", file, self._counts(target)),))
        return self._relabelled(target, file)

    def _triangulated(self, target: Mesh, file: str) -> Outcome | None:
        wrong = triangles_of(self.neutral.faces, target.faces, len(self.neutral.vertices))
        if wrong is None:
            return None
        message = (
            f"its {len(target.faces):,} triangles are the {len(self.neutral.faces):,} polygons of "
            "the neutral, split"
        )
        found = [finding("triangulated", file, message)]
        if wrong.any():
            found.append(reversed_finding(target, file, np.flatnonzero(wrong)))
        mesh = self.neutral.with_vertices(target.vertices)
        return Outcome(mesh, tuple(found), "polygons of the neutral put back")

    def _same_numbers(self, target: Mesh, file: str) -> Outcome | None:
        """A target that numbers vertices as the neutral does."""
        faces, found, repairs, wrong = self.neutral.faces, [], [], None
        corners = corresponding_corners(faces, target.faces)
        if corners is None:
            either = corners_either_way(faces, target.faces)
            if either is None:
                return None
            corners, wrong = either
        partner = target.faces.corner_faces[corners[faces.offsets[:-1]]]
        if wrong is not None:
            found.append(reversed_finding(target, file, np.sort(partner[wrong])))
            repairs.append("polygons wound as in the neutral")
        if wrong is None or (partner != np.arange(len(faces))).any():
            message = "the polygons are the same, but in another order or from another first vertex"
            line = self._first_line(target)
            found.append(finding("polygon-order", file, message, line=line))
            repairs.append("polygons reordered")
            wrong = None
        mesh = _reordered(self.neutral, target, np.arange(len(target.vertices)), corners)
        return Outcome(mesh, tuple(found), ", ".join(repairs), wrong)

    def _relabelled(self, target: Mesh, file: str) -> Outcome:
        """A target that numbers vertices otherwise, if its polygons tell how."""
        every = np.ones(len(target.faces), dtype=bool)
        found = self._search(target)
        if isinstance(found, Mismatch):
            if found.seeds:
                return Outcome(None, (finding("wrong-seed", file, found.reason),))
            for wrong in (every, self._in_parts_without_equal(target)):
                other = self._search(target, wrong)
                if isinstance(other, Relabelling) and self._judge(other, target).plausible:
                    return self._renumbered(other, target, file, wrong)
            line, message = self._differing_polygons(target, found)
            return Outcome(None, (finding("different-polygons", file, message, line=line),))
        judged = self._judge(found, target)
        unlike = judged.unlike
        if judged.plausible and judged.unsure.any():
            other = self._search(target, self._in_parts(found, judged.unsure, target))
            if isinstance(other, Relabelling):
                unlike = judged.unsure & judged.better(self._judge(other, target))
        if judged.plausible and not unlike.any():
            return self._renumbered(found, target, file)
        # The polygons fit, but put something where it cannot be: parts may run backwards.
        wrong = self._in_parts(found, unlike, target) if unlike.any() else every
        other = self._search(target, wrong)
        backwards = isinstance(other, Relabelling) and self._judge(other, target).plausible
        if isinstance(other, Relabelling) and backwards and unlike.any():
            return self._renumbered(other, target, file, wrong)
        if not backwards and not judged.farther and not unlike.any():
            return self._renumbered(found, target, file)
        # Run backwards, or its own mirror image: symmetric polygons fit both ways.
        name = "reversed-winding" if backwards else "different-polygons"
        message = _BACKWARDS if backwards else _TAKEN_AWAY
        return Outcome(None, (finding(name, file, message),))

    def _in_parts(
        self, found: Relabelling, parts: NDArray[np.bool_], target: Mesh
    ) -> NDArray[np.bool_]:
        """(F,) polygons of the target in some parts of the neutral."""
        first = target.faces.indices[target.faces.offsets[:-1]]
        return np.asarray(parts[self._parts.part_of[found.new_index[first]]])

    def _in_parts_without_equal(self, target: Mesh) -> NDArray[np.bool_]:
        """(F,) polygons of the target in parts that are unlike all of the neutral."""
        theirs, ours = self._their_parts(target, None), self._parts.by_colour
        groups = theirs.by_colour.items()
        alone = [part for colour, parts in groups if colour not in ours for part in parts]
        first = target.faces.indices[target.faces.offsets[:-1]]
        return np.asarray(np.isin(theirs.part_of[first], alone))

    def _renumbered(
        self,
        found: Relabelling,
        target: Mesh,
        file: str,
        wrong: NDArray[np.bool_] | None = None,
    ) -> Outcome:
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
        findings = [finding("vertex-order", file, message)]
        if wrong is not None:
            findings.append(reversed_finding(target, file, np.flatnonzero(wrong)))
        mesh = _reordered(self.neutral, target, found.new_index, found.corners)
        return Outcome(mesh, tuple(findings), "vertices reordered")

    def _search(
        self, target: Mesh, wrong: NDArray[np.bool_] | None = None
    ) -> Relabelling | Mismatch:
        """The numbering of the target, with some of its polygons reversed."""
        missing = [f"{a}={b}" for a, b in self.seeds if b >= len(target.vertices)]
        if missing:
            has = f"the target has no such vertex, only 0 to {len(target.vertices) - 1:,}"
            return Mismatch(f"{', '.join(missing)}: {has}", True)
        found = find_relabelling(self._parts, self._their_parts(target, wrong), scale=self.scale)
        if wrong is None or isinstance(found, Mismatch):
            return found
        return replace(found, corners=reversed_corners(target.faces, wrong)[found.corners])

    def _their_parts(self, target: Mesh, wrong: NDArray[np.bool_] | None) -> Parts:
        faces = None if wrong is None else reversed_polygons(target.faces, wrong)
        seeds = [pair[1] for pair in self.seeds]
        return Parts(target, faces=faces, seeds=seeds, rounds=self._parts.colouring.rounds)

    def _judge(self, found: Relabelling, target: Mesh) -> Plausibility:
        here, there = self.neutral.vertices, target.vertices
        return plausibility(here, there, found.new_index, self._parts.vertices, self.scale)

    def _counts(self, target: Mesh) -> str:
        neutral = self.neutral
        message = (
            f"{len(target.vertices):,} vertices and {len(target.faces):,} polygons instead of "
            f"{len(neutral.vertices):,} and {len(neutral.faces):,}"
        )
        here, there = (len(np.unique(mesh.vertices, axis=0)) for mesh in (neutral, target))
        if len(target.vertices) > len(neutral.vertices) and there <= here:
            return f"{message}; vertices were split where texture or normals have seams"
        if set(target.faces.sizes.tolist()) == {3} != set(neutral.faces.sizes.tolist()):
            return f"{message}; all polygons are triangles, so it was triangulated"
        return message

    def _differing_polygons(self, target: Mesh, mismatch: Mismatch) -> tuple[int | None, str]:
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
    """The target in the order of the neutral, with labels and texture of its own.

    ``new_index`` (V,) is the number in the neutral of each vertex of the target, ``corners`` (C,)
    the corner of the target for each corner of the neutral.
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
