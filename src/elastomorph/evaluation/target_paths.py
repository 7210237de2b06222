"""Which way each target of a rig needs, and what that costs: straight, turning, or sculpted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from elastomorph.evaluation.shape import ShapeProbe
from elastomorph.evaluation.words import counted
from elastomorph.model.geometry import moved_extent
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Choice, Morph
from elastomorph.paths import prepare
from elastomorph.paths.auto import INBETWEEN_PAYS

_TIMES = (0.25, 0.5, 0.75)
ROW = 16
"""Bytes of a vertex that a morph target moves, in a file: an index and three numbers."""


@dataclass(frozen=True)
class TargetPath:
    """What the method ``auto`` makes of one target.

    Attributes:
        name: The target.
        choice: How far the turning path is from the straight line, and how far it may be.
        bends: Morph targets that the path needs besides the target itself.
        moved: Vertices that these move, summed.
        bake_error: Largest distance of the stored path from the one it stands for, as a fraction
            of D of the neutral.
        flips: Polygons that point against both ends at t = 0.25, 0.5 or 0.75, at most.
        empty: Whether it moves nothing.
    """

    name: str
    choice: Choice
    bends: int
    moved: int
    bake_error: float
    flips: int
    empty: bool = False

    @property
    def bytes(self) -> int:
        """What the bends add to a file that stores an index and a 32-bit offset a moved vertex."""
        return ROW * self.moved

    @property
    def inbetween_pays(self) -> bool:
        """Whether the two ways part so far, or fold the face, that a sculpted shape must decide."""
        return self.choice.distance > INBETWEEN_PAYS or self.flips > 0

    @property
    def words(self) -> str:
        """What the target needs, in a few words."""
        if self.empty:
            return "moves nothing"
        way = "straight is enough" if self.choice.straight else "rotation"
        return f"{way}; an in-between would pay here" if self.inbetween_pays else way


@dataclass(frozen=True)
class TargetPaths:
    """The targets of a rig by falling distance of the two ways.

    Attributes:
        extent: D of the choices: the largest distance between two vertices that a target moves.
        targets: One a target.
    """

    extent: float
    targets: tuple[TargetPath, ...]

    @property
    def summary(self) -> str:
        """How many go which way and what they cost together, in a sentence."""
        turning = sum(not target.choice.straight for target in self.targets)
        empty = sum(target.empty for target in self.targets)
        bends = sum(target.bends for target in self.targets)
        pays = [target.name for target in self.targets if target.inbetween_pays]
        count = len(self.targets)
        said = f"Of {counted(count, 'target')} {count - turning - empty} may go straight"
        if turning:
            size = sum(target.bytes for target in self.targets) / 1e6
            said += (
                f" and {turning} need rotation, which costs {counted(bends, 'more morph target')} "
                f"({size:.2g} MB)"
            )
        if empty:
            said += f"; {empty} move nothing"
        if pays:
            said += f"; an in-between would pay for {', '.join(pays)}"
        return f"{said}."


def target_paths(
    neutral: Mesh,
    targets: Mapping[str, Mesh],
    *,
    progress: Callable[[str], None] = lambda _: None,
    seen: Callable[[str, Morph, float], object] = lambda *_: None,
    known: Mapping[str, Morph] | None = None,
) -> TargetPaths:
    """Prepare ``auto`` for every target and say what it chose.

    Args:
        neutral: The face at rest.
        targets: The targets by name.
        progress: Told the name of each.
        seen: Given each name, its path and D, so that nobody has to keep all paths.
        known: The paths of ``auto`` that are made already, by the names of their targets.

    Raises:
        TopologyError: A target has other vertices or polygons than the neutral.
        BakeError: A turn is too sharp to be stored.
    """
    extent = moved_extent(neutral.vertices, (target.vertices for target in targets.values()))
    to = prepare(neutral, "auto", extent=extent or None, targets=list(targets.values()))
    found = []
    for number, (name, target) in enumerate(targets.items(), start=1):
        progress(f"choosing a path for {name}, {number} of {len(targets)}")
        morph = (known or {}).get(name) or to(target)
        seen(name, morph, extent)
        choice = morph.choice or Choice(0.0, 0.0)
        moved = sum(int(bend.any(axis=1).sum()) for bend in morph.bends)
        bends, error = len(morph.bends), morph.bake_error
        empty = not morph.delta.any()
        found.append(TargetPath(name, choice, bends, moved, error, _flips(morph), empty))
    found.sort(key=lambda path: -path.choice.distance)
    return TargetPaths(extent, tuple(found))


def _flips(morph: Morph) -> int:
    """Polygons turned over in the worst moment."""
    if not len(morph.neutral.faces):
        return 0
    nobody = np.zeros(len(morph.neutral.vertices), dtype=np.int64)
    probe = ShapeProbe.of(morph.neutral, morph.target, nobody)
    return max(probe.flips(morph.at(time)) for time in _TIMES)
