"""Is a numbering that polygons allow one that positions can mean?

A symmetric piece run backwards fits on its own mirror image polygon by polygon. What tells is where
the vertices are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
        pieces: Vertices of the neutral in pieces that come out as their mirror image while others
            do not.
        farther: The vertices come out farther from the neutral than with the numbers they had.
    """

    whole: bool
    pieces: NDArray[np.int64]
    farther: bool

    def __bool__(self) -> bool:
        return self.whole or self.farther or bool(self.pieces.size)


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
    sense = np.array([_sense(here[own], placed[own]) for own in pieces])
    odd = [own for own, way in zip(pieces, sense, strict=True) if way < 0]
    every = not (sense > 0).any()
    return Doubts(
        not frame.same_axes or (every and bool(odd)),
        np.concatenate([np.zeros(0, dtype=np.int64), *([] if every else odd)]),
        farther,
    )


def _sense(here: NDArray[np.float64], there: NDArray[np.float64]) -> int:
    """1 where points fit themselves far better than their mirror image, -1 where they do not fit.

    However they are turned, and whatever their size; 0 where that does not tell, as of flat pieces.
    """
    if len(here) < _ENOUGH:
        return 0
    here, there = here - here.mean(axis=0), there - there.mean(axis=0)
    lengths = float(np.sqrt((here**2).sum() * (there**2).sum()))
    if lengths == 0:
        return 0
    left, sizes, right = np.linalg.svd(there.T @ here / lengths)
    # What is left of both after the better of the two, and after the other, as a part of all.
    better = 1.0 - float(sizes.sum())
    other = better + 2.0 * float(sizes[2])
    if better > _ASTRAY:
        return -1
    if other < _POORLY or better > _BETTER * other:
        return 0
    return 1 if np.linalg.det(left @ right) > 0 else -1
