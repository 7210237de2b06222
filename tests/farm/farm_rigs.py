"""Rigs whose sliders have names that recipes speak of; what they move does not matter."""

from __future__ import annotations

import numpy as np

import elastomorph as em
from elastomorph.rig.naming import ARKIT

__all__ = ["NAMES", "RIG", "column"]

NAMES = (*ARKIT, "scar", "age", "wrinkles", "ears", "neck")
_MESH = em.Mesh(np.eye(3), [[0, 1, 2]])
_MOVED = em.interpolate(_MESH, _MESH.with_vertices(_MESH.vertices + 1), "linear")
RIG = em.Rig(_MESH, dict.fromkeys(NAMES, _MOVED), groups={"late": NAMES[52:]})


def column(name: str) -> int:
    """The column of a slider."""
    return NAMES.index(name)
