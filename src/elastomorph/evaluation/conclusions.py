"""What a comparison shows, in sentences computed from its numbers: they claim no more than these.

`conclusions` are for a terminal, with the errors of its table; `reach_verdict` is for a page, with
lengths. Who won is said by `Outcome` for both.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from elastomorph.evaluation.inbetweens import Suggestion
from elastomorph.evaluation.summary import MethodSummary, Outcome, places, same
from elastomorph.evaluation.words import NOTHING, SPACE, Lengths, listed, percent, share_of

# A win by less than a twentieth of the error of straight lines is a narrow one.
_NARROW = 0.95
# Paths that turn parts of a face differ from the limit law by less than this without any gap.
_GAP = 1e-2


def conclusions(lines: Sequence[MethodSummary], informed: Collection[str] = ()) -> list[str]:
    """What a table shows; methods given frames of the recording have a sentence of their own."""
    found = Outcome.of(lines, informed)
    said = [] if found.judged == found.informed else _table_sentences(found)
    if found.informed:
        each = " and ".join(f"{line.label} ({_error(line.lme)} of D)" for line in found.informed)
        said.append(
            f"{each} knew frames of this very recording: what scanned in-betweens are worth, not a "
            "win."
        )
    return said


def _table_sentences(found: Outcome) -> list[str]:
    best, linear = found.best, found.linear
    if linear is None or not found.compared:
        return [f"Smallest LME: {best.label}, {_error(best.lme)} of D."]
    timing = (
        f"Free timing brings linear from {_error(linear.lme)} to {_error(linear.path_lme)} of D "
        "(LME): that much is a matter of when, not where."
        if found.timing
        else f"Free timing does not bring linear closer ({_error(linear.lme)} at the captured "
        f"times, {_error(linear.path_lme)} with it, LME): its error is one of path."
    )
    if not found.won:
        return ["No method is closer than linear at the captured times (LME).", timing]
    win = (
        f"{best.label} has the smallest LME, {_error(best.lme)} of D against "
        f"{_error(linear.lme)} for linear"
    )
    if found.timing_alone:
        win += (
            ": a win of timing alone, for with free timing its path is no closer than the straight "
            f"line ({_error(best.path_lme)} against {_error(linear.path_lme)})."
        )
    else:
        where = " and ".join(name.removeprefix("path_").upper() for name in found.closer)
        win += (
            f"; with free timing its path too is closer than the straight line in {where} (LME "
            f"{_error(best.path_lme)} against {_error(linear.path_lme)}, LAE "
            f"{_error(best.path_lae)} against {_error(linear.path_lae)})."
        )
    if found.eases:
        win += f" As close at the captured times: {', '.join(found.eases)}."
    return [win, timing]


def rankings(lines: Sequence[MethodSummary]) -> list[str]:
    """The methods in the order of their errors: as timed, and with free timing.

    Methods that read the same in a table share a place.
    """
    said = []
    for what, name in (("At the captured times", "lme"), ("With free timing", "path_lme")):
        order = "; ".join(
            f"{i}. {', '.join(line.label for line in place)}"
            for i, place in enumerate(places(lines, name), start=1)
        )
        said.append(f"{what} (LME): {order}.")
    return said


def _error(fraction: float) -> str:
    """An error as in the table, such as "1.376 %"."""
    return f"{100 * fraction:.3f} %"


@dataclass(frozen=True)
class Verdict:
    """The outcome in words."""

    headline: str  # One sentence
    reasons: tuple[str, ...]  # One or two sentences each
    timing_alone: bool = False  # Whether the method of smallest error won by its timing alone


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
    headline, reasons = (_as_timed if timing_known else _as_path)(found, lengths, what)
    nearest = _nearest_path(found, lengths) if timing_known else ""
    if nearest and found.timing_alone:
        labels = [line.label for line in places(found.judged, "path_lme")[0]]
        headline += f"; by path {listed(labels)} {_verb(labels, 'come')} closest"
    reasons += [nearest, *_shape(found.judged, lengths)]
    reasons += [_informed(found), _in_betweens(suggestions, lengths)]
    return Verdict(f"{headline}.", tuple(filter(None, reasons)), found.timing_alone)


def _as_timed(found: Outcome, lengths: Lengths, what: str) -> tuple[str, list[str]]:
    """A headline without its full stop, and the reasons for it, some of them empty."""
    best, linear = found.best, found.linear
    at_times = f"At the recorded times, {_off(best, lengths)} {lengths(best.lme)}"
    if linear is None:
        return (
            f"{_winners(found)} closest to {what}, of the methods compared",
            [
                f"{at_times}.",
                "Straight lines (linear) were not among them, so nothing is said of timing.",
            ],
        )
    timing = _share_of_timing(found, linear, lengths)
    if not found.compared:
        average = ", on average" if lengths.diameter is None else ""
        return (
            f"Straight lines (linear) are {lengths(linear.lme)} off {what}",
            [f"That is the largest error at the recorded times{average}.", timing],
        )
    if not found.won:
        return (
            f"No method comes closer to {what} than straight lines (linear)",
            [
                f"At the recorded times, {_off(linear, lengths)} {lengths(linear.lme)}.",
                _others(found, linear),
                timing,
            ],
        )
    narrowly = ", narrowly" if best.lme > _NARROW * linear.lme else ""
    reasons = [f"{at_times}, {_difference(best.lme, linear.lme, lengths)}.", _eases(found), timing]
    headline = f"{_winners(found)} closest to {what}{narrowly}"
    if found.timing_alone:
        reasons.append(
            f"With free timing the path of {best.label} is no closer than the straight line, "
            f"{lengths.plain(best.path_lme)} against {lengths.plain(linear.path_lme)}: it moves at "
            "a better pace, not on a better way. An animation curve on ordinary linear targets can "
            "do as much."
        )
        return f"{headline}, but by timing alone", reasons
    words = {"path_lme": "the largest error", "path_lae": "the largest average of a curve"}
    closer = "; ".join(
        f"{words[name]} is {percent(getattr(best, name))} against {percent(getattr(linear, name))}"
        for name in found.closer
    )
    reasons.append(f"With free timing, its path too is closer than the straight line: {closer}.")
    if best.path_lme > linear.path_lme and not same(best.path_lme, linear.path_lme):
        reasons.append(
            "The largest error with free timing, however, is not: "
            f"{lengths(best.path_lme)} against {lengths(linear.path_lme)}."
        )
    return f"{headline}, and by path too", reasons


def _as_path(found: Outcome, lengths: Lengths, what: str) -> tuple[str, list[str]]:
    """The same where only the way is known."""
    best, linear = found.best, found.linear
    size = f"With free timing, {_off(best, lengths)} {lengths(best.path_lme)}"
    if linear is None or not found.compared:
        return f"{_winners(found)} closest to {what} by path, of the methods compared", [f"{size}."]
    if not found.won:
        size = f"With free timing, {_off(linear, lengths)} {lengths(linear.path_lme)}."
        return (
            f"No path comes closer to {what} than straight lines (linear)",
            [size, _others(found, linear)],
        )
    difference = _difference(best.path_lme, linear.path_lme, lengths)
    return f"{_winners(found)} closest to {what} by path", [f"{size}, {difference}."]


def _winners(found: Outcome) -> str:
    """The subject and verb of a headline: the best method and those that read the same."""
    labels = [found.best.label, *found.alike(found.best)]
    return f"{listed(labels)} {_verb(labels, 'come')}"


def _verb(labels: Sequence[str], verb: str) -> str:
    return f"{verb}s" if len(labels) == 1 else verb


def _off(line: MethodSummary, lengths: Lengths) -> str:
    """The beginning of a sentence about a largest error."""
    if lengths.diameter is None:
        return f"the largest error of {line.label} is on average"
    return f"the vertex of {line.label} that is farthest off is off by"


def _difference(ours: float, theirs: float, lengths: Lengths) -> str:
    return (
        f"that of linear {lengths(theirs)}: a difference of {lengths.plain(theirs - ours)}, or "
        f"{share_of(1 - ours / theirs)}"
    )


def _share_of_timing(found: Outcome, linear: MethodSummary, lengths: Lengths) -> str:
    """How much of the error of the straight line was a matter of when."""
    if found.timing:
        return (
            "With free timing (each recorded frame is compared with the moment of the path that "
            f"fits it best), linear comes as close as {lengths(linear.path_lme)}: "
            f"{share_of(1 - linear.path_lme / linear.lme)} of its largest error was a matter of "
            "when, not of where."
        )
    return (
        "Free timing (each recorded frame is compared with the moment of the path that fits it "
        "best) does not bring linear closer: its error is one of path, not of timing."
    )


def _eases(found: Outcome) -> str:
    """Whether the win is shared by the same timing on straight lines."""
    if not (eases := found.eases):
        return ""
    return (
        f"{listed(eases)}, straight lines at another pace, {_verb(eases, 'read')} the same: what "
        f"{found.best.label} gains at the recorded times, an ease gains as well."
    )


def _others(found: Outcome, linear: MethodSummary) -> str:
    """Who reads the same as the straight line where nobody beats it."""
    alike = found.alike(linear)
    if not alike:
        return ""
    if len(alike) == len(found.judged) - 1:
        return "All other methods read the same in this error."
    return f"{listed(alike)} {_verb(alike, 'read')} the same in this error."


def _nearest_path(found: Outcome, lengths: Lengths) -> str:
    """Whose path is closest, where that is not the method that came closest as timed."""
    best, nearest = found.best, places(found.judged, "path_lme")[0]
    least = nearest[0].path_lme
    if least >= best.path_lme or same(least, best.path_lme):
        return ""
    subject = "path is that" if len(nearest) == 1 else "paths are those"
    return (
        f"The closest {subject} of {listed([line.label for line in nearest])}: with free timing "
        f"{lengths(least)} off, against {lengths.plain(best.path_lme)} for {best.label}."
    )


def _shape(judged: Sequence[MethodSummary], lengths: Lengths) -> list[str]:
    """Who tears the face or turns polygons over."""
    said = []
    torn = [line for line in judged if line.seam > _GAP]
    if torn:
        worst = max(torn, key=lambda line: line.seam)
        said.append(
            f"Neighbouring curves part under {listed([line.label for line in torn])}: with "
            f"{worst.label}, two vertices that share an edge come up to {lengths(worst.seam)} "
            "farther apart than they should."
        )
    turned = [f"{line.label} ({line.flips:.3g})" for line in judged if line.flips > 0]
    if turned:
        said.append(f"Polygons are turned over under {listed(turned)}, counted in the worst frame.")
    return said


def _informed(found: Outcome) -> str:
    """How the methods that know more of the recording did, where others are ranked."""
    if not found.informed or found.judged == found.informed:
        return ""
    each = [f"{line.label} ({percent(getattr(line, found.error))})" for line in found.informed]
    return (
        f"{listed(each)} knew frames of this very recording, so their small errors are "
        "what scanned in-betweens are worth, not a win over methods that know only the two ends."
    )


def _in_betweens(suggestions: Sequence[Suggestion], lengths: Lengths) -> str:
    """What in-betweens would leave of the largest error."""
    bare = next((one for one in suggestions if not one.frames), None)
    if bare is None:
        return ""
    said, least = [], bare.lme
    for one in suggestions:
        if one.frames and one.lme < least and not same(one.lme, least):
            where = listed([f"{time:.2g}" for time in one.times])
            factor = f" (÷{SPACE}{bare.lme / one.lme:.2g})" if one.lme > NOTHING else ""
            said.append(
                f"to {lengths.plain(one.lme)}{factor} with {len(one.frames)} at t = {where}"
            )
            least = one.lme
    if not said:
        return ""
    return (
        "What would help: scanned or sculpted in-betweens, and a smooth path through them. With "
        "the best frames found in this very recording, the largest error of straight lines falls "
        f"from {lengths.plain(bare.lme)} {listed(said)}."
    )
