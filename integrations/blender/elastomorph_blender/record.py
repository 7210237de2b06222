"""Which shape keys of an object follow others: its bends and its correctives.

The record is one text, in JSON, in a custom property of the data-block of the keys, so that it is
saved, copied, appended and undone with them::

    {"version": 1, "bends": [{"name": "jawOpen.bend1", "target": "jawOpen", "method": "rotation",
                              "drivers": ["jawOpen"],
                              "curve": {"breaks": [0, 1], "coefficients": [[0, 1, -1]]}},
                             {"name": "jawOpen_mouthClose.bend1", "target": "jawOpen_mouthClose",
                              "method": "pair", "drivers": ["jawOpen", "mouthClose"],
                              "law": "min", "curve": …},
                             {"name": "smileShut_L", "target": "smileShut_L", "method": "",
                              "drivers": ["mouthSmile_L", "eyeBlink_L"], "curve": null}]}

The weight of a bend is its curve at what a law gives of its drivers, keys that have the law of
`elastomorph.Corrective`: of its target alone, which is what it follows without drivers, or of the
two that a pair bend joins, whose target is no key. What has no curve is no bend but a corrective,
a shape whose weight is what its law gives.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from elastomorph import BendCurve, Corrective
from elastomorph.io.blend_shapes import curve_from_json, curve_to_json
from elastomorph.io.gltf.rig_extras import LAWS

from .actions import remove_animation
from .refusal import RefusedError

PROPERTY = "elastomorph"
VARIABLE = "bent"
"""Name of the first variable of each driver, by which bends that were renamed are found."""


@dataclass(frozen=True, eq=False)
class Follower:
    """One shape key that follows others.

    Attributes:
        name: Of the key.
        target: Of the key whose path it bends, of the pair bend that it is one of, or its own.
        law: What it follows of the weights of other keys.
        curve: From what the law gives to the weight of a bend; a corrective has none.
        method: Of the path of a bend.
    """

    name: str
    target: str
    law: Corrective
    curve: BendCurve | None = None
    method: str = ""

    @property
    def of_pair(self) -> bool:
        """Whether it is a bend that belongs to no key."""
        return self.curve is not None and self.law.drivers != (self.target,)

    def weight(self, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """(...,) its weight from (..., n) those of its drivers."""
        followed = self.law.weight(weights)
        return followed if self.curve is None else self.curve(followed)


def followers(keys: bpy.types.Key) -> list[Follower]:
    """Those in the record that are still there, with what they follow; correctives first."""
    with _record(keys) as entries:
        found = _there(keys, [_follower(entry) for entry in entries])
    return sorted(found, key=lambda own: own.curve is not None)


def bend_names(keys: bpy.types.Key) -> dict[str, tuple[str, ...]]:
    """Name of each shape key that is a bend, and of the keys it follows, renamed or not."""
    with _record(keys) as entries:
        bends = [entry for entry in entries if entry["curve"] is not None]
        stored = {own["name"]: tuple(own.get("drivers", [own["target"]])) for own in bends}
    names = {name: followed for name, followed in stored.items() if name in keys.key_blocks}
    names |= {own.name: own.law.drivers for own in imported(keys) if own.curve is not None}
    animation = keys.animation_data
    paths = {block.path_from_id("value"): block.name for block in keys.key_blocks}
    for followed in animation.drivers if animation else ():
        variables = followed.driver.variables
        if followed.data_path in paths and variables and variables[0].name == VARIABLE:
            goals = [variable.targets[0] for variable in variables]
            if all(goal.id == keys for goal in goals):
                hosts = tuple(paths.get(goal.data_path, "") for goal in goals)
                names[paths[followed.data_path]] = hosts
    return names


def correctives(keys: bpy.types.Key) -> dict[str, Corrective]:
    """The law of each key that is a corrective, of the record and of the file it came with."""
    return {own.name: own.law for own in (*imported(keys), *followers(keys)) if own.curve is None}


def imported(keys: bpy.types.Key) -> list[Follower]:
    """Those that came with a glTF file, whose extras Blender keeps as a property of the mesh.

    Nothing drives them yet, and none of them is in the record.
    """
    mesh = keys.user
    if PROPERTY not in mesh:
        return []
    try:
        found = [*_described(mesh[PROPERTY].to_dict())]
    except (AttributeError, ValueError, KeyError, TypeError) as error:
        raise RefusedError(
            f"the custom property {PROPERTY!r} of the mesh {mesh.name}, which says what its bends "
            f"are, cannot be read ({error!r}): delete it, and the keys that are bends"
        ) from None
    return _there(keys, found)


def _described(extras: dict[str, Any]) -> Iterator[Follower]:
    targets = {morph["name"]: morph.get("target", morph["name"]) for morph in extras["morphs"]}
    laws = {}
    for entry in extras.get("correctives", ()):
        law = entry if extras["version"] >= LAWS else {}
        drivers = [targets[driver] for driver in entry["drivers"]]
        laws[targets[entry["name"]]] = own = Corrective.of({**law, "drivers": drivers})
        yield Follower(targets[entry["name"]], targets[entry["name"]], own)
    for morph in extras["morphs"]:
        target = targets[morph["name"]]
        shared = {"target": target, "method": morph["method"]}
        if "target" not in morph:
            shared |= laws[target].entry()
        for bend in morph.get("bends", ()):
            yield _follower({**bend, "name": bend["target"], **shared})


def comes_folded(keys: bpy.types.Key) -> bool:
    """Whether the file that bends came with has curves for the weights of its targets."""
    imported(keys)  # refuses what cannot be read
    mesh = keys.user
    return PROPERTY in mesh and any("fold" in morph for morph in mesh[PROPERTY]["morphs"])


@contextmanager
def _record(keys: bpy.types.Key) -> Iterator[list[dict[str, Any]]]:
    try:
        yield list(json.loads(keys.get(PROPERTY, '{"bends": []}'))["bends"])
    except (ValueError, KeyError, TypeError) as error:
        raise RefusedError(
            f"the record of bends of {keys.user.name} cannot be read ({error!r}): delete its bend "
            f"keys and the custom property {PROPERTY!r} of its shape keys, and bend it again"
        ) from None


def _there(keys: bpy.types.Key, found: Sequence[Follower]) -> list[Follower]:
    """Those that are keys and follow keys; a slider that drives itself too, Blender has not."""
    known = {*keys.key_blocks.keys()}
    return [
        own
        for own in found
        if {own.name, *own.law.drivers} <= known and own.name not in own.law.drivers
    ]


def _follower(entry: dict[str, Any]) -> Follower:
    law = Corrective.of({"drivers": [entry["target"]], **entry})
    curve = entry["curve"] and curve_from_json(entry["curve"])
    return Follower(entry["name"], entry["target"], law, curve, entry["method"])


def keep(keys: bpy.types.Key, found: Sequence[Follower]) -> None:
    """Write the record anew."""
    entries = [
        {
            "name": own.name,
            "target": own.target,
            "method": own.method,
            **own.law.entry(),
            "curve": own.curve and curve_to_json(own.curve),
        }
        for own in found
    ]
    if entries:
        keys[PROPERTY] = json.dumps({"version": 1, "bends": entries})
    elif PROPERTY in keys:
        del keys[PROPERTY]


def remove_bends(thing: bpy.types.Object, only: Collection[str] | None = None) -> int:
    """Remove the bends of all keys, or of some: shape keys, drivers and keyframes.

    Pair bends go with either key. What came with a file must have been adopted.
    """
    keys = thing.data.shape_keys
    names = bend_names(keys).items()
    gone = [name for name, own in names if only is None or not {*only}.isdisjoint(own)]
    kept = [own for own in followers(keys) if own.name not in gone]
    active = thing.active_shape_key.name if thing.active_shape_key else ""
    for name in gone:
        block = keys.key_blocks[name]
        for what in ("value", "mute"):
            remove_animation(keys, block.path_from_id(what))
        thing.shape_key_remove(block)
    keep(keys, kept)
    thing.active_shape_key_index = max(keys.key_blocks.find(active), 0)
    return len(gone)


def driver_of(keys: bpy.types.Key, data_path: str) -> bpy.types.FCurve | None:
    """The driver of a property of shape keys, if it has one."""
    animation = keys.animation_data
    return animation.drivers.find(data_path) if animation else None
