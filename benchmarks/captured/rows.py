"""Rows of the table from the files of a result and the truth beside the photographs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from captured.geometry import closest
from captured.judging import Chosen, Judge, Spread, flags
from captured.outcome import Outcome, camera_errors, frame_errors, into_truth, true_positions
from captured.running import Run
from captured.table import Row
from photographs.truth import Truth

__all__ = ["camera_rows", "details", "judged", "pose_rows", "scan_errors", "scan_flags", "shown_in"]

Points = NDArray[np.float64]
_SHOWN = 0.004  # of D: how near a scan is that shows a place


def camera_rows(outcome: Outcome, truth: Truth, run: Run | None) -> list[Row]:
    """How many cameras were found, how far off they are, and what a pose took."""
    counts, means = [], []
    for pose, found in outcome.cameras.items():
        counts.append((len(found), len(truth.files)))
        means.append(camera_errors(found, true_positions(truth, pose)).mean())
    fewest = min(counts, default=(0, len(truth.files)))
    worst = max(means, default=float("nan"))
    seconds = run.processor / len(means) if run and means else float("nan")
    text = f"{fewest[0]} of {fewest[1]}, {worst:.4f} cm"
    met = fewest[0] == fewest[1] and worst <= 0.015
    if run:
        text, met = f"{text}, {seconds:.0f} s, {run.gigabytes:.1f} GB", met and seconds <= 120
    return [Row("cameras", text, met)]


def frame_row(outcome: Outcome, truth: Truth, judge: Judge, first: str) -> Row:
    """Mean error of the worst frame, in percent of D."""
    means = [
        100 * frame_errors(outcome, truth, pose, first).mean() / judge.extent
        for pose in outcome.cameras
        if pose != first
    ]
    worst = max(means, default=float("nan"))
    return Row("frames", f"{worst:.3f}", worst <= 0.02)


def judged(outcome: Outcome, truth: Truth, first: str) -> tuple[Outcome, Judge]:
    """The result in the frame of the truth, and its judge."""
    into = into_truth(outcome, truth, first)
    moved = replace(outcome, poses={name: into(own) for name, own in outcome.poses.items()})
    return moved, Judge(truth, moved.poses[first], first)


def pose_rows(outcome: Outcome, truth: Truth, pose: str, first: str = "p00") -> list[Row]:
    """Rows of the neutral, of one pose, and of the confidence of all poses.

    Args:
        outcome: In any frame.
        truth: Of its photographs.
        pose: Which.
        first: The neutral.
    """
    moved, judge = judged(outcome, truth, first)
    surface = judge.surface()
    rows = [frame_row(outcome, truth, judge, first)] if len(outcome.cameras) > 1 else []
    met = surface.mean <= 0.04 and surface.p95 <= 0.09
    rows.append(Row("neutral", f"{surface.mean:.3f} / {surface.p95:.3f}", met))
    if pose not in moved.poses:
        return rows
    own = judge.pose(pose, moved.poses[pose])
    rows += [_row(name, spread) for name, spread in own.items()]
    return [*rows, *_confidence(moved, judge, first)]


def _row(name: str, own: Spread) -> Row:
    """Mean and what else the goal is about."""
    if name == "moving":
        met: bool | None = own.mean <= 0.04 and own.p95 <= 0.12 and own.largest <= 0.5
        return Row(name, f"{own.mean:.3f} / {own.p95:.3f} / {own.largest:.2f}", met)
    if name == "visible":
        return Row(name, f"{own.mean:.3f} / {own.p99:.2f}", own.mean <= 0.08 and own.p99 <= 1)
    met = own.mean <= 0.3 and own.p95 <= 1 if name == "lips" else None
    return Row(name, f"{own.mean:.3f} / {own.p95:.2f}", met)


def _confidence(moved: Outcome, judge: Judge, first: str) -> Iterator[Row]:
    """Of all poses together, over what two photographs of the neutral show.

    Also what a pose hides counts, and lips: there a flag is what is hoped for.
    """
    chosen = (judge.front | judge.chin | judge.lips) & (judge.neutral_views >= 2)
    poses = [name for name in moved.poses if name != first and name in moved.confidence]
    if not poses:
        return
    errors = np.concatenate([judge.errors(name, moved.poses[name])[chosen] for name in poses])
    own = np.concatenate([moved.confidence[name][chosen] for name in poses])
    caught, flagged, off = flags(errors, own, np.ones(len(errors), bool))
    text = f"{100 * caught:.0f} % of {off} caught, {100 * flagged:.1f} % flagged"
    yield Row("confidence", text, caught >= 0.9 and flagged <= 0.05)


def scan_errors(judge: Judge, pose: str, vertices: Points, shown: Chosen) -> tuple[Spread, Spread]:
    """Errors of a registered scan where the skin of the front moves by more than 0.1 cm.

    Away from lips and from under the chin; of what both scans show, as photographs are judged by
    what they show, and of all of it.
    """
    moved = np.linalg.norm(judge.of(pose) - judge.points, axis=1) > 0.1
    chosen = judge.front & moved & ~judge.lips & ~judge.chin
    errors = judge.errors(pose, vertices)
    return Spread.of(errors[chosen & shown]), Spread.of(errors[chosen])


def scan_flags(
    judge: Judge, pose: str, vertices: Points, confidence: NDArray[np.float64], shown: Chosen
) -> str:
    """What the confidence of a registered scan is worth, over what the neutral's scan shows."""
    chosen = (judge.front | judge.chin | judge.lips) & shown
    caught, flagged, off = flags(judge.errors(pose, vertices), confidence, chosen)
    part = off / max(1, np.count_nonzero(chosen))
    return (
        f"{100 * caught:.0f} % of {off} caught, {100 * flagged:.1f} % flagged, "
        f"{100 * part:.1f} % are off"
    )


def shown_in(judge: Judge, pose: str, vertices: Points, triangles: NDArray[np.integer]) -> Chosen:
    """(N,) which vertices of the template a scan of a pose shows: it lies there and faces alike."""
    near = closest(judge.of(pose), vertices, triangles)
    corners = vertices[triangles[near.triangles]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    cosines = np.einsum("ni,ni->n", normals, judge.normals(pose)) / lengths
    return (near.distances < _SHOWN * judge.extent) & (cosines > 0.5)


def details(outcome: Outcome, truth: Truth, first: str = "p00") -> Iterator[str]:
    """A line a pose: mean / p95 / p99 / largest of each region, and what is flagged."""
    moved, judge = judged(outcome, truth, first)
    yield f"D = {judge.extent:.2f} cm; neutral surface {judge.surface()}"
    for pose in moved.poses:
        if pose == first:
            continue
        parts = [
            f"{name} ({own.count}) {own}"
            for name, own in judge.pose(pose, moved.poses[pose]).items()
        ]
        yield f"{pose}: " + "; ".join(parts)
