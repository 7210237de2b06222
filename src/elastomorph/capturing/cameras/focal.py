"""Cameras from matches whatever is known of the focal length: by EXIF, fixed, or found by trying.

Started from a focal length that is wrong by a third, mapping finds few cameras or none. Where EXIF
gives none, or few cameras are found with the one it gives, several are tried, from that of a phone
to that of a portrait lens; the one with which most cameras are found is taken, and among those the
one that leaves the smallest errors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.capturing.cameras.matching import Pairs
from elastomorph.capturing.cameras.reconstruction import mapped, verified
from elastomorph.capturing.cameras.sparse import Lens, Shots, Sparse

# Focal lengths in longer sides of the photograph: 43, 28, 61, 86 and 122 mm on 35-mm film.
_LADDER = (1.2, 0.78, 1.7, 2.4, 3.4)
_ENOUGH = 0.9  # of the photographs that have something in common with others
# Matches of a photograph against those of the middle one; with fewer, blurred or of something else,
# no lens would place it.
_IN_COMMON = 0.25


@dataclass(frozen=True)
class Start:
    """What is known of a lens: its photographs' size, a focal length in px, and if that is sure."""

    size: tuple[int, int]
    focal: float | None
    lens: Lens | None = None  # Known already, and kept

    def as_lens(self, ratio: float) -> Lens:
        """The lens, with this focal length in longer sides where none is known."""
        if self.lens is not None:
            return self.lens
        return Lens.plain(self.size, self.focal or ratio * max(self.size))


def found_cameras(
    shots: Shots,
    starts: Sequence[Start],
    pairs: Pairs,
    folder: Path,
    say: Callable[[str], None],
) -> tuple[Sparse | None, float]:
    """The cameras that most photographs agree on, None where none are found, and how many would do.

    Args:
        shots: The photographs.
        starts: What is known of each lens.
        pairs: Matches of them.
        folder: For files that are no longer needed afterwards.
        say: Told what is tried.
    """
    known = all(start.lens or start.focal for start in starts)
    fixed = all(start.lens for start in starts)
    lenses = [start.as_lens(_LADDER[0]) for start in starts]
    kept, geometries = verified(shots, lenses, pairs, known=known)
    in_common = np.zeros(len(shots.names))
    for pair, matches in kept.items():
        in_common[list(pair)] += len(matches)
    enough = _ENOUGH * np.count_nonzero(in_common >= _IN_COMMON * np.median(in_common))
    best: Sparse | None = None
    if known:
        best = mapped(shots, lenses, geometries, folder, fixed=fixed)
        if fixed or (best is not None and best.found >= enough):
            return best, enough
    for ratio in _LADDER:
        say(f"trying a focal length of {ratio:g} times the longer side")
        # What EXIF says did not do, where it said anything.
        lenses = [Start(start.size, None, start.lens).as_lens(ratio) for start in starts]
        _, again = verified(shots, lenses, kept, known=True)
        best = _better(best, mapped(shots, lenses, again, folder))
    return best, enough


def _better(one: Sparse | None, other: Sparse | None) -> Sparse | None:
    """That with more cameras; of as many, that with smaller errors."""
    if one is None or other is None:
        return other if one is None else one

    def merit(sparse: Sparse) -> tuple[Any, ...]:
        return sparse.found, -sparse.error

    return max(one, other, key=merit)
