"""The graphs of one comparison: curve by curve, over time, and what in-betweens are worth."""

from __future__ import annotations

from collections.abc import Sequence

from elastomorph.draw.graphs import error_graphs, inbetween_graph, time_graphs
from elastomorph.evaluation import Evaluation, Suggestion
from elastomorph.report.about import percent
from elastomorph.report.compared import counted
from elastomorph.report.content import graph_figure
from elastomorph.report.markup import Markup, joined

__all__ = ["graph_section"]


def graph_section(
    evaluation: Evaluation, suggestions: Sequence[Suggestion] = (), *, timing_known: bool = True
) -> Markup:
    """The graphs with their headings and captions.

    Args:
        evaluation: Methods compared with a recorded motion.
        suggestions: What in-betweens would be worth, if that was looked for.
        timing_known: Whether errors at given times mean anything.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    worst = max(evaluation.results, key=lambda result: result.lme)
    best = min(evaluation.results, key=lambda result: result.lme)
    found = []
    if timing_known:
        found.append(
            graph_figure(
                lambda file: error_graphs(evaluation, file),
                "by-curve",
                "Errors of each curve",
                f"Lines of {counted(len(evaluation.results), 'method')} over "
                f"{counted(len(evaluation.curves), 'curve')} and over time. The highest is "
                f"{worst.label}, up to {percent(worst.lme)}; the lowest peak is that of "
                f"{best.label}, {percent(best.lme)}.",
                "As in the paper's Figure 8: (a) average and (b) maximum error of each curve, and "
                "both over time (c, d). A method that is lower everywhere is closer to the "
                "recording; lines that cross say that it depends on the part of the face. Dashed "
                "lines lie on broad ones where a beam does what a straight path does.",
            )
        )
    words = (
        "Above at the times of the frames, below with free timing. What falls from the upper "
        "graphs to the lower was a matter of timing; what is left is the path. Free timing makes "
        "the peak of each line as low as it can be, never higher than above; beside its peak a "
        "line may lie higher."
    )
    if not timing_known:
        words += " The times are made up here, so only the lower graphs count."
    found.append(
        graph_figure(
            lambda file: time_graphs(evaluation, file),
            "over-time",
            "Timing and path",
            "Four graphs of error over time, one line a method: above at the times of the frames, "
            f"with a peak of {percent(worst.lme)}; below with free timing, with a peak of "
            f"{percent(max(result.path_lme for result in evaluation.results))}.",
            words,
        )
    )
    if len(suggestions) > 1:
        first, last = suggestions[0], suggestions[-1]
        found.append(
            graph_figure(
                lambda file: inbetween_graph(suggestions, evaluation.truth.times, file),
                "inbetweens",
                "What in-betweens are worth",
                f"The largest error falls from {percent(first.lme)} without in-betweens to "
                f"{percent(last.lme)} with {len(last.frames)}.",
                "Frames of this recording as in-betweens, at the best times found, and a smooth "
                "path through them. Where the first line falls steeply, one scan more is worth "
                "more than any law.",
            )
        )
    return joined(found)
