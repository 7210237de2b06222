"""What makes the result of each stage, and what stages hand on beside cameras and surfaces.

Which code a stage is made by: what another version of it made is made anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.coverage import missing_cameras
from elastomorph.capturing.cameras.fixed_rig import same_cameras
from elastomorph.capturing.cameras.frames import Frame, brought, near_still, still_vertices
from elastomorph.capturing.cameras.models import Given, SolvedPose
from elastomorph.capturing.geometry import Camera, Similarity, Surface
from elastomorph.capturing.landmarks import Landmarks, fit_to_scale, triangulated
from elastomorph.capturing.neutral import Painted, neutral_surface, paint
from elastomorph.capturing.photographs import Photographs, Views, examine
from elastomorph.capturing.tracking import Matches, Reference, confidences, expected_errors, follow
from elastomorph.capturing.work.apart import done_apart
from elastomorph.capturing.work.progress import StageSay
from elastomorph.capturing.work.template import Template
from elastomorph.errors import CaptureError
from elastomorph.io.rig_cache import code_version, installed_version

Points = NDArray[np.float64]

_LIBRARIES = ("embreex", "opencv-python-headless", "pillow", "pycolmap", "scipy")


@cache
def versions() -> str:
    """Names the code that makes results: of this package, and of the libraries it hands work to."""
    return " ".join([code_version(), *(f"{one} {installed_version(one)}" for one in _LIBRARIES)])


_APART = 0.03  # of the longer side: clicks farther from one point than this are of several


@dataclass(frozen=True, eq=False)
class Placed:
    """How the neutral's cameras are brought to the template.

    Attributes:
        similarity: From the frame of the cameras to that of the template.
        points: Landmark → (3,) where the photographs show it, in the frame of the template.
        residuals: Landmark → how far its clicks are from it, px.
        figures: What else was measured.
    """

    similarity: Similarity
    points: Mapping[str, Points]
    residuals: Mapping[str, float]
    figures: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Posed:
    """The template on the surface of a pose.

    Attributes:
        vertices: (W, 3) of the template without seams, in its frame and units.
        confidence: (W,) in [0, 1].
        measured: Name → (W,) what the confidence was computed from.
        figures: What else was measured.
    """

    vertices: Points
    confidence: NDArray[np.floating]
    measured: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    figures: Mapping[str, Any] = field(default_factory=dict)


class Makers:
    """What makes the result of each stage, by the functions of the rooms below this one."""

    @property
    def version(self) -> str:
        """Of the code that makes them."""
        return versions()

    def photographs(
        self, pose: str, files: Sequence[Path], masks: Mapping[Path, Path]
    ) -> Photographs:
        """Those of use of a pose's files, with masks by file."""
        return examine(pose, files, masks=masks)

    def cameras(
        self, photographs: Photographs, like: SolvedPose | None, say: StageSay
    ) -> SolvedPose:
        """The cameras of a pose; by those of the neutral, if they are known."""
        given = {"photographs": photographs, "like": like}
        found: SolvedPose = done_apart("cameras.cameras.solve_pose", given, say)
        return found

    def given(self, photographs: Photographs, cameras: Given, say: StageSay) -> SolvedPose:
        """Cameras of a pose that are given, and what its photographs show before them."""
        given = {"photographs": photographs, "given": cameras}
        found: SolvedPose = done_apart("cameras.fixed_rig.solve_with", given, say)
        return found

    def rig(
        self, poses: Mapping[str, Photographs], neutral: str, say: StageSay
    ) -> Mapping[str, SolvedPose]:
        """The cameras that stay, of the neutral and of the poses that helped to solve them."""
        given = {"poses": poses, "neutral": neutral}
        found: Mapping[str, SolvedPose] = done_apart("cameras.fixed_rig.solve_rig", given, say)
        return found

    def in_rig(
        self,
        poses: Mapping[str, Photographs],
        neutral: str,
        pose: str,
        rig: SolvedPose,
        say: StageSay,
    ) -> SolvedPose:
        """The cameras of a pose that are those of a rig, by photographs of it and the neutral."""
        same = same_cameras(poses, neutral)[pose]
        given = {"photographs": poses[pose], "rig": rig, "same": same}
        found: SolvedPose = done_apart("cameras.fixed_rig.solve_in_rig", given, say)
        return found

    def placed(
        self, solved: SolvedPose, template: Template, landmarks: Landmarks, pose: str
    ) -> Placed:
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
        places = points | {camera.name: camera.position for camera in solved.cameras}
        similarity = fit_to_scale(on_template, places, landmarks.distances, f"pose {pose!r}")
        found = {name: similarity(point) for name, point in points.items()}
        return Placed(similarity, found, residuals, {"scale": similarity.scale})

    def neutral(
        self,
        template: Template,
        where: Placed,
        solved: SolvedPose,
        landmarks: Landmarks,
        views: Views,
        say: StageSay,
    ) -> Posed:
        """The template on the neutral's surface; its cameras in the frame of the template."""
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
        spread = found.spread / np.sqrt(np.maximum(found.covered, 1))
        confidence = confidences(expected_errors(surface, spread, extent), extent)
        measured = {"covered": found.covered, "spread": found.spread}
        places = {name: found.vertices[own] for name, own in landmarks.vertices.items()}
        lacking = missing_cameras(surface, views.cameras, places)
        remarks = [] if lacking is None else [lacking]
        return Posed(found.vertices, confidence, measured, {"remarks": remarks})

    def texture(
        self,
        template: Template,
        neutral: Posed,
        cameras: Sequence[Camera],
        photographs: Mapping[str, Path],
        say: StageSay,
    ) -> Mapping[str, Painted]:
        """Material → what photographs show of the neutral in its texture coordinates."""
        surface = Surface(neutral.vertices, template.triangles)
        return paint(template.mesh, surface, template.place, cameras, photographs, say=say)

    def framed(
        self,
        neutral: SolvedPose,
        solved: SolvedPose,
        name: str,
        surface: Posed,
        template: Template,
        landmarks: Landmarks,
        stayed: bool,
    ) -> Frame:
        """How a pose is brought to the neutral, whose cameras are in the frame of the template."""
        still = still_vertices(template.work.vertices, landmarks.vertices)
        near = near_still(neutral.points, surface.vertices, still)
        return brought(neutral, solved, name, still=near, rigid=stayed)

    def reference(self, template: Template, neutral: Posed, views: Views) -> Reference:
        """What all poses are tracked from."""
        return Reference(neutral.vertices, template.triangles, views)

    def pose(
        self,
        reference: Reference,
        before: Points,
        matches: Matches,
        views: Views,
        say: StageSay,
    ) -> Posed:
        """The neutral moved into a pose, begun at the vertices of the pose before."""
        found = follow(reference, views, start=before, matches=matches, say=say)
        measured = {"views": found.views, "spread": found.spread}
        return Posed(found.vertices, found.confidence, measured)
