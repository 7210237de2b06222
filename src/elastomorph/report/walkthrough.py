"""The whole paper on one face, and what goes beyond it: paths, errors, graphs and pictures.

It begins with what to do with each target of the rig. Its sections on orbits say how far methods
leave the arc of the jaw, and of the eyeball under a lid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.draw.camera import camera_for
from elastomorph.draw.curves_picture import curves_picture
from elastomorph.draw.graphs import time_law_graph
from elastomorph.draw.hinge import eyelid_graph, hinge_faces, hinge_graph, looks_of
from elastomorph.draw.pictures import Image, heat_colours, write_picture
from elastomorph.draw.stage import Stage
from elastomorph.draw.strips import closure_comparison, contact_sheet, expression_strip
from elastomorph.evaluation import (
    DEFAULT_METHODS,
    Evaluation,
    evaluate,
    every_method,
    suggest_inbetweens,
)
from elastomorph.evaluation.rigid_bodies import (
    Eyelid,
    Hinge,
    HingeError,
    find_eyelid,
    find_hinge,
    hinge_errors,
)
from elastomorph.evaluation.shape import ClosureSeam, closure_seams
from elastomorph.evaluation.summary import informed_methods
from elastomorph.evaluation.target_paths import TargetPath, TargetPaths, target_paths
from elastomorph.evaluation.words import SPACE, Lengths, counted, listed, percent
from elastomorph.io import write
from elastomorph.io.atomic import made_folder, replacing
from elastomorph.io.vertex_lists import write_curves
from elastomorph.model.morph import Morph
from elastomorph.paths import Method, interpolate, prepare
from elastomorph.paths.auto import INBETWEEN_PAYS
from elastomorph.report.comparison import write_evaluation, write_report
from elastomorph.report.document import (
    About,
    Graph,
    Picture,
    Section,
    document,
    picture_sections,
    write_page,
)
from elastomorph.report.faces import evaluation_pictures
from elastomorph.report.outcome import table_1_section
from elastomorph.report.subject import Subject
from elastomorph.rig import Rig
from elastomorph.rig.naming import shape_of
from elastomorph.rig.sliders import spread_rows, weight_combinations

# The pictures and the report of the walkthrough: what each target needs, and the comparison.

_MOST_INBETWEENS = 3


@dataclass(frozen=True)
class BeamTiming:
    """How far the quadratic beam takes another way than the ease t², at t = 0.5.

    Attributes:
        name: The target on which they part most.
        distance: By how much, as a fraction of D.
    """

    name: str
    distance: float


def write_walkthrough_report(
    subject: Subject,
    evaluation: Evaluation | None,
    first: Sequence[Section],
    beam: BeamTiming,
    faces: Sequence[Picture],
    more: Sequence[Picture],
    path: Path,
    *,
    call: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Write the page of a walkthrough: what it begins with, and the comparison if there is one."""
    if evaluation is None:
        sections = [*first, *picture_sections(faces, more)]
        write_page(path, document(subject.name, "What its targets need", sections))
        return
    suggestions = []
    if subject.take is not None:
        say("looking for the best in-betweens")
        suggestions = suggest_inbetweens(subject.take, _MOST_INBETWEENS, curves=evaluation.curves)
    about = About(
        subject.name,
        source=truth_words(subject),
        unit=subject.unit,
        call=call,
        timing_known=subject.take is not None,
        remarks=(beam_words(beam, len(subject.targets)),),
    )
    write_report(
        evaluation,
        path,
        about,
        suggestions=suggestions,
        pictures=more,
        first=first,
        faces=faces,
        say=say,
    )


def truth_words(subject: Subject) -> str:
    """What the methods are compared with, in a sentence or two."""
    parts = subject.rigid_parts
    if subject.take is not None or parts is None:
        return (
            "The recorded motion is one of 11 poses that an anatomical model makes, without the "
            "physics of the beams: the jaw turns about its hinge, the lids about the eyes."
        )
    degrees = math.degrees(parts.screw.angle)
    return (
        f"Compared is what turns rigidly with {subject.jaw}, by {degrees:.1f}°, "
        f"{counted(parts.components, 'part')} ({len(parts.vertices):,} vertices), on paths of the "
        "whole face, whose D all errors are in. The arc is known, the timing is not: only errors "
        "with free timing count."
    )


