"""Keyframes in place of drivers, for exporters that play none.

Where the key of a bend is animated by actions, the bend gets keyframes in each of these, so clips
stay apart. What other drivers move is sampled over the frames of the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor

import bpy
import numpy as np

from .actions import active_curves, all_curves, set_keyframes
from .face import Array
from .record import KeptBend, driver_of, kept_bends
from .refusal import RefusedError


@dataclass(frozen=True)
class Baked:
    """How many shape keys got keyframes, and how many stand still and got a weight."""

    moving: int
    still: int


def bake(context: bpy.types.Context, things: Sequence[bpy.types.Object]) -> Baked:
    """Put keyframes in place of all drivers of shape keys: those of bends, and of the scene."""
    if not any(kept_bends(thing.data.shape_keys) for thing in things):
        raise RefusedError(
            f"{things[0].name} has no bends to bake: run Bend Shape Keys before, and bake last"
        )
    driven = {thing: _driven(thing) for thing in things}
    sampled = _sampled(context.scene, context.view_layer, driven) if any(driven.values()) else {}
    frames = np.arange(context.scene.frame_start, context.scene.frame_end + 1, dtype=float)
    moving = still = 0
    for thing in things:
        keys = thing.data.shape_keys
        for name in driven[thing]:
            _put(keys, name, frames, sampled[thing][name])
        for bend in kept_bends(keys):
            curves = _bend_keys(keys, bend)
            still += not curves
            moving += bool(curves)
        thing.data.update()
    return Baked(moving, still)


def _driven(thing: bpy.types.Object) -> list[str]:
    """The keys that drivers of the scene move, not ours."""
    keys = thing.data.shape_keys
    ours = {bend.name for bend in kept_bends(keys)}
    blocks = (block for block in keys.key_blocks if block.name not in ours)
    return [b.name for b in blocks if driver_of(keys, b.path_from_id("value")) is not None]


def _sampled(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    driven: dict[bpy.types.Object, list[str]],
) -> dict[bpy.types.Object, dict[str, Array]]:
    """(F,) weight of each driven key in each frame of the scene."""
    now = scene.frame_current, scene.frame_subframe
    frames = range(scene.frame_start, scene.frame_end + 1)
    found = {
        thing: {name: np.zeros(len(frames)) for name in names} for thing, names in driven.items()
    }
    for row, frame in enumerate(frames):
        scene.frame_set(frame)
        # Once in some ten thousand times a driver is one moment late; a second time it is not.
        for thing in found:
            thing.data.shape_keys.update_tag()
        view_layer.update()
        for thing, names in found.items():
            for name, weights in names.items():
                weights[row] = thing.data.shape_keys.key_blocks[name].value
    scene.frame_set(now[0], subframe=now[1])
    return found


def _put(keys: bpy.types.Key, name: str, frames: Array, weights: Array) -> None:
    """Keyframes of a key in the active action, in place of its driver."""
    path = keys.key_blocks[name].path_from_id("value")
    keys.driver_remove(path)
    set_keyframes(active_curves(keys), path, frames, weights)


def _bend_keys(keys: bpy.types.Key, bend: KeptBend) -> bool:
    """Keyframes of a bend in every action that moves its key; else its present weight."""
    block, host = keys.key_blocks[bend.name], keys.key_blocks[bend.target]
    path, followed = block.path_from_id("value"), host.path_from_id("value")
    for what in ("value", "mute"):
        if driver_of(keys, block.path_from_id(what)) is not None:
            keys.driver_remove(block.path_from_id(what))
    animated = False
    for curves in all_curves(keys):
        source = curves.find(followed)
        if source is not None:
            frames = _frames(source)
            weights = np.array([source.evaluate(frame) for frame in frames])
            least, most = host.slider_min, host.slider_max
            set_keyframes(curves, path, frames, bend.curve(np.clip(weights, least, most)))
            animated = True
    block.mute = host.mute
    block.value = float(bend.curve(host.value))
    return animated


def _frames(source: bpy.types.FCurve) -> Array:
    """All whole frames of an animation curve, and the frames of its keyframes."""
    first, last = source.range()
    whole = np.arange(floor(first), ceil(last) + 1, dtype=float)
    own = np.empty(2 * len(source.keyframe_points))
    source.keyframe_points.foreach_get("co", own)
    return np.union1d(whole, own[::2])
