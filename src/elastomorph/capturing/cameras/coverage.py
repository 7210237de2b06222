"""What cameras see of a face, and from where it should be photographed once more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Camera, Surface
from elastomorph.capturing.landmarks import typical_face

Points = NDArray[np.float64]

# Cameras that have to see a vertex for it to be measured, and how much it may be turned away.
_FEWEST, _LEAST_COSINE = 3, 0.2
# Part of the face that may stand before a vertex without hiding it.
_BEFORE = 0.015
# What is asked for: in sizes of the face from the middle of its landmarks, up or down and back.
_TALL, _DEEP = 2.0, 1.1
# Parts of the face's area below which a direction is not worth a sentence, and how many are named.
_LEAST_AREA, _MOST_NAMED = 0.01, 3
# Degrees around the face, to the subject's left, and up; and what that is called.
_DIRECTIONS: Mapping[tuple[float, float], str] = {
    (0, 0): "the front",
    (90, 0): "the subject's left side",
    (-90, 0): "the subject's right side",
    (0, -40): "under the chin",
    (0, 40): "above",
    (45, 0): "halfway to the subject's left",
    (-45, 0): "halfway to the subject's right",
    (45, -40): "below, halfway to the subject's left",
    (-45, -40): "below, halfway to the subject's right",
    (90, -40): "below the subject's left side",
    (-90, -40): "below the subject's right side",
    (60, 40): "above, on the subject's left",
    (-60, 40): "above, on the subject's right",
}
# Part of what the best direction would add for which one named earlier is preferred.
_NEARLY = 0.75


def times_seen(surface: Surface, cameras: Sequence[Camera], tolerance: float) -> NDArray[np.int64]:
    """(V,) how many cameras see each vertex well enough to measure it.

    Args:
        surface: all that is photographed.
        cameras: without distortion.
        tolerance: how far before a vertex something may stand, in the units of the surface.
    """
    count = np.zeros(len(surface.vertices), dtype=np.int64)
    for camera in cameras:
        count += surface.visible(
            camera,
            surface.vertices,
            surface.normals,
            least_cosine=_LEAST_COSINE,
            tolerance=tolerance,
        )[0]
    return count


def missing_cameras(
    surface: Surface, cameras: Sequence[Camera], landmarks: Mapping[str, Points]
) -> str | None:
    """One sentence that says from where more photographs are needed; None where none are.

    Only the face is asked for, the subject's ears to the neck: not the back of the head, nor what
    no camera can see.

    Args:
        surface: the template as it stands among the cameras.
        cameras: of the neutral, without distortion.
        landmarks: landmark → (3,) on the surface.

    Raises:
        CaptureError: The landmarks are not those of a face.
    """
    face = typical_face(landmarks, "the template")
    local = face.inverse()(surface.vertices)
    wanted = np.flatnonzero((np.abs(local[:, 1]) < _TALL) & (local[:, 2] > -_DEEP))
    ways = np.array([_direction(*angles) for angles in _DIRECTIONS]) @ face.rotation.T
    before = _BEFORE * face.scale
    open_to = np.array([_open(surface, wanted, way, before) for way in ways])
    areas = np.where(open_to.any(axis=0), _areas(surface)[wanted], 0)
    lacking = areas * (times_seen(surface, cameras, before)[wanted] < _FEWEST)
    whole, total = areas.sum(), lacking.sum()
    named: list[str] = []
    while len(named) < _MOST_NAMED:
        gains = open_to @ lacking
        if gains.max() < max(_LEAST_AREA * whole, 1e-300):
            break
        best = int(np.argmax(gains >= _NEARLY * gains.max()))
        named.append(list(_DIRECTIONS.values())[best])
        lacking = lacking * ~open_to[best]
    if not named:
        return None
    return (
        f"{total / whole:.0%} of the face is seen by fewer than {_FEWEST} cameras: take more "
        f"photographs from {_listed(named)}"
    )


def _direction(around: float, up: float) -> Points:
    """(3,) in the frame of the typical face, from the face to a camera."""
    a, e = np.radians([around, up])
    return np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])


def _open(
    surface: Surface, some: NDArray[np.int64], way: Points, before: float
) -> NDArray[np.bool_]:
    """(N,) whether a far camera in a direction would see some vertices well."""
    found = np.zeros(len(some), dtype=bool)
    turned = np.flatnonzero(surface.normals[some] @ way > _LEAST_COSINE)
    starts = surface.vertices[some[turned]] + before * way
    found[turned] = ~surface.cast(starts, np.broadcast_to(way, starts.shape)).met
    return found


def _areas(surface: Surface) -> Points:
    """(V,) of the triangles around each vertex, a third each."""
    areas = np.linalg.norm(surface.face_normals, axis=1) / 6
    corners = surface.triangles.ravel()
    return np.bincount(corners, np.repeat(areas, 3), len(surface.vertices)).astype(np.float64)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and from " + names[-1]
