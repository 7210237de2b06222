"""Hold a rig together where several of its shapes meet."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from elastomorph.errors import ParameterError
from elastomorph.holding.correction import Correction
from elastomorph.holding.lids import lid_corrections
from elastomorph.holding.pairs import Folds, Lips, pair_corrections
from elastomorph.model.morph import Morph
from elastomorph.numbers import is_whole
from elastomorph.rig import Rig
from elastomorph.rig.laws import Corrective
from elastomorph.rig.performance import Performance, slider_weights


@dataclass(frozen=True, eq=False)
class Held:
    """A rig that holds together.

    Attributes:
        rig: The rig with its correctives; its other morphs are the same objects.
        corrections: One row for each corrective that was added, and for what was left out.
    """

    rig: Rig
    corrections: tuple[Correction, ...]


def hold(
    rig: Rig,
    takes: Performance | Iterable[Performance] | None = None,
    lids: bool = True,
    folds: int = 0,
    lips: int = 0,
) -> Held:
    """Add correctives to a rig where its shapes do not fit together.

    What is there already is kept and never doubled: to hold a rig that is held adds nothing.

    Args:
        rig: The rig; it stays as it is.
        takes: Recorded weights that the correctives are fitted to, beside combinations of
            sliders drawn at random.
        lids: Let lids meet that several sliders shut together: two correctives an eye, 0 as long as
            the eye is open.
        folds: Most correctives that undo folds of the skin where two sliders meet in the first half
            of a take, so that the second can tell what was gained. None by default, for the eye
            gains little.
        lips: Most correctives against lips that pass deeper through each other where two sliders
            meet than any slider of a frame takes them alone; chosen as those of folds, before them.

    Returns:
        The rig, and what was added.

    Raises:
        ParameterError: No rig, a take that is none, folds or lips without a take, or nothing that
            could be held.
    """
    if not isinstance(rig, Rig):
        raise ParameterError(f"what is held is a Rig, found {type(rig).__name__}")
    given = [takes] if isinstance(takes, Performance) else list(takes or [])
    for take in given:
        if not isinstance(take, Performance):
            raise ParameterError(f"takes are performances, found {type(take).__name__}")
    for own, most in (("lips", lips), ("folds", folds)):
        if not is_whole(most) or most < 0:
            raise ParameterError(
                f"the number of {own} must be a whole number from 0, found {most!r}"
            )
        if most and not given:
            raise ParameterError(f"{own} are found in takes: give one, or leave {own} at 0")
    rows: list[Correction] = []

    def add(found: Iterator[tuple[Correction, Morph | None]]) -> None:
        nonlocal rig
        for row, morph in found:
            rows.append(row)
            if morph is not None:
                law = Corrective(row.drivers, row.law, row.numbers)
                laws = {**rig.sliders.correctives, row.name: law}
                morphs = {**rig.morphs, row.name: morph}
                rig = Rig(rig.neutral, morphs, correctives=laws, groups=rig.sliders.groups)

    # Correctives that are added drive nothing, so the sliders and their weights stay.
    weights = [slider_weights(rig, take, clip=False) for take in given]
    table = np.concatenate(weights) if weights else None
    if lids:
        add(lid_corrections(rig, table))
    if lips:
        add(pair_corrections(Lips, rig, lips, given))
    if folds:
        add(pair_corrections(Folds, rig, folds, given))
    return Held(rig, tuple(rows))