def beam_words(beam: BeamTiming, targets: int) -> str:
    """How far the quadratic beam takes another way than the ease of its own timing."""
    return (
        f"Of {counted(targets, 'target')}, the quadratic beam differs from the ease t² by at most "
        f"{percent(beam.distance)} ({beam.name}, t = 0.5): with these materials it changes when a "
        "shape arrives, hardly the way it takes."
    )


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
        "headline": _hinge_headline(best, errors, lengths),
        "words": _hinge_words(hinge, target),
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


def _hinge_words(hinge: Hinge, target: str) -> str:
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


def _hinge_headline(best: HingeError, errors: Sequence[HingeError], lengths: Lengths) -> str:
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


_SIDES = (168, 210)
_MOST_SHOWN = 24
"""Of a group; more of them are a click away."""


class TargetPictures:
    """Draws each target once its path is known, coloured by how far that is off the straight line.

    Use as a context manager.
    """

    def __init__(self, subject: Subject) -> None:
        neutral = subject.neutral
        self.drawn: dict[str, Picture] = {}
        self._extent = 0.0
        if len(neutral.faces):
            poses = np.stack([neutral.vertices, subject.targets[subject.jaw].vertices])
            camera = camera_for(neutral, poses=poses, head=subject.head, size=_SIDES)
            self._stage: Stage | None = Stage(neutral, camera, size=_SIDES)
        else:
            self._stage = None

    def draw(self, name: str, morph: Morph, extent: float) -> None:
        """Draw a target; ``extent`` is the D of its colours."""
        if self._stage is None:
            return
        colours, words = None, f"{name}, for which the straight line is enough."
        if len(morph.bends):
            middle = morph.neutral.vertices + 0.5 * morph.delta
            away = np.linalg.norm(morph.at(0.5) - middle, axis=1) / (extent or 1.0)
            colours = heat_colours(away, INBETWEEN_PAYS)
            most = percent(float(away.max()))
            words = f"{name}, darkest where halfway the bent path is {most} off the straight line."
        image = self._stage.picture(morph.target.vertices, colours=colours)
        self.drawn[name] = Picture(name, image, words, "")

    def __enter__(self) -> TargetPictures:
        if self._stage is not None:
            self._stage.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        if self._stage is not None:
            self._stage.__exit__(*error)


@dataclass(frozen=True)
class _Group:
    """Targets with one verdict."""

    title: str
    why: str
    targets: Sequence[TargetPath]
    folded: bool = False
    then: str = ""  # What to do next, below the pictures


def advice(paths: TargetPaths, pictures: Mapping[str, Picture], subject: Subject) -> Section:
    """The first section: in a sentence, then group by group with a picture of each target."""
    empty = [target for target in paths.targets if target.empty]
    pays = [target for target in paths.targets if target.inbetween_pays]
    bend = [t for t in paths.targets if not t.choice.straight and not t.inbetween_pays]
    keep = [t for t in paths.targets if t.choice.straight and not t.inbetween_pays and not t.empty]
    # A share tells more than a length in a unit that nobody knows.
    lengths = Lengths(paths.extent or None if subject.unit else None, subject.unit)
    groups = [
        _Group(
            f"Bend, and sculpt an in-between: {len(pays)}",
            f"Halfway the bent path is more than {lengths(INBETWEEN_PAYS)} off the straight line, "
            "or polygons turn over. Only a shape sculpted or scanned there can say which is right.",
            pays,
            then=_sculpted(pays),
        ),
        _Group(f"Bend: {len(bend)}", "The path turns what turns. Nothing to sculpt.", bend),
        _Group(f"Keep straight: {len(keep)}", "A bend would change nothing one sees.", keep, True),
        _Group(f"Empty: {len(empty)}", "They move nothing: sculpt or remove them.", empty, True),
    ]
    coloured = any(target.bends and target.name in pictures for target in paths.targets)
    content = {
        "headline": _headline(len(pays), len(bend), len(keep), len(empty)),
        "cost": _cost(paths),
        "command": subject.command if any(target.bends for target in paths.targets) else "",
        "groups": [_shown(group, pictures, lengths) for group in groups if group.targets],
        "scale": f"{lengths.plain(INBETWEEN_PAYS)} and more" if coloured else "",
        "colours": "How far at t = 0.5 the bent path is off the straight line; below each picture "
        "the most. D is the extent of all that the targets move.",
    }
    return Section("advice", "What to do with each target", content)


