"""Scenes of rigs and paths that are in memory: one alone, or several compared."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import ParameterError
from elastomorph.io.gltf import write_glb
from elastomorph.model.mesh import require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from elastomorph.viewer.scene import Role, Scene, SceneModel

__all__ = ["SLIDER", "comparison_scene", "comparison_start", "rig_model", "rig_scene"]

# The slider of a path that is no part of a rig.
SLIDER = "motion"
_MOST_SIDE_BY_SIDE = 3


def rig_scene(
    rig: Rig | Morph,
    *,
    name: str = "rig",
    title: str | None = None,
    unit: str = "",
    curves: CurveNetwork | None = None,
) -> Scene:
    """A scene of one rig, or of one path half way.

    Args:
        rig: The rig, or a single path; that has a slider called ``motion``.
        name: What the page calls it.
        title: What the page is called; the name by default.
        unit: Unit of the coordinates, for legends.
        curves: Curves to draw on it; found on the neutral by default.

    Raises:
        ParameterError: The mesh has no polygons.
        FormatError: Coordinates too large for single precision.
    """
    return Scene(
        (rig_model(rig, name, "rig"),),
        name if title is None else title,
        unit,
        rig.neutral.diameter,
        extract_curves(rig.neutral) if curves is None else curves,
        _half_way() if isinstance(rig, Morph) else {},
    )


def comparison_scene(
    models: Mapping[str, Rig | Morph],
    *,
    title: str | None = None,
    unit: str = "",
    curves: CurveNetwork | None = None,
) -> Scene:
    """A scene of several rigs or paths of one neutral, side by side.

    Args:
        models: What to compare, by name: all rigs, or all single paths. Sliders of the same name
            move together; single paths share one called ``motion``.
        title: What the page is called; the names by default.
        unit: Unit of the coordinates, for legends.
        curves: Curves to draw on them; found on the neutral by default.

    Raises:
        TopologyError: They differ in vertices or polygons.
        ParameterError: No models, rigs mixed with single paths, or a mesh without polygons.
        FormatError: Coordinates too large for single precision.
    """
    if not models:
        raise ParameterError("name at least one rig or morph to compare")
    every = list(models.values())
    paths = [isinstance(model, Morph) for model in every]
    if any(paths) and not all(paths):
        raise ParameterError("compare rigs with rigs, or single morphs with single morphs")
    neutral = every[0].neutral
    for model in every[1:]:
        require_same_topology(neutral, model.neutral)
    role: Role = "rig" if len(every) == 1 else "method"
    return Scene(
        tuple(rig_model(model, name, role) for name, model in models.items()),
        " and ".join(models) if title is None else title,
        unit,
        neutral.diameter,
        extract_curves(neutral) if curves is None else curves,
        {**comparison_start(len(every)), **(_half_way() if all(paths) else {})},
    )


def comparison_start(count: int) -> dict[str, Any]:
    """What the comparison of so many models begins with."""
    if count < 2:
        return {}
    return {"arrangement": "side", "shown": list(range(min(count, _MOST_SIDE_BY_SIDE)))}


def rig_model(rig: Rig | Morph, name: str, role: Role) -> SceneModel:
    """A model from a rig, or from a single path with a slider of its own.

    Raises:
        ParameterError: The mesh has no polygons.
        FormatError: Coordinates too large for single precision.
    """
    whole = Rig(rig.neutral, {SLIDER: rig}) if isinstance(rig, Morph) else rig
    if not len(whole.neutral.faces):
        raise ParameterError(
            f"{name!r} has no polygons, only {len(whole.neutral.vertices):,} points: the viewer "
            "shows surfaces. Draw the curves of a marker take with 'elastomorph evaluate' instead"
        )
    file = io.BytesIO()
    # The page finds normals from positions; those of targets would make it half as large again.
    write_glb(file, whole, normals="none")
    return SceneModel(name, role, file.getvalue())


def _half_way() -> dict[str, Any]:
    # Where paths differ most from the straight line, on the whole.
    return {"weights": {SLIDER: 1.0}, "t": 0.5}
