"""Who came closest, in words and by rank, and the table of all errors."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

from elastomorph.evaluation import Evaluation
from elastomorph.evaluation.conclusions import Verdict
from elastomorph.evaluation.summary import MethodSummary, places, same
from elastomorph.evaluation.table import PAPER_TABLE_1, SHAPE_COLUMNS, number_text, table_1
from elastomorph.evaluation.words import SPACE, Lengths, counted
from elastomorph.report.document import About, Section

_TIMED = {"LME": "lme", "LAE": "lae", "mean LME": "mean_lme", "mean LAE": "mean_lae"}
_LOW = "Low confidence too"
_UNMASKED = {"LME": "unmasked_lme", "LAE": "unmasked_lae"}
_FREE = {title: f"path_{name}" for title, name in _TIMED.items()}


def outcome(verdict: Verdict, scope: str) -> Section:
    """The outcome in words, and how far it reaches."""
    reasons = [*verdict.reasons, scope]
    return Section("outcome", "The outcome", {"headline": verdict.headline, "reasons": reasons})


def table_1_section(evaluation: Evaluation) -> Section | None:
    """The paper's Table 1 beside that of a recorded motion; None where a method of it lacks."""
    rows = table_1(evaluation)
    if not rows:
        return None
    heads = ["Fractions of D", *(name for name, *_ in PAPER_TABLE_1.values())]
    words = (
        "The paper's numbers are of 49 curves of its own scans, which are not public; those found "
        f"here are of {counted(len(evaluation.curves), 'curve')} of another motion. So the order "
        "of the methods may be compared, not their sizes: it depends on how the motion is timed."
    )
    content = {"words": words, "heads": heads, "rows": rows}
    return Section("paper", "The paper's Table 1", content, appendix=True)


def ranked(lines: Sequence[MethodSummary], about: About) -> list[dict[str, Any]]:
    """Rankings by the largest error: at the recorded times where they are known, and without."""
    kinds = {"Ranking with free timing": "path_lme"}
    if about.timing_known:
        kinds = {"Ranking at the recorded times": "lme"} | kinds
    return [{"title": title, "places": _ranking(lines, kinds[title])} for title in kinds]


def _ranking(lines: Sequence[MethodSummary], error: str) -> list[dict[str, Any]]:
    """The methods in order of an error, with its span in each place; ties share a place."""
    found = []
    for place in places(lines, error):
        texts = [number_text(line, error) for line in place]
        span = texts[0] if len(set(texts)) == 1 else f"{texts[0]} to {texts[-1]}"
        found.append({"labels": [line.label for line in place], "errors": f"{span}{SPACE}%"})
    return found


def errors(
    tables: Sequence[dict[str, Any]],
    rankings: Sequence[dict[str, Any]],
    lengths: Lengths,
    *,
    shape: bool,
    informed: Collection[str],
) -> Section:
    """What the columns of tables mean, the tables, and who came closest."""
    size = "" if lengths.diameter is None else f" 1 % is {lengths.plain(0.01)}."
    titles = [group["title"] for table in tables for group in table["groups"]]
    content = {
        "size": size,
        "shape": shape,
        "masked": _LOW in titles,
        "informed": bool(informed),
        "tables": tables,
        "rankings": rankings,
    }
    return Section("errors", "Errors", content, appendix=True)


def error_table(
    lines: Sequence[MethodSummary],
    caption: str,
    *,
    informed: Collection[str] = (),
    shape: bool = True,
    timing_known: bool = True,
) -> dict[str, Any]:
    """One row a method, in three groups of columns: at the times, with free timing, shape.

    No method is called the best that was ``informed`` by frames of the recording, nor at given
    times where the timing is not known.
    """
    timed = "At the recorded times" if timing_known else "At constant speed, assumed"
    groups = {timed: _TIMED, "With free timing": _FREE}
    if shape:
        groups["Shape"] = SHAPE_COLUMNS
    if lines and all(line.unmasked_lme is not None for line in lines):
        groups[_LOW] = _UNMASKED
    names = [name for group in groups.values() for name in group.values()]
    judged = [line for line in lines if line.label not in informed]
    best = {
        name: _best(judged, name) if timing_known or name not in _TIMED.values() else ()
        for name in names
    }
    rows = [
        {
            "label": line.label,
            "informed": line.label in informed,
            "cells": [
                {"text": number_text(line, name), "best": line.label in best[name]}
                for name in names
            ],
        }
        for line in lines
    ]
    heads = [{"title": title, "heads": list(group)} for title, group in groups.items()]
    return {"caption": caption, "groups": heads, "rows": rows}


def _best(judged: Sequence[MethodSummary], name: str) -> Collection[str]:
    """The labels whose number is the best, or reads the same; none where all do."""
    values = {line.label: float(getattr(line, name)) for line in judged}
    least = min(values.values(), default=0.0)
    # A difference that nobody can see must not pick a winner.
    good = {
        label
        for label, value in values.items()
        if value == least or (math.isfinite(value) and same(value, least))
    }
    return () if len(good) == len(values) else good
