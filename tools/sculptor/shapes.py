"""Blendshapes and expressions of the built-in head."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

import numpy as np

from elastomorph.model.mesh import Mesh
from elastomorph.samples.paper_expressions import EXPRESSIONS
from sculptor import turns
from sculptor.assembly import build
from sculptor.implicit import Points
from sculptor.muscles import movements

__all__ = ["expressions", "pose", "shape_names", "shapes"]

# How far the upper and the lower lid close with each shape, and degrees towards the temple.
_LIDS: Mapping[str, turns.Lids] = MappingProxyType(
    {
        "eyeBlink": (0.86, 0.14, 0.0),
        "eyeSquint": (0.14, 0.34, 0.0),
        "eyeWide": (-0.24, -0.06, 0.0),
        "eyeLookDown": (0.60, -0.30, 0.0),
        "eyeLookIn": (0.0, 0.0, -6.0),
        "eyeLookOut": (0.0, 0.0, 6.0),
        "eyeLookUp": (-0.42, 0.19, 0.0),
        "cheekSquint": (0.05, 0.32, 0.0),
        "browDown": (0.08, 0.0, 0.0),
        "mouthSmile": (0.02, 0.10, 0.0),
    }
)
# Degrees that the eye looks up and towards the temple.
_GAZES = MappingProxyType(
    {
        "eyeLookDown": (-27.0, 0.0),
        "eyeLookIn": (0.0, -32.0),
        "eyeLookOut": (0.0, 32.0),
        "eyeLookUp": (24.0, 0.0),
    }
)


def pose(weights: Mapping[str, float]) -> Points:
    """Positions of all vertices when several shapes act at once.

    Displacements of the skin add up; the turns of lids and eyes add up as angles. A weight of
    zero adds nothing, not even rounding.

    Args:
        weights: How far each shape goes; a name without its side stands for both sides.
    """
    moves = movements()
    points = build().mesh.vertices.copy()
    closing = {"L": np.zeros(3), "R": np.zeros(3)}
    gaze = {"L": np.zeros(2), "R": np.zeros(2)}
    for name, weight in weights.items():
        if weight == 0.0:
            continue
        for full in _sided(name):
            if full in moves:
                points += moves[full](weight)
            base, _, side = full.rpartition("_")
            if base in _LIDS:
                closing[side] += weight * np.array(_LIDS[base])
            if base in _GAZES:
                gaze[side] += weight * np.array(_GAZES[base])
    looks = {s: (float(g[0]), float(g[1])) for s, g in gaze.items()}
    points = turns.turn_eyes(points, looks)
    swept = {s: (float(c[0]), float(c[1]), float(c[2])) for s, c in closing.items()}
    return turns.keep_off_eyes(turns.turn_lids(points, swept))


def _sided(name: str) -> list[str]:
    """The full names that a name stands for."""
    if name in movements() or name.endswith(("_L", "_R")):
        return [name]
    return [f"{name}_L", f"{name}_R"]


@cache
def _shapes() -> dict[str, Mesh]:
    neutral = build().mesh
    return {name: neutral.with_vertices(pose({name: 1.0})) for name in shape_names()}


@cache
def _expressions() -> dict[str, Mesh]:
    neutral = build().mesh
    return {name: neutral.with_vertices(pose(parts)) for name, parts in EXPRESSIONS.items()}


def shape_names() -> list[str]:
    """The names of `shapes`, which need not be built to be told."""
    return sorted({*movements(), *(f"{lid}_{side}" for lid in _LIDS for side in "LR")})


def shapes() -> dict[str, Mesh]:
    """The head's single blendshapes, each at full strength, by their ARKit names.

    "_L" is the character's left, +x.
    """
    return dict(_shapes())


def expressions() -> dict[str, Mesh]:
    """The five expressions of the paper on the built-in head.

    Returns:
        "sad", "angry", "confused", "grinning" and "puff", with the topology of ``head()``.
    """
    return dict(_expressions())
