"""What solved cameras are held against beside their reprojection error.

Wrong lenses and wrong cameras can agree with each other to half a pixel. What gives them away is
what photographs of a head are like: the lens of EXIF, an axis near the middle of the photograph,
little distortion, cameras around the head that look at it, and points in front of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.sparse import Sparse
from elastomorph.capturing.photographs.photographs import FEWEST, Photograph
from elastomorph.errors import CaptureError

_FEWEST_POINTS = 200
_WIDEST_ANGLE, _LEAST_SPAN = 60.0, 15.0  # degrees
_OFF_CENTRE, _CROPPED = 0.25, 0.04  # of the longer side
_MOST_DISTORTION = 0.35  # at the corner
_FOCAL_OFF = 0.12
_ERROR, _AT_SIZE = 1.2, 2000  # px mean in a photograph of this longer side


def require_plausible(pose: str, sparse: Sparse, given: int) -> None:
    """Refuse cameras that cannot be.

    Raises:
        CaptureError: And why.
    """
    cameras = [camera for camera in sparse.cameras if camera is not None]
    if len(cameras) < min(FEWEST, given) or len(sparse.points) < _FEWEST_POINTS:
        raise CaptureError(
            f"pose '{pose}': only {len(cameras)} cameras and {len(sparse.points)} points are "
            "found; take more photographs, closer to each other, of skin that is sharp"
        )
    span = spanned(sparse)
    if span < _LEAST_SPAN:
        raise CaptureError(
            f"pose '{pose}': all photographs are taken from within {span:.0f} degrees of each "
            "other; walk around the face, from one ear to the other"
        )
    for camera in cameras:
        longest = max(camera.size)
        off = camera.centre - (np.array(camera.size) - 1) / 2
        corner = float(np.hypot(*camera.size)) / 2 / camera.focal
        if abs(off).max() > _OFF_CENTRE * longest or abs(camera.radial) * corner**2 > (
            _MOST_DISTORTION
        ):
            raise CaptureError(
                f"pose '{pose}': no lens has what was found for {camera.name} (focal length "
                f"{camera.focal:,.0f} px, axis {abs(off).max():,.0f} px off the middle, distortion "
                f"{camera.radial:.2f}); give original photographs, neither cropped nor corrected, "
                "all with the same lens and zoom"
            )


def remarks_on(sparse: Sparse, taken: Sequence[Photograph]) -> Iterator[str]:
    """What is unusual in cameras that may be right."""
    told = set()
    for photograph, camera in zip(taken, sparse.cameras, strict=True):
        if camera is None or photograph.lens in told:
            continue
        told.add(photograph.lens)
        longest = max(camera.size)
        if photograph.focal and abs(camera.focal / photograph.focal - 1) > _FOCAL_OFF:
            yield (
                f"the focal length is {camera.focal:,.0f} px; the EXIF of {photograph.name} says "
                f"{photograph.focal:,.0f} px and was not followed"
            )
        off = camera.centre - (np.array(camera.size) - 1) / 2
        if abs(off).max() > _CROPPED * longest:
            yield (
                f"the axis of the lens is {off[0]:+.0f}, {off[1]:+.0f} px from the middle: the "
                "photographs may be cropped, or turned without their EXIF"
            )
    longest = max(max(photograph.size) for photograph in taken)
    limit = _ERROR * max(0.5, longest / _AT_SIZE)
    if sparse.error > limit:
        yield (
            f"features are {sparse.error:.2f} px from where they should be, {limit:.1f} px is "
            "usual: the face moved between photographs, or the focus changed"
        )
    span = spanned(sparse)
    if span < _WIDEST_ANGLE:
        yield f"the photographs span {span:.0f} degrees only; the sides of the face will lack"


def spanned(sparse: Sparse) -> float:
    """Largest angle between two cameras, seen from the middle of the points, in degrees."""
    middle: NDArray[np.float64] = np.median(sparse.points, axis=0)
    places = [camera.position for camera in sparse.cameras if camera is not None]
    away = np.array(places) - middle
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    return float(np.degrees(np.arccos(np.clip(away @ away.T, -1.0, 1.0).min())))
