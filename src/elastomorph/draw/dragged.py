"""Faces and the handles they were dragged by: where each point is, and where it should be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.draw.camera import View, camera_for
from elastomorph.draw.pictures import ColourScale, Image, imported, round_up, written
from elastomorph.draw.sheet import picture_grid
from elastomorph.draw.stage import Stage
from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import Mesh, as_vertices
from elastomorph.rig.handles import Handle, Place, asked

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