def _sculpted(pays: Sequence[TargetPath]) -> str:
    """How an in-between comes into the rig."""
    key = tomlkit.key(pays[0].name).as_string() if pays else ""
    return (
        f"Name what you sculpt in elastomorph.toml, under [inbetweens.{key}] and the like, and the "
        "paths go through it."
    )


def _headline(pays: int, bend: int, keep: int, empty: int) -> str:
    said = []
    if pays + bend:
        said.append(f"bend {counted(pays + bend, 'target')}")
    if pays:
        which = "it" if pays + bend == 1 else f"{pays} of them"
        said.append(f"sculpt an in-between for {which}")
    if keep:
        every = f"{'all ' if keep > 1 else ''}{counted(keep, 'target')}"
        said.append(f"keep {keep if said else every} straight")
    text = listed(said) if said else "" if empty else "there are no targets"
    if empty:
        moving = f"{counted(empty, 'target')} {'moves' if empty == 1 else 'move'} nothing"
        text = f"{text}; {moving}" if text else moving
    return f"{text[0].upper()}{text[1:]}."


def _cost(paths: TargetPaths) -> str:
    bends = sum(target.bends for target in paths.targets)
    if not bends:
        return "The rig stays as it is."
    size = sum(target.bytes for target in paths.targets) / 1e6
    return (
        f"All bends together cost {counted(bends, 'more morph target')}, {size:.2g}{SPACE}MB; end "
        "shapes and sliders stay what they are. This writes them:"
    )


def _shown(group: _Group, pictures: Mapping[str, Picture], lengths: Lengths) -> dict[str, Any]:
    cards = [
        {
            "name": target.name,
            "words": "" if group.folded else _words(target, lengths),
            "picture": pictures.get(target.name),
        }
        for target in group.targets
    ]
    first = 0 if group.folded else _MOST_SHOWN
    return {
        "title": group.title,
        "why": group.why,
        "then": group.then,
        "shown": cards[:first],
        "folded": cards[first:],
        "folded_words": "Show them" if group.folded else f"{len(cards) - first} more",
    }


def _words(target: TargetPath, lengths: Lengths) -> str:
    """Such as "0.13 cm, +2 targets"."""
    said = [lengths.plain(target.choice.distance)]
    if target.bends:
        said.append(f"+{counted(target.bends, 'target')}")
    if target.flips:
        said.append(f"{counted(target.flips, 'polygon')} turned over")
    return ", ".join(said)


def targets_table(paths: TargetPaths, unit: str) -> Section:
    """The numbers behind the advice, a row a target."""
    allowed = max((target.choice.allowed for target in paths.targets), default=0.0)
    content = {
        "allowed": f"{100 * allowed:g}",
        "pays": f"{100 * INBETWEEN_PAYS:g}",
        "extent": Lengths(paths.extent or None, unit).plain(1.0),
        "targets": paths.targets,
    }
    return Section("targets", "Each target in numbers", content, appendix=True)


_JAW_METHODS = ("linear", "arc", "rotation", "auto")
_LID_METHODS = ("linear", "beam:2", "auto")
_IN_BETWEEN_TIMES = (0.25, 0.5, 0.75)


@dataclass(frozen=True, eq=False)
class Walkthrough:
    """What was found on the way.

    Attributes:
        subject: The face.
        curves: Its curves.
        paths: What each target needs.
        hinge: How far methods leave the arc of the jaw; none where nothing turns rigidly.
        eyelid: How far a lid sinks towards the eye on its way, by method, as fractions of D; none
            without lid and eyeball.
        evaluation: Table 1 on the recorded motion, or on the rigid parts of a rig; or none.
        seams: Each closure on the jaw, halfway.
        beam: Where the quadratic beam differs most from the ease.
        written: Every file.
    """

    subject: Subject
    curves: CurveNetwork
    paths: TargetPaths
    hinge: list[HingeError]
    eyelid: dict[str, float]
    evaluation: Evaluation | None
    seams: list[ClosureSeam]
    beam: BeamTiming
    written: list[Path]


