"""The solved cameras of one pose, and what was found of its surface on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Camera


@dataclass(frozen=True, eq=False)
class SolvedPose:
    """Cameras and points of one pose, in a frame and a unit of their own.

    Attributes:
        cameras: those found, in the order of the photographs' names.
        points: (N, 3) seen by at least three photographs.
        descriptors: (N, 128) float32 of length 1, mean look of each point.
        reprojection: photograph → mean distance of its features from where their points are
            seen, px.
        rejected: photograph → why it is not used.
        lenses: photograph → what took it; the same text, the same lens.
        remarks: sentences about what is unusual without being an error.
    """

    cameras: tuple[Camera, ...]
    points: NDArray[np.float64]
    descriptors: NDArray[np.float32]
    reprojection: Mapping[str, float]
    rejected: Mapping[str, str] = field(default_factory=dict)
    lenses: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
