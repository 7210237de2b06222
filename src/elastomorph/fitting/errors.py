"""The errors of methods on motions, as `elastomorph.evaluation` measures them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import TimeLawWarning
from elastomorph.evaluation.curve_errors import CurveVertices, curve_errors
from elastomorph.fitting.results import Errors
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method, interpolate

__all__ = ["method_errors", "pooled_errors"]


def method_errors(
    motion: MeshSequence,
    methods: Sequence[Method],
    curves: CurveNetwork,
    along: CurveVertices,
    diameter: float,
) -> NDArray[np.float64]:
    """RMS, LME and LAE of each method over the frames between first and last.

    Returns:
        (methods, 3) fractions of D.
    """
    found = []
    for method in methods:
        with warnings.catch_warnings():
            # The fit says itself how far its laws run back.
            warnings.simplefilter("ignore", TimeLawWarning)
            morph = interpolate(motion.neutral, motion.target, method, curves=curves)
        squared, largest, average = 0.0, 0.0, 0.0
        for time, captured in zip(motion.times[1:-1], motion.frames[1:-1], strict=True):
            positions = morph.at(float(time))
            mean, most = curve_errors(positions, captured, along, diameter)
            squared += float(((positions - captured)[along.indices] ** 2).sum())
            largest, average = max(largest, float(most.max())), max(average, float(mean.max()))
        count = max(len(along.indices) * (len(motion) - 2), 1)
        found.append((np.sqrt(squared / count) / diameter, largest, average))
    return np.array(found)


def pooled_errors(
    labels: Sequence[str], errors: NDArray[np.float64], frames: NDArray[np.integer]
) -> tuple[Errors, ...]:
    """The errors over several motions: RMS over all frames, the mean of LME and LAE.

    Args:
        labels: One a method.
        errors: (motions, methods, 3) RMS, LME and LAE.
        frames: (motions,) frames between first and last.
    """
    rms = np.sqrt(np.average(errors[:, :, 0] ** 2, axis=0, weights=frames))
    means = errors[frames > 0, :, 1:].mean(axis=0)
    return tuple(
        Errors(label, float(r), float(lme), float(lae))
        for label, r, (lme, lae) in zip(labels, rms, means, strict=True)
    )
