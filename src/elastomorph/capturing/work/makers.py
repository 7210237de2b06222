"""What makes the result of each stage, and what stages hand on beside cameras and surfaces."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.frames import Frame
from elastomorph.capturing.cameras.solved import SolvedPose
from elastomorph.capturing.geometry.similarity import Similarity
from elastomorph.capturing.landmarks.landmarks import Landmarks
from elastomorph.capturing.photographs.photographs import Photographs
from elastomorph.capturing.photographs.views import Views
from elastomorph.capturing.work.progress import StageSay
from elastomorph.capturing.work.template import Template

__all__ = ["Makers", "Pairs", "Placed", "Posed"]

Points = NDArray[np.float64]
Pairs = tuple[Points, Points]
"""(P, 3) points of the neutral and (P, 3) of a pose that look the same, in the neutral's frame."""


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


@dataclass(frozen=True)
class Makers:
    """What makes the result of each stage; the last argument of each is told how far it is.

    Attributes:
        photographs: Pose, its files and masks by file → those of use.
        cameras: Photographs of a pose, and the neutral's cameras if they are known → its cameras.
        rig: Photographs of all poses, by cameras that stay, the name of the neutral → its cameras.
        in_rig: Photographs of all poses or two, name of the neutral and of the pose, what ``rig``
            made → the cameras of the pose.
        placed: The neutral's cameras, template, landmarks, name of the neutral → how they are
            brought together.
        neutral: Template, how it was placed, the neutral's cameras in its frame, landmarks, views
            → surface.
        framed: The neutral's cameras in the frame of the template, those of a pose, its name, the
            neutral's surface, the template and its landmarks, whether the cameras stayed → how the
            pose is brought to the neutral.
        reference: Template, surface of the neutral, its views → what poses are tracked from; made
            once for all of them.
        pose: That, the vertices of the pose before, the points of the neutral and of the pose that
            look the same, its views → the tracked pose.
        code: Name of a stage → the version of its code.
    """

    photographs: Callable[[str, Sequence[Path], Mapping[Path, Path]], Photographs]
    cameras: Callable[[Photographs, SolvedPose | None, StageSay], SolvedPose]
    rig: Callable[[Mapping[str, Photographs], str, StageSay], SolvedPose]
    in_rig: Callable[[Mapping[str, Photographs], str, str, SolvedPose, StageSay], SolvedPose]
    placed: Callable[[SolvedPose, Template, Landmarks, str], Placed]
    neutral: Callable[[Template, Placed, SolvedPose, Landmarks, Views, StageSay], Posed]
    framed: Callable[[SolvedPose, SolvedPose, str, Posed, Template, Landmarks, bool], Frame]
    reference: Callable[[Template, Posed, Views], Any]
    pose: Callable[[Any, Points, Pairs, Views, StageSay], Posed]
    code: Callable[[str], str]
