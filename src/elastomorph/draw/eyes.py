"""Irises for eyes that have theirs only in an image, or behind a glass cornea."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.components import component_of
from elastomorph.model.mesh import Mesh

__all__ = ["eye_image", "iris_coordinates"]

SPAN = 0.75
"""The image of the eye spans this many radii of the eyeball to each side of its middle."""
IRIS, PUPIL = 0.47, 0.18
"""Radius of iris and pupil over the radius of the eyeball (human: about 5.9 and 2.3 of 12 mm)."""
ROUND = 0.75
"""Smallest over largest side of the box round a shell that may be an eyeball."""

WHITE = np.array([0.94, 0.93, 0.915])
IRIS_RIM, IRIS_MIDDLE, IRIS_HEART = np.array(
    [[0.16, 0.19, 0.21], [0.37, 0.44, 0.47], [0.50, 0.50, 0.43]]
)
PUPIL_BLACK = np.array([0.035, 0.035, 0.04])


def iris_coordinates(
    mesh: Mesh, shell: NDArray[np.int64], inner: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Where each corner of the eyes' white lies in `eye_image`.

    The eyes are taken to look along +Z in the mesh as it stands. What is no eyeball, or shows an
    iris of its own outside the white, is given the image's white edge.

    Args:
        mesh: The head in its neutral pose.
        shell: Polygon numbers of the eyes' white, ascending.
        inner: Polygon numbers of the irises and pupils that the mesh has of its own.

    Returns:
        (C_shell, 2) from 0 to 1, in the order of the polygons' corners.
    """
    faces = mesh.faces
    corners = np.flatnonzero(_flags(shell, len(faces))[faces.corner_faces])
    corner_label = _components(mesh, corners)
    place = np.zeros((len(corners), 2))
    own = mesh.vertices[faces.indices[_flags(inner, len(faces))[faces.corner_faces]]]
    for label in np.unique(corner_label):
        ball = corner_label == label
        points = mesh.vertices[faces.indices[corners[ball]]]
        low, high = points.min(axis=0), points.max(axis=0)
        sides = high - low
        if sides.min() < ROUND * sides.max():
            continue
        radius = float(sides[:2].mean()) / 2
        middle = (low + high) / 2
        middle[2] = low[2] + radius  # a cornea may bulge in front, nothing does behind
        aside = np.hypot(*(own - middle)[:, :2].T)
        before = (aside < radius / 2) & (own[:, 2] >= points[:, 2].max() - 0.01 * radius)
        if before.any():
            continue
        seen = (points - middle) / radius
        flat = np.clip(0.5 + seen[:, :2] / (2 * SPAN), 0.0, 1.0)
        place[ball] = np.where(seen[:, 2:] > 0, flat, 0.0)
    return place


def eye_image(pixels: int = 512) -> NDArray[np.uint8]:
    """(pixels, pixels, 3) picture of an iris on white, white at the edges."""
    across = (np.arange(pixels) + 0.5) / pixels * 2 * SPAN - SPAN
    x, y = np.meshgrid(across, across)
    out, turn = np.hypot(x, y), np.arctan2(y, x)
    spokes = 0.04 * np.sin(47 * turn) * np.sin(23 * turn + 1.0) + 0.03 * np.sin(71 * turn + 2.0)
    inward = np.clip((IRIS - out) / (IRIS - PUPIL), 0.0, 1.0)
    colour = _mix(IRIS_RIM, IRIS_MIDDLE, _step(inward, 0.0, 0.35))
    colour = _mix(colour, IRIS_HEART, 0.7 * _step(inward, 0.55, 1.0)) + spokes[..., None]
    colour = _mix(colour, PUPIL_BLACK, _step(-out, -PUPIL - 0.012, -PUPIL + 0.012))
    colour = _mix(colour, WHITE, _step(out, IRIS - 0.02, IRIS + 0.02))
    return np.rint(np.clip(colour, 0.0, 1.0) * 255).astype(np.uint8)


def _flags(numbers: NDArray[np.int64], count: int) -> NDArray[np.bool_]:
    flags = np.zeros(count, dtype=bool)
    flags[numbers] = True
    return flags


def _step(values: NDArray[np.float64], start: float, stop: float) -> NDArray[np.float64]:
    """0 below start, 1 above stop, smooth between."""
    s = np.clip((values - start) / (stop - start), 0.0, 1.0)
    return np.asarray(s * s * (3 - 2 * s))


def _mix(
    one: NDArray[np.float64], other: NDArray[np.float64], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    return np.asarray(one + (other - one) * share[..., None])


def _components(mesh: Mesh, corners: NDArray[np.int64]) -> NDArray[np.int32]:
    """For each of these corners of whole polygons, the connected part it belongs to."""
    start = mesh.faces.indices[corners]
    end = mesh.faces.indices[mesh.faces.next_corners[corners]]
    return component_of(len(mesh.vertices), np.stack([start, end], axis=1))[start]
