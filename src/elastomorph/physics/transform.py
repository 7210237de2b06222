"""From the vertices of a curve to its modes and back, exact at every vertex.

Closed curves: the real Fourier series over their M vertices (Eq. 6, all ⌊M/2⌋ harmonics). Open
curves: cosine modes cos nπu (DCT-II), because a periodic series jumps at the ends and rings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

__all__ = ["ModeTransform", "mode_stiffness"]


@dataclass(frozen=True)
class ModeTransform:
    """The modes of a curve of M vertices.

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
        if self.closed:
            return np.asarray(scipy.fft.rfft(values, axis=-2))
        return np.asarray(scipy.fft.dct(values, type=2, norm="ortho", axis=-2))

    def inverse(self, modes: NDArray[np.floating | np.complexfloating]) -> NDArray[np.float64]:
        """Values (…, M, 3) of modes (…, count, 3)."""
        if self.closed:
            return np.asarray(scipy.fft.irfft(modes, n=self.size, axis=-2))
        return np.asarray(scipy.fft.idct(modes.real, type=2, norm="ortho", axis=-2))


def mode_stiffness(
    modes: NDArray[np.integer], closed: bool, rigidity: float
) -> NDArray[np.float64]:
    """B_n = 16 π⁴ k n⁴ for cos 2nπu and sin 2nπu (Eq. 19), k π⁴ n⁴ for cos nπu."""
    wave = np.pi * modes.astype(np.float64) * (2.0 if closed else 1.0)
    return rigidity * wave**4
