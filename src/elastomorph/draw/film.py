"""A performance on a rig as moving pictures, drawn one after another on one stage."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.camera import Camera, View, camera_for
from elastomorph.draw.head import head_of
from elastomorph.draw.pictures import Image
from elastomorph.draw.sheet import Style
from elastomorph.draw.stage import Stage
from elastomorph.draw.strips import telling_frames
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn

_MOST_FRAMED = 9
"""Frames of a performance that the camera makes room for: those that differ most."""
_MOST_TURNS = 24
"""Directions of a head likewise."""
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
    turn: HeadTurn | None = None,
) -> Generator[Image, None, None]:
    """The face in each frame: (H, W, 3) uint8, or (H, W, 4) where transparent.

    Args:
        rig: The rig.
        weights: (T, J) weights of its sliders. A frame with those of the one before, and turned
            alike, is not drawn again.
        size: Width and height of a frame in pixels.
        view: As for `camera_for`.
        style: How faces are drawn.
        draft: One sample a pixel, which is jagged and two to three times as fast.
        turn: How the head is turned in each of the T frames; it is still by default.
    """
    style, camera = style or Style(), film_camera(rig, weights, view, size, turn)
    samples = 1 if draft else None
    with Stage(
        rig.neutral, camera, size=size, supersampling=samples, occlusion=_OCCLUSION
    ) as stage:
        drawn: Image | None = None
        moving = weights if turn is None else np.hstack([weights, turn.angles])
        before = moving[:1]
        faces = (f for block in rig.stream(weights, block=_BLOCK) for f in block)
        for frame, (row, positions) in enumerate(zip(moving, faces, strict=True)):
            if drawn is None or (row != before).any():
                face = positions.astype(np.float64)
                drawn = style.draw(stage, face if turn is None else turn.of(face, frame))
            before = row
            yield drawn


def film_camera(
    rig: Rig,
    weights: NDArray[np.float64],
    view: View,
    size: tuple[int, int],
    turn: HeadTurn | None = None,
) -> Camera:
    """One camera for all frames of a film."""
    mesh, head = rig.neutral, head_of(rig.neutral, rig.morphs.values())
    widest = weights[telling_frames(weights, _MOST_FRAMED)]
    framed = np.concatenate([mesh.vertices[None], rig.batch(widest, dtype=np.float64)])
    seen = None if turn is None else turn.only(telling_frames(turn.angles, _MOST_TURNS))
    return camera_for(mesh, view, poses=framed, head=head, size=size, turn=seen)
