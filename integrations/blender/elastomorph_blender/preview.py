"""The active key of a face along its path."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from .record import driver_of
from .refusal import RefusedError


def preview(things: Sequence[bpy.types.Object], name: str, t: float) -> None:
    """Set a key of all objects that have it, widening its range where it ends before."""
    for thing in things:
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
