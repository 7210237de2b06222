"""Nonlinear blendshapes that run anywhere linear ones do.

A face rig moves every vertex on a straight line from the neutral face to a target. Here each target
gets a *path*, stored as a few ordinary morph targets with scalar weight curves.

A public name is imported when it is first used, so that nothing heavy is loaded for a program that
asks for little.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from elastomorph._lazy import lazy_names
from elastomorph.errors import *  # noqa: F403
from elastomorph.errors import __all__ as _errors

if TYPE_CHECKING:
    from elastomorph.bending import BendReport as BendReport
    from elastomorph.bending import bend as bend
    from elastomorph.bending import unbend as unbend
    from elastomorph.capturing.scans.registration import register as register
    from elastomorph.capturing.scans.registration import register_all as register_all
    from elastomorph.capturing.work.capture import capture as capture
    from elastomorph.capturing.work.captured import Captured as Captured
    from elastomorph.capturing.work.registered import Registered as Registered
    from elastomorph.curves import Curve as Curve
    from elastomorph.curves import CurveNetwork as CurveNetwork
    from elastomorph.curves import edge_loops as edge_loops
    from elastomorph.curves.extraction import extract_curves as extract_curves
    from elastomorph.evaluation import Evaluation as Evaluation
    from elastomorph.evaluation import Suggestion as Suggestion
    from elastomorph.evaluation import evaluate as evaluate
    from elastomorph.evaluation import suggest_inbetweens as suggest_inbetweens
    from elastomorph.evaluation.learning import Learned as Learned
    from elastomorph.evaluation.learning import learn as learn
    from elastomorph.farm.making.run import make_faces as make_faces
    from elastomorph.farm.reading.faces import FaceSet as FaceSet
    from elastomorph.farm.reading.faces import open_faces as open_faces
    from elastomorph.farm.sampling.sampler import FaceSampler as FaceSampler
    from elastomorph.holding import Correction as Correction
    from elastomorph.holding import Held as Held
    from elastomorph.holding import hold as hold
    from elastomorph.io.performance import read_performance as read_performance
    from elastomorph.io.performance import write_performance as write_performance
    from elastomorph.io.poses import read_poses as read_poses
    from elastomorph.io.poses import write_poses as write_poses
    from elastomorph.io.registry import read as read
    from elastomorph.io.registry import write as write
    from elastomorph.io.rig_folder import read_rig as read_rig
    from elastomorph.io.sequences import read_markers as read_markers
    from elastomorph.io.sequences import read_sequence as read_sequence
    from elastomorph.io.sequences import write_sequence as write_sequence
    from elastomorph.io.simplex import read_correctives as read_correctives
    from elastomorph.model.bend_curve import BendCurve as BendCurve
    from elastomorph.model.markers import Markers as Markers
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
    from elastomorph.rig import timing as timing
    from elastomorph.rig.laws import Corrective as Corrective
    from elastomorph.rig.performance import Performance as Performance
    from elastomorph.rig.rig import Rig as Rig

_HOMES = {
    "bending": ("BendReport", "bend", "unbend"),
    "capturing.work.capture": ("capture",),
    "capturing.work.captured": ("Captured",),
    "capturing.work.registered": ("Registered",),
    "capturing.scans.registration": ("register", "register_all"),
    "curves": ("Curve", "CurveNetwork", "edge_loops"),
    "curves.extraction": ("extract_curves",),
    "evaluation": ("Evaluation", "Suggestion", "evaluate", "suggest_inbetweens"),
    "evaluation.learning": ("Learned", "learn"),
    "farm.sampling.sampler": ("FaceSampler",),
    "farm.reading.faces": ("FaceSet", "open_faces"),
    "farm.making.run": ("make_faces",),
    "holding": ("Correction", "Held", "hold"),
    "io.performance": ("read_performance", "write_performance"),
    "io.poses": ("read_poses", "write_poses"),
    "io.registry": ("read", "write"),
    "io.rig_folder": ("read_rig",),
    "io.sequences": ("read_markers", "read_sequence", "write_sequence"),
    "io.simplex": ("read_correctives",),
    "model.bend_curve": ("BendCurve",),
    "model.markers": ("Markers",),
    "model.mesh": ("Mesh",),
    "model.morph": ("Morph",),
    "model.sequence": ("MeshSequence",),
    "paths": ("Method",),
    "paths.bake": ("bake",),
    "paths.interpolate": ("interpolate", "prepare"),
    "paths.through": ("through",),
    "physics": ("Load", "Material"),
    "rig.laws": ("Corrective",),
    "rig.performance": ("Performance",),
    "rig.rig": ("Rig",),
}
"""The module of each public name that is no error."""

__all__ = sorted({*(name for names in _HOMES.values() for name in names), *_errors})


__getattr__ = lazy_names(__name__, {**_HOMES, "rig": ("timing",), "samples": ()})


def __dir__() -> list[str]:
    return sorted({*(name for name in globals() if name.startswith("__")), *__all__, "timing"})
