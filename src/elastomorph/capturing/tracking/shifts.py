"""Patches of skin found again in a photograph, to a fraction of a pixel.

What the neutral's photographs show at the samples of a patch is looked for in a photograph of the
pose: each patch is shifted by the displacement that fits best after brightness and contrast are
fitted too (Lucas and Kanade, IJCAI 1981; Baker and Matthews, IJCV 56(3), 2004).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera
from elastomorph.capturing.geometry.sampling import sampled
from elastomorph.capturing.tracking.patches import Patches

Points = NDArray[np.float64]
Single = NDArray[np.float32]

# Grey values: what a photograph's noise and rounding leave at least; a flat patch's contrast.
_NOISE = 1.0
# Samples of a blurred photograph tell less than as many independent ones.
_CORRELATED = 3.0
# Pixels that cameras are off by at least.
_FLOOR = 0.12


@dataclass(frozen=True, eq=False)
class Shifts:
    """Where patches were found in one photograph.

    Attributes:
        vertices: (N,) their middles.
        shifts: (N, 2) in pixels from where the surface has them.
        information: (N, 2, 2) inverse covariance, per pixel².
        likeness: (N,) correlation of neutral and pose after the shift.
    """

    vertices: NDArray[np.int64]
    shifts: Points
    information: Points
    likeness: Points


def shifted(
    patches: Patches,
    places: Points,
    camera: Camera,
    picture: Single,
    reference: tuple[NDArray[np.uint8], NDArray[np.bool_], NDArray[np.int64]],
    seen: NDArray[np.bool_],
    vertices: NDArray[np.int64],
    cosines: Points,
) -> Shifts:
    """Find patches in a photograph of the pose by one step of Gauss–Newton each.

    Args:
        patches: of the neutral.
        places: (S, 3) their samples on the surface of the pose so far.
        camera: of the photograph.
        picture: (H, W, 3) float32 its grey values and their changes along x and y.
        reference: (K, S) uint8 what the neutral's photographs show at the samples, (K, S) which
            samples they see, and (N,) which of the K is asked for each vertex.
        seen: (S,) which samples this photograph sees.
        vertices: (N,) whose patches are looked for.
        cosines: (N,) between their normals and the direction to the camera.
    """
    entries, owners = patches.entries(vertices)
    samples = patches.samples[entries]
    shown, known, chosen = reference
    chosen = chosen[owners]
    usable = seen[samples] & known[chosen, samples]
    entries, owners, samples, chosen = (x[usable] for x in (entries, owners, samples, chosen))
    values = np.zeros((len(places), 3), dtype=np.float32)
    values[seen] = sampled(picture, camera.project(places[seen])[0])
    values = values[samples]
    weight = patches.closeness[entries]
    here = shown[chosen, samples].astype(np.float32)
    sums = _Sums(owners, weight, len(vertices))
    return _solved(sums, here, values, patches.ramps[entries], vertices, cosines)


class _Sums:
    """Weighted sums over the entries of each vertex."""

    def __init__(self, owners: NDArray[np.int64], weights: Single, count: int) -> None:
        self._owners, self._weights, self._count = owners, weights, count
        self.total = np.bincount(owners, weights, count)
        self.effective = self.total**2 / np.maximum(np.bincount(owners, weights**2, count), 1e-9)

    def __call__(self, values: Single) -> Points:
        weights = (self._weights * values).astype(np.float64)
        return np.asarray(np.bincount(self._owners, weights, self._count), dtype=np.float64)

    def centred(self, values: Single) -> Single:
        """Values less the mean of their vertex."""
        mean = self(values) / np.maximum(self.total, 1e-9)
        less: Single = values - mean[self._owners].astype(np.float32)
        return less


def _solved(
    sums: _Sums,
    here: Single,
    values: Single,
    ramps: Single,
    vertices: NDArray[np.int64],
    cosines: Points,
) -> Shifts:
    """Shift, contrast and shading of each patch: I + ∇I · u = α R + β + γ · x."""
    there = sums.centred(values[:, 0])
    columns = [values[:, 1], values[:, 2], here, ramps[:, 0], ramps[:, 1]]
    columns = [sums.centred(column) for column in columns]
    count = len(columns)
    matrix = np.empty((len(vertices), count, count))
    right = np.empty((len(vertices), count))
    for i, one in enumerate(columns):
        for j in range(i, count):
            matrix[:, i, j] = matrix[:, j, i] = sums(one * columns[j])
        right[:, i] = sums(one * there)
    total = np.maximum(sums.total, 1e-9)
    floor = _NOISE**2 * total
    # Only what contrast and shading cannot explain tells of a shift.
    own = matrix[:, 2:, 2:] + (1e-4 * total)[:, None, None] * np.eye(count - 2)
    explained = np.linalg.solve(own, matrix[:, 2:, :2])
    tensor = matrix[:, :2, :2] - matrix[:, :2, 2:] @ explained
    goal = np.einsum("nij,ni->nj", explained, right[:, 2:]) - right[:, :2]
    damped = tensor + (1e-2 * floor)[:, None, None] * np.eye(2)
    shifts = np.linalg.solve(damped, goal[..., None])[..., 0]
    # What is left of both after the shading, and how alike it is.
    change = np.concatenate([shifts, np.zeros((len(vertices), count - 2))], axis=1)
    moved = right + np.einsum("nij,nj->ni", matrix, change)
    energy = sums(there * there) + np.einsum("ni,ni->n", change, right + moved)
    shade = np.linalg.solve(own[:, 1:, 1:], np.stack([moved[:, 3:], matrix[:, 3:, 2]], axis=2))
    energy -= np.einsum("ni,ni->n", shade[..., 0], moved[:, 3:])
    along = moved[:, 2] - np.einsum("ni,ni->n", shade[..., 0], matrix[:, 3:, 2])
    contrast = matrix[:, 2, 2] - np.einsum("ni,ni->n", shade[..., 1], matrix[:, 3:, 2])
    energy, contrast = np.maximum(energy, 0), np.maximum(contrast, 1e-9)
    likeness = along / np.sqrt((contrast + floor) * (energy + floor))
    left = np.maximum(energy - along**2 / contrast, 0) / total + _NOISE**2
    spread = (
        np.linalg.inv(damped)
        * (left * total * _CORRELATED / np.maximum(sums.effective * cosines, 1.0))[:, None, None]
    )
    information = np.linalg.inv(spread + _FLOOR**2 * np.eye(2))
    information[sums.effective < 12] = 0
    return Shifts(vertices, shifts, information, likeness)
