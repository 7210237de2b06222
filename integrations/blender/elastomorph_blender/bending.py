"""Bends as shape keys of the objects of a face."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from elastomorph.bending.plan import BentMorph, make_plan
from elastomorph.model.bend_curve import BendCurve

from .actions import remove_animation
from .drivers import drive
from .face import Part, read_face
from .record import (
    PROPERTY,
    KeptBend,
    comes_folded,
    imported_bends,
    keep_bends,
    kept_bends,
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

    Everything is read and computed before anything is changed.
    """
    for thing in things:
        if only is not None and comes_folded(thing.data.shape_keys):
            raise RefusedError(
                f"{thing.name} came from a file with folds, which a shape key cannot follow: bend "
                "all of its keys anew, not the active one only"
            )
    face = read_face(things)
    plan = make_plan(face.rig, method, only=only, tolerance=tolerance)
    made = 0
    for part, span in zip(face.parts, face.spans, strict=True):
        remove_bends(part.thing, only)
        adopt(part.thing)
        made += _add(part, span, plan.bent, plan.extent)
    error = max((morph.error for morph in plan.bent), default=0.0)
    return Outcome(tuple(morph.name for morph in plan.bent), made, plan.extent, error)


def adopt(thing: bpy.types.Object) -> None:
    """Drive the bends that came with a glTF file, in place of the keyframes they have."""
    keys = thing.data.shape_keys
    imported = imported_bends(keys)
    for bend in imported:
        block, host = keys.key_blocks[bend.name], keys.key_blocks[bend.target]
        remove_animation(keys, block.path_from_id("value"))
        least, most = value_range(bend.curve, host.slider_min, host.slider_max)
        block.slider_min, block.slider_max = max(least, -WIDEST), min(most, WIDEST)
        drive(keys, block, host, bend.curve)
    if imported:
        keep_bends(keys, [*kept_bends(keys), *imported])
        del thing.data[PROPERTY]


def _add(part: Part, span: slice, bent: Sequence[BentMorph], extent: float) -> int:
    keys, thing = part.keys, part.thing
    shown = thing.active_shape_key_index
    added = []
    for morph in bent:
        if morph.name not in part.offsets:
            continue
        curves = zip(morph.morph.bends, morph.morph.bend_curves, strict=True)
        for number, (field, curve) in enumerate(curves, start=1):
            offsets = field[span]
            if np.linalg.norm(offsets, axis=1).max() > _NOTHING * extent:
                name = f"{morph.name}.bend{number}"
                block, followed = _add_key(part, morph.name, name, part.own(offsets), curve)
                added.append(KeptBend(block.name, morph.name, followed, morph.morph.method))
    keep_bends(keys, [*kept_bends(keys), *added])
    thing.active_shape_key_index = shown
    thing.data.update()
    return len(added)


def _add_key(
    part: Part, target: str, name: str, offsets: NDArray[np.float64], curve: BendCurve
) -> tuple[bpy.types.ShapeKey, BendCurve]:
    """The key of a bend and the curve it follows, which is scaled where weights would end at 10."""
    keys = part.keys
    block = part.thing.shape_key_add(name=name, from_mix=False)
    block.relative_key = keys.reference_key
    host = keys.key_blocks[target]
    least, most = value_range(curve, host.slider_min, host.slider_max)
    scale = max(1.0, -least / WIDEST, most / WIDEST)
    block.data.foreach_set("co", (part.basis + scale * offsets).astype(np.float32).ravel())
    block.slider_min, block.slider_max = least / scale, most / scale
    if scale > 1:
        curve = BendCurve(curve.breaks, curve.coefficients / scale)
    drive(keys, block, host, curve)
    return block, curve


def value_range(curve: BendCurve, least: float, most: float) -> tuple[float, float]:
    """The weights of a bend while its key is within a range, and somewhat beyond 0 and 1."""
    ends = min(least, _AROUND[0]), max(most, _AROUND[1])
    values = np.append(curve(np.linspace(0, 1, _SAMPLES)), curve(np.array(ends)))
    margin = 0.01 * np.ptp(values)
    return float(values.min() - margin), float(values.max() + margin)
