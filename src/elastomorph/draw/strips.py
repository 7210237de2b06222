"""Faces over time, in rows: methods, expressions, a take."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.framing import View, camera_for
from elastomorph.draw.head import head_of
from elastomorph.draw.pictures import Image
from elastomorph.draw.sheet import Face, face_sheet
from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation import Evaluation
from elastomorph.model.mesh import Mesh, require_same_topology
from elastomorph.model.morph import Morph
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
