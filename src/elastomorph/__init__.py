"""Nonlinear blendshapes that run anywhere linear ones do.

A face rig moves every vertex on a straight line from the neutral face to a target. Here each target
gets a *path*, stored as a few ordinary morph targets with scalar weight curves.

A public name is imported when it is first used, so that nothing heavy is loaded for a program that
asks for little.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from elastomorph._renamed import accept_old_names
from elastomorph.errors import *  # noqa: F403
from elastomorph.errors import __all__ as _errors

if TYPE_CHECKING:
    from elastomorph.curves import Curve as Curve
    from elastomorph.curves import CurveNetwork as CurveNetwork
    from elastomorph.curves import edge_loops as edge_loops
    from elastomorph.curves import extract_curves as extract_curves
    from elastomorph.evaluation import Evaluation as Evaluation
    from elastomorph.evaluation import Suggestion as Suggestion
    from elastomorph.evaluation import evaluate as evaluate
    from elastomorph.evaluation import suggest_inbetweens as suggest_inbetweens
    from elastomorph.fitting import Fit as Fit
    from elastomorph.fitting.fit import fit as fit
    from elastomorph.io import read as read
    from elastomorph.io import read_rig as read_rig
    from elastomorph.io import read_sequence as read_sequence
    from elastomorph.io import write as write
    from elastomorph.io import write_sequence as write_sequence
    from elastomorph.model.bend_curve import BendCurve as BendCurve
    from elastomorph.model.mesh import Mesh as Mesh
    from elastomorph.model.morph import Morph as Morph
    from elastomorph.model.sequence import MeshSequence as MeshSequence
    from elastomorph.paths import Method as Method
    from elastomorph.paths.bake import bake as bake
    from elastomorph.paths.interpolate import interpolate as interpolate
    from elastomorph.paths.interpolate import prepare as prepare
    from elastomorph.paths.through import through as through
    from elastomorph.physics import Load as Load
    from elastomorph.physics import Material as Material
    from elastomorph.rig import Rig as Rig
    from elastomorph.rig import timing as timing

_HOMES: dict[str, tuple[str, ...]] = {
    "elastomorph.paths.bake": ("bake",),
    "elastomorph.paths.interpolate": ("interpolate", "prepare"),
    "elastomorph.paths.through": ("through",),
    "elastomorph.model.bend_curve": ("BendCurve",),
    "elastomorph.curves": ("Curve", "CurveNetwork", "edge_loops", "extract_curves"),
    "elastomorph.evaluation": ("Evaluation", "Suggestion", "evaluate", "suggest_inbetweens"),
    "elastomorph.fitting": ("Fit",),
    "elastomorph.fitting.fit": ("fit",),
    "elastomorph.io": ("read", "read_rig", "read_sequence", "write", "write_sequence"),
    "elastomorph.model.mesh": ("Mesh",),
    "elastomorph.model.morph": ("Morph",),
    "elastomorph.paths": ("Method",),
    "elastomorph.physics": ("Load", "Material"),
    "elastomorph.rig": ("Rig",),
    "elastomorph.model.sequence": ("MeshSequence",),
}
"""The module of each public name that is no error."""

_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = sorted({*_HOME, *_errors})

accept_old_names()


def __getattr__(name: str) -> Any:
    if name == "timing":
        return import_module("elastomorph.rig.timing")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    special = (name for name in globals() if name.startswith("__"))
    return sorted({*special, *__all__, "timing"})
