"""The scene of an evaluation: every method beside the motion that was recorded."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import through
from elastomorph.viewer.rig_scenes import SLIDER, rig_model
from elastomorph.viewer.scene import Scene

__all__ = ["MOST_FRAMES", "evaluation_scene", "motion_morph"]

# Each frame is a morph target of the page, and the graphics card adds two of them at a time.
MOST_FRAMES = 24


def evaluation_scene(
    evaluation: Evaluation,
    *,
    title: str | None = None,
    unit: str = "",
    frames: int = MOST_FRAMES,
    truth: str = "recorded",
) -> Scene:
    """A scene of the methods of an evaluation and of the recorded motion, half way.

    It begins with the straight line if that is among the methods, the method of smallest LME and
    the recorded motion, coloured by the distance from the latter.

    Args:
        evaluation: Methods compared with a recorded motion.
        title: What the page is called; it also says how many frames of a long take are shown.
        unit: Unit of the coordinates, for legends.
        frames: The most frames of the recorded motion to show, evenly spread.
        truth: What the motion is called, where it is not a recorded one.

    Raises:
        ParameterError: The motion has no polygons, as those of markers, or fewer than two frames
            were asked for.
        FormatError: Coordinates too large for single precision.
    """
    motion = evaluation.truth
    recorded = motion_morph(motion, frames)
    shown = len(recorded.bends) + 2
    name = "Methods and recorded motion" if title is None else title
    if shown < len(motion):
        name += f" ({shown} of {len(motion):,} frames)"
    methods = [rig_model(result.morph, result.label, "method") for result in evaluation.results]
    return Scene(
        (*methods, rig_model(recorded, truth, "truth")),
        name,
        unit,
        evaluation.diameter,
        evaluation.curves,
        _start(evaluation),
    )


def motion_morph(motion: MeshSequence, frames: int = MOST_FRAMES) -> Morph:
    """A recorded motion as a path that passes through its frames, straight from one to the next.

    Args:
        motion: The frames.
        frames: The most of them to keep, evenly spread, first and last included.

    Returns:
        A path that is each kept frame at its time, with one bend for each frame but the ends.

    Raises:
        ParameterError: Fewer than two frames were asked for.
    """
    if frames < 2:
        raise ParameterError(f"a motion needs at least 2 frames, found {frames}")
    last = len(motion) - 1
    kept = np.unique(np.round(np.linspace(0, last, min(frames, last + 1))).astype(int))
    between = {float(motion.times[frame]): motion[frame] for frame in kept[1:-1].tolist()}
    path = through(motion.neutral, motion.target, between, method="linear")
    return replace(path, method="recorded")


def _start(evaluation: Evaluation) -> dict[str, Any]:
    labels = [result.label for result in evaluation.results]
    best = min(evaluation.results, key=lambda result: result.lme).label
    # Best beside truth; the straight line, which everybody knows, first.
    chosen = dict.fromkeys([label for label in ("linear", best) if label in labels])
    truth = len(labels)
    return {
        "weights": {SLIDER: 1.0},
        "t": 0.5,
        "arrangement": "side",
        "shown": [*(labels.index(label) for label in chosen), truth],
        "heat": True,
        "against": truth,
    }
