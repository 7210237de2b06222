"""The tables of the report of a capture: photographs, agreement, time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from elastomorph.evaluation.words import SPACE, significant
from elastomorph.report.document import Section

__all__ = [
    "agreement",
    "duration",
    "photographs_section",
    "size_words",
    "times",
]

Figures = Mapping[str, Any]

_HEADS = {
    "points": "Points",
    "matches": "Matches",
    "median": "Median",
    "mean": "Mean",
    "p95": "95 % below",
    "max": "Largest",
    "views": "Photographs a vertex, median",
    "seen": "Vertices in 4 photographs or more",
}
_SHARES = ("seen",)


def photographs_section(figures: Figures) -> Section:
    """Reprojection error of each photograph, and why some are not used."""
    poses = figures.get("poses", {})
    rejected = [
        (name, [pose, why])
        for pose, own in poses.items()
        for name, why in own.get("rejected", {}).items()
    ]
    rows, bars = [], []
    highest = max(
        (error for own in poses.values() for error in own.get("reprojection", {}).values()),
        default=1.0,
    )
    for pose, own in poses.items():
        errors = own.get("reprojection", {})
        worst = max(errors, key=lambda name: errors[name], default="")
        cells = [
            f"{own.get('cameras', len(errors))} of {own.get('photographs', len(errors))}",
            f"{own.get('points', 0):,}",
            f"{np.mean(list(errors.values())):.3f}" if errors else "",
            f"{errors[worst]:.3f} ({worst})" if worst else "",
        ]
        rows.append((pose, cells))
        bars.append(
            {
                "pose": pose,
                "errors": [
                    {"name": name, "text": f"{error:.3f}", "share": error / (highest or 1.0)}
                    for name, error in errors.items()
                ],
            }
        )
    content = {
        "heads": ["Pose", "Photographs used", "Points", "Reprojection, mean, px", "Worst, px"],
        "rows": rows,
        "bars": bars,
        "highest": f"{highest:.2f}{SPACE}px",
        "rejected": rejected,
    }
    return Section("photographs", "Photograph by photograph", content)


def agreement(figures: Figures) -> Section:
    """How well surfaces fit, and apart from it how well skin is where it was."""
    poses = figures.get("poses", {})
    content = {
        "surface": _measured(poses, "surface"),
        "correspondence": _measured(poses, "correspondence"),
        "landmarks": [
            (name, [f"{error:.1f}"]) for name, error in figures.get("landmarks", {}).items()
        ],
        "frames": [
            (pose, [f"{100 * own['frame']['rms_of_extent']:.3f}", f"{own['frame']['agreeing']:,}"])
            for pose, own in poses.items()
            if "frame" in own
        ],
    }
    return Section("agreement", "Surface and correspondence", content)


def _measured(poses: Mapping[str, Any], kind: str) -> dict[str, Any] | None:
    """One row a pose of what was measured of one kind; None where nothing was."""
    found = {pose: own[kind] for pose, own in poses.items() if own.get(kind)}
    names = list(dict.fromkeys(name for own in found.values() for name in own))
    if not names:
        return None
    rows = [(pose, [_cell(name, own.get(name)) for name in names]) for pose, own in found.items()]
    return {"heads": ["Pose", *(_HEADS.get(name, name) for name in names)], "rows": rows}


def _cell(name: str, value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, int):
        return f"{value:,}"
    return f"{100 * value:.1f}{SPACE}%" if name in _SHARES else f"{100 * value:.3f}"


def times(figures: Figures) -> Section:
    """How long each stage took, whenever it was made."""
    seconds: Mapping[str, float] = figures.get("seconds", {})
    total = sum(seconds.values())
    rows = [
        {
            "name": name,
            "text": duration(own),
            "share": own / max(max(seconds.values()), 1e-9),
        }
        for name, own in seconds.items()
    ]
    return Section("times", "How long it took", {"rows": rows, "total": duration(total)})


def duration(seconds: float) -> str:
    """Such as "0.4 s", "38 s", "4 min 10 s" or "1 h 5 min"."""
    if seconds < 9.95:
        return f"{seconds:.1f}{SPACE}s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole}{SPACE}s"
    minutes, rest = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes}{SPACE}min {rest}{SPACE}s"
    return f"{minutes // 60}{SPACE}h {minutes % 60}{SPACE}min"


def size_words(diameter: float, unit: str) -> str:
    """D, the size of the neutral."""
    return (
        f"D = {significant(diameter)} {unit or 'units'}, the distance of the two vertices of the "
        "neutral that are farthest apart"
    )
