"""The pictures of a walkthrough, written to files and with words that say what they show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from elastomorph.draw.comparisons import contact_sheet
from elastomorph.draw.pictures import Image, write_picture
from elastomorph.draw.strips import expression_strip
from elastomorph.evaluation.shape import ClosureSeam
from elastomorph.evaluation.words import listed, percent
from elastomorph.model.morph import Morph
from elastomorph.report.images import Picture
from elastomorph.rig import Rig
from elastomorph.rig.sliders import spread_rows, weight_combinations

__all__ = ["closures_picture", "expressions_picture", "jaw_picture", "sheet_picture"]

_SHEET_FACES = 50
_LEVELS = 6


def expressions_picture(morphs: Mapping[str, Morph], file: Path) -> Picture:
    """Expressions growing out of the neutral (Fig. 9)."""
    names = list(morphs)
    return Picture(
        "Expressions",
        expression_strip(morphs, file, face=(200, 250)),
        f"{len(names)} rows of faces, {listed(names)}, growing from the neutral face at t = 0 on "
        "the left to the whole expression at t = 1 on the right.",
        "As in the paper's Figure 9, at an even pace: each expression on the way that the method "
        "auto chose for it. (The paper's quadratic beam takes the straight way at the pace t².) "
        "Look for lips that cross, lids that cut the eye and skin that creases on the way.",
    )


def jaw_picture(morphs: Mapping[str, Morph], target: str, file: Path) -> Picture:
    """One target on several methods where there is no recording to compare with."""
    return Picture(
        f"In-betweens of {target}",
        expression_strip(morphs, file, title=target),
        f"{len(morphs)} rows of faces, {listed(list(morphs))}, from the neutral on the left to "
        f"{target} on the right.",
        "As in the paper's Figure 6, without a recorded row. All rows share their ends. What "
        "differs in between is mostly how early the mouth opens.",
    )


def sheet_picture(morphs: Mapping[str, Morph], file: Path) -> Picture:
    """Faces blended from expressions, chosen evenly from all combinations of weights (Fig. 10)."""
    rig = Rig(next(iter(morphs.values())).neutral, dict(morphs))
    rows = weight_combinations(len(rig.names), _LEVELS)
    chosen = rows[spread_rows(len(rows), _SHEET_FACES)]
    names = ", ".join(rig.names)
    image = contact_sheet(rig, chosen, title=names)
    write_picture(image, file)
    return Picture(
        "Blended faces",
        image,
        f"{len(chosen)} small faces in rows of ten, each a different mixture of {names}.",
        f"As in the paper's Figure 10: {len(chosen)} of the {len(rows):,} combinations of "
        f"{_LEVELS} weights of each expression, spread evenly, at t = 1. Below each face its "
        f"weights of {names}. Weights that sum to more than 1 exaggerate: that is what the "
        "paper's grid asks for.",
    )


def closures_picture(image: Image, target: str, seams: Sequence[ClosureSeam]) -> Picture:
    """What the closure of the mean does to a face, drawn already."""
    by_name = {seam.closure: seam.shape.seam for seam in seams}
    worst, best = max(by_name, key=by_name.__getitem__), min(by_name, key=by_name.__getitem__)
    return Picture(
        "What the closure does",
        image,
        f"{target} halfway, twice, and its mouth close up: whole on the left under the closure "
        "limit, on the right under unforced.",
        "The paper leaves open how the mean of a curve moves. Neighbouring curves have different "
        "means, so a bad choice tears the face between them: seams of up to "
        f"{percent(by_name[worst])} under {worst}, {percent(by_name[best])} under {best}. All "
        "methods of this report use limit unless they say otherwise.",
        wide=False,
    )
