"""Rigs under weights that run together, as under the viewer's master t, in pictures and clips."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.draw.camera import Turntable, View, camera_for
from elastomorph.draw.head import head_of
from elastomorph.draw.pictures import ColourScale, Image, imported, round_up, written
from elastomorph.draw.sheet import (
    Face,
    Style,
    face_sheet,
    in_rows,
    legend_height,
    picture_grid,
    with_legend,
)
from elastomorph.draw.stage import Stage
from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import Mesh, as_vertices
from elastomorph.paths import Method
from elastomorph.rig import Rig, build
from elastomorph.rig.handles import Handle, Place, asked
from elastomorph.rig.timing import Timing

Positions = NDArray[np.float64]

_MOST_FRAMED = 9
"""Poses of a clip that the camera makes room for."""
_WIDER = 1.7
"""How many more columns than rows a sheet of poses has, to be about twice as wide as high."""
_LEAST = 16
"""Fewest pixels on each side of a face."""


@dataclass(frozen=True, eq=False)
class PosedRig:
    """A rig, the weight of each slider at t = 1, and its label beside its row of a strip."""

    label: str
    rig: Rig
    weights: Mapping[str, float]

    def at(self, t: float) -> NDArray[np.float64]:
        """(V, 3) positions at one master time: each path at its weight times t."""
        if not np.isfinite(t):
            raise ParameterError(f"t must be a finite number, found {t}")
        return self.rig.pose({name: weight * t for name, weight in self.weights.items()})


def with_paths(rig: Rig, method: Method | None, sliders: Mapping[str, float]) -> Rig:
    """The rig with the paths of a method to the same targets, for the sliders that move.

    Morphs that these sliders do not move keep theirs, for paths may cost time to find. Without a
    method, paths that are there are kept.
    """
    rig.sliders.row(sliders)
    # A hinge moves where one of its drivers does; other laws are 0 where one of them is.
    hinges = {name for name, own in rig.sliders.correctives.items() if own.law == "hinge"}
    moved = [
        name
        for name in rig.morphs
        if (any if name in hinges else all)(d in sliders for d in rig.sliders.drivers(name))
    ]
    return build.with_paths(rig, method, names=moved)


def swing(count: int, timing: Timing, reach: float = 1.0) -> NDArray[np.float64]:
    """(count,) t of each frame of a clip from 0 to ``reach`` and back, to be played in a loop.

    The way back is the mirror image of the way there, and the last frame is one step before the
    first. A timing that comes back by itself, as a blink does, is played once instead.
    """
    clip = np.arange(count) / count
    start, end = timing.at([0.0, 1.0])
    there = clip if end == start else 1.0 - np.abs(1.0 - 2.0 * clip)
    return np.asarray(reach * timing.at(there))


@dataclass(frozen=True, eq=False)
class Comparison:
    """How far rigs are from a reference, the positions `at` a time, over all times and vertices."""

    at: Callable[[float], Positions]
    largest: float
    mean: float
    diameter: float
    scale: ColourScale

    @property
    def facts(self) -> dict[str, float]:
        """The numbers by name."""
        return {"largest": self.largest, "mean": self.mean, "diameter": self.diameter}

    def distances(self, positions: Positions, t: float) -> NDArray[np.float64]:
        """(V,) distance of each vertex from the reference at one time."""
        return np.asarray(np.linalg.norm(positions - self.at(t), axis=1))


def compare(
    rigs: Sequence[PosedRig],
    times: Sequence[float],
    name: str,
    at: Callable[[float], Positions],
    *,
    highest: float | None = None,
    unit: str = "",
) -> Comparison:
    """Measure rigs against a reference at times, and choose one scale of colours for all pictures.

    The last colour is the largest distance, rounded up, unless ``highest`` says another.
    """
    if highest is not None and not (np.isfinite(highest) and highest > 0):
        raise ParameterError(f"the distance of the last colour must be above 0, found {highest:g}")
    largest, means = 0.0, []
    for t in times:
        there = at(t)
        for rig in rigs:
            distances = np.linalg.norm(rig.at(t) - there, axis=1)
            largest = max(largest, float(distances.max()))
            means.append(float(distances.mean()))
    diameter = _diameter(rigs[0])
    share = 100 * largest / diameter if diameter > 0 else 0.0
    words = f" {unit}" if unit else ""
    label = (
        f"distance from {name}{', ' * bool(unit)}{unit}   "
        f"(largest {largest:.3g}{words} = {share:.2g} % of D, D = {diameter:.4g}{words})"
    )
    scale = ColourScale(round_up(largest) if highest is None else highest, label)
    return Comparison(at, largest, float(np.mean(means)), diameter, scale)


def pose_picture(
    rig: PosedRig,
    t: float,
    *,
    size: tuple[int, int] = (720, 900),
    view: View = "front",
    style: Style | None = None,
    comparison: Comparison | None = None,
) -> Image:
    """One face as of `clip_frames`, with room for the whole path, so that all times match."""
    return next(clip_frames(rig, [t], size=size, view=view, style=style, comparison=comparison))


def pose_strip(
    rigs: Sequence[PosedRig],
    times: Sequence[float],
    *,
    face: tuple[int, int] = (240, 300),
    view: View = "front",
    style: Style | None = None,
    comparison: Comparison | None = None,
    title: str = "",
) -> Image:
    """Rigs with the same vertices and polygons in rows, times in columns: (H, W, 3) uint8.

    Arguments as for `clip_frames`, on a background that is not transparent.
    """
    style = style or Style()
    if not rigs or not times or style.background is None:
        raise ParameterError("a strip needs rigs, times and a background that is not transparent")
    mesh = rigs[0].rig.neutral
    return face_sheet(
        mesh,
        [[_face(rig.at(t), t, comparison) for t in times] for rig in rigs],
        camera_for(mesh, view, poses=_framed(rigs, times), head=_head(rigs[0]), size=face),
        face,
        row_labels=[rig.label for rig in rigs] if len(rigs) > 1 else (),
        column_labels=[f"t = {t:.3g}" for t in times],
        title=title,
        scale=None if comparison is None else comparison.scale,
        style=style,
    )


def pose_sheet(
    rig: Rig,
    poses: Mapping[str, Mapping[str, float]],
    *,
    face: tuple[int, int] = (240, 300),
    view: View = "front",
    style: Style | None = None,
    title: str = "",
) -> Image:
    """Named poses of a rig, each above its name, all seen by one camera: (H, W, 3) uint8."""
    style = style or Style()
    if not poses or style.background is None:
        raise ParameterError("a sheet needs poses and a background that is not transparent")
    mesh, columns = rig.neutral, int(np.ceil(np.sqrt(_WIDER * len(poses))))
    faces = [Face(rig.pose(weights), name) for name, weights in poses.items()]
    framed = np.stack([mesh.vertices, *(each.vertices for each in faces)])
    head = head_of(mesh, rig.morphs.values())
    camera = camera_for(mesh, view, poses=framed, head=head, size=face)
    return face_sheet(mesh, in_rows(faces, columns), camera, face, title=title, style=style)


def _face(positions: Positions, t: float, comparison: Comparison | None) -> Face:
    if comparison is None:
        return Face(positions)
    away = comparison.distances(positions, t)
    return Face(positions, f"max {away.max():.3g}, mean {away.mean():.3g}", away)


def clip_frames(
    rig: PosedRig,
    times: Sequence[float],
    angles: ArrayLike | None = None,
    *,
    size: tuple[int, int] = (480, 600),
    view: View = "front",
    style: Style | None = None,
    comparison: Comparison | None = None,
) -> Generator[Image, None, None]:
    """Frames of a clip, drawn one by one: (H, W, 3) uint8, or (H, W, 4) where transparent.

    Args:
        rig: The rig and its weights.
        times: (N,) master time of each frame.
        angles: (N,) degrees by which the head is turned in each frame, if at all.
        size: Width and height of a frame in pixels, legend included.
        view: As for `camera_for`; of the whole head where it turns.
        style: How faces are drawn.
        comparison: For heat maps and their legend.
    """
    style = style or Style()
    scale = None if comparison is None else comparison.scale
    if style.background is None and scale is not None:
        raise ParameterError("a legend needs a background that is not transparent")
    turns = np.zeros(len(times)) if angles is None else np.asarray(angles, dtype=np.float64)
    if turns.shape != (len(times),):
        raise ParameterError(f"expected {len(times)} angles, found {turns.shape}")
    mesh, face = rig.rig.neutral, (size[0], size[1] - legend_height(size[0], scale))
    if face[1] < _LEAST:
        raise ParameterError(f"{size[0]} × {size[1]} pixels have no room for a face and its legend")
    framed, head = _framed([rig], times), _head(rig)
    table = None
    if angles is None:
        camera = camera_for(mesh, view, poses=framed, head=head, size=face)
    else:
        table = Turntable.around(mesh, turns, view, poses=framed, head=head, size=face)
        camera = table.camera
    with Stage(mesh, camera, size=face) as stage:
        for t, degrees in zip(times, turns.tolist(), strict=True):
            positions = rig.at(t)
            colours = None
            if comparison is not None:
                colours = comparison.scale.colours(comparison.distances(positions, t))
            seen = positions if table is None else table.turned(positions, degrees)
            yield with_legend(style.draw(stage, seen, colours), scale)


def _diameter(posed: PosedRig) -> float:
    """The unit of distances: of a character with a body, the extent of what its targets move."""
    whole = posed.rig.neutral.diameter
    return whole if _head(posed) is None else build.extent_of(posed.rig) or whole


def _head(posed: PosedRig) -> NDArray[np.int64] | None:
    return head_of(posed.rig.neutral, posed.rig.morphs.values())


def _framed(rigs: Sequence[PosedRig], times: Sequence[float]) -> Positions:
    """Poses that the camera must have room for: the whole path, whatever part of it is shown."""
    spread = np.linspace(min([0.0, *times]), max([1.0, *times]), _MOST_FRAMED).tolist()
    poses = [rig.at(t) for rig in rigs for t in ([0.0, *spread] if rig.weights else [0.0])]
    return np.stack(poses)


# Faces and the handles they were dragged by: where each point is, and where it should be.

RING, LINE = (20, 90, 230), (225, 30, 30)
"""Colours of where a handle should be, and of the way that is left to there."""
# Rings and lines are drawn this many times larger, for their edges to be smooth.
_FINER = 4
_RADIUS = 0.011


def drag_picture(
    mesh: Mesh,
    handles: Mapping[Handle, ArrayLike],
    faces: Mapping[str, ArrayLike],
    path: str | Path | None = None,
    *,
    landmarks: Mapping[str, Place] | None = None,
    views: Sequence[View] = ("front",),
    face: tuple[int, int] = (340, 425),
) -> Image:
    """Faces side by side, with rings where handles should be and lines to there from the face.

    Colours say how far a vertex is from where the first face has it, captions how far the handle
    farthest off is left. Rings are drawn over the face, also where they are within it.

    Args:
        mesh: The neutral of the rig.
        handles: (3,) position of each, as for `Rig.solve`, as are the landmarks.
        faces: (V, 3) positions of each face by its label, such as those at rest and solved.
        path: Picture to write, if any; the suffix chooses the format.
        landmarks: Vertex of each landmark that handles name.
        views: One row of pictures for each, as for `camera_for`.
        face: Width and height of one face in pixels.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No faces or views, or a handle or position that cannot be.
        MeshError: A face with another number of vertices.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    mix, goals = asked(handles, landmarks, len(mesh.vertices))
    if not faces or not views:
        raise ParameterError("a picture of dragged faces needs at least one face and one view")
    poses = _as_poses(mesh, faces)
    away = [np.linalg.norm(pose - poses[0], axis=1) for pose in poses]
    held = [mix.of(pose[None, mix.vertices])[0] for pose in poses]
    label = f"how far a vertex is from where {next(iter(faces))!r} has it"
    scale = ColourScale(round_up(float(np.max(away))), label)
    rows, framed = [], np.stack([*poses, poses[0]])
    framed[-1, mix.vertices] = np.repeat(goals, np.diff(mix.firsts, append=len(mix.vertices)), 0)
    for view in views:
        camera = camera_for(mesh, view, poses=framed, size=face)
        with Stage(mesh, camera, size=face) as stage:
            pictures = [
                stage.picture(pose, colours=scale.colours(far))
                for pose, far in zip(poses, away, strict=True)
            ]
        rings, starts = camera.seen(goals, face), [camera.seen(place, face) for place in held]
        rows.append([_marked(*each, rings) for each in zip(pictures, starts, strict=True)])
    left = [np.linalg.norm(goals - place, axis=1).max() for place in held]
    digits = max(2 - int(np.floor(np.log10(scale.highest))), 0)
    captions = [[f"{far:.{digits}f} left" for far in left]] * len(rows)
    sheet = picture_grid(rows, column_labels=list(faces), captions=captions, scale=scale)
    return written(sheet, path)


