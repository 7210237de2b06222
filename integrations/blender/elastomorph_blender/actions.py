"""The animation curves of shape keys, as this version of Blender keeps them."""

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
    used = [(animation.action, getattr(animation, "action_slot", None))]
    for track in animation.nla_tracks:
        used += [(strip.action, getattr(strip, "action_slot", None)) for strip in track.strips]
    seen = set()
    for action, slot in used:
        if action is None or (action, getattr(slot, "handle", None)) in seen:
            continue
        seen.add((action, getattr(slot, "handle", None)))
        found = _curves_in(action, slot)
        if found is not None:
            yield found


def active_curves(keys: bpy.types.Key) -> bpy.types.bpy_prop_collection:
    """The curves of the active action of these keys, which is made where there is none."""
    animation = keys.animation_data or keys.animation_data_create()
    if animation.action is None:
        animation.action = bpy.data.actions.new(f"{keys.user.name} Shape Keys")
    action = animation.action
    if not hasattr(action, "slots"):
        return action.fcurves
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


def _curves_in(
    action: bpy.types.Action, slot: object | None
) -> bpy.types.bpy_prop_collection | None:
    """The curves for one slot; before Blender 4.4 actions had no slots."""
    if not hasattr(action, "slots"):
        return action.fcurves
    if slot is None:
        return None
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot)
            if bag is not None:
                return bag.fcurves
    return None
