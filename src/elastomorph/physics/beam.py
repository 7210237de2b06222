"""The beam: every curve of a mesh as an elastic beam, solved mode by mode (Eqs. 3-33).

Prepared once for a set of curves and a material, then applied to any number of targets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.physics.equation import Load, Material
from elastomorph.physics.response import guard_laws, mean_and_limit, modal_response

BASES = ("cosine", "fourier")
STIFFNESSES = ("uniform", "length")


@dataclass(frozen=True)
class ModeTransform:
    """From the M vertices of a curve to its modes and back, exact at every vertex.

    Closed curves: the real Fourier series over their vertices (Eq. 6, all ⌊M/2⌋ harmonics). Open
    curves: cosine modes cos nπu (DCT-II), because a periodic series jumps at the ends and rings.

    Attributes:
        size: M.
        closed: Fourier modes if true, cosine modes if false.
    """

    size: int
    closed: bool

    @property
    def count(self) -> int:
        """Number of modes, the mean (n = 0) included."""
        return self.size // 2 + 1 if self.closed else self.size

    def stiffness(self, rigidity: float) -> NDArray[np.float64]:
        """(count,) B_n of each mode n from 0 up."""
        return mode_stiffness(np.arange(self.count), self.closed, rigidity)

    def forward(self, values: NDArray[np.float64]) -> NDArray[np.floating | np.complexfloating]:
        """Modes (…, count, 3) of values (…, M, 3)."""
        from scipy import fft  # a third of a second that only beams need

        if self.closed:
            return np.asarray(fft.rfft(values, axis=-2))
        return np.asarray(fft.dct(values, type=2, norm="ortho", axis=-2))

    def inverse(self, modes: NDArray[np.floating | np.complexfloating]) -> NDArray[np.float64]:
        """Values (…, M, 3) of modes (…, count, 3)."""
        from scipy import fft  # a third of a second that only beams need

        if self.closed:
            return np.asarray(fft.irfft(modes, n=self.size, axis=-2))
        return np.asarray(fft.idct(modes.real, type=2, norm="ortho", axis=-2))


def mode_stiffness(
    modes: NDArray[np.integer], closed: bool, rigidity: float
) -> NDArray[np.float64]:
    """B_n = 16 π⁴ k n⁴ for cos 2nπu and sin 2nπu (Eq. 19), k π⁴ n⁴ for cos nπu."""
    wave = np.pi * modes.astype(np.float64) * (2.0 if closed else 1.0)
    return rigidity * wave**4


@dataclass(frozen=True, eq=False)
class _Group:
    """(G, M) vertices of curves of one kind and size; (N, K) or (G, N, K) laws of their N modes."""

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
        mean, limit = mean_and_limit(closure, load, material)
        members: dict[tuple[bool, int], list[int]] = {}
        for number, (vertices, closed) in enumerate(curves):
            periodic = closed or basis == "fourier"
            members.setdefault((periodic, len(vertices)), []).append(number)

        transforms = [ModeTransform(size, periodic) for periodic, size in members]
        stiffness: list[NDArray[np.float64]] = []
        for transform, numbers in zip(transforms, members.values(), strict=True):
            own = transform.stiffness(material.rigidity)[1:][:harmonics]
            if lengths is not None:
                with np.errstate(divide="ignore", over="ignore"):
                    own = own / np.asarray(lengths, dtype=float)[numbers, None] ** 4
            stiffness.append(own)
        kinds = ["closed curves" if periodic else "open curves" for periodic, _ in members]
        guard_laws(list(zip(kinds, stiffness, strict=True)), closure, load, material)

        groups = []
        for transform, numbers, own in zip(transforms, members.values(), stiffness, strict=True):
            laws = np.empty((*own.shape[:-1], transform.count, len(limit)))
            laws[...] = limit
            laws[..., 0, :] = mean
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