def walk_through(
    subject: Subject,
    folder: str | Path,
    say: Callable[[str], None] = lambda _: None,
    *,
    call: str = "",
) -> Walkthrough:
    """Run the paper's experiments on a face, beside the methods that turn what turns."""
    place = _Folder(Path(folder))
    neutral, jaw = subject.neutral, subject.targets[subject.jaw]
    say("tracing curves")
    curves = extract_curves(neutral)
    write_curves(place.file("curves.json"), curves)
    curves_picture(neutral, curves, place.file("curves.png"))
    with TargetPictures(subject) as cards:
        paths = target_paths(
            neutral, subject.targets, progress=say, seen=cards.draw, known=subject.paths
        )
    with replacing(place.file("targets.csv")) as table:
        table.write(_targets_csv(paths).encode())

    say(f"interpolating {subject.jaw} by every method")
    morphs = _every_morph(subject, curves)
    evaluation = _compared(subject, curves, morphs, say)
    faces: list[Picture] = []
    if evaluation is not None:
        if subject.take is not None:  # the parts of a rig alone are no face to look at
            lengths = Lengths(evaluation.diameter, subject.unit)
            faces = evaluation_pictures(evaluation, lengths, informed_methods(evaluation), say)
        place.written += write_evaluation(evaluation, place.path, faces=faces, say=say)
        morphs = morphs or {result.label: result.morph for result in evaluation.results}
    say("writing in-betweens")
    for label, morph in morphs.items():
        for t in _IN_BETWEEN_TIMES:
            write(
                place.file(f"in-betweens/{label} t={t:g}.obj"), neutral.with_vertices(morph.at(t))
            )
    turning = _jaw_on_its_hinge(subject, morphs, place, say)
    if subject.take is None:
        say(f"drawing {subject.jaw}")
        shown = {label: morphs[label] for label in ("linear", "beam R=2", "auto")}
        faces.append(jaw_picture(shown, subject.jaw, place.file("in-betweens.png")))
    more = _expressions(subject, place, say)
    say("comparing closures")
    seams = closure_seams(neutral, jaw, curves)
    image = closure_comparison(neutral, jaw, place.file("closures.png"), curves=curves)
    more.append(closures_picture(image, subject.jaw, seams))
    beam = _beam_timing(subject, curves)
    first = [advice(paths, cards.drawn, subject)]
    if turning is not None:
        first.append(hinge_section(turning, subject.jaw, subject.unit))
    dips, lid = _lid_on_its_eye(subject, curves, place, say)
    paper = None if subject.take is None or evaluation is None else table_1_section(evaluation)
    first += [each for each in (lid, targets_table(paths, subject.unit), paper) if each is not None]
    found = (subject, evaluation, first, beam, faces, more)
    write_walkthrough_report(*found, place.file("report.html"), call=call, say=say)
    hinge = [] if turning is None else turning.errors
    return Walkthrough(subject, curves, paths, hinge, dips, evaluation, seams, beam, place.written)


class _Folder:
    """Where a walkthrough writes, and what it has written."""

    def __init__(self, path: Path) -> None:
        for folder in (path, path / "in-betweens"):
            made_folder(folder)
        self.path = path
        self.written: list[Path] = []

    def file(self, name: str) -> Path:
        self.written.append(self.path / name)
        return self.written[-1]


def _every_morph(subject: Subject, curves: CurveNetwork) -> dict[str, Morph]:
    """The jaw of a rig by every method; nothing for a recorded motion, which has its own ends."""
    if subject.take is not None:
        return {}
    neutral, jaw = subject.neutral, subject.targets[subject.jaw]
    names = (*DEFAULT_METHODS, "plate:2", "arc", "rotation", "auto")
    methods = [Method.parse(name) for name in names]
    return {each.label: interpolate(neutral, jaw, each, curves=curves) for each in methods}


