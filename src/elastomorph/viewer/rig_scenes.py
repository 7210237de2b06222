"""Scenes of what is in memory: a rig or path, several compared, methods beside a recording."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation
from elastomorph.io.gltf import write_glb
from elastomorph.io.gltf.clips import WeightClip
from elastomorph.model.mesh import Mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import through
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn
from elastomorph.viewer.scene import Role, Scene, SceneModel

_SLIDER = "motion"  # of a path that is no part of a rig
# Each frame is a morph target of the page, and the graphics card adds two of them at a time.
_MOST_FRAMES = 24
# Where paths differ most from the straight line, on the whole.
_HALF_WAY: dict[str, Any] = {"weights": {_SLIDER: 1.0}, "t": 0.5}
_MOST_SIDE_BY_SIDE = 3
_ROUNDED = 1e-5


def rig_scene(
    rig: Rig | Morph,
    *,
    name: str = "rig",
    title: str | None = None,
    unit: str = "",
    curves: CurveNetwork | None = None,
) -> Scene:
    """A scene of one rig, or of one path half way.

    Args:
        rig: The rig, or a single path; that has a slider called ``motion``.
        name: What the page calls it.
        title: What the page is called; the name by default.
        unit: Unit of the coordinates, for legends.
        curves: Curves to draw on it; found on the neutral by default.

    Raises:
        ParameterError: The mesh has no polygons.
        FormatError: Coordinates too large for single precision.
    """
    return comparison_scene({name: rig}, title=title, unit=unit, curves=curves)


def comparison_scene(
    models: Mapping[str, Rig | Morph],
    *,
    title: str | None = None,
    unit: str = "",
    curves: CurveNetwork | None = None,
) -> Scene:
    """A scene of several rigs or paths of one neutral, side by side.

    Args:
        models: What to compare, by name: all rigs, or all single paths. Sliders of the same name
            move together; single paths share one called ``motion``.
        title: What the page is called; the names by default.
        unit: Unit of the coordinates, for legends.
        curves: Curves to draw on them; found on the neutral by default.

    Raises:
        TopologyError: They differ in vertices or polygons.
        ParameterError: No models, rigs mixed with single paths, or a mesh without polygons.
        FormatError: Coordinates too large for single precision.
    """
    if not models:
        raise ParameterError("name at least one rig or morph to compare")
    every = list(models.values())
    paths = [isinstance(model, Morph) for model in every]
    if any(paths) and not all(paths):
        raise ParameterError("compare rigs with rigs, or single morphs with single morphs")
    neutral = every[0].neutral
    for model in every[1:]:
        require_same_topology(neutral, model.neutral)
    role: Role = "rig" if len(every) == 1 else "method"
    return Scene(
        tuple(rig_model(model, name, role) for name, model in models.items()),
        " and ".join(models) if title is None else title,
        unit,
        neutral.diameter,
        extract_curves(neutral) if curves is None else curves,
        {**comparison_start(len(every)), **(_HALF_WAY if all(paths) else {})},
    )


def comparison_start(count: int) -> dict[str, Any]:
    """What the comparison of so many models begins with."""
    if count < 2:
        return {}
    return {"arrangement": "side", "shown": list(range(min(count, _MOST_SIDE_BY_SIDE)))}


def evaluation_scene(
    evaluation: Evaluation,
    *,
    title: str | None = None,
    unit: str = "",
    frames: int = _MOST_FRAMES,
    truth: str = "recorded",
    images: bool = True,
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
        images: Whether faces have the images of their materials, each of them in a file of its own.

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
    dressed: Callable[[Morph], Morph] = (lambda path: path) if images else _plain
    methods = [
        rig_model(dressed(_rounded(result.morph)), result.label, "method")
        for result in evaluation.results
    ]
    return Scene(
        (*methods, rig_model(dressed(recorded), truth, "truth")),
        name,
        unit,
        evaluation.diameter,
        evaluation.curves,
        _start(evaluation),
    )


def motion_morph(motion: MeshSequence, frames: int = _MOST_FRAMES) -> Morph:
    """A recorded motion as a path through its frames, of which the most are kept, evenly spread.

    It is straight from one to the next, with one bend for each kept frame but the ends.
    """
    if frames < 2:
        raise ParameterError(f"a motion needs at least 2 frames, found {frames}")
    last = len(motion) - 1
    kept = np.unique(np.round(np.linspace(0, last, min(frames, last + 1))).astype(int))
    between = {float(motion.times[frame]): motion[frame] for frame in kept[1:-1].tolist()}
    path = through(motion.neutral, motion.target, between, method="linear")
    return replace(path, method="recorded")


def _plain(morph: Morph) -> Morph:
    """The path on a mesh without images, which colours of distances hide."""
    neutral = morph.neutral
    bare = Mesh(neutral.vertices, neutral.faces, materials=neutral.materials)
    return replace(morph, neutral=bare, target=bare.with_vertices(morph.target.vertices))


def _rounded(morph: Morph) -> Morph:
    """The path with bends rounded to 1e-5 of D, in binary: numbers of few bits pack well."""
    step = 2.0 ** np.floor(np.log2(_ROUNDED * (morph.neutral.diameter or 1.0)))
    return replace(morph, bends=np.round(morph.bends / step) * step)


def _start(evaluation: Evaluation) -> dict[str, Any]:
    labels = [result.label for result in evaluation.results]
    best = min(evaluation.results, key=lambda result: result.lme).label
    # Best beside truth; the straight line, which everybody knows, first.
    chosen = dict.fromkeys([label for label in ("linear", best) if label in labels])
    truth = len(labels)
    return {
        **_HALF_WAY,
        "arrangement": "side",
        "shown": [*(labels.index(label) for label in chosen), truth],
        "heat": True,
        "against": truth,
    }


def rig_model(
    rig: Rig | Morph, name: str, role: Role, clips: Sequence[WeightClip] = ()
) -> SceneModel:
    """A model from a rig with clips of its sliders, or from a path with a slider of its own."""
    whole = Rig(rig.neutral, {_SLIDER: rig}) if isinstance(rig, Morph) else rig
    if not len(whole.neutral.faces):
        raise ParameterError(
            f"{name!r} has no polygons, only {len(whole.neutral.vertices):,} points: the viewer "
            "shows surfaces. Draw the curves of a marker take with 'elastomorph evaluate' instead"
        )
    file = io.BytesIO()
    # The page finds normals from positions; those of targets would make it half as large again.
    played = [(clip.times, clip.weights, clip.name) for clip in clips]
    write_glb(file, whole, normals="none", animation=played or None, turn=_turn(clips))
    return SceneModel(name, role, file.getvalue())


def _turn(clips: Sequence[WeightClip]) -> HeadTurn | None:
    """How the head turns in clips one after another, about the neck that the first has."""
    turns = [clip.turn for clip in clips if clip.turn is not None]
    if not turns:
        return None
    still = [np.zeros((len(clip.times), 3)) for clip in clips]
    angles = [at if c.turn is None else c.turn.angles for c, at in zip(clips, still, strict=True)]
    return HeadTurn(turns[0].pivot, np.concatenate(angles))
