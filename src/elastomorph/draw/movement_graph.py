"""A graph of the largest error of each movement of a take, one line a method."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from elastomorph.draw.figure import new_figure
from elastomorph.draw.method_style import styles_for
from elastomorph.errors import ParameterError
from elastomorph.evaluation.movements import JudgedMovement

__all__ = ["movement_graph"]

_NAMED = 24
"""With more movements than this their frames could not be read below each other."""


def movement_graph(judged: Sequence[JudgedMovement], path: str | Path, *, title: str = "") -> None:
    """LME of each movement at the recorded times (a) and with free timing (b), in % of D.

    Args:
        judged: Every movement with its evaluation, by the same methods.
        path: Graph to write: .png, .svg or .pdf.
        title: Above the graph.

    Raises:
        ParameterError: There is no movement, or another suffix.
        MissingExtraError: matplotlib is not installed.
    """
    if not judged:
        raise ParameterError("there is no movement to draw")
    labels = [result.label for result in judged[0].evaluation.results]
    styles = styles_for(labels)
    where = np.arange(1, len(judged) + 1)
    with new_figure(path, 11.0, 7.0) as figure:
        panels = figure.subplots(2, 1, sharex=True, sharey=True)
        for axes, words, name in (
            (panels[0], "(a) largest error at the recorded times", "lme"),
            (panels[1], "(b) largest error with free timing", "path_lme"),
        ):
            for label in labels:
                style = styles[label]
                errors = [100 * getattr(one.evaluation[label], name) for one in judged]
                (line,) = axes.plot(
                    where,
                    errors,
                    color=style.colour,
                    linewidth=style.width,
                    zorder=style.layer,
                    label=label,
                    marker="o",
                    markersize=4,
                )
                if style.dashes:
                    line.set_dashes(style.dashes)
            axes.set_title(words)
            axes.set_ylabel("LME, % of D")
            axes.set_ylim(bottom=0)
        panels[1].set_xlabel("movement")
        if len(judged) <= _NAMED:
            names = [f"{n}\n{one.movement.kind}" for n, one in enumerate(judged, start=1)]
            panels[1].set_xticks(where, names)
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside right upper", handlelength=3.4)
        if title:
            figure.suptitle(title, fontweight="bold", fontsize=13)
