"""The colour of points: materials under a lamp and under light from all around."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.farm.pictures.subject import PARTS
from elastomorph.farm.pictures.view import Points, View, mixed

__all__ = ["clothed", "radiance"]

Colours = NDArray[np.float32]

_EXPOSURE = 0.9
_GROUND = 0.5  # of the light from all around that comes from below
_SOFT = np.isin(PARTS, ("skin", "lips", "gum", "tongue", "mouth", "nostril"))
_AROUND = np.array([0.28, 0.14, 0.10], dtype=np.float32)
"""How far light comes around the edge of what is lit, in skin: red farthest."""
_GLOSS = 0.55


def clothed(view: View, points: Points) -> Colours:
    """(N, 4) linear colour and opacity of points in even light, without highlights."""
    subject = view.subject
    cloth = subject.cloth[points.triangle]
    colours = np.stack([own.colour for own in subject.cloths])[cloth]
    for number, own in enumerate(subject.cloths):
        mine = np.flatnonzero(cloth == number) if own.texels is not None else cloth[:0]
        if own.texels is None or not len(mine):
            continue
        triangle = points.triangle[mine]
        places = subject.places[triangle]
        level = own.texels.level(_texels_a_pixel(view, triangle, own.texels.levels[0].shape))
        colours[mine] = own.texels.at(mixed(points.weights[mine], places), level)
    return np.asarray(colours)


def radiance(
    view: View, points: Points, lit: NDArray[np.float32], open_: NDArray[np.float32]
) -> tuple[Colours, NDArray[np.float32]]:
    """(N, 3) linear light from points to the camera, and (N,) their opacity.

    Args:
        view: What they are on.
        points: N of them.
        lit: (N,) how much of the lamp they see, see `shadows`.
        open_: (N,) how much of the light from all around, see `hollows`.
    """
    scene, subject = view.scene, view.subject
    colours = clothed(view, points)
    lamp, above = scene.lamp.astype(np.float32), scene.above.astype(np.float32)
    facing = points.normal @ lamp
    soft = np.where(_SOFT[subject.part[points.triangle]][:, None], _AROUND, np.float32(0))
    # Light that enters skin leaves it elsewhere: beyond the edge of what is lit too.
    around = np.clip((facing[:, None] + soft) / (1 + soft), 0, 1) ** (1 + soft)
    direct = around * lit[:, None] * scene.light.astype(np.float32)
    sky = (1 + _GROUND + (1 - _GROUND) * (points.normal @ above)) / 2
    even = (sky * open_)[:, None] * scene.ambient.astype(np.float32)
    shown = colours[:, :3] * (direct + even)
    shown += (_highlight(view, points, lamp) * lit)[:, None] * scene.light.astype(np.float32)
    unlit = np.array([own.unlit for own in subject.cloths])[subject.cloth[points.triangle]]
    shown = np.where(unlit[:, None], colours[:, :3], np.float32(_EXPOSURE) * shown)
    return shown, colours[:, 3]


def _highlight(view: View, points: Points, lamp: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N,) Blinn and Phong: how much of the lamp is mirrored to the camera."""
    cloth = view.subject.cloth[points.triangle]
    shine = np.array([own.shine for own in view.subject.cloths], dtype=np.float32)[cloth]
    polish = np.array([own.polish for own in view.subject.cloths], dtype=np.float32)[cloth]
    length = np.sqrt(np.einsum("ni,ni->n", points.position, points.position))
    half = lamp - points.position / length[:, None]
    half /= np.maximum(np.sqrt(np.einsum("ni,ni->n", half, half)), np.float32(1e-6))[:, None]
    mirrored = np.maximum(np.einsum("ni,ni->n", half, points.normal), 0) ** (2 * polish)
    before = np.clip(4 * (points.normal @ lamp), 0, 1)
    return np.asarray(np.float32(_GLOSS) * shine * mirrored * before)


def _texels_a_pixel(view: View, triangle: NDArray[np.int64], shape: tuple[int, ...]) -> float:
    """How many texels of an image one pixel covers, over some seen triangles."""
    corners = view.places[view.subject.triangles[triangle]]
    pixels = _areas(corners).sum()
    texels = _areas(view.subject.places[triangle].astype(np.float64)).sum() * shape[0] * shape[1]
    return float(texels / max(pixels, 1e-12))


def _areas(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) / 2)
