"""What a comparison shows, in sentences computed from its numbers."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from elastomorph.evaluation.inbetweens import Suggestion
from elastomorph.evaluation.summary import MethodSummary, Outcome, places, same
from elastomorph.evaluation.words import NOTHING, SPACE, Lengths, percent, share_of

# A win by less than a twentieth of the error of straight lines is a narrow one.
_NARROW = 0.95
# Paths that turn parts of a face differ from the limit law by less than this without any gap.
_GAP = 1e-2


@dataclass(frozen=True)
class Verdict:
    """The outcome in words."""

    headline: str  # One sentence
    reasons: tuple[str, ...]  # One or two sentences each
    timing_alone: bool = False  # Whether the method of smallest error won by its timing alone


def conclusions(lines: Sequence[MethodSummary], informed: Collection[str] = ()) -> list[str]:
    """What a table shows, for a terminal and a notebook: in shares of D, without its columns."""
    found = Outcome.of(lines, informed)
    said = _informed(found)
    if found.judged != found.informed:
        said = [_headline(found, "the motion"), *_errors(found, Lengths(None)), *said]
    return [sentence.replace(SPACE, " ") for sentence in said]


def rankings(lines: Sequence[MethodSummary]) -> list[str]:
    """The methods in the order of their errors: as timed, and with free timing.

    Methods that read the same in a table share a place.
    """
    said = []
    for what, name in (("At the captured times", "lme"), ("With free timing", "path_lme")):
        order = "; ".join(
            f"{i}. {_labels(place)}" for i, place in enumerate(places(lines, name), start=1)
        )
        said.append(f"{what} (LME): {order}.")
    return said


def reach_verdict(
    lines: Sequence[MethodSummary],
    lengths: Lengths,
    *,
    informed: Collection[str] = (),
    suggestions: Sequence[Suggestion] = (),
    timing_known: bool = True,
    what: str = "this recording",
) -> Verdict:
    """Say what a page shows; the method labelled ``linear`` is the yardstick, if it is there.

    `informed` were given frames of the recording between its ends: they are ranked, but win nothing
    against methods that were not. `suggestions` are what in-betweens would leave.
    """
    found = Outcome.of(lines, informed, "lme" if timing_known else "path_lme")
    reasons = [*_errors(found, lengths), *_shape(found.judged, lengths)]
    if found.judged != found.informed:
        reasons += _informed(found)
    reasons += _in_betweens(suggestions, lengths)
    return Verdict(_headline(found, what), tuple(reasons), found.timing_alone)


def _headline(found: Outcome, what: str) -> str:
    """Who came closest, and whether by timing or by path."""
    best, linear = found.best, found.linear
    winners = ", ".join([best.label, *found.alike(best)])
    how = "" if found.error == "lme" else ", by path"
    if linear is not None and found.compared:
        if not found.won:
            return f"Closest to {what}{how}: no method is closer than straight lines (linear)."
        if getattr(best, found.error) > _NARROW * getattr(linear, found.error):
            how += ", narrowly"
        if found.error == "lme":
            how += ", by timing alone" if found.timing_alone else ", by path too"
            # A better pace wins at the recorded times; where the face goes, another may be closer.
            if found.timing_alone and (nearest := _nearest(found)):
                how += f"; closest path: {_labels(nearest)}"
    return f"Closest to {what}: {winners}{how}."


def _errors(found: Outcome, lengths: Lengths) -> list[str]:
    """The errors that decide, of the best method and of linear."""
    best, linear, timed = found.best, found.linear, found.error == "lme"
    against = linear if found.compared else None
    when = "at the recorded times" if timed else "with free timing"
    ours = getattr(best, found.error)
    said = [f"Largest error {when}: {best.label} {lengths(ours)}"]
    if against is not None and best is not against:
        theirs = getattr(against, found.error)
        said[0] += f", linear {lengths(theirs)}"
        if found.won:
            said[0] += f"; {share_of(1 - ours / theirs)} less"
    said[0] += "."
    if found.won and found.eases:
        said.append(f"As close on straight lines, at another pace: {', '.join(found.eases)}.")
    if linear is None or not timed:
        return said
    free = "Free timing (each frame is compared with the moment of the path that fits it best)"
    said.append(
        f"{free} brings linear to {lengths(linear.path_lme)}: "
        f"{share_of(1 - linear.path_lme / linear.lme)} of its error was a matter of when."
        if found.timing
        else f"{free} does not bring linear closer: its error is one of path, not of timing."
    )
    if found.won:
        said.append(
            f"With free timing, {best.label} against linear: largest error "
            f"{percent(best.path_lme)} against {percent(linear.path_lme)}, largest average of a "
            f"curve {percent(best.path_lae)} against {percent(linear.path_lae)}."
        )
    if found.timing_alone:
        said.append("An animation curve on ordinary linear targets can do as much.")
    if nearest := _nearest(found):
        said.append(
            f"Closest path: {_labels(nearest)}, with free timing {lengths(nearest[0].path_lme)} "
            f"off; {best.label} {lengths.plain(best.path_lme)}."
        )
    return said


def _labels(lines: Sequence[MethodSummary]) -> str:
    return ", ".join(line.label for line in lines)


def _nearest(found: Outcome) -> list[MethodSummary]:
    """Whose path is closest, where that is not the method that came closest as timed."""
    nearest = places(found.judged, "path_lme")[0]
    least, best = nearest[0].path_lme, found.best.path_lme
    return [] if least >= best or same(least, best) else nearest


def _shape(judged: Sequence[MethodSummary], lengths: Lengths) -> list[str]:
    """Who tears the face or turns polygons over."""
    said = []
    if torn := [f"{line.label} {lengths(line.seam)}" for line in judged if line.seam > _GAP]:
        said.append(f"Neighbouring curves part, across an edge by up to: {', '.join(torn)}.")
    if turned := [f"{line.label} {line.flips:.3g}" for line in judged if line.flips > 0]:
        said.append(f"Polygons turned over in the worst frame: {', '.join(turned)}.")
    return said


def _informed(found: Outcome) -> list[str]:
    """How the methods that know more of the recording did."""
    each = [f"{line.label} ({percent(getattr(line, found.error))})" for line in found.informed]
    return each and [
        f"Given frames of this very recording, so no win: {', '.join(each)}. This is what scanned "
        "in-betweens are worth."
    ]


def _in_betweens(suggestions: Sequence[Suggestion], lengths: Lengths) -> list[str]:
    """What in-betweens would leave of the largest error."""
    bare = next((one for one in suggestions if not one.frames), None)
    if bare is None:
        return []
    said, least = [], bare.lme
    for one in suggestions:
        if one.frames and one.lme < least and not same(one.lme, least):
            where = ", ".join(f"{time:.2g}" for time in one.times)
            factor = f" (÷{SPACE}{bare.lme / one.lme:.2g})" if one.lme > NOTHING else ""
            said.append(f"{lengths.plain(one.lme)}{factor} with {len(one.frames)} at t = {where}")
            least = one.lme
    return said and [
        "What would help: scanned or sculpted in-betweens, and a smooth path through them. With "
        "the best frames of this recording, the largest error of straight lines falls from "
        f"{lengths.plain(bare.lme)} to {'; '.join(said)}."
    ]
