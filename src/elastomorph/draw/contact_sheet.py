"""A contact sheet: many faces of a rig on one page (Fig. 10)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.framing import camera_for
from elastomorph.draw.grid import picture_grid
from elastomorph.draw.method_words import method_words
from elastomorph.draw.pictures import write_picture
from elastomorph.draw.stage import Image, Stage
from elastomorph.rig import Rig

__all__ = ["contact_sheet"]


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
    """Draw one face for each row of weights, its weights below it, the method above all.

    Args:
        rig: The rig.
        weights: (S, J) in the order of ``rig.names``.
        t: Common time.
        path: Picture to write, if any; the suffix chooses the format.
        normalize: Divide the weights of each face by their sum.
        columns: Faces in a row.
        face: Width and height of one face in pixels.
        title: Above the faces, before the method.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: Weights of another shape, or none.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    poses = rig.batch(weights, t, normalize=normalize, dtype=np.float64)
    camera = camera_for(rig.neutral, "front", poses=poses, size=face)
    with Stage(rig.neutral, camera, size=face) as stage:
        faces = [stage.picture(pose) for pose in poses]
    captions = [" ".join(f"{w:.1f}".removeprefix("0") for w in row) for row in weights]
    words = method_words(rig.morphs.values())
    starts = range(0, len(faces), columns)
    image = picture_grid(
        [faces[start : start + columns] for start in starts],
        captions=[captions[start : start + columns] for start in starts],
        title=f"{title} ({words})" if title else words,
    )
    if path is not None:
        write_picture(image, path)
    return image
