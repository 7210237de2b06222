"""Which shape keys of an object are bends, kept with its shape keys.

The record is one text, in JSON, in a custom property of the data-block of the keys, so that it is
saved, copied, appended and undone with them::

    {"version": 1, "bends": [{"name": "jawOpen.bend1", "target": "jawOpen", "method": "rotation",
                              "curve": {"breaks": [0, 1], "coefficients": [[0, 1, -1]]}}]}

The weight of a bend is its curve at the weight of its target.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from elastomorph import BendCurve

from .actions import remove_animation
from .refusal import RefusedError

PROPERTY = "elastomorph"
VARIABLE = "bent"
"""Name of the variable of each driver, by which bends that were renamed are found."""


@dataclass(frozen=True, eq=False)
class KeptBend:
    """One shape key that is a bend."""

    name: str
    target: str
    curve: BendCurve
    method: str = ""


def kept_bends(keys: bpy.types.Key) -> list[KeptBend]:
    """The bends of an object that are still there, in order."""
    try:
        bends = [_bend(entry) for entry in _entries(keys)]
    except (ValueError, KeyError, TypeError) as error:
        raise _unreadable(keys, error) from None
    return [bend for bend in bends if bend.name in keys.key_blocks]


def bend_names(keys: bpy.types.Key) -> dict[str, str]:
    """Name of each shape key that is a bend, and of the key it belongs to, renamed or not."""
    try:
        stored = {entry["name"]: entry["target"] for entry in _entries(keys)}
    except (ValueError, KeyError, TypeError) as error:
        raise _unreadable(keys, error) from None
    names = {name: target for name, target in stored.items() if name in keys.key_blocks}
    names |= {bend.name: bend.target for bend in imported_bends(keys)}
    animation = keys.animation_data
    paths = {block.path_from_id("value"): block.name for block in keys.key_blocks}
    for followed in animation.drivers if animation else ():
        variables = followed.driver.variables
        if followed.data_path in paths and [v.name for v in variables] == [VARIABLE]:
            goal = variables[0].targets[0]
            if goal.id == keys:
                names[paths[followed.data_path]] = paths.get(goal.data_path, "")
    return names


def imported_bends(keys: bpy.types.Key) -> list[KeptBend]:
    """Bends that came with a glTF file, whose extras Blender keeps as a property of the mesh.

    Nothing drives them yet, and none of them is in the record.
    """
    mesh = keys.user
    if PROPERTY not in mesh:
        return []
    try:
        bends = [
            _bend({**bend, "name": bend["target"], **_of_morph(morph)})
            for morph in mesh[PROPERTY].to_dict()["morphs"]
            for bend in morph.get("bends", ())
        ]
    except (AttributeError, ValueError, KeyError, TypeError) as error:
        raise RefusedError(
            f"the custom property {PROPERTY!r} of the mesh {mesh.name}, which says what its bends "
            f"are, cannot be read ({error!r}): delete it, and the keys that are bends"
        ) from None
    known = keys.key_blocks
    return [bend for bend in bends if bend.name in known and bend.target in known]


def comes_folded(keys: bpy.types.Key) -> bool:
    """Whether the file that bends came with has curves for the weights of its targets."""
    imported_bends(keys)  # refuses what cannot be read
    mesh = keys.user
    return PROPERTY in mesh and any("fold" in morph for morph in mesh[PROPERTY]["morphs"])


def _of_morph(morph: dict[str, Any]) -> dict[str, Any]:
    return {"target": morph["target"], "method": morph["method"]}


def _entries(keys: bpy.types.Key) -> list[dict[str, Any]]:
    return list(json.loads(keys.get(PROPERTY, '{"bends": []}'))["bends"])


def _bend(entry: dict[str, Any]) -> KeptBend:
    curve = entry["curve"]
    own = BendCurve(*(np.array(curve[part], float) for part in ("breaks", "coefficients")))
    return KeptBend(entry["name"], entry["target"], own, entry["method"])


def _unreadable(keys: bpy.types.Key, error: Exception) -> RefusedError:
    return RefusedError(
        f"the record of bends of {keys.user.name} cannot be read ({error!r}): delete its bend keys "
        f"and the custom property {PROPERTY!r} of its shape keys, and bend it again"
    )


def keep_bends(keys: bpy.types.Key, bends: Sequence[KeptBend]) -> None:
    """Write the record anew."""
    if not bends:
        if PROPERTY in keys:
            del keys[PROPERTY]
        return
    entries = [
        {
            "name": bend.name,
            "target": bend.target,
            "method": bend.method,
            "curve": {
                "breaks": bend.curve.breaks.tolist(),
                "coefficients": bend.curve.coefficients.tolist(),
            },
        }
        for bend in bends
    ]
    keys[PROPERTY] = json.dumps({"version": 1, "bends": entries})


def remove_bends(thing: bpy.types.Object, only: Collection[str] | None = None) -> int:
    """Remove the bends of all keys, or of some: shape keys, drivers and keyframes."""
    keys = thing.data.shape_keys
    gone = [name for name, host in bend_names(keys).items() if only is None or host in only]
    kept = [bend for bend in kept_bends(keys) if bend.name not in gone]
    active = thing.active_shape_key.name if thing.active_shape_key else ""
    for name in gone:
        block = keys.key_blocks[name]
        for what in ("value", "mute"):
            remove_animation(keys, block.path_from_id(what))
        thing.shape_key_remove(block)
    keep_bends(keys, kept)
    if PROPERTY in thing.data and not imported_bends(keys):
        del thing.data[PROPERTY]
    thing.active_shape_key_index = max(keys.key_blocks.find(active), 0)
    return len(gone)


def driver_of(keys: bpy.types.Key, data_path: str) -> bpy.types.FCurve | None:
    """The driver of a property of shape keys, if it has one."""
    animation = keys.animation_data
    return animation.drivers.find(data_path) if animation else None