def _compared(
    subject: Subject,
    curves: CurveNetwork,
    morphs: Mapping[str, Morph],
    say: Callable[[str], None],
) -> Evaluation | None:
    """Every method against the recorded motion, or against the known arc of rigid parts."""
    if subject.take is not None:
        methods = every_method(subject.take, curves, progress=say)
        say("comparing them with the recorded motion")
        return evaluate(subject.take, methods, curves)
    parts = subject.rigid_parts
    if parts is None:
        return None
    say("comparing them with the known arc")
    # Paths of the whole face, of which the parts are looked at: what a rigger would get.
    of_parts = {label: parts.restricted(morph) for label, morph in morphs.items()}
    return evaluate(
        parts.truth, of_parts, parts.curves(curves), extent=subject.neutral.diameter or None
    )


def _jaw_on_its_hinge(
    subject: Subject, known: Mapping[str, Morph], place: _Folder, say: Callable[[str], None]
) -> Jaw | None:
    parts = subject.rigid_parts
    if parts is None:
        return None
    say("measuring the jaw on its hinge")
    neutral, jaw = subject.neutral, subject.targets[subject.jaw]
    hinge = find_hinge(neutral, jaw, parts)
    if subject.take is None:  # its methods were tried on this very jaw
        morphs = {name: known[name] for name in _JAW_METHODS}
    else:
        made = {"auto": subject.paths[subject.jaw]} if subject.jaw in subject.paths else {}
        morphs = {name: made.get(name) or interpolate(neutral, jaw, name) for name in _JAW_METHODS}
    image = hinge_faces(hinge, morphs, place.file("hinge.png"))
    hinge_graph(hinge, morphs, place.file("hinge-graph.png"), subject.unit)
    return Jaw(hinge, morphs, hinge_errors(hinge, morphs), image)


def _lid_on_its_eye(
    subject: Subject, curves: CurveNetwork, place: _Folder, say: Callable[[str], None]
) -> tuple[dict[str, float], Section | None]:
    """How far a lid sinks towards the eye on its way over it, and what the report says of it."""
    name = next((each for each in subject.targets if shape_of(each) == "eyeBlinkLeft"), None)
    lid = None if name is None else find_eyelid(subject.neutral, subject.targets[name])
    if name is None or lid is None:
        return {}, None
    say("measuring the eyelid on the eyeball")
    methods = [Method.parse(each) for each in _LID_METHODS]
    neutral, target = subject.neutral, subject.targets[name]
    made = {"auto": subject.paths[name]} if name in subject.paths else {}
    morphs = {
        each.label: made.get(each.label) or interpolate(neutral, target, each, curves=curves)
        for each in methods
    }
    eyelid_graph(lid, morphs, place.file("eyelid-graph.png"), subject.unit)
    dips = {label: lid.dip(morph) for label, morph in morphs.items()}
    return dips, eyelid_section(lid, morphs, dips, name, subject.unit)


def _expressions(subject: Subject, place: _Folder, say: Callable[[str], None]) -> list[Picture]:
    say("drawing expressions")
    to = prepare(subject.neutral, "auto", targets=list(subject.expressions.values()))
    morphs = {
        name: subject.paths.get(name) or to(mesh) for name, mesh in subject.expressions.items()
    }
    growing = expressions_picture(morphs, place.file("expressions.png"))
    time_law_graph(place.file("time-laws.png"))
    say("drawing blended faces")
    return [growing, sheet_picture(morphs, place.file("blended-faces.png"))]


def _beam_timing(subject: Subject, curves: CurveNetwork) -> BeamTiming:
    neutral = subject.neutral
    beam, ease = (prepare(neutral, name, curves=curves) for name in ("beam:2", "ease:2"))
    found = []
    for name, target in subject.targets.items():
        apart = np.linalg.norm(beam(target).at(0.5) - ease(target).at(0.5), axis=1)
        found.append(BeamTiming(name, float(apart.max()) / (neutral.diameter or 1.0)))
    return max(found, key=lambda each: each.distance)


def _targets_csv(paths: TargetPaths) -> str:
    lines = ["target,needs,off the straight line,allowed,bends,bytes,bake error,flips"]
    lines[0] += ",eased,crossing,deeper"
    for path in paths.targets:
        choice = path.choice
        numbers = f"{choice.distance:.9g},{choice.allowed:.9g},{path.bends},{path.bytes}"
        numbers += f",{path.bake_error:.9g},{path.flips}"
        numbers += f",{choice.eased},{choice.crossing},{choice.deeper:.9g}"
        lines.append(f"{path.name},{path.words},{numbers}")
    return "\n".join(lines) + "\n"
