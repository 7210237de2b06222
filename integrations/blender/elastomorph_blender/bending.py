"""Bends as shape keys of the objects of a face."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from elastomorph import Corrective
from elastomorph.bending.plan import BentMorph, make_plan
from elastomorph.model.bend_curve import BendCurve

from .actions import remove_animation
from .drivers import drive
from .face import Part, read_face
from .record import (
    PROPERTY,
    Follower,
    bend_names,
    comes_folded,
    driver_of,
    followers,
    imported,
    keep,
    remove_bends,
)
from .refusal import RefusedError

WIDEST = 10.0
"""The range of a shape key ends here in Blender."""

# A bend that moves an object less than this, as a fraction of D, is not stored with it.
_NOTHING = 1e-7

# How far beyond the slider of a key its bends can follow it without being made again.
_AROUND = (-1.0, 2.0)
_SAMPLES = 1001


@dataclass(frozen=True)
class Outcome:
    """Names of the keys that were bent, the number of their bends, D, and the largest error."""

    names: tuple[str, ...]
    bends: int
    extent: float
    error: float


def bend(
    things: Sequence[bpy.types.Object],
    method: str = "auto",
    tolerance: float = 1e-6,
    only: Collection[str] | None = None,
) -> Outcome:
    """Make the bends of these objects anew, for all keys or some.

    Pair bends are made of keys that are bent together; where some are bent anew, also of those that
    pair bends joined with them. An object has those whose both keys it has. Everything is read and
    computed before anything is changed.
    """
    for thing in things:
        if only is not None and comes_folded(thing.data.shape_keys):
            raise RefusedError(
                f"{thing.name} came from a file with folds, which a shape key cannot follow: bend "
                "all of its keys anew, not the active one only"
            )
    face = read_face(things)
    known = [own for thing in things for own in followers(thing.data.shape_keys)]
    straight = {own.name for own in known if own.method == "hold"}
    whole = face.rig.morphs.keys() & (_joined(things, only) if only else face.rig.morphs.keys())
    plan = make_plan(face.rig, method, only=whole - straight, tolerance=tolerance)
    bent = [
        morph for morph in plan.bent if only is None or not {*only}.isdisjoint(_law(morph).drivers)
    ]
    made = 0
    for part, span in zip(face.parts, face.spans, strict=True):
        adopt(part.thing)
        remove_bends(part.thing, only)
        made += _add(part, span, bent, plan.extent)
    error = max((morph.error for morph in bent), default=0.0)
    names = tuple(morph.name for morph in bent if morph.law is None)
    return Outcome(names, made, plan.extent, error)


def _joined(things: Sequence[bpy.types.Object], names: Collection[str]) -> set[str]:
    """These keys, and those that pair bends join with them."""
    followed = [own for t in things for own in bend_names(t.data.shape_keys).values()]
    return {*names}.union(*(own for own in followed if not {*names}.isdisjoint(own)))


def _law(morph: BentMorph) -> Corrective:
    """What its bends follow: that of a pair bend, or its key alone."""
    return morph.law or Corrective((morph.name,))


def adopt(thing: bpy.types.Object) -> None:
    """Drive what came with a glTF file and correctives, in place of the keyframes they have."""
    keys = thing.data.shape_keys
    came, kept = imported(keys), followers(keys)
    for own in (*came, *(own for own in kept if own.curve is None)):
        block = keys.key_blocks[own.name]
        path = block.path_from_id("value")
        if own in came or driver_of(keys, path) is None:
            remove_animation(keys, path)
            least, most = weight_range(keys, own.law, own.curve)
            block.slider_min, block.slider_max = max(least, -WIDEST), min(most, WIDEST)
            drive(keys, block, own.law, own.curve)
    if PROPERTY in thing.data:
        keep(keys, [*kept, *came])
        del thing.data[PROPERTY]


def _add(part: Part, span: slice, bent: Sequence[BentMorph], extent: float) -> int:
    keys, thing = part.keys, part.thing
    shown = thing.active_shape_key_index
    added = []
    for morph in bent:
        law = _law(morph)
        if not part.offsets.keys() >= {*law.drivers}:
            continue
        curves = zip(morph.morph.bends, morph.morph.bend_curves, strict=True)
        for number, (field, curve) in enumerate(curves, start=1):
            offsets = field[span]
            if np.linalg.norm(offsets, axis=1).max() > _NOTHING * extent:
                name = f"{morph.name}.bend{number}"
                block, followed = add_key(part, law, name, part.own(offsets), curve)
                added.append(Follower(block.name, morph.name, law, followed, morph.morph.method))
    keep(keys, [*followers(keys), *added])
    thing.active_shape_key_index = shown
    thing.data.update()
    return len(added)


def add_key(
    part: Part,
    law: Corrective,
    name: str,
    offsets: NDArray[np.float64],
    curve: BendCurve | None = None,
) -> tuple[bpy.types.ShapeKey, BendCurve | None]:
    """A key that follows others, and the curve of a bend, scaled where weights would end at 10."""
    keys = part.keys
    block = part.thing.shape_key_add(name=name, from_mix=False)
    block.relative_key = keys.reference_key
    least, most = weight_range(keys, law, curve)
    scale = 1.0 if curve is None else max(1.0, -least / WIDEST, most / WIDEST)
    block.data.foreach_set("co", (part.basis + scale * offsets).astype(np.float32).ravel())
    block.slider_min = max(least / scale, -WIDEST)
    block.slider_max = min(most / scale, WIDEST)
    if curve is not None and scale > 1:
        curve = BendCurve(curve.breaks, curve.coefficients / scale)
    drive(keys, block, law, curve)
    return block, curve


def weight_range(
    keys: bpy.types.Key, law: Corrective, curve: BendCurve | None = None
) -> tuple[float, float]:
    """What a key follows while sliders are within their ranges, and somewhat beyond 0 and 1."""
    hosts = [keys.key_blocks[name] for name in law.drivers]
    least, most = _AROUND
    ends = law.reach([(min(h.slider_min, least), max(h.slider_max, most)) for h in hosts])
    if curve is None:
        return ends
    values = np.append(curve(np.linspace(0, 1, _SAMPLES)), curve(np.array(ends)))
    margin = 0.01 * np.ptp(values)
    return float(values.min() - margin), float(values.max() + margin)
