"""Where landmarks are on a face, roughly: which way it looks, how large it is, if it is one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.similarity import Similarity, fit_similarity
from elastomorph.errors import CaptureError

Points = NDArray[np.float64]

# Towards the subject's left, up and out of the face; their root mean square is 1.
_TYPICAL: Mapping[str, tuple[float, float, float]] = {
    "nose_tip": (0.0, 0.15, 0.68),
    "right_eye_outer": (-0.85, 0.79, -0.13),
    "right_eye_inner": (-0.33, 0.76, -0.06),
    "left_eye_inner": (0.33, 0.76, -0.06),
    "left_eye_outer": (0.85, 0.79, -0.13),
    "nose_bridge": (0.0, 0.85, 0.23),
    "right_nostril": (-0.25, -0.11, 0.26),
    "left_nostril": (0.25, -0.11, 0.26),
    "mouth_right": (-0.48, -0.51, 0.14),
    "mouth_left": (0.48, -0.51, 0.14),
    "upper_lip": (0.0, -0.37, 0.43),
    "lower_lip": (0.0, -0.69, 0.36),
    "chin": (0.0, -1.28, 0.16),
    "right_jaw": (-1.18, -0.25, -1.13),
    "left_jaw": (1.18, -0.25, -1.13),
}
_FEWEST, _FEWEST_IN_PHOTOGRAPH = 4, 6
# Root mean square distance from the typical face, of one, above which landmarks are on no face.
# Two heads that differ much are 0.15 from it; the landmarks in any other order 0.5 and more.
_NO_FACE = 0.35
# Cosine to the front from which on it is certain which side of a face is seen.
_SIDEWAYS = 0.3


def typical_face(points: Mapping[str, Points], where: str) -> Similarity:
    """The similarity from a typical face to landmarks.

    The typical face has its middle at the origin and a size of 1; x points to the subject's left,
    y up and z out of the face.

    Args:
        points: landmark → (3,).
        where: they are, for messages.

    Raises:
        CaptureError: Fewer than four landmarks, left and right exchanged, or no face.
    """
    names = [name for name in _TYPICAL if name in points]
    if len(names) < _FEWEST:
        raise CaptureError(
            f"{where}: {len(names)} landmarks, expected at least {_FEWEST}; place more with "
            "'elastomorph landmarks'"
        )
    typical = np.array([_TYPICAL[name] for name in names])
    goal = np.array([points[name] for name in names])
    found = fit_similarity(typical, goal)
    off = _distance(found, typical, goal)
    mirrored = _distance(fit_similarity(typical, goal, mirrored=True), typical, goal)
    if mirrored < off / 2:
        raise CaptureError(
            f"{where}: the landmarks are those of a mirrored face: left and right are the "
            "subject's own"
        )
    if off > _NO_FACE:
        raise CaptureError(
            f"{where}: the landmarks do not lie as on a face (they are {off:.0%} of its size from "
            "where they should be): check their names, and that this is a face"
        )
    return found


def require_sides(places: Mapping[str, tuple[float, float]], where: str) -> None:
    """Refuse landmarks of a photograph in which left and right are exchanged.

    A camera far away takes points X to A X + b. Whether it stands before the face or, as it seems
    where sides are exchanged, within the head is the sign of the rows of A, crossed.

    Args:
        places: landmark → (x, y) in pixels.
        where: they are, for messages.

    Raises:
        CaptureError: They are exchanged.
    """
    names = [name for name in _TYPICAL if name in places]
    if len(names) < _FEWEST_IN_PHOTOGRAPH:
        return
    typical = np.array([_TYPICAL[name] for name in names])
    seen = np.array([places[name] for name in names], dtype=np.float64)
    matrix = np.linalg.lstsq(typical - typical.mean(axis=0), seen - seen.mean(axis=0))[0]
    towards = np.cross(matrix[:, 0], matrix[:, 1])
    if towards[2] > _SIDEWAYS * np.linalg.norm(towards) > 0:
        raise CaptureError(
            f"{where}: left and right of the landmarks are exchanged: they are the subject's own, "
            "so that the left eye is on the right of a photograph; place them again"
        )


def _distance(found: Similarity, typical: Points, goal: Points) -> float:
    """Root mean square distance in sizes of the typical face."""
    return float(np.sqrt(((found(typical) - goal) ** 2).sum(axis=1).mean()) / found.scale)
