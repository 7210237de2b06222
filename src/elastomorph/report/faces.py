"""The pictures of a comparison, each with words that say what it shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.strips import TRUTH, error_strip, face_strip, side_by_side
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.evaluation.words import Lengths, listed, percent
from elastomorph.report.document import Picture

_COLUMNS = 11
_ALIKE = 2.5e-3
"""As a fraction of D: half a pixel of a face in the strip."""
_SAME_WAY = 1e-3
"""As a fraction of D: what nobody could call another way."""
_NOTHING = 1e-5
"""As a fraction of D: the last digit of a table."""


def evaluation_pictures(
    evaluation: Evaluation,
    lengths: Lengths,
    informed: Sequence[str] = (),
    say: Callable[[str], None] = lambda _: None,
) -> list[Picture]:
    """In-betweens over time (Fig. 6), one moment side by side (Fig. 7), and where methods err.

    For a motion with polygons. ``informed`` methods were given frames of it; beside it they show
    nothing.
    """
    frame = telling_frame(evaluation)
    pair = [result.label for result in _telling_methods(evaluation, informed)]
    time = float(evaluation.truth.times[frame])
    say("drawing in-betweens")
    alike = look_alikes(evaluation)
    found = [_strip(evaluation, alike)]
    say("drawing one moment")
    image = side_by_side(evaluation, labels=pair, time=time, face=(360, 450))
    off = [
        f"{label} by {lengths(float(evaluation[label].maximum[:, frame].max()))}" for label in pair
    ]
    found.append(
        Picture(
            "One moment, side by side",
            image,
            f"{len(pair) + 1} faces from the front at t = {time:.2g}: the recorded one, then "
            f"{listed(pair)}. Farthest off is, at this moment, {listed(off)}.",
            f"As in the paper's Figure 7, at t = {time:.2g}, where {_yardstick(evaluation).label} "
            "is farthest from the recording. Compare how far the jaw is open, where the corners "
            "of the mouth are and how far the lids have come.",
            name="side-by-side",
        )
    )
    say("drawing errors")
    found.append(_heat_map(evaluation, frame, alike, lengths.unit))
    say("drawing errors of paths")
    found.append(_path_heat_map(evaluation, lengths.unit))
    return found


def telling_frame(evaluation: Evaluation) -> int:
    """The frame in which linear, or the first method, is farthest from the recording."""
    return int(_yardstick(evaluation).maximum.max(axis=0).argmax())


def _yardstick(evaluation: Evaluation) -> MethodResult:
    known = {result.label: result for result in evaluation.results}
    return known.get("linear", evaluation.results[0])


def _telling_methods(evaluation: Evaluation, informed: Sequence[str]) -> list[MethodResult]:
    """The closest method, the straight line and the paper's choice, as far as there are."""
    judged = [r for r in evaluation.results if r.label not in informed] or evaluation.results
    chosen = [min(judged, key=lambda result: result.lme)]
    for label in ("linear", "beam R=2", "auto"):
        chosen += [r for r in judged if r.label == label and r not in chosen]
    return chosen


def look_alikes(evaluation: Evaluation) -> dict[str, list[str]]:
    """Methods whose faces nobody could tell apart in a strip, by the first of them."""
    times = _shown_times(evaluation)
    return _grouped(evaluation, lambda result: result.morph.at(times), _ALIKE)


def _grouped(
    evaluation: Evaluation, pose: Callable[[MethodResult], NDArray[np.float64]], within: float
) -> dict[str, list[str]]:
    """Methods none of whose vertices is farther than a fraction of D from the first of them."""
    found: dict[str, list[str]] = {}
    poses: dict[str, NDArray[np.float64]] = {}
    for result in evaluation.results:
        own = pose(result)
        for label, other in poses.items():
            if np.linalg.norm(own - other, axis=-1).max() <= within * evaluation.diameter:
                found[label].append(result.label)
                break
        else:
            found[result.label], poses[result.label] = [result.label], own
    return found


def _shown_times(evaluation: Evaluation) -> NDArray[np.float64]:
    return evaluation.truth.times[_shown_frames(len(evaluation.truth))]


def _shown_frames(count: int) -> NDArray[np.intp]:
    return np.rint(np.linspace(0, count - 1, min(_COLUMNS, count))).astype(int)


