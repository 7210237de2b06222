"""Faces side by side: methods at one moment and where they err, closures, blended faces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.draw.camera import Camera
from elastomorph.draw.framing import View, camera_for
from elastomorph.draw.head import head_of
from elastomorph.draw.pictures import COLOUR_MAP, Image, written
from elastomorph.draw.sheet import Face, face_sheet, in_rows, scale_of, stack
from elastomorph.draw.strips import TRUTH, method_words
from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.evaluation.shape import ClosureSeam, closure_seams
from elastomorph.model.mesh import Mesh
from elastomorph.physics import Material
from elastomorph.rig import Rig


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

    The recorded frame nearest to the time is shown; the rest is as for `method_strip`.
    """
    truth, frame = evaluation.truth, _nearest_frame(evaluation, time)
    chosen = [evaluation[label] for label in labels]
    faces = [Face(truth.frames[frame], f"t = {truth.times[frame]:.2g}")]
    for result in chosen:
        caption = (
            f"largest error {100 * result.maximum[:, frame].max():.2f} % of D\n"
            f"largest average of a curve {100 * result.average[:, frame].max():.2f} %"
        )
        faces.append(Face(result.morph.at(float(truth.times[frame])), caption))
    return face_sheet(
        truth.mesh,
        [faces],
        _camera(evaluation, view, face),
        face,
        path,
        column_labels=[TRUTH, *(result.label for result in chosen)],
        title=title,
    )


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

    The distance of every vertex from the recorded one is drawn on the face of the method. Where
    the confidence of vertices is too low for them to count, none is drawn.

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
    """
    results = evaluation.results if labels is None else [evaluation[label] for label in labels]
    truth, frame = evaluation.truth, _nearest_frame(evaluation, time)
    faces = [_error_face(evaluation, frame, result, free_timing, names or {}) for result in results]
    words = (
        f"distance from the recorded face at t = {float(truth.times[frame]):.2g}"
        f"{', with free timing' if free_timing else ''}, % of D   "
        f"(D = {evaluation.diameter:.4g}{' ' * bool(unit)}{unit})"
    )
    top = None if highest is None else 100 * highest
    scale, camera = scale_of(faces, words, top, colour_map), _camera(evaluation, view, face)
    return face_sheet(
        truth.mesh, in_rows(faces, columns), camera, face, path, title=title, scale=scale
    )


def _error_face(
    evaluation: Evaluation,
    frame: int,
    result: MethodResult,
    free_timing: bool,
    names: Mapping[str, str],
) -> Face:
    times = result.path_times if free_timing else evaluation.truth.times
    pose = result.morph.at(float(times[frame]))
    away = np.linalg.norm(pose - evaluation.truth.frames[frame], axis=1)
    error = np.asarray(100 * away / evaluation.diameter)
    of = error
    if evaluation.confidence is not None:  # what is not to be trusted is no error of a method
        counted = evaluation.confidence.counted[frame]
        error = np.where(counted, error, 0.0)
        of = error[counted] if counted.any() else error
    name = names.get(result.label, result.label)
    return Face(pose, f"{name}\nmax {of.max():.2f} %, mean {of.mean():.2f} %", error)


def _camera(evaluation: Evaluation, view: View, face: tuple[int, int]) -> Camera:
    truth = evaluation.truth
    return camera_for(truth.mesh, view, poses=truth.frames, size=face)


def _nearest_frame(evaluation: Evaluation, time: float) -> int:
    return int(np.abs(evaluation.truth.times - time).argmin())


def closure_comparison(
    neutral: Mesh,
    target: Mesh,
    path: str | Path | None = None,
    *,
    closures: Sequence[str] = ("limit", "unforced"),
    time: float = 0.5,
    order: int = 2,
    material: Material | None = None,
    curves: CurveNetwork | None = None,
    width: int = 560,
    view: View = "front",
) -> Image:
    """One in-between under several closures: the face, its mouth close up, and its seam.

    The seam is the largest jump across an edge between two curves, against the law every stiff
    mode follows, as a fraction of D; flips are polygons turned over. The order is R of the load
    t^R, and the width that of one face in pixels.
    """
    if not closures:
        raise ParameterError("a comparison needs at least one closure")
    curves = extract_curves(neutral) if curves is None else curves
    made = closure_seams(
        neutral, target, curves, closures=closures, time=time, order=order, material=material
    )
    poses = [seam.morph.at(time) for seam in made]
    ends = np.stack([neutral.vertices, target.vertices])
    head = head_of(neutral, (seam.morph for seam in made))
    face, mouth = (width, round(1.2 * width)), (width, round(0.7 * width))
    whole = face_sheet(
        neutral,
        [[Face(pose) for pose in poses]],
        camera_for(neutral, view, poses=ends, head=head, size=face),
        face,
        column_labels=[f"beam R={order}, {closure}, t = {time:g}" for closure in closures],
    )
    seen = np.stack([neutral.vertices, *poses])
    near = camera_for(neutral, "mouth", poses=seen, head=head, size=mouth)
    close = [Face(pose, _seam_words(seam)) for pose, seam in zip(poses, made, strict=True)]
    return written(stack(whole, face_sheet(neutral, [close], near, mouth)), path)


def _seam_words(seam: ClosureSeam) -> str:
    flips = seam.shape.flips
    polygons = "polygon" if flips == 1 else "polygons"
    return f"seam {100 * seam.shape.seam:.2f} % of D, {flips:,} {polygons} turned over"


def contact_sheet(
    rig: Rig,
    weights: NDArray[np.float64],
    t: float = 1.0,
    path: str | Path | None = None,
    *,
    normalize: bool = False,
    columns: int = 10,
    face: tuple[int, int] = (150, 188),
    title: str = "",
) -> Image:
    """Faces of a rig, each with its (S, J) weights below it, the method above all (Fig. 10)."""
    poses = rig.batch(weights, t, normalize=normalize, dtype=np.float64)
    faces = [
        Face(pose, " ".join(f"{weight:.1f}".removeprefix("0") for weight in row))
        for pose, row in zip(poses, weights, strict=True)
    ]
    words = method_words(rig[name] for name in rig.targets)
    return face_sheet(
        rig.neutral,
        in_rows(faces, columns),
        camera_for(
            rig.neutral,
            "front",
            poses=poses,
            head=head_of(rig.neutral, rig.morphs.values()),
            size=face,
        ),
        face,
        path,
        title=f"{title} ({words})" if title else words,
    )
