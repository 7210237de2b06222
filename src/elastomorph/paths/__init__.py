"""Paths from a neutral to a target: one file a method.

A new method is a file beside this one, its import here, and its name in `Method.known`.
"""

from __future__ import annotations

import warnings

from elastomorph.paths.arc import Arc
from elastomorph.paths.auto import Auto
from elastomorph.paths.beam import Beam
from elastomorph.paths.cosine import Cosine
from elastomorph.paths.ease import Ease
from elastomorph.paths.interpolate import interpolate, prepare
from elastomorph.paths.linear import Linear
from elastomorph.paths.method import Method
from elastomorph.paths.plate import Plate
from elastomorph.paths.rotation import Rotation
from elastomorph.paths.through import Through, through

__all__ = [
    "Arc",
    "Auto",
    "Beam",
    "Cosine",
    "Ease",
    "Linear",
    "Method",
    "Plate",
    "Rotation",
    "Through",
    "interpolate",
    "prepare",
    "through",
]

# The registry: what texts may name, in the order of lists.
Method.known = (Linear, Cosine, Ease, Beam, Plate, Arc, Rotation, Auto)


def __getattr__(name: str) -> tuple[str, ...]:
    if name != "METHODS":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    message = "METHODS is now Method.known; the old name works until elastomorph 0.3."
    warnings.warn(message, DeprecationWarning, stacklevel=2)
    return tuple(each.name for each in Method.known)