def _strip(evaluation: Evaluation, alike: Mapping[str, Sequence[str]]) -> Picture:
    truth = evaluation.truth
    frames, times = _shown_frames(len(truth)), _shown_times(evaluation)
    rows = {TRUTH: (truth.mesh, truth.frames[frames])}
    for label, group in alike.items():
        rows[", ".join(group)] = (truth.mesh, evaluation[label].morph.at(times))
    columns = ", ".join(f"{time:.2g}" for time in times)
    return Picture(
        "In-betweens",
        face_strip(rows, times, face=(144, 180)),
        f"{len(rows)} rows of {len(times)} faces from the front at t = {columns}. The first row "
        f"is {TRUTH}; below it {'; '.join(list(rows)[1:])}. All rows begin with one face and end "
        "with one face; between them they differ.",
        "As in the paper's Figure 6: the first row was recorded, every other row was computed from "
        "its first and last face. Read down a column: a mouth that is open too early or too late "
        f"is timing; one that opens elsewhere is path.{_sharing(alike)}",
        name="in-betweens",
    )


def _sharing(alike: Mapping[str, Sequence[str]], what: str = "row") -> str:
    if all(len(group) == 1 for group in alike.values()):
        return ""
    return (
        f" Methods that stay within {percent(_ALIKE)} of each other, less than a pixel here, "
        f"share a {what}."
    )


def _heat_map(
    evaluation: Evaluation, frame: int, alike: Mapping[str, Sequence[str]], unit: str
) -> Picture:
    time = float(evaluation.truth.times[frame])
    off = {label: float(evaluation[label].maximum[:, frame].max()) for label in alike}
    worst, best = max(off, key=off.__getitem__), min(off, key=off.__getitem__)
    image = error_strip(
        evaluation,
        labels=list(alike),
        time=time,
        columns=min(4, len(alike)),
        face=(280, 350),
        unit=unit,
        names={label: ", ".join(group) for label, group in alike.items()},
    )
    return Picture(
        "Where each method errs",
        image,
        f"One face a method at t = {time:.2g}, pale where it meets the recorded face and dark "
        f"where it is farthest off. {worst} is darkest, up to {percent(off[worst])}; {best} is "
        f"palest, up to {percent(off[best])}.",
        "Distance of each vertex from the recorded one, on one scale for all methods. Two methods "
        "with the same pattern in other strengths differ in timing; another pattern is another "
        f"path.{_sharing(alike, 'face')}{_masked(evaluation)}",
        name="error-heat-map",
    )


def _path_heat_map(evaluation: Evaluation, unit: str) -> Picture:
    """The same with free timing, at the frame where it leaves linear, or the first, farthest off.

    Of methods on the same way, such as linear, cosine and ease, one is shown.
    """
    frame = int(_yardstick(evaluation).path_maximum.max(axis=0).argmax())
    alike = _grouped(
        evaluation, lambda result: result.morph.at(float(result.path_times[frame])), _SAME_WAY
    )
    time = float(evaluation.truth.times[frame])
    off = {label: float(evaluation[label].path_maximum[:, frame].max()) for label in alike}
    worst, best = max(off, key=off.__getitem__), min(off, key=off.__getitem__)
    image = error_strip(
        evaluation,
        labels=list(alike),
        time=time,
        highest=_NOTHING if off[worst] < _NOTHING else None,
        columns=min(4, len(alike)),
        face=(280, 350),
        unit=unit,
        names={label: _names(group) for label, group in alike.items()},
        free_timing=True,
    )
    crowds = [f"{group[0]} is also {listed(group[1:])}" for group in alike.values() if group[2:]]
    return Picture(
        "Where each path errs, whatever its timing",
        image,
        f"One face for each way at t = {time:.2g}, each method with free timing. "
        f"{worst} is darkest, up to {percent(max(off[worst], _NOTHING))}; {best} is palest, up to "
        f"{percent(max(off[best], _NOTHING))}.",
        "The same with free timing, on a scale of its own: what is dark here no animation curve "
        f"can mend. Methods within {percent(_SAME_WAY)} of each other share a face."
        f"{f' {listed(crowds)}.' if crowds else ''}{_masked(evaluation)}",
        name="path-error-heat-map",
    )


def _masked(evaluation: Evaluation) -> str:
    if evaluation.confidence is None:
        return ""
    return " Where the confidence is low nothing is drawn."


def _names(group: Sequence[str]) -> str:
    """The labels of a group, in as few words as say which they are."""
    return group[0] if len(group) == 1 else ", ".join(group[:2]) + (", …" if group[2:] else "")
