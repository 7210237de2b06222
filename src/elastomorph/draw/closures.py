"""What a closure does to a face: whole or torn along its curves, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.draw.framing import View, camera_for
from elastomorph.draw.grid import picture_grid, stack
from elastomorph.draw.pictures import write_picture
from elastomorph.draw.stage import Image, Stage
from elastomorph.errors import ParameterError
from elastomorph.evaluation.closure_seams import closure_seams
from elastomorph.model.mesh import Mesh
from elastomorph.physics import Material

__all__ = ["closure_comparison"]


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
    mode follows, as a fraction of D; flips are polygons turned over.

    Args:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1, such as an open jaw.
        path: Picture to write, if any; the suffix chooses the format.
        closures: One column each.
        time: t of the in-between.
        order: R of the load t^R.
        material: m, c, k; 1, 1, 1 by default.
        curves: The curves of the neutral; found by `extract_curves` by default.
        width: Of one face, in pixels.
        view: Of the whole face, as for `camera_for`.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No closures, or one that does not exist.
        TopologyError: Neutral and target differ in vertices or polygons.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    if not closures:
        raise ParameterError("a comparison needs at least one closure")
    curves = extract_curves(neutral) if curves is None else curves
    made = closure_seams(
        neutral, target, curves, closures=closures, time=time, order=order, material=material
    )
    poses = [seam.morph.at(time) for seam in made]
    ends = np.stack([neutral.vertices, target.vertices])
    heads = (width, round(1.2 * width))
    mouths = (width, round(0.7 * width))
    mouth_poses = np.stack([neutral.vertices, *poses])
    with Stage(neutral, camera_for(neutral, view, poses=ends, size=heads), size=heads) as stage:
        faces = [stage.picture(pose) for pose in poses]
    close = camera_for(neutral, "mouth", poses=mouth_poses, size=mouths)
    with Stage(neutral, close, size=mouths) as stage:
        near = [stage.picture(pose) for pose in poses]
    captions = [
        f"seam {100 * seam.shape.seam:.2f} % of D, {_polygons(seam.shape.flips)} turned over"
        for seam in made
    ]
    names = [f"beam R={order}, {closure}, t = {time:g}" for closure in closures]
    image = stack(
        picture_grid([faces], column_labels=names),
        picture_grid([near], captions=[captions]),
        gap=0,
    )
    if path is not None:
        write_picture(image, path)
    return image


def _polygons(count: int) -> str:
    return f"{count:,} polygon" if count == 1 else f"{count:,} polygons"
