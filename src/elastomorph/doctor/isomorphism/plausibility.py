"""Is a numbering that polygons allow one that positions can mean?

A symmetric part with its polygons reversed fits on its own mirror image polygon by polygon. What
tells is where the vertices are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.frames import frame_between

Positions = NDArray[np.float64]

# A part is its mirror image if reflecting it leaves less than this part of what turning leaves,
_BETTER = 0.25
# and if turning leaves more than this part of its extent: flat parts are their own mirror image.
_POORLY = 0.005
# A part of which even the better leaves more than this is not itself: a jaw that drops leaves 0.08
# of gums and teeth, a blink 0.05 of lashes, an eyeball laid on itself back to front 0.4.
_UNLIKE = 0.2
# Parts of fewer vertices are bent too easily to tell.
_ENOUGH = 8


@dataclass(frozen=True, eq=False)
class Plausibility:
    """What positions say of a numbering."""

    changes_axes: bool  # the whole comes out as its mirror image, or with other axes
    # (P,) which parts of the neutral come out as their mirror image, or not as themselves at all,
    # while others do not.
    unlike: NDArray[np.bool_]
    farther: bool  # vertices come out farther from the neutral than with the numbers they had
    left: NDArray[np.float64]  # (P,) what moving and turning each part leaves of its extent

    @property
    def plausible(self) -> bool:
        """Whether nothing speaks against it."""
        return not (self.changes_axes or self.farther or self.unlike.any())

    @property
    def unsure(self) -> NDArray[np.bool_]:
        """(P,) parts that fit so badly that they may fit better the other way round."""
        return np.asarray(self.left > _POORLY)

    def better(self, other: Plausibility) -> NDArray[np.bool_]:
        """(P,) which parts fit far better with another numbering."""
        return np.asarray(other.left < _BETTER * self.left)


def plausibility(
    here: Positions,
    there: Positions,
    new_index: NDArray[np.int64],
    parts: Sequence[NDArray[np.int64]],
    scale: float,
) -> Plausibility:
    """Compare positions of a target under a numbering with those of the neutral.

    ``new_index`` is (V,) the number in the neutral of each vertex of the target.
    """
    frame = frame_between(here[new_index], there, scale)
    back = frame.back(there)
    placed = np.empty_like(there)
    placed[new_index] = back
    farther = bool(((placed - here) ** 2).sum() >= ((back - here) ** 2).sum())
    placed[new_index] = there
    fits = [_fit(here[own], placed[own]) for own in parts]
    sense = np.array([fit[0] for fit in fits])
    mirrored = not (sense > 0).any()
    return Plausibility(
        not frame.same_axes or (mirrored and bool((sense < 0).any())),
        (sense < 0) & (not mirrored),
        farther,
        np.array([fit[1] for fit in fits]),
    )


def _fit(here: Positions, there: Positions) -> tuple[int, float]:
    """How a part fits itself, however it is moved and turned, and whatever its size.

    1 where it fits far better than its mirror image, -1 where it does not fit, 0 where that does
    not tell, as of flat parts; and what the best fit leaves, as a part of its extent.
    """
    here, there = here - here.mean(axis=0), there - there.mean(axis=0)
    lengths = float(np.sqrt((here**2).sum() * (there**2).sum()))
    if len(here) < _ENOUGH or lengths == 0:
        return 0, 0.0
    left, sizes, right = np.linalg.svd(there.T @ here / lengths)
    # What is left of both after the better of turning and reflecting, and after the other.
    better = 1.0 - float(sizes.sum())
    other = better + 2.0 * float(sizes[2])
    itself = bool(np.linalg.det(left @ right) > 0)
    remains = better if itself else other
    if better > _UNLIKE:
        return -1, remains
    if other < _POORLY or better > _BETTER * other:
        return 0, remains
    return 1 if itself else -1, remains
