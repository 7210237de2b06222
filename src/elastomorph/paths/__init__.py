"""Paths from a neutral to a target: one class a method.

A new method is a class beside this file, its import here, and its name in `Method.known`.
"""

from __future__ import annotations

from elastomorph.paths.arc import Arc
from elastomorph.paths.auto import Auto
from elastomorph.paths.beam import Beam, Plate
from elastomorph.paths.interpolate import interpolate, prepare
from elastomorph.paths.method import Method
from elastomorph.paths.rotation import Rotation
from elastomorph.paths.straight import Cosine, Ease, Linear
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
