"""The other poses, followed by what the neutral's own photographs show.

Matches of single points begin. Then the photographs of the neutral are carried by both surfaces
into those of the pose and what they miss by is measured, first everywhere at once by optical flow
in small photographs, then patch by patch in larger ones; a step of Gauss–Newton on all
photographs with a deformation that is as rigid as possible follows each turn. What is compared is
always the neutral, so that nothing drifts along a chain of poses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capture.camera import View
from elastomorph.capture.confidence import confidences, expected_errors, spreads
from elastomorph.capture.deformation import Deformation
from elastomorph.capture.flow import missed, nearest_views
from elastomorph.capture.matches import Matches, consistent
from elastomorph.capture.observations import Observations, normal_equations
from elastomorph.capture.patches import shifted
from elastomorph.capture.reference import Level, Reference, masked, resized
from elastomorph.capture.sampling import prepared
from elastomorph.capture.surface import Surface
from elastomorph.errors import CaptureError

Points = NDArray[np.float64]
Say = Callable[[str, float], None]

# Pixels that D is long at, and correlation that is asked for, in each turn.
_FLOWS = ((330.0, 2, 0.4, 6.0), (650.0, 1, 0.5, 5.0))
_PATCHES = (
    (650.0, 0.5, 6.0),
    (650.0, 0.5, 5.0),
    (1300.0, 0.5, 5.0),
    (1300.0, 0.5, 4.0),
    (1300.0, 0.5, 4.0),
)
# Stiffness beside observations of one pixel² (flow) and of their own spread (patches).
_FLOW_STIFFNESS = ((0.02, 0.2), (0.01, 0.08))
_PATCH_STIFFNESS = (0.1, 0.5)
# Fewest photographs and matches with which a pose can be followed.
_FEWEST_VIEWS, _FEWEST_MATCHES = 3, 12


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
    if matches is not None:
        vertices = begun(reference, vertices, matches)
    turns = len(_FLOWS) + len(_PATCHES)
    for turn, ((head, sources, least, robust), stiffness) in enumerate(
        zip(_FLOWS, _FLOW_STIFFNESS, strict=True)
    ):
        say("optical flow", turn / turns)
        level, small = _at(reference, views, head)
        seen = by_flow(level, small, vertices, least, sources)
        vertices = settled(reference.deformation, level, small, vertices, seen, robust, stiffness)
    for turn, (head, least, robust) in enumerate(_PATCHES, start=len(_FLOWS)):
        say("patches", turn / turns)
        level, small = _at(reference, views, head)
        seen = by_patches(level, small, vertices, reference.deformation.rotations(vertices), least)
        vertices = settled(
            reference.deformation,
            level,
            small,
            vertices,
            seen,
            robust,
            _PATCH_STIFFNESS,
            level.patches.mixing,
        )
    spread = spreads([view.camera for view in small], vertices, seen)
    errors = expected_errors(reference.surface, spread, reference.extent)
    return TrackedPose(
        vertices,
        np.bincount(seen.vertices, minlength=len(vertices)),
        spread,
        confidences(errors, reference.extent),
    )


def _at(reference: Reference, views: Sequence[View], head: float) -> tuple[Level, list[View]]:
    """The neutral, and the photographs of the pose, at a size."""
    scale = reference.scales([head])[0]
    return reference.level(scale), [resized(view, scale) for view in views]


def begun(reference: Reference, start: Points, matches: Matches) -> Points:
    """(V, 3) the surface as matches alone have it, begun at another pose."""
    surface, extent = reference.surface, reference.extent
    closest = surface.closest(matches.neutral)
    corners = surface.triangles[closest.triangles]
    on_start = np.einsum("ni,nij->nj", closest.weights, start[corners])
    lift = matches.neutral - closest.points
    good = closest.distances < 0.01 * extent
    good[good] = consistent(matches.chosen(good), (on_start + lift)[good], extent)
    if np.count_nonzero(good) < _FEWEST_MATCHES:
        raise CaptureError(
            f"{np.count_nonzero(good)} points of the skin were found both in the neutral and in "
            f"the pose, expected at least {_FEWEST_MATCHES}: are both of one person, sharp, and "
            "lit alike?"
        )
    goal, corners, weights = (matches.pose - lift)[good], corners[good], closest.weights[good]
    deformation = reference.deformation.around(start)
    vertices = start
    for robust, bending in ((0.1, 0.5), (0.03, 0.5), (0.015, 0.2), (0.01, 0.2), (0.01, 0.2)):
        off = goal - np.einsum("ni,nij->nj", weights, vertices[corners])
        pull = 1 / (1 + (off**2).sum(axis=1) / (robust * extent) ** 2) ** 2
        quadratic, linear = np.zeros((len(start), 3, 3)), np.zeros_like(start)
        for corner, weight in zip(corners.T, (weights * pull[:, None]).T, strict=True):
            np.add.at(quadratic, corner, weight[:, None, None] * np.eye(3))
            np.add.at(linear, corner, weight[:, None] * (vertices[corner] + off))
        vertices = deformation.solve(vertices, quadratic, linear, arap=0.02, bending=bending)
    return vertices


def settled(
    deformation: Deformation,
    level: Level,
    views: Sequence[View],
    vertices: Points,
    seen: Observations,
    robust: float,
    stiffness: tuple[float, float],
    mixing: Any = None,
) -> Points:
    """(V, 3) where the vertices are after a step or two towards what was seen."""
    cameras = [view.camera for view in views]
    for _ in range(2 if mixing is None else 1):
        quadratic, linear = normal_equations(
            cameras, vertices, seen, unit=level.pixel, robust=robust, mixing=mixing
        )
        vertices = deformation.solve(
            vertices, quadratic, linear, arap=stiffness[0], bending=stiffness[1], rounds=2
        )
    return vertices


def by_flow(
    level: Level, views: Sequence[View], vertices: Points, least: float, sources: int
) -> Observations:
    """What optical flow from some photographs of the neutral into each of the pose shows."""
    neutral = level.surface.vertices
    posed = Surface(vertices, level.surface.triangles)
    cameras = [view.camera for view in level.views]
    found = []
    for number, view in enumerate(views):
        seen, cosines = level.looked(posed, view.camera)
        seen &= masked(view, view.camera.project(vertices)[0])
        near = nearest_views(cameras, neutral.mean(axis=0), view.camera, vertices.mean(axis=0))
        taken = [(level.views[i], level.depths[i], level.seen[0][i]) for i in near[:sources]]
        found += missed(number, view, posed, neutral, taken, (seen, cosines), least)
    return Observations.join(found)


def by_patches(
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
        seen &= masked(view, pixels)
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
    return Observations.join(found)
