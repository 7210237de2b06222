"""What tracking a take of markers finds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import warn

Floats = NDArray[np.float64]

_OFF = 0.1
# Of the size of the face: 0.08 is between two people, 0.33 where left and right are exchanged.
_UNLIKE = 0.2


def warn_unlike(distances: Floats, rest: Floats) -> None:
    """Warn where most markers are so far from their (M, 3) places that these are hardly theirs."""
    size = np.sqrt(np.square(rest - rest.mean(axis=0)).sum(axis=1).mean())
    part = float(np.nanmedian(distances) / size)
    if part > _UNLIKE:
        warn(
            f"half of the markers are off their places on the rig by {part:.0%} of the size of the "
            "face and more: check that each place is that of its marker, and that left and right "
            "are not exchanged"
        )


@dataclass(frozen=True, eq=False)
class Tracked:
    """The weights of a take, and where the head was.

    Attributes:
        names: J sliders, those that the markers show.
        weights: (T, J) weights; of frames with too few markers those between their neighbours.
        scale: Size of the recorded face over that of the rig.
        rotations: (T, 3, 3) of the head, NaN for frames with too few markers.
        offsets: (T, 3) of the head, in the unit of the markers: y = scale·R·p + offset.
        distances: (T, M) of each marker from the face, in the unit of the rig; NaN where missing.
        trust: (T, M) how much each marker counts, from 0, missing or far off, to 1.
        unseen: Sliders that no marker shows, and that are left out: their weights would be the
            prior's, and 0 whatever the face does.
    """

    names: tuple[str, ...]
    weights: Floats
    scale: float
    rotations: Floats
    offsets: Floats
    distances: Floats
    trust: Floats
    unseen: tuple[str, ...] = ()

    @property
    def left(self) -> Floats:
        """(M,) RMS of what is left of each marker where it counts, in the unit of the rig."""
        counts = self._seen & (self.trust >= _OFF)
        squares = np.square(np.where(counts, self.distances, 0.0)).sum(axis=0)
        with np.errstate(invalid="ignore"):
            left: Floats = np.sqrt(squares / counts.sum(axis=0))
        return left

    @property
    def between(self) -> NDArray[np.intp]:
        """Frames with too few markers."""
        return np.flatnonzero(np.isnan(self.rotations[:, 0, 0]))

    @property
    def _seen(self) -> NDArray[np.bool_]:
        return np.isfinite(self.distances)

    def __str__(self) -> str:
        count = len(self.weights)
        seen, off = self._seen, self._seen & (self.trust < _OFF)
        rms = np.sqrt(np.mean(np.square(self.distances[seen & ~off])))
        said = (
            f"{count:,} frame{'s' * (count != 1)}, scale {self.scale:.4g}, {rms:.3g} left (RMS); "
            f"{(~seen).mean():.1%} of the markers missing, {off.mean():.1%} far off and left out"
        )
        if count := len(self.unseen):
            said += f"; {count} slider{'s' * (count != 1)} that no marker shows left out"
        few = len(self.between)
        return said + (f"; {few:,} frames with too few are between their neighbours" if few else "")
