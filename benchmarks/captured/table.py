"""The table of goals beside what a trial and this package reach."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Row", "shown"]

# What a throw-away trial reached on the head that its parameters were tuned on.
TRIAL = {
    "cameras": ".011-.016 cm; 95-259 s",
    "saharov32": "32; .193 px; .8 %",
    "frames": ".012-.025",
    "neutral": ".042 / .093",
    "moving": ".057 / .17 / 1.0",
    "lips": ".61 / 3.1",
    "chin": ".66 / 2.0",
    "visible": ".158 / p99 -",
    "confidence": "-",
    "untextured": ".60 with the rig; 1.4",
    "textured": "-",
    "eleven": "about 25 min; 1.4 GB",
}
GOALS = {
    "cameras": "all, mean ≤ .015 cm, ≤ 120 s",
    "saharov32": "32; ≤ .25 px; ≤ .7 %",
    "frames": "mean ≤ .02",
    "neutral": "mean ≤ .04, p95 ≤ .09",
    "moving": "mean ≤ .04, p95 ≤ .12, max ≤ .5",
    "lips": "mean ≤ .3, p95 ≤ 1",
    "chin": "-",
    "visible": "mean ≤ .08, p99 ≤ 1",
    "confidence": "≥ 90 % caught, ≤ 5 % flagged",
    "untextured": "≤ .5 with the rig; ≤ 1.2",
    "textured": "mean ≤ .1",
    "eleven": "≤ 25 min on two cores, ≤ 3 GB",
}
NAMES = {
    "cameras": "cameras, worst pose",
    "saharov32": "saharov32: cameras",
    "frames": "poses in one frame, mean of the worst",
    "neutral": "neutral surface, mean / p95",
    "moving": "displacement, moving, mean / p95 / max",
    "lips": "lips, mean / p95",
    "chin": "under the chin, mean / p95",
    "visible": "all visible, mean / p99",
    "confidence": "confidence",
    "untextured": "untextured scans, moving, mean",
    "textured": "textured scans, moving, mean",
    "eleven": "eleven poses",
}


@dataclass(frozen=True)
class Row:
    """One line of the table: what it is about, what was found, and whether that is the goal."""

    what: str
    found: str
    met: bool | None = None


def shown(rows: list[Row]) -> str:
    """The table as text, widths from its longest cells."""
    head = ("% of D unless told", "goal", "trial", "here", "")
    cells = [head]
    for row in rows:
        verdict = "" if row.met is None else "met" if row.met else "NOT MET"
        cells.append(
            (NAMES[row.what], GOALS[row.what], TRIAL[row.what], row.found, verdict),
        )
    widths = [max(len(line[column]) for line in cells) for column in range(len(head))]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in cells
    ]
    return "\n".join([lines[0], "-" * len(lines[0]), *lines[1:]])
