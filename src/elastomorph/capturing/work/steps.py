"""What each stage is made by: the functions of this room, with what a capture has for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.coverage import missing_cameras
from elastomorph.capturing.cameras.fixed_rig import same_cameras
from elastomorph.capturing.cameras.frames import Frame, brought, near_still, still_vertices
from elastomorph.capturing.cameras.solved import SolvedPose
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.landmarks.landmarks import Landmarks, triangulated
from elastomorph.capturing.landmarks.metric import fit_to_scale
from elastomorph.capturing.neutral.neutral import neutral_surface
from elastomorph.capturing.photographs.photographs import Photographs, examine
from elastomorph.capturing.photographs.views import Views
from elastomorph.capturing.tracking.confidence import confidences, expected_errors
from elastomorph.capturing.tracking.matches import Matches
from elastomorph.capturing.tracking.reference import Reference
from elastomorph.capturing.tracking.tracking import follow
from elastomorph.capturing.work.apart import done_apart
from elastomorph.capturing.work.makers import Makers, Pairs, Placed, Posed
from elastomorph.capturing.work.progress import StageSay
from elastomorph.capturing.work.sources import code_of
from elastomorph.capturing.work.template import Template
from elastomorph.errors import CaptureError

__all__ = ["MAKERS", "placed"]

_APART = 0.03  # of the longer side: clicks farther from one point than this are of several
_MODULES = {
    "photographs": ("photographs.photographs",),
    "cameras": ("cameras.cameras",),
    "rig": ("cameras.fixed_rig",),
    "placed": ("landmarks.metric",),
    "neutral": ("neutral.neutral", "tracking.confidence", "cameras.coverage"),
    "frames": ("cameras.frames",),
    "poses": ("tracking.tracking",),
}


def _photographs(pose: str, files: Sequence[Path], masks: Mapping[Path, Path]) -> Photographs:
    return examine(pose, files, masks=masks)


def _cameras(photographs: Photographs, like: SolvedPose | None, say: StageSay) -> SolvedPose:
    found: SolvedPose = done_apart(
        "cameras.cameras.solve_pose", {"photographs": photographs, "like": like}, say
    )
    return found


def _rig(poses: Mapping[str, Photographs], neutral: str, say: StageSay) -> SolvedPose:
    found: SolvedPose = done_apart(
        "cameras.fixed_rig.solve_rig", {"poses": poses, "neutral": neutral}, say
    )
    return found


def _in_rig(
    poses: Mapping[str, Photographs], neutral: str, pose: str, rig: SolvedPose, say: StageSay
) -> SolvedPose:
    same = same_cameras(poses, neutral)[pose]
    given = {"photographs": poses[pose], "rig": rig, "same": same}
    found: SolvedPose = done_apart("cameras.fixed_rig.solve_in_rig", given, say)
    return found


def placed(solved: SolvedPose, template: Template, landmarks: Landmarks, pose: str) -> Placed:
    """The neutral brought to the template by landmarks in its photographs, or to its true size.

    Raises:
        CaptureError: Too few of them, or some of them elsewhere than the others say.
    """
    cameras = {camera.name: camera for camera in solved.cameras}
    points, residuals = triangulated(landmarks.photographs.get(pose, {}), cameras)
    longest = max(max(camera.size) for camera in solved.cameras)
    worst = max(residuals, key=lambda name: residuals[name], default="")
    if worst and residuals[worst] > _APART * longest:
        raise CaptureError(
            f"pose {pose!r}: the clicks of {worst} are {residuals[worst]:.0f} px from any one "
            "point; look at them with 'elastomorph landmarks' and place them again"
        )
    vertices = template.work.vertices
    on_template = {name: vertices[own] for name, own in landmarks.vertices.items()}
    similarity = fit_to_scale(on_template, points, landmarks.distances, f"pose {pose!r}")
    found = {name: similarity(point) for name, point in points.items()}
    return Placed(similarity, found, residuals, {"scale": similarity.scale})


def _neutral(
    template: Template,
    where: Placed,
    solved: SolvedPose,
    landmarks: Landmarks,
    views: Views,
    say: StageSay,
) -> Posed:
    found = neutral_surface(
        views,
        solved.points,
        template.work.vertices,
        template.triangles,
        landmarks.vertices,
        where.points,
        say=say,
    )
    surface = Surface(found.vertices, template.triangles)
    extent = template.work.with_vertices(found.vertices).diameter
    errors = expected_errors(surface, found.spread / np.sqrt(np.maximum(found.covered, 1)), extent)
    measured = {"covered": found.covered, "spread": found.spread}
    places = {name: found.vertices[own] for name, own in landmarks.vertices.items()}
    lacking = missing_cameras(surface, views.cameras, places)
    remarks = [] if lacking is None else [lacking]
    return Posed(found.vertices, confidences(errors, extent), measured, {"remarks": remarks})


def _framed(
    neutral: SolvedPose,
    solved: SolvedPose,
    name: str,
    surface: Posed,
    template: Template,
    landmarks: Landmarks,
    stayed: bool,
) -> Frame:
    still = still_vertices(template.work.vertices, landmarks.vertices)
    near = near_still(neutral.points, surface.vertices, still)
    return brought(neutral, solved, name, still=near, rigid=stayed)


def _reference(template: Template, neutral: Posed, views: Views) -> Reference:
    return Reference(neutral.vertices, template.triangles, views)


def _pose(
    reference: Reference, before: NDArray[np.float64], pairs: Pairs, views: Views, say: StageSay
) -> Posed:
    found = follow(reference, views, start=before, matches=Matches(*pairs), say=say)
    return Posed(found.vertices, found.confidence, {"views": found.views, "spread": found.spread})


def _code(stage: str) -> str:
    return " ".join(code_of(module) for module in _MODULES[stage])


MAKERS = Makers(
    photographs=_photographs,
    cameras=_cameras,
    rig=_rig,
    in_rig=_in_rig,
    placed=placed,
    neutral=_neutral,
    framed=_framed,
    reference=_reference,
    pose=_pose,
    code=_code,
)
