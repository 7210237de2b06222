"""The other poses, followed by what the neutral's own photographs show.

Matches of single points begin. Then the photographs of the neutral are carried by both surfaces
into those of the pose and what they miss by is measured, first everywhere at once by optical flow
in small photographs, then patch by patch in larger ones; a step of Gauss–Newton on all
photographs with a deformation that is as rigid as possible follows each turn. What is compared is
always the neutral, so that nothing drifts along a chain of poses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import View
from elastomorph.capturing.geometry.deformation import Deformation
from elastomorph.capturing.geometry.sampling import prepared
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.tracking.anchors import Anchors, begun
from elastomorph.capturing.tracking.confidence import (
    beside,
    confidences,
    contradictions,
    expected_errors,
    filled,
    spreads,
    stretched,
)
from elastomorph.capturing.tracking.flow import by_flow
from elastomorph.capturing.tracking.lips import folded
from elastomorph.capturing.tracking.matches import Matches
from elastomorph.capturing.tracking.observations import (
    Observations,
    normal_equations,
    photographs,
    supported,
)
from elastomorph.capturing.tracking.reference import PATCH_RADIUS, Level, Reference
from elastomorph.capturing.tracking.shifts import shifted
from elastomorph.errors import CaptureError

Points = NDArray[np.float64]
Say = Callable[[str, float], None]

# Pixels that D is long at in each turn of flow, and residual from which on it counts less.
_FLOWS, _FLOW_ROBUST = (330.0, 330.0, 330.0, 650.0), 4.0
# Of patches also the correlation that is asked for.
_PATCHES = (
    (650.0, 0.5, 6.0),
    (650.0, 0.5, 5.0),
    (1300.0, 0.5, 5.0),
    (1300.0, 0.5, 4.0),
    (1300.0, 0.5, 4.0),
)
# Stiffness beside observations of one pixel² (flow) and of their own spread (patches).
_FLOW_STIFFNESS = (0.02, 0.2)
_PATCH_STIFFNESS = (0.1, 0.5)
# Photographs that have to show a patch to be believed.
_PATCH_SUPPORT = 2
# Weight of a match beside observations, and its reach in pixels.
_ANCHORED, _ANCHOR_REACH = 1.0, 2.0
# Fewest photographs with which a pose can be followed, and part of the skin that has to be found.
_FEWEST_VIEWS, _LEAST_FOUND = 3, 0.1


@dataclass(frozen=True, eq=False)
class TrackedPose:
    """A pose in the topology of the neutral.

    Attributes:
        vertices: (V, 3) in the frame of the neutral.
        views: (V,) photographs in which each was found; 0 where it was only filled in.
        spread: (V,) length, standard deviation that the photographs leave; infinite where fewer
            than two show it.
        confidence: (V,) in [0, 1].
    """

    vertices: Points
    views: NDArray[np.int64]
    spread: Points
    confidence: Points


def follow(
    reference: Reference,
    views: Sequence[View],
    *,
    start: Points | None = None,
    matches: Matches | None = None,
    say: Say = lambda text, part: None,
) -> TrackedPose:
    """Find the vertices of the neutral in photographs of a pose.

    Args:
        reference: the neutral and its photographs.
        views: photographs of the pose, with cameras in the frame of the neutral.
        start: (V, 3) of a pose like it, followed before; unless given the neutral.
        matches: points of the skin in both.
        say: told what is done and which part of it, in [0, 1], lies behind.

    Raises:
        CaptureError: too few photographs or matches, or the heads do not match.
    """
    if len(views) < _FEWEST_VIEWS:
        raise CaptureError(
            f"a pose is followed in at least {_FEWEST_VIEWS} photographs, found {len(views)}"
        )
    vertices = reference.surface.vertices if start is None else start
    anchors = Anchors.of(reference, vertices, matches)
    sizes = _sizes(reference, views)
    turns = _Turns(reference, sizes, anchors, lambda turn: say(*_told(turn)))
    vertices = turns.patched(turns.flowed(begun(reference, vertices, anchors)))
    level, small = sizes[_PATCHES[-1][0]]
    seen = turns.seen
    cameras, deformation = [view.camera for view in small], reference.deformation
    radius = PATCH_RADIUS * level.pixel
    parts = (
        spreads(cameras, vertices, seen),
        contradictions(cameras, vertices, seen, level.pixel),
        stretched(deformation, vertices, radius),
        beside(deformation, reference.touching, radius),
    )
    spread = np.sqrt(sum(part**2 for part in parts))
    rates = filled(deformation, vertices)
    errors = expected_errors(reference.surface, spread, reference.extent, rates)
    return TrackedPose(
        vertices,
        photographs(seen, len(vertices)),
        spread,
        confidences(errors, reference.extent),
    )


def _told(turn: int) -> tuple[str, float]:
    """What is done in a turn, and which part of all lies behind it."""
    return (
        "optical flow" if turn < len(_FLOWS) else "patches",
        turn / (len(_FLOWS) + len(_PATCHES)),
    )


@dataclass(eq=False)
class _Turns:
    """The turns of looking and solving for one pose; `seen` is what the last one saw."""

    reference: Reference
    sizes: dict[float, tuple[Level, list[View]]]
    anchors: Anchors
    say: Callable[[int], None]
    seen: Observations = field(default_factory=Observations.none)

    def flowed(self, vertices: Points) -> Points:
        """(V, 3) where optical flow in small photographs has the vertices.

        Raises:
            CaptureError: the photographs hardly show the skin of the neutral.
        """
        deformation = self.reference.deformation.around(vertices)
        for turn, head in enumerate(_FLOWS):
            self.say(turn)
            level, small = self.sizes[head]
            self.seen = by_flow(level, small, vertices)
            vertices = self._settled(
                deformation, head, vertices, _FLOW_ROBUST, stiffness=_FLOW_STIFFNESS, steps=2
            )
        known = int(np.count_nonzero(level.seen[0].any(axis=0)))
        part = len(np.unique(self.seen.vertices)) / max(1, known)
        if part < _LEAST_FOUND:
            raise CaptureError(
                f"only {part:.0%} of the skin that photographs of the neutral show was found in "
                "those of the pose: are both of one person and head, and the cameras of both in "
                "one frame?"
            )
        return vertices

    def patched(self, vertices: Points) -> Points:
        """(V, 3) where patches in larger photographs have the vertices."""
        surface = self.reference.surface
        # What only the flow reaches stays where that has it.
        before, deformation = vertices, self.reference.deformation.around(vertices)
        for turn, (head, least, robust) in enumerate(_PATCHES, start=len(_FLOWS)):
            self.say(turn)
            level, small = self.sizes[head]
            turned = self.reference.deformation.rotations(vertices)
            self.seen = _by_patches(level, small, vertices, turned, least)
            vertices = self._patches(deformation, head, vertices, robust)
        turned = self.reference.deformation.rotations(vertices)
        over = folded(surface, vertices, turned)
        if over.any():
            # Order is kept: what was seen of vertices that passed each other is not believed.
            self.seen = self.seen.chosen(~over[self.seen.vertices])
            vertices = np.where(over[:, None], before, vertices)
            vertices = self._patches(deformation, head, vertices, robust)
        return vertices

    def _patches(
        self, deformation: Deformation, head: float, vertices: Points, robust: float
    ) -> Points:
        mixing = self.sizes[head][0].patches.mixing
        return self._settled(
            deformation, head, vertices, robust, stiffness=_PATCH_STIFFNESS, steps=1, mixing=mixing
        )

    def _settled(
        self,
        deformation: Deformation,
        head: float,
        vertices: Points,
        robust: float,
        *,
        stiffness: tuple[float, float],
        steps: int,
        mixing: Any = None,
    ) -> Points:
        """(V, 3) where the vertices are after some steps towards what was seen."""
        level, small = self.sizes[head]
        cameras = [view.camera for view in small]
        for _ in range(steps):
            quadratic, linear = normal_equations(
                cameras, vertices, self.seen, unit=level.pixel, robust=robust, mixing=mixing
            )
            held, pull = self.anchors.equations(vertices, _ANCHORED, _ANCHOR_REACH * level.pixel)
            vertices = deformation.solve(
                vertices,
                quadratic + held,
                linear + pull,
                arap=stiffness[0],
                bending=stiffness[1],
                rounds=2,
            )
        return vertices


def _sizes(reference: Reference, views: Sequence[View]) -> dict[float, tuple[Level, list[View]]]:
    """For each length of D: the neutral, and the photographs of the pose, at that size."""
    heads = sorted({*_FLOWS, *(head for head, *_ in _PATCHES)})
    scales = reference.scales(heads)
    small: list[list[View]] = [[] for _ in heads]
    for view in views:
        for scale, kept in zip(scales, small, strict=True):
            kept.append(view.scaled(scale))
    return {
        head: (reference.level(scale), kept)
        for head, scale, kept in zip(heads, scales, small, strict=True)
    }


def _by_patches(
    level: Level, views: Sequence[View], vertices: Points, rotations: Points, least: float
) -> Observations:
    """What patches of the neutral found in each photograph of the pose show.

    For each vertex and photograph the neutral's photograph is the one that looked most alike at
    it, the turn of the skin taken back.
    """
    surface, patches = level.surface, level.patches
    posed = Surface(vertices, surface.triangles)
    visible = level.seen[0]
    shown, known = level.shown
    places = patches.at(vertices)
    corners = surface.triangles[patches.triangles]
    found = []
    for number, view in enumerate(views):
        camera = view.camera
        seen, cosines = level.looked(posed, camera)
        pixels = camera.project(vertices)[0]
        seen &= view.usable(pixels)
        way = camera.position - vertices
        way = np.einsum("nji,nj->ni", rotations, way / np.linalg.norm(way, axis=1, keepdims=True))
        alike = np.einsum("kni,ni->kn", level.ways, way)
        alike[~visible] = -1
        which = np.flatnonzero(seen & visible.any(axis=0))
        chosen = alike.argmax(axis=0)[which]
        got = shifted(
            patches,
            places,
            camera,
            prepared(view.grey),
            (shown, known, chosen),
            np.all(seen[corners], axis=1),
            which,
            cosines[which],
        )
        good = (got.likeness > least) & (np.abs(got.shifts).max(axis=1) < 5)
        good &= got.information[:, 0, 0] > 0
        mine = got.vertices[good]
        found.append(
            Observations(
                np.full(len(mine), number),
                mine,
                pixels[mine] + got.shifts[good],
                got.information[good],
                got.likeness[good],
            )
        )
    return supported(
        Observations.join([Observations.none(), *found]), len(vertices), _PATCH_SUPPORT
    )
