"""A morph: the path from a neutral to a target, stored as Δ and bends."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.bend_curve import BendCurve, as_times
from elastomorph.model.mesh import LARGEST, Mesh, require_same_topology
from elastomorph.numbers import as_numbers, path_times


@dataclass(frozen=True)
class Choice:
    """Why the method ``auto`` took a straight line or a bent path.

    Attributes:
        distance: Largest distance, halfway, between the path of ``rotation`` and the straight
            line, as a fraction of D; an upper bound where that was enough to decide.
        allowed: The distance up to which the straight line is taken, as a fraction of D.
        exact: Whether `distance` is the distance itself, not an upper bound.
        shrunk: Vertices that go straight for the target shrinks what is around them to a point, or
            grows it from one, so that there is no rotation to find.
        hidden: Vertices of connected parts that go straight for they end inside the others, where
            nobody sees how they turn.
        eased: Vertices whose bends are smaller because surfaces that face each other, as lips do,
            would pass through each other by more than 0.1 % of D deeper than on the straight line,
            in the neutral and in the target.
        crossing: Vertices that this path leads through the surface they face and the straight line
            does not, at the time with most of them.
        deeper: How much deeper such surfaces still pass through each other than on the straight
            line, in the neutral and in the target, at most, as a fraction of D.
        meeting: Of a pair bend: how many times farther the bends of both paths depart from linear
            than their straight sum moves. `distance` is then how far it moves a vertex, at most.
    """

    distance: float
    allowed: float
    exact: bool = True
    shrunk: int = 0
    hidden: int = 0
    eased: int = 0
    crossing: int = 0
    deeper: float = 0.0
    meeting: float = 0.0

    @property
    def straight(self) -> bool:
        """Whether the straight line was taken."""
        return self.distance <= self.allowed

    @property
    def passing(self) -> str:
        """What was eased where surfaces pass through each other, and what is left, if any."""
        eased = f"{self.eased:,} vertices bend less, not to pass through the surface they face"
        left = f"surfaces pass through each other up to {100 * self.deeper:.2g} % of D deeper"
        left += f", {self.crossing:,} vertices cross" * bool(self.crossing)
        return "; ".join([eased] * bool(self.eased) + [left] * (self.deeper >= 5e-5))

    @property
    def text(self) -> str:
        """What was chosen and why, in a few words."""
        bound = "" if self.exact else "at most "
        off = f"{bound}{100 * self.distance:.2g} % of D"
        gone = f"; {self.shrunk:,} vertices that shrink to a point go straight" * bool(self.shrunk)
        gone += f"; {self.hidden:,} that end inside other parts go straight" * bool(self.hidden)
        gone += f"; {self.passing}" * bool(self.passing)
        if self.meeting:
            return (
                f"auto: pair bend of up to {100 * self.distance:.2g} % of D, for the bends of both "
                f"depart {self.meeting:.2g} times farther than their straight sum moves"
            )
        if self.straight:
            return f"auto: straight, turning differs by {off}{gone}"
        return f"auto: turned, the straight line is {off} away{gone}"


@dataclass(frozen=True, eq=False, repr=False)
class Morph:
    """A path V(t) = V₀ + t·Δ + Σ_k b_k(t)·D_k from a neutral (t = 0) to a target (t = 1).

    Δ = V₁ - V₀ is the ordinary morph target. The bends D_k are further morph targets, each driven
    by a bend curve b_k that is zero at both ends, so software that knows only Δ falls back to
    linear interpolation. Outside [0, 1] the path continues straight along its end tangents.

    Attributes:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1, of the same topology.
        bends: (K, V, 3) float64, read-only, in the unit of the vertices.
        bend_curves: K scalar curves.
        method: How the path was made, for tables and captions.
        limit_law: The bend curve of Δ that a perfectly stiff material would follow: the law at
            which no seam can open between curves.
        bake_error: Largest distance between the stored path and the path it stands for, as a
            fraction of ``neutral.diameter``; 0 where the storage is exact.
        choice: Why ``auto`` chose this path; None where the method was named.
        bare: Whether only the target was known, as in a file of another program: the straight
            line then stands for a path that is still to be chosen.

    Raises:
        TopologyError: Neutral and target differ in vertices or polygons.
        MeshError: The bends have another shape, or are not finite.
        ParameterError: A bend curve is none.
    """

    neutral: Mesh
    target: Mesh
    bends: NDArray[np.float64]
    bend_curves: tuple[BendCurve, ...]
    method: str = "linear"
    limit_law: BendCurve = field(default_factory=lambda: BendCurve.polynomial([0.0]))
    bake_error: float = 0.0
    choice: Choice | None = None
    bare: bool = False

    def __post_init__(self) -> None:
        require_same_topology(self.neutral, self.target)
        curves = self.bend_curves
        listed = isinstance(curves, tuple | list)
        if not listed or not all(isinstance(curve, BendCurve) for curve in curves):
            raise ParameterError(f"bend_curves must be BendCurves, one a bend, found {curves!r}")
        object.__setattr__(self, "bend_curves", tuple(curves))
        bends = _as_bends(self.bends)
        expected = (len(curves), *self.neutral.vertices.shape)
        if bends.shape != expected:
            raise MeshError(f"bends must have shape {expected}, found {bends.shape}")
        if bends.size and not (bends.max() <= LARGEST and bends.min() >= -LARGEST):
            raise MeshError(f"bends must be finite numbers, at most {LARGEST:g}")
        bends.flags.writeable = False
        object.__setattr__(self, "bends", bends)

    @cached_property
    def delta(self) -> NDArray[np.float64]:
        """(V, 3) Δ = V₁ - V₀, read-only."""
        delta = self.target.vertices - self.neutral.vertices
        delta.flags.writeable = False
        return delta

    def at(self, times: ArrayLike) -> NDArray[np.float64]:
        """Vertex positions at one time or at several.

        The ends are exact: ``at(0)`` and ``at(1)`` are the vertices of neutral and target to the
        last bit.

        Args:
            times: A number, or (T,) numbers; 0 is the neutral, 1 the target.

        Returns:
            (V, 3) for a number, (T, V, 3) for an array, float64.

        Raises:
            ParameterError: A time is not a finite number, or beyond 1,000.
        """
        t = path_times(as_times(times))
        moments = np.atleast_1d(t)
        weights = np.zeros((moments.size, len(self.bend_curves)))
        for column, curve in zip(weights.T, self.bend_curves, strict=True):
            column[:] = curve(moments)
        positions = np.empty((moments.size, *self.neutral.vertices.shape))
        for moment, bend_weights, position in zip(moments, weights, positions, strict=True):
            self._straight(float(moment), position)
            for weight, bend in zip(bend_weights, self.bends, strict=True):
                if weight:
                    position += weight * bend
        return positions if t.ndim else positions[0]

    def _straight(self, t: float, out: NDArray[np.float64]) -> None:
        """V₀ + tΔ, counted from the nearer end so that both ends are exact."""
        if t <= 0.5:
            np.multiply(self.delta, t, out=out)
            out += self.neutral.vertices
        else:
            np.multiply(self.delta, t - 1.0, out=out)
            out += self.target.vertices

    def _repr_html_(self) -> str:
        """The viewer, for a notebook."""
        # One of the imports upward that pyproject.toml names: a notebook asks the object itself.
        from elastomorph.viewer.notebook import notebook_html

        return notebook_html(self)

    def __repr__(self) -> str:
        return (
            f"Morph({self.method}, {len(self.neutral.vertices):,} vertices, "
            f"{len(self.bends)} bends)"
        )


def _as_bends(bends: object) -> NDArray[np.float64]:
    """The bends as they are if they are float64, for they may be large."""
    if isinstance(bends, np.ndarray) and bends.dtype == np.float64:
        return bends
    try:
        return as_numbers(bends, "bends")  # type: ignore[arg-type]
    except ParameterError as error:
        raise MeshError(str(error)) from None
