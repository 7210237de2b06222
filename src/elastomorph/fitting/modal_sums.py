"""What a fit needs to know of a captured motion: a few sums for each stiffness B.

By Parseval the squared distance between a captured frame and V₀ + Σ_n φ_n(t) Δ_n is a sum over
modes, and all modes of one B share one law φ. With y_n(t) the modes of Y(t) - V₀,

    Σ_n |y_n(t) - φ Δ_n|² = A (φ - C(t)/A)² + S(t) - C(t)²/A,
    A = Σ_n |Δ_n|²,   C(t) = Σ_n Re y_n(t)·Δ̄_n,   S(t) = Σ_n |y_n(t)|².

φ = Σ_r φ_r t^r is linear in its K coefficients, so over all frames of all motions each B keeps no
more than a (K, K) triangle F and K numbers z (one QR factorisation): misfit = ‖F φ - z‖² + rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import Curve
from elastomorph.model.sequence import MeshSequence
from elastomorph.physics import Load, Material, mean_response, modal_response
from elastomorph.physics.beam import ModeTransform
from elastomorph.physics.guard import excursion


@dataclass(frozen=True, eq=False)
class ModalSums:
    """The sums of one motion over some curves; its first and last frame are known and left out.

    Attributes:
        stiffness: (G,) distinct B/k, rising from 0 (the means).
        displacement: (G,) A.
        along: (T, G) C of the inner frames.
        total: S, summed over modes and frames.
        times: (T,) of the inner frames.
        vertices: Number of vertices of the curves.
    """

    stiffness: NDArray[np.float64]
    displacement: NDArray[np.float64]
    along: NDArray[np.float64]
    total: float
    times: NDArray[np.float64]
    vertices: int

    @classmethod
    def joined(cls, parts: Sequence[ModalSums]) -> ModalSums:
        """The sums of several sets of curves in one motion."""
        every = np.concatenate([part.stiffness for part in parts])
        stiffness, group = np.unique(every, return_inverse=True)
        displacement = np.zeros(len(stiffness))
        np.add.at(displacement, group, np.concatenate([part.displacement for part in parts]))
        along = np.zeros((len(stiffness), len(parts[0].times)))
        np.add.at(along, group, np.concatenate([part.along for part in parts], axis=1).T)
        return cls(
            stiffness,
            displacement,
            along.T,
            sum(part.total for part in parts),
            parts[0].times,
            sum(part.vertices for part in parts),
        )


def curve_sums(motion: MeshSequence, curves: Sequence[Curve]) -> list[ModalSums]:
    """The sums of every curve in one motion: cosine modes of open, Fourier modes of closed."""
    found = []
    start = motion.frames[0]
    for curve in curves:
        at = curve.vertices
        transform = ModeTransform(len(curve), curve.closed)
        weights = np.ones(transform.count)
        if curve.closed:  # a real series: modes ±n are stored once, and rfft is not normalised
            weights[1 : (len(curve) + 1) // 2] = 2.0
            weights /= len(curve)
        delta = transform.forward(motion.frames[-1][at] - start[at])
        moved = transform.forward(motion.frames[1:-1, at] - start[at])
        along = weights * (moved * delta.conj()).real.sum(axis=-1)
        squared = weights * (np.abs(moved) ** 2).sum(axis=-1)
        found.append(
            ModalSums(
                transform.stiffness(1.0),
                weights * (np.abs(delta) ** 2).sum(axis=-1),
                along,
                float(squared.sum()),
                motion.times[1:-1],
                len(curve),
            )
        )
    return found


@dataclass(frozen=True, eq=False)
class LawSums:
    """The squared distance to any number of motions as a function of the laws.

    Attributes:
        stiffness: (G,) distinct B/k, rising from 0.
        factors: (G, K, K) F.
        aims: (G, K) z.
        rest: What no law can remove.
        total: The squared distance of the motions from their first frames.
        count: Vertices times inner frames.
        frames: Inner frames.
    """

    stiffness: NDArray[np.float64]
    factors: NDArray[np.float64]
    aims: NDArray[np.float64]
    rest: float
    total: float
    count: int
    frames: int

    @classmethod
    def of(cls, sums: ModalSums, powers: int) -> LawSums:
        """The sums of one motion for laws of t … t^powers."""
        root = np.sqrt(sums.displacement)
        wanted = sums.along.T / np.where(root > 0, root, 1.0)[:, None]  # without motion both are 0
        basis = sums.times[:, None] ** np.arange(1, powers + 1)
        rows = root[:, None, None] * basis
        explained = float((wanted**2).sum())
        rest, count = max(sums.total - explained, 0.0), sums.vertices * len(sums.times)
        whole = cls(sums.stiffness, rows, wanted, rest, sums.total, count, len(sums.times))
        return whole._reduced()

    @classmethod
    def together(cls, parts: Sequence[LawSums]) -> LawSums:
        """The sums of several motions of the same curves."""
        if len(parts) == 1:
            return parts[0]
        return cls(
            parts[0].stiffness,
            np.concatenate([part.factors for part in parts], axis=1),
            np.concatenate([part.aims for part in parts], axis=1),
            sum(part.rest for part in parts),
            sum(part.total for part in parts),
            sum(part.count for part in parts),
            sum(part.frames for part in parts),
        )._reduced()

    def _reduced(self) -> LawSums:
        """The same with any number of rows for each B turned into at most K."""
        missing = max(self.factors.shape[2] - self.factors.shape[1], 0)
        rows = np.pad(self.factors, ((0, 0), (0, missing), (0, 0)))
        wanted = np.pad(self.aims, ((0, 0), (0, missing)))
        basis, factors = np.linalg.qr(rows)
        aims = np.einsum("gij,gi->gj", basis, wanted)
        beyond = wanted - np.einsum("gij,gj->gi", basis, aims)
        return replace(self, factors=factors, aims=aims, rest=self.rest + float((beyond**2).sum()))

    def residuals(self, laws: NDArray[np.float64]) -> NDArray[np.float64]:
        """(G, K) F φ - z for (G, K) coefficients of the laws."""
        return np.asarray(np.einsum("gij,gj->gi", self.factors, laws) - self.aims)

    def misfit(self, laws: NDArray[np.float64]) -> float:
        """Sum of squared distances over vertices and inner frames."""
        return float((self.residuals(laws) ** 2).sum()) + self.rest


EXCURSION = 0.1
# The penalty begins a little before the border, so that what it stops is still inside.
_PENALISED = 0.099
_STEEPNESS = 100.0
_HUGE = 1e6
_LARGEST_LOAD = 100.0
# Laws of materials this much softer or stiffer than any mode no longer change.
_STIFF = 1e-9
_SOFT = 1e3


@dataclass(frozen=True, eq=False)
class Objective:
    """What a fit makes small for some motions: the load has this degree, the means this closure."""

    sums: LawSums
    degree: int
    closure: str

    @cached_property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest value of each parameter.

        For a material at the lowest every law is the limit law to about eight digits.
        """
        b = self.sums.stiffness[1:]
        least, most = (float(b.min()), float(b.max())) if b.size else (1.0, 1.0)
        rest = np.full(self.degree - 1, _LARGEST_LOAD)
        low = np.concatenate([np.full(2, np.log(_STIFF * least)), -rest])
        return low, np.concatenate([np.full(2, np.log(_SOFT * most)), rest])

    @property
    def free(self) -> NDArray[np.bool_]:
        """(R + 1,) which parameters have any influence on the laws.

        A linear load is linear interpolation whatever the material (but for the means of some
        closures); with a quadratic one the mass drops out of every mode but the means. The laws of
        the means depend on m/c only, so a curve of one vertex has no c/k.
        """
        modes = len(self.sums.stiffness) > 1
        forced = self.closure in ("unforced", "rest")
        means = forced or (self.closure == "compatible" and self.degree >= 2)
        damping = modes and (self.degree >= 2 or forced)
        mass = means or (modes and self.degree >= 3)
        return np.array([damping, mass] + [True] * (self.degree - 1))

    def load(self, point: NDArray[np.float64]) -> Load:
        """p(t) at a point, with p(1) = 1."""
        return Load([1.0 - float(point[2:].sum()), *point[2:].tolist()])

    def material(self, point: NDArray[np.float64]) -> Material:
        """The material at a point, with k = 1."""
        damping, mass = np.exp(point[:2]).tolist()
        return Material(mass, damping, 1.0)

    def laws(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """(G, K) coefficients of t … t^K of the law of each B."""
        load, material = self.load(point), self.material(point)
        laws = np.zeros(self.sums.aims.shape)
        with np.errstate(all="ignore"):
            mean = mean_response(self.closure, load, material)
            laws[0, : len(mean)] = mean
            laws[1:, : load.order] = modal_response(self.sums.stiffness[1:], load, material)
        return np.where(np.isnan(laws), _HUGE, np.clip(laws, -_HUGE, _HUGE))

    def excursion(self, point: NDArray[np.float64]) -> float:
        """How far the worst law leaves [0, 1] or runs back."""
        return float(excursion(self.laws(point)).max())

    def misfit(self, point: NDArray[np.float64]) -> float:
        """Squared distance over that of the first frames; the penalty is not in it."""
        return self.sums.misfit(self.laws(point)) / self.sums.total

    def residuals(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """What to make small: distances over those of the first frames, and the penalty."""
        laws = self.laws(point)
        own = self.sums.residuals(laws).ravel() / np.sqrt(self.sums.total)
        penalty = _STEEPNESS * np.maximum(np.minimum(excursion(laws), _HUGE) - _PENALISED, 0.0)
        return np.concatenate([own, penalty])

    def cost(self, point: NDArray[np.float64]) -> float:
        """The misfit and the penalty."""
        return float((self.residuals(point) ** 2).sum()) + self.sums.rest / self.sums.total
