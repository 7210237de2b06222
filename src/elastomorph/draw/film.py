"""A performance on a rig as moving pictures, drawn one after another on one stage."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.camera import Camera
from elastomorph.draw.framing import View, camera_for
from elastomorph.draw.head import head_of
from elastomorph.draw.pictures import Image
from elastomorph.draw.sheet import Style
from elastomorph.draw.stage import Stage
from elastomorph.draw.strips import telling_frames
from elastomorph.rig import Rig

_MOST_FRAMED = 9
"""Frames of a performance that the camera makes room for: those that differ most."""
_OCCLUSION = 16
"""Twice as many frames a second as with those of a still, from which nobody tells them."""
_BLOCK = 16


def film_frames(
    rig: Rig,
    weights: NDArray[np.float64],
    *,
    size: tuple[int, int] = (480, 600),
    view: View = "front",
    style: Style | None = None,
    draft: bool = False,
) -> Generator[Image, None, None]:
    """The face in each frame: (H, W, 3) uint8, or (H, W, 4) where transparent.

    Args:
        rig: The rig.
        weights: (T, J) weights of its sliders. A frame with those of the one before is not drawn
            again.
        size: Width and height of a frame in pixels.
        view: As for `camera_for`.
        style: How faces are drawn.
        draft: One sample a pixel, which is jagged and two to three times as fast.
    """
    style, camera = style or Style(), film_camera(rig, weights, view, size)
    samples = 1 if draft else None
    with Stage(
        rig.neutral, camera, size=size, supersampling=samples, occlusion=_OCCLUSION
    ) as stage:
        drawn: Image | None = None
        before = weights[:1]
        faces = (f for block in rig.stream(weights, block=_BLOCK) for f in block)
        for row, positions in zip(weights, faces, strict=True):
            if drawn is None or (row != before).any():
                drawn = style.draw(stage, positions.astype(np.float64))
            before = row
            yield drawn


def film_camera(
    rig: Rig, weights: NDArray[np.float64], view: View, size: tuple[int, int]
) -> Camera:
    """One camera for all frames of a film."""
    mesh, head = rig.neutral, head_of(rig.neutral, rig.morphs.values())
    widest = weights[telling_frames(weights, _MOST_FRAMED)]
    framed = np.concatenate([mesh.vertices[None], rig.batch(widest, dtype=np.float64)])
    return camera_for(mesh, view, poses=framed, head=head, size=size)
