"""Which Δ and bends of a rig become morph targets, what they are called, and what is lost.

Bends are turned so that their weights are positive. b_k(t)·D_k is the same as (-b_k(t))·(-D_k),
but not to every program: Blender, for one, holds the weights of imported morph targets between 0
and 1, and plays a path whose bends have the weights t² - t of a beam as a straight line. With
t - t² it plays the path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig


@dataclass(frozen=True, eq=False)
class KeptMorph:
    """The targets of one morph: Δ, then its bends."""

    first: int  # Number of the target with Δ
    bends: tuple[int, ...]  # The bends k that became targets
    # (V, 3) float64 of each of these bends, zero where it hardly moves
    displacements: tuple[NDArray[np.float64], ...]
    dropped_error: float  # How far what was left out can move a vertex, fraction of D
    rounding_error: float  # How far single precision can move a vertex, fraction of D

    @classmethod
    def of(cls, morph: Morph, first: int, tolerance: float) -> KeptMorph:
        """The targets of a morph from number ``first`` on; the tolerance is a fraction of D."""
        scale = morph.neutral.diameter or 1.0
        kept: dict[int, NDArray[np.float64]] = {}
        dropped, rounded = 0.0, _rounding(morph.neutral.vertices) + _rounding(morph.delta)
        for k, (curve, bend) in enumerate(zip(morph.bend_curves, morph.bends, strict=True)):
            moves = _peak(curve) / scale * np.linalg.norm(bend, axis=1)
            small = (moves < tolerance) | (moves == 0)
            dropped += float(moves[small].max(initial=0.0))
            if not small.all():
                kept[k] = np.where(small[:, None], 0.0, bend)
                rounded += _peak(curve) * _rounding(bend)
        return cls(first, tuple(kept), tuple(kept.values()), dropped, rounded / scale)


@dataclass(frozen=True, eq=False)
class MorphTargets:
    """The morph targets of a rig."""

    names: tuple[str, ...]  # One a target
    morphs: tuple[KeptMorph, ...]  # The targets of each morph, in the order of the rig
    dropped: tuple[str, ...]  # Names of the bends left out

    @classmethod
    def of(cls, rig: Rig, tolerance: float) -> MorphTargets:
        """All Δ, and of the bends what moves vertices farther than a fraction of D."""
        names: list[str] = []
        dropped: list[str] = []
        morphs: list[KeptMorph] = []
        taken = set(rig.morphs)
        for name, morph in rig.morphs.items():
            morphs.append(KeptMorph.of(morph, len(names), tolerance))
            names.append(name)
            for k in range(len(morph.bends)):
                title = f"{name}.bend{k + 1}"
                while title in taken:
                    title += "_"
                taken.add(title)
                (names if k in morphs[-1].bends else dropped).append(title)
        return cls(tuple(names), tuple(morphs), tuple(dropped))


def _peak(curve: BendCurve) -> float:
    """The largest |b(t)| on [0, 1], to within a thousandth."""
    return float(np.abs(_samples(curve)).max())


def _samples(curve: BendCurve) -> NDArray[np.float64]:
    """b(t) at 65 times in each piece."""
    return curve(curve.breaks[:-1] + np.linspace(0, 1, 65)[:, None] * np.diff(curve.breaks))


def _rounding(values: NDArray[np.float64]) -> float:
    """The farthest that single precision moves one of (V, 3) vectors."""
    away = values.astype(np.float32) - values
    return float(np.sqrt(np.einsum("vi,vi->v", away, away).max(initial=0.0)))


def with_positive_weights(rig: Rig) -> Rig:
    """The same rig, each bend turned to where its curve is farther above 0 than below.

    Curves of both signs, such as those of several scanned in-betweens, keep a smaller negative
    part.
    """
    morphs = {name: _turned(morph) for name, morph in rig.morphs.items()}
    if all(morphs[name] is morph for name, morph in rig.morphs.items()):
        return rig
    sliders = rig.sliders
    return Rig(rig.neutral, morphs, correctives=sliders.correctives, groups=sliders.groups)


def _turned(morph: Morph) -> Morph:
    values = [_samples(curve) for curve in morph.bend_curves]
    signs = np.array([-1.0 if -own.min() > own.max() else 1.0 for own in values])
    if (signs > 0).all():
        return morph
    curves = tuple(
        curve if sign > 0 else BendCurve(curve.breaks, 0.0 - curve.coefficients)
        for curve, sign in zip(morph.bend_curves, signs, strict=True)
    )
    return replace(morph, bends=signs[:, None, None] * morph.bends, bend_curves=curves)
