"""Sections on orbits: how far methods leave the arc of the jaw, and the eyeball under a lid."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from elastomorph.draw.hinge import eyelid_graph, hinge_graph, looks_of
from elastomorph.draw.pictures import Image
from elastomorph.evaluation.rigid_bodies import Eyelid, Hinge, HingeError
from elastomorph.evaluation.words import SPACE, Lengths, counted, listed, percent
from elastomorph.model.morph import Morph
from elastomorph.report.document import Section
from elastomorph.report.images import Graph, Picture

__all__ = ["Jaw", "eyelid_section", "hinge_section"]

_ALIKE = 1.05
"""Times the smallest distance: no more than that apart, methods do equally well."""
_LAST_DIGIT = 1e-5
"""As a fraction of D: the last digit of the table."""
_LEAST = "0.001"


@dataclass(frozen=True, eq=False)
class Jaw:
    """The jaw on its hinge.

    Attributes:
        hinge: What turns.
        morphs: Its paths, by the labels of their methods.
        errors: How far each method leaves the arc.
        image: What turns, coloured by its distance from the arc, drawn already.
    """

    hinge: Hinge
    morphs: Mapping[str, Morph]
    errors: list[HingeError]
    image: Image


def hinge_section(jaw: Jaw, target: str, unit: str = "") -> Section:
    """The numbers, the picture and the graph of a jaw on its hinge."""
    hinge, errors = jaw.hinge, jaw.errors
    lengths = Lengths(hinge.neutral.diameter, unit)
    worst = max(errors, key=lambda error: error.parts)
    best = min(errors, key=lambda error: error.parts)
    picture = Picture(
        "On the hinge",
        jaw.image,
        f"{counted(len(errors), 'picture')} of what turns with {target}, halfway: "
        f"{worst.label} is darkest, up to {lengths(worst.parts)} off the arc.",
        "Pale is on the arc, dark is off it, on one scale for all. A straight line cuts the corner "
        "of every arc, most of all where the way is longest.",
    )
    graph = Graph.drawn(
        lambda file: hinge_graph(hinge, jaw.morphs, file, unit),
        "hinge",
        "The way of the jaw",
        f"Left the way of one vertex, right the distance from the arc over time. {worst.label} "
        f"leaves the arc by up to {lengths(worst.parts)}, {best.label} by no more than "
        f"{_length(best.parts, lengths)}.",
        "Left the broad green line is the true arc: linear is its chord, whatever its timing. "
        "Right: the farthest vertex of all that turns, at even timing.",
    )
    content = {
        "headline": _headline(best, errors, lengths),
        "words": _words(hinge, target),
        "caption": "Largest distance from the true arc at t = 0.25, 0.5 and 0.75, in % of D",
        **_table(hinge, errors, lengths),
        "picture": picture,
        "graph": graph,
    }
    return Section("hinge", "The jaw on its hinge", content)


def eyelid_section(
    lid: Eyelid,
    morphs: Mapping[str, Morph],
    dips: Mapping[str, float],
    target: str,
    unit: str = "",
) -> Section:
    """The way of a lid over the eyeball by labelled paths, and how far they dip (Fig. 2)."""
    lengths = Lengths(next(iter(morphs.values())).neutral.diameter, unit)
    worst, best = max(dips, key=dips.__getitem__), min(dips, key=dips.__getitem__)
    told = f"by {_length(dips[worst], lengths)} on {worst}, by {_length(dips[best], lengths)}"
    graph = Graph.drawn(
        lambda file: eyelid_graph(lid, morphs, file, unit),
        "eyelid",
        "The way of the lid",
        f"Left the way of the lid's edge beside the eyeball, right its height above it over time: "
        f"it sinks towards the eye {told} on {best}.",
        "As in the paper's Figure 2: a straight line is a chord that cuts towards the eye.",
    )
    headline = f"With {target} the edge of the lid sinks towards the eye {told} on {best}."
    return Section("eyelid", "The eyelid on the eyeball", {"headline": headline, "graph": graph})


def _words(hinge: Hinge, target: str) -> str:
    """What turns, by how much, and why its arc is known."""
    parts, along = _names(hinge)
    words = (
        f"With {target}, {parts} ({counted(len(hinge.parts), 'vertex', 'vertices')}) turn as one "
        f"rigid body by {math.degrees(hinge.screw.angle):.1f}°"
    )
    if len(hinge.along):
        words += f", and {along} ({counted(len(hinge.along), 'vertex', 'vertices')}) with them"
    words += (
        ". Neutral and target give the axis away, so here the true way is known: every vertex runs "
        "on a circle."
    )
    if hinge.residual > _LAST_DIGIT:
        words += (
            f" The target itself is up to {percent(hinge.residual)} off a rigid turn, which no "
            "method can undo: it is in the numbers, and is what the graph shows at t = 1."
        )
    return words


def _names(hinge: Hinge) -> tuple[str, str]:
    own = looks_of(hinge.neutral, hinge.parts)
    more = [name for name in looks_of(hinge.neutral, hinge.along) if name not in own]
    return (listed(own) if own else "rigid parts", listed(more) if more else "others")


def _headline(best: HingeError, errors: Sequence[HingeError], lengths: Lengths) -> str:
    straight = next((error for error in errors if error.label == "linear"), None)
    good = [error.label for error in errors if error.parts <= max(_ALIKE * best.parts, _LAST_DIGIT)]
    verb = "keeps" if len(good) == 1 else "keep"
    most = max(error.parts for error in errors if error.label in good)
    said = f"{listed(good)} {verb} the jaw within {_length(most, lengths)} of its arc"
    if straight is None or straight.label in good:
        return f"{said}."
    return f"{said}; a straight line leaves it by {lengths(straight.parts)}."


def _length(fraction: float, lengths: Lengths) -> str:
    """As a length and in % of D; what the table shows as 0 is not written to more digits."""
    return lengths(fraction) if fraction > _LAST_DIGIT else f"{_LEAST}{SPACE}% of D"


def _table(
    hinge: Hinge, errors: Sequence[HingeError], lengths: Lengths
) -> dict[str, Sequence[object]]:
    parts, along = _names(hinge)
    heads = ["Method", parts.capitalize()]
    if len(hinge.along):
        heads.append(along.capitalize())
    rows = []
    for error in errors:
        values = (error.parts, error.along)[: len(heads) - 1]
        most = max(values)
        less = "" if most > _LAST_DIGIT else f"<{SPACE}"
        length = f"{less}{lengths.plain(max(most, _LAST_DIGIT))}"
        rows.append((error.label, [*(f"{100 * value:.3f}" for value in values), length]))
    return {"heads": [*heads, "The worst, as a length"], "rows": rows}
