"""The animation curves of shape keys: in each action those of the slot that they use."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np
from numpy.typing import NDArray


def remove_animation(keys: bpy.types.Key, data_path: str) -> None:
    """Remove the driver of a property, and its curves in all actions of these keys."""
    if keys.animation_data is None:
        return
    if keys.animation_data.drivers.find(data_path) is not None:
        keys.driver_remove(data_path)
    for curves in all_curves(keys):
        found = curves.find(data_path)
        if found is not None:
            curves.remove(found)


def all_curves(keys: bpy.types.Key) -> Iterator[bpy.types.bpy_prop_collection]:
    """The curves of these keys in each of their actions: the active one and those of NLA strips."""
    animation = keys.animation_data
    if animation is None:
        return
    used = [(animation.action, animation.action_slot)]
    for track in animation.nla_tracks:
        used += [(strip.action, strip.action_slot) for strip in track.strips]
    slots = {(a.name, slot.handle): (a, slot) for a, slot in used if a and slot}
    for action, slot in slots.values():
        for layer in action.layers:
            for strip in layer.strips:
                bag = strip.channelbag(slot)
                if bag is not None:
                    yield bag.fcurves


def active_curves(keys: bpy.types.Key) -> bpy.types.bpy_prop_collection:
    """The curves of the active action of these keys, which is made where there is none."""
    animation = keys.animation_data or keys.animation_data_create()
    if animation.action is None:
        animation.action = bpy.data.actions.new(f"{keys.user.name} Shape Keys")
    action = animation.action
    slot = animation.action_slot
    if slot is None:
        slot = action.slots.new(id_type="KEY", name=keys.name)
        animation.action_slot = slot
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(slot, ensure=True).fcurves


def set_keyframes(
    curves: bpy.types.bpy_prop_collection,
    data_path: str,
    frames: NDArray[np.float64],
    values: NDArray[np.float64],
    group: str = "",
) -> None:
    """Keyframes of a property, straight from one to the next, in place of those it had."""
    found = curves.find(data_path)
    if found is not None:
        curves.remove(found)
    curve = curves.new(data_path)
    curve.keyframe_points.add(len(frames))
    places = np.stack([frames, values], axis=1).astype(np.float32)
    curve.keyframe_points.foreach_set("co", places.ravel())
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"
    curve.update()
