"""The paper's strips of faces: methods over time and at one moment, expressions over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.face_strip import face_strip
from elastomorph.draw.framing import View, camera_for
from elastomorph.draw.grid import ColourScale, picture_grid
from elastomorph.draw.heat import COLOUR_MAP, heat_colours, round_up
from elastomorph.draw.method_words import method_words
from elastomorph.draw.pictures import write_picture
from elastomorph.draw.stage import Image, Stage
from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.model.morph import Morph

__all__ = ["error_strip", "expression_strip", "method_strip", "side_by_side"]

TRUTH = "recorded"
TIMES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)


def method_strip(
    evaluation: Evaluation,
    path: str | Path | None = None,
    *,
    labels: Sequence[str] | None = None,
    count: int = 11,
    face: tuple[int, int] = (176, 220),
    view: View = "front",
    title: str = "",
) -> Image:
    """Recorded faces and those of each method over time (Fig. 6).

    Args:
        evaluation: Methods compared with a recorded motion.
        path: Picture to write, if any; the suffix chooses the format.
        labels: The methods to show; all by default.
        count: Most columns; where there are more frames, evenly spread ones are shown.
        face: Width and height of one face in pixels.
        view: As for `camera_for`.
        title: Above the strip.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No such method, or fewer than two columns.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    if count < 2:
        raise ParameterError(f"a strip needs at least 2 columns, found {count}")
    truth = evaluation.truth
    frames = np.rint(np.linspace(0, len(truth) - 1, min(count, len(truth)))).astype(int)
    times = truth.times[frames]
    rows = {TRUTH: (truth.mesh, truth.frames[frames])}
    names = [result.label for result in evaluation.results] if labels is None else labels
    for label in names:
        rows[label] = (truth.mesh, evaluation[label].morph.at(times))
    return face_strip(rows, times, path, face=face, view=view, title=title)


def expression_strip(
    morphs: Mapping[str, Morph],
    path: str | Path | None = None,
    *,
    times: Sequence[float] = TIMES,
    face: tuple[int, int] = (240, 300),
    view: View = "front",
    title: str | None = None,
) -> Image:
    """Expressions growing out of the neutral (Fig. 9).

    Args:
        morphs: Name of each expression and its path; all of one mesh.
        path: Picture to write, if any; the suffix chooses the format.
        times: The columns.
        face: Width and height of one face in pixels.
        view: As for `camera_for`.
        title: Above the strip; the method of the paths by default.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No expressions or no times.
        TopologyError: The morphs belong to different meshes.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    when = np.asarray(times, dtype=np.float64)
    rows = {name: (morph.neutral, morph.at(when)) for name, morph in morphs.items()}
    words = method_words(morphs.values()) if title is None else title
    return face_strip(rows, when, path, face=face, view=view, title=words)


def side_by_side(
    evaluation: Evaluation,
    path: str | Path | None = None,
    *,
    labels: Sequence[str] = ("beam R=2", "linear"),
    time: float = 0.7,
    face: tuple[int, int] = (560, 700),
    view: View = "front",
    title: str = "",
) -> Image:
    """The recorded face beside those of methods at one moment, large (Fig. 7).

    Args:
        evaluation: Methods compared with a recorded motion.
        path: Picture to write, if any; the suffix chooses the format.
        labels: The methods to show.
        time: The recorded frame nearest to this time is shown.
        face: Width and height of one face in pixels.
        view: As for `camera_for`.
        title: Above the faces.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No such method.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    truth = evaluation.truth
    frame = _nearest_frame(evaluation, time)
    chosen = [evaluation[label] for label in labels]
    camera = camera_for(truth.mesh, view, poses=truth.frames, size=face)
    with Stage(truth.mesh, camera, size=face) as stage:
        faces = [stage.picture(truth.frames[frame])]
        captions = [f"t = {truth.times[frame]:.2g}"]
        for result in chosen:
            faces.append(stage.picture(result.morph.at(float(truth.times[frame]))))
            captions.append(
                f"largest error {100 * result.maximum[:, frame].max():.2f} % of D\n"
                f"largest average of a curve {100 * result.average[:, frame].max():.2f} %"
            )
    names = [TRUTH, *(result.label for result in chosen)]
    image = picture_grid([faces], column_labels=names, captions=[captions], title=title)
    return _written(image, path)


