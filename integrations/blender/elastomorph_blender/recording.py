"""Recorded weights (CSV) as keyframes of shape keys."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from elastomorph.io.performance import read_performance
from elastomorph.rig.performance import match

from .actions import active_curves, set_keyframes
from .bending import weight_range
from .face import target_names
from .record import correctives, driver_of, followers
from .refusal import RefusedError


def import_performance(
    context: bpy.types.Context, things: Sequence[bpy.types.Object], path: str, start: float
) -> str:
    """Play a recording on the shape keys of these objects, at the frames of the scene.

    Returns:
        What drives what, for people.
    """
    scene = context.scene
    performance = read_performance(path)
    rate = scene.render.fps / scene.render.fps_base
    at_frames = performance.resampled(rate)
    frames = start + np.arange(len(at_frames), dtype=float)
    names = list(dict.fromkeys(name for thing in things for name in _sliders(thing)))
    matched = match(at_frames.names, names)
    if not matched.drives:
        raise RefusedError(
            f"{path}: none of its weights ({', '.join(performance.names[:3])}, …) is the name of a "
            f"shape key of {things[0].name} ({', '.join(names[:3])}, …): rename the columns or keys"
        )
    weights = dict(zip(names, matched.drive(at_frames.weights).T, strict=True))
    driven = {name: weights[name] for name in matched.drives}
    for thing in things:
        _require_free(thing, [*driven])
    for thing in things:
        _play(thing, frames, driven)
    scene.frame_end = max(scene.frame_end, int(frames[-1]))
    scene.frame_set(scene.frame_current)
    return f"{len(frames):,} frames at {rate:g} fps; {matched.text()}"


def _sliders(thing: bpy.types.Object) -> list[str]:
    laws = correctives(thing.data.shape_keys)
    return [name for name in target_names(thing) if name not in laws]


def _require_free(thing: bpy.types.Object, names: Sequence[str]) -> None:
    keys = thing.data.shape_keys
    own = (keys.key_blocks[name] for name in names if name in keys.key_blocks)
    busy = [b.name for b in own if driver_of(keys, b.path_from_id("value")) is not None]
    if busy:
        raise RefusedError(
            f"{busy[0]} of {thing.name} has a driver, which would win over keyframes: remove the "
            "driver (right click > Delete Drivers), or key what drives it"
        )


def _play(
    thing: bpy.types.Object, frames: np.ndarray, driven: dict[str, np.ndarray]
) -> None:  # fmt: skip
    keys = thing.data.shape_keys
    own = {name: weights for name, weights in driven.items() if name in keys.key_blocks}
    if not own:
        return
    curves = active_curves(keys)
    for name, weights in own.items():
        block = keys.key_blocks[name]
        block.slider_min = min(block.slider_min, float(weights.min()))
        block.slider_max = max(block.slider_max, float(weights.max()))
        set_keyframes(curves, block.path_from_id("value"), frames, weights)
    for follower in followers(keys):
        if not own.keys().isdisjoint(follower.law.drivers):
            block = keys.key_blocks[follower.name]
            least, most = weight_range(keys, follower.law, follower.curve)
            block.slider_min = min(block.slider_min, least)
            block.slider_max = max(block.slider_max, most)