def _as_poses(mesh: Mesh, faces: Mapping[str, ArrayLike]) -> list[NDArray[np.float64]]:
    poses = [as_vertices(face) for face in faces.values()]
    for label, pose in zip(faces, poses, strict=True):
        if pose.shape != mesh.vertices.shape:
            raise MeshError(
                f"the face {label!r} needs {len(mesh.vertices):,} vertices, found {len(pose):,}"
            )
    return poses


def _marked(picture: Image, starts: NDArray[np.float64], rings: NDArray[np.float64]) -> Image:
    """The picture with a ring at each (H, 2) pixel, and a line to it from where its point is."""
    height, width = picture.shape[:2]
    paint, draw = imported("PIL.Image"), imported("PIL.ImageDraw").Draw
    radius = _FINER * max(_RADIUS * height, 3.0)
    for shade, parts in ((LINE, starts), (RING, rings)):
        cover = paint.new("L", (_FINER * width, _FINER * height))
        for start, (x, y) in zip(_FINER * parts, _FINER * rings, strict=True):
            if shade is LINE:
                draw(cover).line([*start, x, y], 255, round(0.6 * radius))
            else:
                box = (x - radius, y - radius, x + radius, y + radius)
                draw(cover).ellipse(box, outline=255, width=round(0.5 * radius))
        share = np.asarray(cover.resize((width, height), paint.Resampling.BOX)) / 255.0
        picture = np.round(picture + share[..., None] * (np.array(shade) - picture)).astype(
            np.uint8
        )
    return picture