def error_strip(
    evaluation: Evaluation,
    path: str | Path | None = None,
    *,
    labels: Sequence[str] | None = None,
    time: float = 0.5,
    highest: float | None = None,
    columns: int = 4,
    face: tuple[int, int] = (320, 400),
    view: View = "front",
    unit: str = "",
    colour_map: str = COLOUR_MAP,
    title: str = "",
    names: Mapping[str, str] | None = None,
    free_timing: bool = False,
) -> Image:
    """Where each method errs at one moment, on one scale of colours.

    The distance of every vertex from the recorded one is drawn on the face of the method.

    Args:
        evaluation: Methods compared with a recorded motion.
        path: Picture to write, if any; the suffix chooses the format.
        labels: The methods to show; all by default.
        time: The recorded frame nearest to this time is shown.
        highest: Error of the last colour, as a fraction of D; the largest error of all faces,
            rounded up, by default.
        columns: Faces in a row.
        face: Width and height of one face in pixels.
        view: As for `camera_for`.
        unit: Unit of the vertices, to be named in the legend.
        colour_map: A colour map of matplotlib.
        title: Above the faces.
        names: What stands below the face of a method instead of its label.
        free_timing: Each method at the moment that free timing, which makes its LME smallest,
            picks for this frame.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No such method, no columns, or ``highest`` is not above 0.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    if columns < 1:
        raise ParameterError(f"a row needs at least 1 column, found {columns}")
    results = evaluation.results if labels is None else [evaluation[label] for label in labels]
    frame = _nearest_frame(evaluation, time)
    poses = [_pose_at(result, evaluation, frame, free_timing) for result in results]
    errors = [_percent_off(pose, evaluation, frame) for pose in poses]
    largest = max((float(error.max()) for error in errors), default=0.0)
    top = round_up(largest) if highest is None else 100 * highest
    mesh = evaluation.truth.mesh
    camera = camera_for(mesh, view, poses=evaluation.truth.frames, size=face)
    with Stage(mesh, camera, size=face) as stage:
        faces = [
            stage.picture(pose, colours=heat_colours(error, top, colour_map=colour_map))
            for pose, error in zip(poses, errors, strict=True)
        ]
    captions = [
        f"{(names or {}).get(result.label, result.label)}\n"
        f"max {error.max():.2f} %, mean {error.mean():.2f} %"
        for result, error in zip(results, errors, strict=True)
    ]
    words = _distance_words(evaluation, frame, unit, free_timing)
    starts = range(0, len(faces), columns)
    image = picture_grid(
        [faces[start : start + columns] for start in starts],
        captions=[captions[start : start + columns] for start in starts],
        title=title,
        scale=ColourScale(top, words, colour_map),
    )
    return _written(image, path)


def _pose_at(
    result: MethodResult, evaluation: Evaluation, frame: int, free_timing: bool
) -> NDArray[np.float64]:
    """The face of a method at a frame, or at the moment that free timing picks for it."""
    times = result.path_times if free_timing else evaluation.truth.times
    return result.morph.at(float(times[frame]))


def _percent_off(
    pose: NDArray[np.float64], evaluation: Evaluation, frame: int
) -> NDArray[np.float64]:
    """(V,) distance of each vertex from the recorded one, in % of D."""
    away = np.linalg.norm(pose - evaluation.truth.frames[frame], axis=1)
    return np.asarray(100 * away / evaluation.diameter)


def _distance_words(evaluation: Evaluation, frame: int, unit: str, free_timing: bool) -> str:
    return (
        f"distance from the recorded face at t = {float(evaluation.truth.times[frame]):.2g}"
        f"{', with free timing' if free_timing else ''}, % of D   "
        f"(D = {evaluation.diameter:.4g}{' ' * bool(unit)}{unit})"
    )


def _nearest_frame(evaluation: Evaluation, time: float) -> int:
    return int(np.abs(evaluation.truth.times - time).argmin())


def _written(image: Image, path: str | Path | None) -> Image:
    if path is not None:
        write_picture(image, path)
    return image
