"""One recording to learn from: its frames, which of its vertices count, and its straight line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.evaluation.curve_errors import CurveVertices, free_timing
from elastomorph.fitting.learned import Learned, PathErrors
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence

__all__ = ["Take", "counted_together"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Take:
    """A recording along curves."""

    motion: MeshSequence
    along: CurveVertices
    counted: NDArray[np.bool_] | None = None  # (T, V) which vertices count; all by default

    @cached_property
    def line(self) -> Learned:
        """The straight line between its ends."""
        none = np.zeros((0, *self.motion.mesh.vertices.shape))
        return Learned(self.motion.neutral, self.motion.target, none, ())

    @cached_property
    def nearest(self) -> Floats:
        """(T,) the moments, in order, at which the straight line is nearest to the frames."""
        points = np.unique(self.along.indices)
        first, last = self.motion.frames[0, points], self.motion.frames[-1, points]
        way = (last - first) / np.square(last - first).sum()
        moments = np.array([((frame[points] - first) * way).sum() for frame in self.motion.frames])
        moments = np.clip(moments, 0.0, 1.0)
        moments[[0, -1]] = 0.0, 1.0
        ahead = np.maximum.accumulate(moments)
        behind = np.minimum.accumulate(moments[::-1])[::-1]
        return np.asarray((ahead + behind) / 2)

    def between(self, path: Morph) -> Learned:
        """A path of others between the ends of this recording."""
        return replace(self.line, bends=path.bends, bend_curves=path.bend_curves)

    def errors(self, path: Morph, moments: Floats) -> PathErrors:
        """Those of a path whose (T,) moments the frames are compared with."""
        return PathErrors.of(path, self.motion, moments, self.along, self.counted)

    def closest(self, path: Morph) -> tuple[PathErrors, Floats]:
        """The errors of a path between its ends at the moments, in order, that make them least."""
        own = self.between(path)
        moments = free_timing(own, self.motion, self.along, counted=self.counted)
        return self.errors(own, moments), moments


def counted_together(takes: Sequence[Take]) -> NDArray[np.bool_] | None:
    """(T, V) which vertices count in the frames of all; None where all do."""
    if all(take.counted is None for take in takes):
        return None
    masks = [
        np.ones(take.motion.frames.shape[:2], dtype=np.bool_)
        if take.counted is None
        else take.counted
        for take in takes
    ]
    return np.concatenate(masks)
