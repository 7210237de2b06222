"""Is a numbering that polygons allow one that positions can mean?

A symmetric piece run backwards fits on its own mirror image polygon by polygon. What tells is where
the vertices are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.frames import frame_between

__all__ = ["Doubts", "doubts_about"]

# A piece is its mirror image if reflecting it leaves less than this part of what turning leaves,
_BETTER = 0.25
# and if turning leaves more than this part of its extent: flat pieces are their own mirror image.
_POORLY = 0.005
# A piece of which even the better leaves more than this is not itself: a jaw that drops leaves 0.08
# of gums and teeth, a blink 0.05 of lashes, an eyeball laid on itself back to front 0.4.
_ASTRAY = 0.2
# Pieces of fewer vertices are bent too easily to tell.
_ENOUGH = 8


@dataclass(frozen=True, eq=False)
class Doubts:
    """What speaks against a numbering.

    Attributes:
        whole: It comes out as its mirror image, or with other axes.
        astray: (P,) which pieces of the neutral come out as their mirror image, or not as
            themselves at all, while others do not.
        farther: The vertices come out farther from the neutral than with the numbers they had.
        left: (P,) what moving and turning each piece leaves of its extent.
    """

    whole: bool
    astray: NDArray[np.bool_]
    farther: bool
    left: NDArray[np.float64]

    def __bool__(self) -> bool:
        return self.whole or self.farther or bool(self.astray.any())

    @property
    def unsure(self) -> NDArray[np.bool_]:
        """(P,) pieces that fit so badly that they may fit better the other way round."""
        return np.asarray(self.left > _POORLY)

    def better(self, other: Doubts) -> NDArray[np.bool_]:
        """(P,) which pieces fit far better with another numbering."""
        return np.asarray(other.left < _BETTER * self.left)


def doubts_about(
    here: NDArray[np.float64],
    there: NDArray[np.float64],
    new_index: NDArray[np.int64],
    pieces: Sequence[NDArray[np.int64]],
    scale: float,
) -> Doubts:
    """Compare positions under a numbering with those of the neutral.

    Args:
        here: (V, 3) the neutral.
        there: (V, 3) a target in its own order.
        new_index: (V,) number in the neutral of each vertex of the target.
        pieces: The vertices of each piece of the neutral.
        scale: Factors up to this are no change of unit.
    """
    frame = frame_between(here[new_index], there, scale)
    back = frame.back(there)
    placed = np.empty_like(there)
    placed[new_index] = back
    farther = bool(((placed - here) ** 2).sum() >= ((back - here) ** 2).sum())
    placed[new_index] = there
    fits = [_fit(here[own], placed[own]) for own in pieces]
    sense = np.array([fit.sense for fit in fits])
    every = not (sense > 0).any()
    return Doubts(
        not frame.same_axes or (every and bool((sense < 0).any())),
        (sense < 0) & (not every),
        farther,
        np.array([fit.left for fit in fits]),
    )


class _Fit(NamedTuple):
    """How a piece fits itself, however it is moved and turned, and whatever its size.

    Attributes:
        sense: 1 where it fits far better than its mirror image, -1 where it does not fit; 0 where
            that does not tell, as of flat pieces.
        left: What the best fit leaves, as a part of its extent.
    """

    sense: int
    left: float


def _fit(here: NDArray[np.float64], there: NDArray[np.float64]) -> _Fit:
    here, there = here - here.mean(axis=0), there - there.mean(axis=0)
    lengths = float(np.sqrt((here**2).sum() * (there**2).sum()))
    if len(here) < _ENOUGH or lengths == 0:
        return _Fit(0, 0.0)
    left, sizes, right = np.linalg.svd(there.T @ here / lengths)
    # What is left of both after the better of turning and reflecting, and after the other.
    better = 1.0 - float(sizes.sum())
    other = better + 2.0 * float(sizes[2])
    itself = bool(np.linalg.det(left @ right) > 0)
    remains = better if itself else other
    if better > _ASTRAY:
        return _Fit(-1, remains)
    if other < _POORLY or better > _BETTER * other:
        return _Fit(0, remains)
    return _Fit(1 if itself else -1, remains)
