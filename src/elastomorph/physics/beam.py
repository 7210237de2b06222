"""The beam: every curve of a mesh as an elastic beam, solved mode by mode (Eqs. 3-33).

Prepared once for a set of curves and a material, then applied to any number of targets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.physics.guard import guard_laws
from elastomorph.physics.load import Load
from elastomorph.physics.material import Material
from elastomorph.physics.response import mean_response, modal_response
from elastomorph.physics.transform import ModeTransform

__all__ = ["BASES", "STIFFNESSES", "BeamModes"]

BASES = ("cosine", "fourier")
STIFFNESSES = ("uniform", "length")


@dataclass(frozen=True, eq=False)
class _Group:
    """Curves of one kind and one number of vertices, solved together.

    Attributes:
        vertices: (G, M) vertex indices.
        transform: From M vertices to modes and back.
        laws: (N, K) or (G, N, K) coefficients of t … t^K for the N modes.
    """

    vertices: NDArray[np.int64]
    transform: ModeTransform
    laws: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BeamModes:
    """The time law of every mode of every curve.

    Attributes:
        limit_law: (K,) coefficients of t … t^K of p(t)/p(1); vertices on no curve follow it.
    """

    groups: tuple[_Group, ...]
    limit_law: NDArray[np.float64]

    @classmethod
    def prepare(
        cls,
        curves: Sequence[tuple[NDArray[np.integer], bool]],
        material: Material,
        load: Load,
        *,
        closure: str = "limit",
        basis: str = "cosine",
        harmonics: int | None = None,
        lengths: NDArray[np.float64] | None = None,
    ) -> BeamModes:
        """Find the time laws of all modes.

        Args:
            curves: Vertex indices in order, and whether the curve is closed.
            material: m, c, k.
            load: p(t).
            closure: Time law of mode 0, see `mean_response`.
            basis: Modes of open curves. ``cosine``: B_n = k π⁴ n⁴, free of jumps at the ends.
                ``fourier``: the paper's periodic series, as for closed curves.
            harmonics: Modes above this number follow the limit law; all are solved by default.
            lengths: (curves,) length of each curve over D; B is divided by its fourth power, so
                that short curves are stiffer. All curves are alike by default.

        Raises:
            ParameterError: An option is out of its range.
            ResonanceError: A time law is singular for this material and load.
        """
        if basis not in BASES:
            raise ParameterError(f"basis must be one of {', '.join(BASES)}, found {basis!r}")
        if harmonics is not None and (not isinstance(harmonics, int) or harmonics < 0):
            raise ParameterError(f"harmonics must be a whole number ≥ 0, found {harmonics!r}")
        mean = mean_response(closure, load, material)
        degree = load.order + 1 if mean[-1] != 0 else load.order
        limit = np.zeros(degree)
        limit[: load.order] = load.limit_law

        members: dict[tuple[bool, int], list[int]] = {}
        for number, (vertices, closed) in enumerate(curves):
            periodic = closed or basis == "fourier"
            members.setdefault((periodic, len(vertices)), []).append(number)

        stiffness: list[NDArray[np.float64]] = []
        for (periodic, size), numbers in members.items():
            own = ModeTransform(size, periodic).stiffness(material.rigidity)[1:][:harmonics]
            if lengths is not None:
                with np.errstate(divide="ignore", over="ignore"):
                    own = own / np.asarray(lengths, dtype=float)[numbers, None] ** 4
            stiffness.append(own)
        kinds = ["closed curves" if periodic else "open curves" for periodic, _ in members]
        guard_laws(list(zip(kinds, stiffness, strict=True)), closure, load, material)

        groups = []
        for ((periodic, size), numbers), own in zip(members.items(), stiffness, strict=True):
            transform = ModeTransform(size, periodic)
            laws = np.empty((*own.shape[:-1], transform.count, degree))
            laws[...] = limit
            laws[..., 0, :] = mean[:degree]
            solved = laws[..., 1 : own.shape[-1] + 1, :]
            solved[...] = 0.0
            solved[..., : load.order] = modal_response(own, load, material)
            indices = np.stack([np.asarray(curves[n][0], dtype=np.int64) for n in numbers])
            groups.append(_Group(indices, transform, laws))
        return cls(tuple(groups), limit)

    def bends(self, delta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The bends of t², t³, … for one displacement field.

        With φ_n(t) = Σ_r φ_nr t^r and Σ_r φ_nr = 1, the solution w₀ + Σ_n φ_n(t) Δ_n is
        w₀ + tΔ + Σ_{r≥2} (t^r - t) D_r with D_r = Σ_n φ_nr Δ_n.

        Args:
            delta: (V, 3) displacement from neutral to target.

        Returns:
            (K - 1, V, 3) bends, for the bend curves t² - t … t^K - t.
        """
        bends = np.multiply.outer(self.limit_law[1:], delta)
        if len(bends):
            for group in self.groups:
                modes = group.transform.forward(delta[group.vertices])
                for power in range(len(bends)):
                    weights = group.laws[..., power + 1, None]
                    bends[power, group.vertices] = group.transform.inverse(weights * modes)
        return bends
