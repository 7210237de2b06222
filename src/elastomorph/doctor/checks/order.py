"""Are the vertices and polygons of a target those of the neutral, in the same order?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks.reordering import reordered
from elastomorph.doctor.checks.welds import examine_welds
from elastomorph.doctor.checks.winding import reversed_finding
from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.relabelling import (
    Doubts,
    Mismatch,
    Parts,
    Relabelling,
    corners_either_way,
    corresponding_corners,
    doubts_about,
    find_relabelling,
    split_polygons,
    turned_corners,
)
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

__all__ = ["InOrder", "NeutralOrder"]

# If at most this part of the polygons differs, naming the first helps more than anything else.
_FEW = 0.1


@dataclass(frozen=True, eq=False)
class InOrder:
    """What became of one target.

    Attributes:
        mesh: The target with vertices and polygons in the order of the neutral, or None.
        findings: What was wrong.
        repair: What was done, in a few words; empty where nothing was wrong, or nothing helped.
        turned: (F,) polygons of the neutral that it only runs the other way round; None where
            there are none, or anything else was wrong.
    """

    mesh: Mesh | None
    findings: tuple[Finding, ...] = ()
    repair: str = ""
    turned: NDArray[np.bool_] | None = None


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
        """Compare a target with the neutral, and put it into its order where that is possible.

        A numbering with which the polygons are those of the neutral is never touched, however they
        are listed, split or wound.
        """
        neutral = self.neutral
        if len(target.vertices) == len(neutral.vertices):
            if target.faces == neutral.faces:
                return InOrder(target)
            same = self._split(target, file) or self._same_numbers(target, file)
            if same is not None:
                return same
        else:
            near = 1e-6 * target.diameter
            rejoined = examine_welds(neutral, target, file, near)
            if rejoined is not None:
                return InOrder(rejoined.mesh, (rejoined.finding,), rejoined.repair)
        if len(target.vertices) != len(neutral.vertices) or len(target.faces) != len(neutral.faces):
            return InOrder(None, (finding("different-counts", file, self._counts(target)),))
        return self._relabelled(target, file)

    def _split(self, target: Mesh, file: str) -> InOrder | None:
        """A target whose polygons were split into triangles."""
        turned = split_polygons(self.neutral.faces, target.faces, len(self.neutral.vertices))
        if turned is None:
            return None
        message = (
            f"its {len(target.faces):,} triangles are the {len(self.neutral.faces):,} polygons of "
            "the neutral, split"
        )
        found = [finding("triangulated", file, message)]
        if turned.any():
            found.append(reversed_finding(target, file, np.flatnonzero(turned)))
        mesh = self.neutral.with_vertices(target.vertices)
        return InOrder(mesh, tuple(found), "polygons of the neutral put back")

    def _same_numbers(self, target: Mesh, file: str) -> InOrder | None:
        """A target that numbers vertices as the neutral does."""
        faces, found, repairs, turned = self.neutral.faces, [], [], None
        corners = corresponding_corners(faces, target.faces)
        if corners is None:
            either = corners_either_way(faces, target.faces)
            if either is None:
                return None
            corners, turned = either.corners, either.turned
            partner = _partners(faces, target.faces, corners)
            found.append(reversed_finding(target, file, np.sort(partner[turned])))
            repairs.append("polygons wound as in the neutral")
        partner = _partners(faces, target.faces, corners)
        if not found or (partner != np.arange(len(faces))).any():
            message = "the polygons are the same, but in another order or from another first vertex"
            line = self._first_line(target)
            found.append(finding("polygon-order", file, message, line=line))
            repairs.append("polygons reordered")
            turned = None
        mesh = reordered(self.neutral, target, np.arange(len(target.vertices)), corners)
        return InOrder(mesh, tuple(found), ", ".join(repairs), turned)

    def _relabelled(self, target: Mesh, file: str) -> InOrder:
        """A target that numbers vertices otherwise, if its polygons tell how."""
        found = self._search(target)
        if isinstance(found, Mismatch):
            if found.seeds:
                return InOrder(None, (finding("wrong-seed", file, found.reason),))
            every = np.ones(len(target.faces), dtype=bool)
            for turned in (every, self._without_equal(target)):
                other = self._search(target, turned)
                if isinstance(other, Relabelling) and not self._doubts(other, target):
                    return self._renumbered(other, target, file, turned)
            line, message = self._polygons(target, found)
            return InOrder(None, (finding("different-polygons", file, message, line=line),))
        doubts = self._doubts(found, target)
        astray = doubts.astray
        if not doubts and doubts.unsure.any():
            other = self._search(target, self._polygons_of(found, doubts.unsure, target))
            if isinstance(other, Relabelling):
                astray = doubts.unsure & doubts.better(self._doubts(other, target))
        if not doubts and not astray.any():
            return self._renumbered(found, target, file)
        return self._in_doubt(found, doubts, astray, target, file)

    def _in_doubt(
        self,
        found: Relabelling,
        doubts: Doubts,
        astray: NDArray[np.bool_],
        target: Mesh,
        file: str,
    ) -> InOrder:
        """Polygons that fit, but put something where it cannot be: parts may run backwards."""
        turned = np.ones(len(target.faces), dtype=bool)
        if astray.any():
            turned = self._polygons_of(found, astray, target)
        other = self._search(target, turned)
        if isinstance(other, Relabelling) and not self._doubts(other, target):
            if astray.any():
                return self._renumbered(other, target, file, turned)
            # Run backwards, or its own mirror image: symmetric polygons fit both ways.
            message = (
                "vertices are in another order, and every polygon runs the other way round; "
                "no order of vertices alone makes it the neutral"
            )
            return InOrder(None, (finding("reversed-winding", file, message),))
        if not doubts.farther and not astray.any():
            return self._renumbered(found, target, file)
        message = (
            "its polygons are those of the neutral in another order of the vertices, but that "
            "order would take them away from where they are"
        )
        return InOrder(None, (finding("different-polygons", file, message),))

    def _polygons_of(
        self, found: Relabelling, pieces: NDArray[np.bool_], target: Mesh
    ) -> NDArray[np.bool_]:
        """(F,) polygons of the target in some pieces of the neutral."""
        first = target.faces.indices[target.faces.offsets[:-1]]
        return np.asarray(pieces[self._parts.part_of[found.new_index[first]]])

    def _renumbered(
        self,
        found: Relabelling,
        target: Mesh,
        file: str,
        turned: NDArray[np.bool_] | None = None,
    ) -> InOrder:
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
        if turned is not None:
            findings.append(reversed_finding(target, file, np.flatnonzero(turned)))
        mesh = reordered(self.neutral, target, found.new_index, found.corners)
        return InOrder(mesh, tuple(findings), "vertices reordered")

    def _search(
        self, target: Mesh, turned: NDArray[np.bool_] | None = None
    ) -> Relabelling | Mismatch:
        missing = [pair for pair in self.seeds if pair[1] >= len(target.vertices)]
        if missing:
            names = ", ".join(f"{a}={b}" for a, b in missing)
            return Mismatch(
                f"{names}: the target has no such vertex, only 0 to {len(target.vertices) - 1:,}",
                True,
            )
        found = find_relabelling(self._parts, self._their_parts(target, turned), scale=self.scale)
        if turned is None or isinstance(found, Mismatch):
            return found
        corners = turned_corners(target.faces, turned)[found.corners]
        return replace(found, corners=corners)

    def _their_parts(self, target: Mesh, turned: NDArray[np.bool_] | None) -> Parts:
        faces = target.faces
        if turned is not None:
            faces = Polygons(faces.indices[turned_corners(faces, turned)], faces.offsets)
        seeds = [pair[1] for pair in self.seeds]
        return Parts(target, faces=faces, seeds=seeds, rounds=self._parts.colouring.rounds)

    def _without_equal(self, target: Mesh) -> NDArray[np.bool_]:
        """(F,) polygons of the target in pieces that are unlike all of the neutral."""
        parts, ours = self._their_parts(target, None), self._parts.by_colour
        alone = [
            p for colour, alike in parts.by_colour.items() if colour not in ours for p in alike
        ]
        return np.asarray(
            np.isin(parts.part_of[target.faces.indices[target.faces.offsets[:-1]]], alone)
        )

    def _doubts(self, found: Relabelling, target: Mesh) -> Doubts:
        return doubts_about(
            self.neutral.vertices,
            target.vertices,
            found.new_index,
            self._parts.vertices,
            self.scale,
        )

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


def _partners(ours: Polygons, theirs: Polygons, corners: NDArray[np.int64]) -> NDArray[np.int32]:
    """(F,) which of their polygons each of ours is."""
    return theirs.corner_faces[corners[ours.offsets[:-1]]]


def _positions(mesh: Mesh) -> int:
    return len(np.unique(mesh.vertices, axis=0))
