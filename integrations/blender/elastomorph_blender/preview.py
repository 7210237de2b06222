"""The active key of a face along its path, or two that a pair bend joins."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import bpy

from .record import driver_of
from .refusal import RefusedError


def preview(things: Sequence[bpy.types.Object], names: Sequence[str], t: float) -> None:
    """Set keys of all objects that have them, widening their range where it ends before."""
    for thing, name in product(things, names):
        keys = thing.data.shape_keys
        block = keys.key_blocks.get(name)
        if block is None:
            continue
        if driver_of(keys, block.path_from_id("value")) is not None:
            raise RefusedError(
                f"{name} of {thing.name} is moved by a driver: move what drives it, such as a bone"
            )
        block.slider_min, block.slider_max = min(block.slider_min, t), max(block.slider_max, t)
        block.value = t
