"""Coordinates as whole numbers: KHR_mesh_quantization.

A file that we compress stores positions and morph targets in whole steps of one length, in 16 bits
that stand for -1 to 1; the node that shows the mesh multiplies. The step is as long as the error
asked for allows, and what storing really moves is measured. Normals are stored in 127ths.

Small moves would fit into 8 bits, but once packed take hardly fewer bytes. Other programs rescale
targets only if they have the type of their mesh, and whole numbers only if these are normalized.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.rig import Rig

# A coordinate is off by at most half a step, a vertex by half the diagonal of a cube of steps.
_WORST = np.sqrt(3) / 2
_LARGEST = np.iinfo(np.int16).max
_FARTHEST, _TINY = 1e30, 1e-37


@dataclass(frozen=True, eq=False)
class Grid:
    """Steps in which positions and displacements are stored."""

    scale: float  # Length of 32767 steps, in units of the rig
    origin: NDArray[np.float64]  # (3,) where the steps of positions are counted from

    @classmethod
    def of(cls, rig: Rig, error: float) -> Grid:
        """The longest steps at which no slider is off by more than a fraction of D.

        A vertex sums the errors of the neutral, of Δ, and of each bend times its curve.
        """
        vertices = rig.neutral.vertices
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        sums = [sum(curve.height for curve in m.bend_curves) for m in rig.morphs.values()]
        step = error * (rig.neutral.diameter or 1.0) / (_WORST * (2 + max(sums, default=0.0)))
        fields = [own for m in rig.morphs.values() for own in (m.delta, m.bends)]
        farthest = max(float(np.abs(own).max(initial=0.0)) for own in [high - low, *fields])
        # In single precision, as viewers hold the scale of a node, and no number of steps too large
        # for it where targets move vertices beyond all measure.
        scale = _LARGEST * max(step, farthest / _FARTHEST, _TINY)
        return cls(float(np.float32(scale)), (low + high) / 2)

    @property
    def step(self) -> float:
        """Length of a step, in units of the rig."""
        return self.scale / _LARGEST

    def positions(self, rows: NDArray[np.float64]) -> NDArray[Any]:
        """(N, 3) positions from the origin: int16 steps, or float32 in units of the scale."""
        return self._whole(rows - self.origin)

    def displacements(self, rows: NDArray[np.float64]) -> NDArray[Any]:
        """(N, 3) displacements: int16 steps, or float32 in units of the scale."""
        return self._whole(rows)

    def stored_positions(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) positions as a reader gets them."""
        return self._units(self.positions(rows)) + self.origin

    def stored_displacements(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) displacements as a reader gets them."""
        return self._units(self.displacements(rows))

    def placing(self) -> dict[str, list[float]]:
        """The scale and the translation of the node of the mesh, as JSON."""
        return {"scale": [self.scale] * 3, "translation": self.origin.tolist()}

    def _units(self, stored: NDArray[Any]) -> NDArray[np.float64]:
        """What was stored, in units of the rig."""
        return stored.astype(np.float64) * (self.step if stored.dtype.kind == "i" else self.scale)

    def _whole(self, rows: NDArray[np.float64]) -> NDArray[Any]:
        """In 16 bits; as floats, unrounded, where these do not hold them."""
        whole = np.rint(rows / self.step)
        if np.abs(whole).max(initial=0.0) > _LARGEST:
            return (rows / self.scale).astype("<f4")
        return whole.astype("<i2")


def byte_normals(normals: NDArray[np.float64]) -> NDArray[np.int8]:
    """(N, 3) unit vectors, or what is added to them, in 127ths."""
    found: NDArray[np.int8] = np.rint(127 * np.clip(normals, -1, 1)).astype(np.int8)
    return found


def within_reach(turned: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) what is added to unit normals, with no part of it beyond 1, which is all bytes hold.

    A normal only tells a direction: n + δ is shortened until each part of δ fits. The direction at
    the end of the slider stays what it was.
    """
    end = normals + turned
    # |s·e − n| ≤ 1 for each part: s ≤ (1 ± n) / |e| by the sign of e.
    with np.errstate(all="ignore"):
        room = np.where(end == 0, np.inf, (1 + np.sign(end) * normals) / np.abs(end))
    shorter = np.clip(room.min(axis=1, keepdims=True), 0.0, 1.0)
    return np.where(shorter < 1, shorter * end - normals, turned)


def padded(rows: NDArray[Any]) -> NDArray[np.uint8]:
    """(N, bytes) rows as bytes, each filled up with zeros to fours, as attributes must lie."""
    content = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), -1)
    return np.pad(content, ((0, 0), (0, -content.shape[1] % 4)))


def largest_move(away: Sequence[NDArray[np.float64]]) -> float:
    """The farthest that (V, 3) errors move a vertex together, however they point."""
    total = sum(np.sqrt(np.einsum("vi,vi->v", own, own)) for own in away)
    return float(np.max(total, initial=0.0))
