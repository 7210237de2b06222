"""What a comparison shows, in plain language: who won, by how much, and whether by timing alone.

Every sentence is computed from the numbers of the table and claims no more than they do.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from elastomorph.evaluation.inbetweens import Suggestion
from elastomorph.evaluation.summary import MethodSummary, places, same
from elastomorph.report.about import Lengths, listed, percent, share_of
from elastomorph.report.findings import (
    inbetween_findings,
    informed_findings,
    nearest_path_findings,
    shape_findings,
)

__all__ = ["Verdict", "reach_verdict"]

_NARROW = 0.95
"""A win by less than a twentieth of the error of straight lines is a narrow one."""
AT_TIMES = "At the recorded times"


@dataclass(frozen=True)
class Verdict:
    """The outcome.

    Attributes:
        headline: One sentence.
        findings: The reasons, one or two sentences each.
        timing_alone: Whether the method of smallest error won by its timing alone.
    """

    headline: str
    findings: tuple[str, ...]
    timing_alone: bool = False


def reach_verdict(
    lines: Sequence[MethodSummary],
    lengths: Lengths,
    *,
    informed: Collection[str] = (),
    suggestions: Sequence[Suggestion] = (),
    timing_known: bool = True,
    what: str = "this recording",
) -> Verdict:
    """Say in words what a table shows.

    Args:
        lines: The methods. The one labelled ``linear`` is the yardstick, if it is there.
        lengths: Writes errors.
        informed: Labels of the methods that were given frames of the recording, besides its first
            and last. They are ranked, but win nothing against methods that were not.
        suggestions: What in-betweens would leave, from none to several.
        timing_known: Whether errors at the recorded times mean anything.
        what: What the errors were measured on.

    Raises:
        ValueError: There are no lines.
    """
    judged = [line for line in lines if line.label not in informed] or list(lines)
    linear = next((line for line in judged if line.label == "linear"), None)
    if timing_known:
        headline, findings, alone = _as_timed(judged, linear, lengths, what)
        best = min(judged, key=lambda line: line.lme)
        nearer = nearest_path_findings(best, judged, lengths)
        if alone and nearer:
            nearest = [line.label for line in places(judged, "path_lme")[0]]
            verb = "comes" if len(nearest) == 1 else "come"
            headline = f"{headline[:-1]}; by path {listed(nearest)} {verb} closest."
        findings += nearer
    else:
        headline, findings = _as_path(judged, linear, lengths, what)
        alone = False
    findings += shape_findings(judged, lengths)
    findings += informed_findings(lines, judged, timing_known)
    findings += inbetween_findings(suggestions, lengths)
    return Verdict(headline, tuple(findings), alone)


def _as_timed(
    judged: Sequence[MethodSummary], linear: MethodSummary | None, lengths: Lengths, what: str
) -> tuple[str, list[str], bool]:
    best = min(judged, key=lambda line: line.lme)
    if linear is None:
        return (
            f"{_also(best, judged, 'lme')} closest to {what}, of the methods compared.",
            [
                f"{AT_TIMES}, {_off(best, lengths)} {lengths(best.lme)}.",
                "Straight lines (linear) were not among them, so nothing is said of timing.",
            ],
            False,
        )
    if len(judged) == 1:
        return (
            f"Straight lines (linear) are {lengths(linear.lme)} off {what}.",
            [
                f"That is the largest error at the recorded times{_on_average(lengths)}.",
                _share_of_timing(linear, lengths),
            ],
            False,
        )
    if best is linear or same(best.lme, linear.lme):
        return (
            f"No method comes closer to {what} than straight lines (linear).",
            [
                f"{AT_TIMES}, {_off(linear, lengths)} {lengths(linear.lme)}.",
                *_others(linear, judged, "lme"),
                _share_of_timing(linear, lengths),
            ],
            False,
        )
    closer = _closer(best, linear)
    findings = [
        f"{AT_TIMES}, {_off(best, lengths)} {lengths(best.lme)}, that of linear "
        f"{lengths(linear.lme)}: a difference of {lengths.plain(linear.lme - best.lme)}, or "
        f"{share_of(1 - best.lme / linear.lme)}."
    ]
    findings += [*_eases(best, judged), _share_of_timing(linear, lengths)]
    if closer:
        many = _also(best, judged, "lme")
        headline = f"{many} closest to {what}{_narrowly(best, linear)}, and by path too."
        findings.append(
            f"With free timing, its path too is closer than the straight line: {closer}."
        )
        if best.path_lme > linear.path_lme and not same(best.path_lme, linear.path_lme):
            findings.append(
                "The largest error with free timing, however, is not: "
                f"{lengths(best.path_lme)} against {lengths(linear.path_lme)}."
            )
    else:
        many = _also(best, judged, "lme")
        headline = f"{many} closest to {what}{_narrowly(best, linear)}, but by timing alone."
        findings.append(
            f"With free timing the path of {best.label} is no closer than the straight line, "
            f"{lengths.plain(best.path_lme)} against {lengths.plain(linear.path_lme)}: it moves at "
            "a better pace, not on a better way. An animation curve on ordinary linear targets can "
            "do as much."
        )
    return headline, findings, not closer


def _as_path(
    judged: Sequence[MethodSummary], linear: MethodSummary | None, lengths: Lengths, what: str
) -> tuple[str, list[str]]:
    best = min(judged, key=lambda line: line.path_lme)
    size = f"With free timing, {_off(best, lengths)} {lengths(best.path_lme)}"
    if linear is None or len(judged) == 1:
        return (
            f"{_also(best, judged, 'path_lme')} closest to {what} by path, of the methods "
            "compared.",
            [f"{size}."],
        )
    if best is linear or same(best.path_lme, linear.path_lme):
        off = f"With free timing, {_off(linear, lengths)} {lengths(linear.path_lme)}."
        return (
            f"No path comes closer to {what} than straight lines (linear).",
            [off, *_others(linear, judged, "path_lme")],
        )
    return (
        f"{_also(best, judged, 'path_lme')} closest to {what} by path.",
        [
            f"{size}, that of linear {lengths(linear.path_lme)}: a difference of "
            f"{lengths.plain(linear.path_lme - best.path_lme)}, or "
            f"{share_of(1 - best.path_lme / linear.path_lme)}."
        ],
    )


def _narrowly(best: MethodSummary, linear: MethodSummary) -> str:
    return ", narrowly" if best.lme > _NARROW * linear.lme else ""


def _closer(best: MethodSummary, linear: MethodSummary) -> str:
    """In which errors a path beats the straight line once timing is free; empty for none.

    The rule is that of `elastomorph.evaluation.summary.conclusions`.
    """
    found = [
        f"{words} is {percent(ours)} against {percent(theirs)}"
        for words, ours, theirs in (
            ("the largest error", best.path_lme, linear.path_lme),
            ("the largest average of a curve", best.path_lae, linear.path_lae),
        )
        if ours < theirs and not same(ours, theirs)
    ]
    return "; ".join(found)


def _share_of_timing(linear: MethodSummary, lengths: Lengths) -> str:
    """How much of the error of the straight line was a matter of when."""
    if linear.path_lme < linear.lme and not same(linear.path_lme, linear.lme):
        share = 1 - linear.path_lme / linear.lme
        return (
            "With free timing (each recorded frame is compared with the moment of the path that "
            f"fits it best), linear comes as close as {lengths(linear.path_lme)}: "
            f"{share_of(share)} of its largest error was a matter of when, not of where."
        )
    return (
        "Free timing (each recorded frame is compared with the moment of the path that fits it "
        "best) does not bring linear closer: its error is one of path, not of timing."
    )


def _eases(best: MethodSummary, judged: Sequence[MethodSummary]) -> list[str]:
    """Whether the win is shared by the same timing on straight lines."""
    eases = [
        line.label
        for line in judged
        if line.label.startswith("ease") and line is not best and same(line.lme, best.lme)
    ]
    if not eases:
        return []
    verb = "reads" if len(eases) == 1 else "read"
    return [
        f"{listed(eases)}, straight lines at another pace, {verb} the same: what {best.label} "
        "gains at the recorded times, an ease gains as well."
    ]


def _others(linear: MethodSummary, judged: Sequence[MethodSummary], name: str) -> list[str]:
    """Who reads the same as the straight line where nobody beats it."""
    alike = [
        line.label
        for line in judged
        if line is not linear and same(getattr(line, name), getattr(linear, name))
    ]
    if not alike:
        return []
    if len(alike) == len(judged) - 1:
        return ["All other methods read the same in this error."]
    return [f"{listed(alike)} {'reads' if len(alike) == 1 else 'read'} the same in this error."]


def _also(best: MethodSummary, judged: Sequence[MethodSummary], name: str) -> str:
    """The subject and verb of a headline: the best method and those that read the same."""
    alike = [
        line.label
        for line in judged
        if line is not best and same(getattr(line, name), getattr(best, name))
    ]
    if not alike:
        return f"{best.label} comes"
    return f"{listed([best.label, *alike])} come"


def _off(line: MethodSummary, lengths: Lengths) -> str:
    """The beginning of a sentence about a largest error."""
    if lengths.several:
        return f"the largest error of {line.label} is on average"
    return f"the vertex of {line.label} that is farthest off is off by"


def _on_average(lengths: Lengths) -> str:
    return ", on average" if lengths.several else ""
