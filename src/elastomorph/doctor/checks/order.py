"""Are the vertices and polygons of a target those of the neutral, in the same order?

Is a numbering that polygons allow one that positions can mean?

A symmetric part with its polygons reversed fits on its own mirror image polygon by polygon. What
tells is where the vertices are.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, Outcome, counted, finding, listed, polygon_finding
from elastomorph.doctor.frames import frame_between
from elastomorph.doctor.isomorphism import (
    Mismatch,
    Parts,
    Relabelling,
    corners_either_way,
    corresponding_corners,
    find_relabelling,
    reversed_corners,
    reversed_polygons,
    triangles_of,
)
from elastomorph.doctor.neutral import HalfEdges, Neutral
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.polygons import Polygons

# Meshes with polygons in another order, or wound otherwise than neighbours, rig and inside say.

# 36 π V² / A³ is 1 of a ball and 0 of a sheet. Sheets have no inside; a face mask has 0.05 and
# more, sockets of eyes 0.014, gums 0.0002.
_HOLDS = 0.005


def with_reversed(mesh: Mesh, which: NDArray[np.bool_]) -> Mesh:
    """A mesh with some polygons (F,) run the other way round; every corner keeps its texture."""
    corners = reversed_corners(mesh.faces, which)
    return Mesh(
        mesh.vertices,
        Polygons(mesh.faces.indices[corners], mesh.faces.offsets),
        uv=mesh.uv and UVMap(mesh.uv.coordinates, mesh.uv.corners[corners]),
        materials=mesh.materials,
        groups=mesh.groups,
        material_library=mesh.material_library,
        source=mesh.source,
    )


def reordered(
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


def inconsistent_winding(neutral: Neutral, file: str) -> list[Finding]:
    """Polygons to reverse so that all neighbours run their common edge in opposite directions."""
    half, mesh = neutral.half_edges, neutral.mesh
    wrong = np.flatnonzero((half.alike == 2) & (half.against == 0) & half.proper)
    if not wrong.size:
        return []
    wrong = wrong[np.argsort(half.edge_keys[wrong], kind="stable")]
    faces = half.faces.corner_faces.astype(np.int64)
    against = np.stack([faces[wrong[::2]], faces[wrong[1::2]]], axis=1)
    paired = np.flatnonzero(half.twin >= 0)
    along = np.stack([faces[paired], faces[half.twin[paired]]], axis=1)
    count = len(half.faces)
    # Each polygon twice, as it is and reversed: what is connected here must be decided together.
    ends = np.concatenate([along, along + count, against + [0, count], against + [count, 0]])
    part_of = component_of(2 * count, ends)
    as_is, reverse = part_of[:count], part_of[count:]
    if (as_is == reverse).any():
        strip = as_is == reverse
        message = (
            f"{int(strip.sum()):,} polygons form a surface with one side only, as a Möbius strip "
            "has"
        )
        vertices = np.unique(half.start[strip[faces]])
        return [finding("inconsistent-winding", file, message, vertices=vertices)]
    # Of the two ways to agree, the one that reverses fewer polygons.
    kept = np.bincount(as_is, minlength=2 * count)
    fewer = kept[as_is] < kept[reverse]
    flipped = np.flatnonzero(fewer | ((kept[as_is] == kept[reverse]) & (as_is > reverse)))
    runs = counted(flipped, "polygon runs", "polygons run")
    message = f"{runs} against the others around: {listed(flipped)}"
    return [polygon_finding("inconsistent-winding", mesh, file, flipped, message)]


def common_reversal(own: Sequence[NDArray[np.bool_]]) -> NDArray[np.bool_] | None:
    """(F,) polygons that most targets, two at least and alike, run the other way round, or None.

    It is the neutral that is wrong there. ``own`` is (F,) for each target.
    """
    alike = Counter(which.tobytes() for which in own)
    most = max(alike, key=lambda key: alike[key], default=b"")
    if not most or alike[most] < 2 or 2 * alike[most] <= len(own):
        return None
    wrong = np.frombuffer(most, dtype=bool)
    return wrong if wrong.any() else None


def reversed_finding(
    mesh: Mesh, file: str, polygons: NDArray[np.integer], others: str = "in the neutral"
) -> Finding:
    """The finding for polygons, rising, that run the other way round than others."""
    if len(polygons) == len(mesh.faces):
        which = "every polygon runs the other way round: its normals point inwards"
    else:
        which = (
            f"{counted(polygons, 'polygon runs', 'polygons run')} the other way round than "
            f"{others}: {listed(polygons)}"
        )
    return polygon_finding("reversed-winding", mesh, file, polygons, which)


def inside_out(mesh: Mesh) -> NDArray[np.bool_]:
    """(F,) polygons of parts that enclose a volume and are wound towards it.

    Borders are closed by a fan to their middle. Only the largest part and closed ones are looked
    at: a mouth socket that is open is rightly seen from within.
    """
    if not len(mesh.faces):
        return np.zeros(0, dtype=bool)
    points, half = mesh.vertices, HalfEdges.of(mesh.faces, len(mesh.vertices))
    part_of = component_of(len(points), mesh.edges)
    number = int(part_of.max()) + 1
    centres = np.stack([np.bincount(part_of, points[:, i], number) for i in range(3)], axis=1)
    arms = points - (centres / np.bincount(part_of, minlength=number)[:, None])[part_of]
    triangles = mesh.faces.triangles()
    a, b, c = (arms[triangles[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    part = part_of[triangles[:, 0]]
    areas = np.bincount(part, np.linalg.norm(across, axis=1), number) / 2.0
    volumes = np.bincount(part, (a * across).sum(axis=1), number) / 6.0
    start, end = half.start[half.border], half.end[half.border]
    if start.size:
        loop = component_of(len(points), np.stack([start, end], axis=1))[start]
        size = np.maximum(np.bincount(loop), 1)
        middles = np.stack([np.bincount(loop, arms[start][:, i]) for i in range(3)], axis=1)
        fans = ((middles / size[:, None])[loop] * np.cross(arms[end], arms[start])).sum(axis=1)
        volumes += np.bincount(part_of[start], fans, number) / 6.0
    closed = np.bincount(part_of[half.start[half.polygons_of_edge != 2]], minlength=number) == 0
    closed[int(np.argmax(areas))] = True
    holds = 36.0 * np.pi * volumes**2 > _HOLDS * areas**3
    bad = closed & holds & (volumes < 0)
    return np.asarray(bad[part_of[mesh.faces.indices[mesh.faces.offsets[:-1]]]])


Positions = NDArray[np.float64]

# A part is its mirror image if reflecting it leaves less than this part of what turning leaves,
_BETTER = 0.25
# and if turning leaves more than this part of its extent: flat parts are their own mirror image.
_POORLY = 0.005
# A part of which even the better leaves more than this is not itself: a jaw that drops leaves 0.08
# of gums and teeth, a blink 0.05 of lashes, an eyeball laid on itself back to front 0.4.
_UNLIKE = 0.2
# Parts of fewer vertices are bent too easily to tell.
_ENOUGH = 8


@dataclass(frozen=True, eq=False)
class Plausibility:
    """What positions say of a numbering."""

    changes_axes: bool  # the whole comes out as its mirror image, or with other axes
    # (P,) which parts of the neutral come out as their mirror image, or not as themselves at all,
    # while others do not.
    unlike: NDArray[np.bool_]
    farther: bool  # vertices come out farther from the neutral than with the numbers they had
    left: NDArray[np.float64]  # (P,) what moving and turning each part leaves of its extent

    @property
    def plausible(self) -> bool:
        """Whether nothing speaks against it."""
        return not (self.changes_axes or self.farther or self.unlike.any())

    @property
    def unsure(self) -> NDArray[np.bool_]:
        """(P,) parts that fit so badly that they may fit better the other way round."""
        return np.asarray(self.left > _POORLY)

    def better(self, other: Plausibility) -> NDArray[np.bool_]:
        """(P,) which parts fit far better with another numbering."""
        return np.asarray(other.left < _BETTER * self.left)


def plausibility(
    here: Positions,
    there: Positions,
    new_index: NDArray[np.int64],
    parts: Sequence[NDArray[np.int64]],
    scale: float,
) -> Plausibility:
    """Compare positions of a target under a numbering with those of the neutral.

    ``new_index`` is (V,) the number in the neutral of each vertex of the target.
    """
    frame = frame_between(here[new_index], there, scale)
    back = frame.back(there)
    placed = np.empty_like(there)
    placed[new_index] = back
    farther = bool(((placed - here) ** 2).sum() >= ((back - here) ** 2).sum())
    placed[new_index] = there
    fits = [_fit(here[own], placed[own]) for own in parts]
    sense = np.array([fit[0] for fit in fits])
    mirrored = not (sense > 0).any()
    return Plausibility(
        not frame.same_axes or (mirrored and bool((sense < 0).any())),
        (sense < 0) & (not mirrored),
        farther,
        np.array([fit[1] for fit in fits]),
    )


def _fit(here: Positions, there: Positions) -> tuple[int, float]:
    """How a part fits itself, however it is moved and turned, and whatever its size.

    1 where it fits far better than its mirror image, -1 where it does not fit, 0 where that does
    not tell, as of flat parts; and what the best fit leaves, as a part of its extent.
    """
    here, there = here - here.mean(axis=0), there - there.mean(axis=0)
    lengths = float(np.sqrt((here**2).sum() * (there**2).sum()))
    if len(here) < _ENOUGH or lengths == 0:
        return 0, 0.0
    left, sizes, right = np.linalg.svd(there.T @ here / lengths)
    # What is left of both after the better of turning and reflecting, and after the other.
    better = 1.0 - float(sizes.sum())
    other = better + 2.0 * float(sizes[2])
    itself = bool(np.linalg.det(left @ right) > 0)
    remains = better if itself else other
    if better > _UNLIKE:
        return -1, remains
    if other < _POORLY or better > _BETTER * other:
        return 0, remains
    return 1 if itself else -1, remains


# If at most this part of the polygons differs, naming the first helps more than anything else.
_FEW = 0.1

Corners = NDArray[np.int32]

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

    ``seeds`` are pairs (vertex of the neutral, vertex of a target in another order) that are known,
    ``scale`` is the factor from which on sizes are another unit.
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
            found = _rejoined(neutral, target, file, 1e-6 * target.diameter)
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
        mesh = reordered(self.neutral, target, np.arange(len(target.vertices)), corners)
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
        mesh = reordered(self.neutral, target, found.new_index, found.corners)
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


def _rejoined(neutral: Mesh, target: Mesh, file: str, near: float) -> Outcome | None:
    """Look for vertices that were split or welded while the polygons stayed in their order.

    Positions are one up to the distance ``near``. No mesh where positions were lost; None where the
    polygons do not tell.
    """
    ours, theirs = neutral.faces.indices, target.faces.indices
    if not np.array_equal(neutral.faces.offsets, target.faces.offsets):
        triangles = neutral.faces.triangles()
        if len(target.faces) != len(triangles) or (target.faces.sizes != 3).any():
            return None
        ours = triangles.ravel()
    joined = _split if len(target.vertices) > len(neutral.vertices) else _welded
    return joined(neutral, target, ours, theirs, file, near)


def _image(start: Corners, end: Corners, count: int) -> NDArray[np.int64] | None:
    """For each of ``count`` vertices the one it always meets; None where it meets two, or none."""
    image = np.full(count, -1, dtype=np.int64)
    image[start] = end
    return image if np.array_equal(image[start], end) and (image >= 0).all() else None


def _split(
    neutral: Mesh, target: Mesh, ours: Corners, theirs: Corners, file: str, near: float
) -> Outcome | None:
    origin = _image(theirs, ours, len(target.vertices))
    if origin is None:
        return None
    copies = np.bincount(origin, minlength=len(neutral.vertices))
    if not copies.all():
        return None
    points = np.empty_like(neutral.vertices)
    points[origin] = target.vertices
    if (np.abs(points[origin] - target.vertices) > near).any():
        return None
    split = np.flatnonzero(copies > 1)
    message = (
        f"{len(target.vertices):,} vertices instead of {len(neutral.vertices):,}: "
        f"{counted(split, 'vertex is', 'vertices are')} there more than once, at seams: "
        f"{listed(split)}"
    )
    found = finding("split-vertices", file, message, vertices=split)
    return Outcome(neutral.with_vertices(points), (found,), "split vertices joined")


def _welded(
    neutral: Mesh, target: Mesh, ours: Corners, theirs: Corners, file: str, near: float
) -> Outcome | None:
    now = _image(ours, theirs, len(neutral.vertices))
    if now is None or len(np.unique(now)) != len(target.vertices):
        return None
    welded = np.flatnonzero(np.bincount(now)[now] > 1)
    message = (
        f"{len(target.vertices):,} vertices instead of {len(neutral.vertices):,}: "
        f"{len(welded):,} of the neutral were welded into {len(np.unique(now[welded])):,}: "
        f"{listed(welded)}"
    )
    found = finding("welded-vertices", file, message, vertices=welded)
    # Those at one place in the neutral were put together because they were at one place here too.
    first = np.unique(now, return_index=True)[1]
    if (np.abs(neutral.vertices[first[now]] - neutral.vertices) > near).any():
        return Outcome(None, (found,))
    return Outcome(neutral.with_vertices(target.vertices[now]), (found,), "welded vertices parted")
