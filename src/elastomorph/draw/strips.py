"""Faces over time, in rows: methods, expressions, a take."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.draw.camera import Camera, View, camera_for
from elastomorph.draw.head import head_of
from elastomorph.draw.pictures import COLOUR_MAP, Image, written
from elastomorph.draw.sheet import Face, face_sheet, in_rows, scale_of, stack
from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.evaluation.shape import ClosureSeam, closure_seams
from elastomorph.model.mesh import Mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.physics import Material
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn, Performance

TRUTH = "recorded"
"""The label of faces that were recorded."""
TIMES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
_LABEL_WIDTH = 12


def face_strip(
    rows: Mapping[str, tuple[Mesh, NDArray[np.float64]]],
    times: Sequence[float] | NDArray[np.float64],
    path: str | Path | None = None,
    *,
    face: tuple[int, int] = (240, 300),
    view: View = "front",
    head: NDArray[np.int64] | None = None,
    title: str = "",
    turn: HeadTurn | None = None,
) -> Image:
    """Faces in rows, their times above, all seen by one camera.

    Args:
        rows: Label of each row, with a mesh and (T, V, 3) positions of its vertices. All meshes
            have the same vertices and polygons.
        times: (T,) t of each column.
        path: Picture to write, if any; the suffix chooses the format.
        face: Width and height of one face in pixels.
        view: As for `camera_for`, as is the head.
        head: (N,) vertices of the head of a character.
        title: Above the strip.
        turn: How the head is turned in each of the T columns; it is still by default.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No rows or no times.
        TopologyError: The meshes differ in vertices or polygons.
        MeshError: The positions do not fit the mesh and the times.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    if not rows or not len(times):
        raise ParameterError("a strip of faces needs at least one row and one time")
    first = next(iter(rows.values()))[0]
    for label, (mesh, positions) in rows.items():
        require_same_topology(first, mesh)
        expected = (len(times), *mesh.vertices.shape)
        if np.shape(positions) != expected:
            raise MeshError(
                f"row {label!r} needs positions of shape {expected}, found {np.shape(positions)}"
            )
    poses = np.concatenate([first.vertices[None], *(positions for _, positions in rows.values())])
    return face_sheet(
        first,
        [
            [Face(pose if turn is None else turn.of(pose, i)) for i, pose in enumerate(positions)]
            for _, positions in rows.values()
        ],
        camera_for(first, view, poses=poses, head=head, size=face, turn=turn),
        face,
        path,
        row_labels=[_in_lines(label) for label in rows],
        column_labels=[f"t = {float(time):.3g}" for time in times],
        title=title,
    )


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

    All methods are shown unless labels name some; of more frames than ``count``, evenly spread
    ones are. The rest is as for `face_strip`.
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
    """Expressions, paths of one mesh by name, growing out of the neutral (Fig. 9).

    The title is the method of the paths by default; the rest is as for `face_strip`.
    """
    when = np.asarray(times, dtype=np.float64)
    rows = {name: (morph.neutral, morph.at(when)) for name, morph in morphs.items()}
    words = method_words(morphs.values()) if title is None else title
    head = next((head_of(m.neutral, morphs.values()) for m in morphs.values()), None)
    return face_strip(rows, when, path, face=face, view=view, head=head, title=words)


def take_strip(
    rig: Rig,
    performance: Performance,
    weights: NDArray[np.float64],
    path: str | Path | None = None,
    *,
    count: int = 5,
    face: tuple[int, int] = (300, 375),
    turn: HeadTurn | None = None,
) -> Image:
    """Draw frames that show what a take, (T, J) weights of the rig's sliders, holds, in order.

    The head is turned as in its T frames, or still.
    """
    frames = telling_frames(weights, count)
    poses = rig.batch(weights[frames], dtype=np.float64).astype(np.float64)
    rows, head = {"": (rig.neutral, poses)}, head_of(rig.neutral, rig.morphs.values())
    seen = None if turn is None else turn.only(frames)
    return face_strip(rows, performance.times[frames], path, face=face, head=head, turn=seen)


def telling_frames(weights: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """(min(count, T),) frames of (T, J) weights: the most active, then always the least alike."""
    chosen = [int(np.abs(weights).sum(axis=1).argmax())]
    nearest = np.full(len(weights), np.inf)
    while len(chosen) < min(count, len(weights)):
        nearest = np.minimum(nearest, np.linalg.norm(weights - weights[chosen[-1]], axis=1))
        nearest[chosen] = -1.0
        chosen.append(int(nearest.argmax()))
    return np.sort(np.array(chosen, dtype=np.int64))


def method_words(morphs: Iterable[Morph]) -> str:
    """Such as "method auto, even timing" or "method beam R=2, uneven timing"."""
    paths = list(morphs)
    labels = dict.fromkeys("auto" if path.choice is not None else path.method for path in paths)
    even = all(not path.limit_law(0.25) for path in paths)
    names = ", ".join(labels)
    what = "method" if len(labels) == 1 else "methods"
    return f"{what} {names}, {'even' if even else 'uneven'} timing"


def _in_lines(label: str) -> str:
    """A label in lines short enough to stand beside a face."""
    lines = [""]
    for word in label.split():
        if lines[-1] and len(lines[-1]) + len(word) >= _LABEL_WIDTH:
            lines.append(word)
        else:
            lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)


# Faces side by side: methods at one moment and where they err, closures, blended faces.


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
