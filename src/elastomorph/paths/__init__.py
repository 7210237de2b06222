"""Paths from a neutral to a target: one file a method, listed in `registry`."""

from __future__ import annotations

import warnings

from elastomorph.paths import registry as registry
from elastomorph.paths.interpolate import interpolate, prepare
from elastomorph.paths.method import Method
from elastomorph.paths.through import Through, through

__all__ = ["Method", "Through", "interpolate", "prepare", "through"]


def __getattr__(name: str) -> tuple[str, ...]:
    if name != "METHODS":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    message = "METHODS is now Method.known; the old name works until elastomorph 0.3."
    warnings.warn(message, DeprecationWarning, stacklevel=2)
    return tuple(each.name for each in Method.known)
