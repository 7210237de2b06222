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
from .record import Follower, driver_of, followers
from .refusal import RefusedError


@dataclass(frozen=True)
class Baked:
    """How many shape keys got keyframes, and how many stand still and got a weight."""

    moving: int
    still: int


def bake(context: bpy.types.Context, things: Sequence[bpy.types.Object]) -> Baked:
    """Put keyframes in place of all drivers of shape keys: those of bends, and of the scene."""
    if not any(followers(thing.data.shape_keys) for thing in things):
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
        for own in followers(keys):
            moves = _own_keys(keys, own)
            still += not moves
            moving += moves
        thing.data.update()
    return Baked(moving, still)


def _driven(thing: bpy.types.Object) -> list[str]:
    """The keys that drivers of the scene move, not ours."""
    keys = thing.data.shape_keys
    ours = {own.name for own in followers(keys)}
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


def _own_keys(keys: bpy.types.Key, own: Follower) -> bool:
    """Keyframes in every action that moves a key that this one follows; else its present weight."""
    block, hosts = keys.key_blocks[own.name], [keys.key_blocks[name] for name in own.law.drivers]
    path = block.path_from_id("value")
    for what in ("value", "mute"):
        if driver_of(keys, block.path_from_id(what)) is not None:
            keys.driver_remove(block.path_from_id(what))
    animated = False
    for curves in all_curves(keys):
        sources = [curves.find(host.path_from_id("value")) for host in hosts]
        moving = [_frames(source) for source in sources if source is not None]
        if moving:
            frames = np.unique(np.concatenate(moving))
            both = [*zip(sources, hosts, strict=True)]
            rows = [[h.value if s is None else s.evaluate(f) for s, h in both] for f in frames]
            weights = np.clip(rows, [h.slider_min for h in hosts], [h.slider_max for h in hosts])
            set_keyframes(curves, path, frames, own.weight(weights))
            animated = True
    if own.curve is not None:
        block.mute = any(host.mute for host in hosts)
    block.value = float(own.weight(np.array([host.value for host in hosts])))
    return animated


def _frames(source: bpy.types.FCurve) -> Array:
    """All whole frames of an animation curve, and the frames of its keyframes."""
    first, last = source.range()
    whole = np.arange(floor(first), ceil(last) + 1, dtype=float)
    own = np.empty(2 * len(source.keyframe_points))
    source.keyframe_points.foreach_get("co", own)
    return np.union1d(whole, own[::2])
