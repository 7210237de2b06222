"""Faces in rows over time, all seen by one camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.framing import View, camera_for
from elastomorph.draw.grid import picture_grid
from elastomorph.draw.pictures import write_picture
from elastomorph.draw.stage import Image, Stage
from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import Mesh, require_same_topology

__all__ = ["face_strip"]

_LABEL_WIDTH = 12


def face_strip(
    rows: Mapping[str, tuple[Mesh, NDArray[np.float64]]],
    times: Sequence[float] | NDArray[np.float64],
    path: str | Path | None = None,
    *,
    face: tuple[int, int] = (240, 300),
    view: View = "front",
    title: str = "",
) -> Image:
    """Faces in rows, their times above, all seen by one camera.

    Args:
        rows: Label of each row, with a mesh and (T, V, 3) positions of its vertices. All meshes
            have the same vertices and polygons.
        times: (T,) t of each column.
        path: Picture to write, if any; the suffix chooses the format.
        face: Width and height of one face in pixels.
        view: As for `camera_for`.
        title: Above the strip.

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
    with Stage(first, camera_for(first, view, poses=poses, size=face), size=face) as stage:
        faces = _drawn(stage, [positions for _, positions in rows.values()])
    image = picture_grid(
        faces,
        row_labels=[_in_lines(label) for label in rows],
        column_labels=[f"t = {float(time):.3g}" for time in times],
        title=title,
    )
    if path is not None:
        write_picture(image, path)
    return image


def _drawn(stage: Stage, rows: Sequence[NDArray[np.float64]]) -> list[list[Image]]:
    """A picture of each pose; those that rows share, as their ends, are drawn once."""
    known: dict[bytes, Image] = {}
    for pose in (pose for row in rows for pose in row):
        if pose.tobytes() not in known:
            known[pose.tobytes()] = stage.picture(pose)
    return [[known[pose.tobytes()] for pose in row] for row in rows]


def _in_lines(label: str) -> str:
    """A label in lines short enough to stand beside a face."""
    lines = [""]
    for word in label.split():
        if lines[-1] and len(lines[-1]) + len(word) >= _LABEL_WIDTH:
            lines.append(word)
        else:
            lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)
