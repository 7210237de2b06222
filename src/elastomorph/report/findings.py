"""What a comparison shows beside its winner: torn faces, methods in the know, what helps."""

from __future__ import annotations

from collections.abc import Sequence

from elastomorph.evaluation.inbetweens import Suggestion
from elastomorph.evaluation.summary import MethodSummary, places, same
from elastomorph.report.about import SPACE, Lengths, listed, percent

__all__ = ["inbetween_findings", "informed_findings", "nearest_path_findings", "shape_findings"]

# Paths that turn parts of a face differ from the limit law by less than this without any gap.
_GAP = 1e-2


def nearest_path_findings(
    best: MethodSummary, judged: Sequence[MethodSummary], lengths: Lengths
) -> list[str]:
    """Whose path is closest, where that is not the method that came closest as timed."""
    nearest = places(judged, "path_lme")[0]
    least = nearest[0].path_lme
    if least >= best.path_lme or same(least, best.path_lme):
        return []
    one = len(nearest) == 1
    return [
        f"The closest {'path is that' if one else 'paths are those'} of "
        f"{listed([line.label for line in nearest])}: with free timing {lengths(least)} off, "
        f"against {lengths.plain(best.path_lme)} for {best.label}."
    ]


def shape_findings(judged: Sequence[MethodSummary], lengths: Lengths) -> list[str]:
    """Who tears the face or turns polygons over."""
    torn = [line for line in judged if line.seam > _GAP]
    turned = [line for line in judged if line.flips > 0]
    found = []
    if torn:
        worst = max(torn, key=lambda line: line.seam)
        found.append(
            f"Neighbouring curves part under {listed([line.label for line in torn])}: with "
            f"{worst.label}, two vertices that share an edge come up to {lengths(worst.seam)} "
            "farther apart than they should."
        )
    if turned:
        each = [f"{line.label} ({line.flips:.3g})" for line in turned]
        found.append(f"Polygons are turned over under {listed(each)}, counted in the worst frame.")
    return found


def informed_findings(
    lines: Sequence[MethodSummary], judged: Sequence[MethodSummary], timing_known: bool
) -> list[str]:
    """How the methods that know more of the recording did."""
    known = {line.label for line in judged}
    others = [line for line in lines if line.label not in known]
    name = "lme" if timing_known else "path_lme"
    found = [f"{line.label} ({percent(getattr(line, name))})" for line in others]
    if not found:
        return []
    return [
        f"{listed(found)} passed through frames of this very recording, so their small errors are "
        "what scanned in-betweens are worth, not a win over methods that know only the two ends."
    ]


def inbetween_findings(suggestions: Sequence[Suggestion], lengths: Lengths) -> list[str]:
    """What in-betweens would leave of the largest error."""
    bare = next((one for one in suggestions if not one.frames), None)
    if bare is None:
        return []
    said, least = [], bare.lme
    for one in suggestions:
        if one.frames and one.lme < least and not same(one.lme, least):
            where = listed([f"{time:.2g}" for time in one.times])
            factor = f" (÷{SPACE}{bare.lme / one.lme:.2g})" if one.lme > 0 else ""
            said.append(
                f"to {lengths.plain(one.lme)}{factor} with {len(one.frames)} at t = {where}"
            )
            least = one.lme
    if not said:
        return []
    return [
        "What would help: scanned or sculpted in-betweens, and a smooth path through them. With "
        "the best frames found in this very recording, the largest error of straight lines falls "
        f"from {lengths.plain(bare.lme)} {listed(said)}."
    ]
