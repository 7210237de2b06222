"""Nonlinear blendshapes that run anywhere linear ones do.

A face rig moves every vertex on a straight line from the neutral face to a target. Here each target
gets a *path*, stored as a few ordinary morph targets with scalar weight curves.
"""

from elastomorph import timing as timing
from elastomorph.bake import bake
from elastomorph.bend_curve import BendCurve
from elastomorph.curves import Curve, CurveNetwork, edge_loops, extract_curves
from elastomorph.errors import (
    BakeError,
    CurveError,
    ElastomorphError,
    ElastomorphWarning,
    FileError,
    FormatError,
    MeshError,
    MissingExtraError,
    ParameterError,
    ResonanceError,
    TimeLawWarning,
    TopologyError,
)
from elastomorph.evaluation import Evaluation, Suggestion, evaluate, suggest_inbetweens
from elastomorph.fit import Fit, fit
from elastomorph.io import read, read_rig, read_sequence, write, write_sequence
from elastomorph.mesh import Mesh
from elastomorph.morph import Morph
from elastomorph.paths import Method, interpolate, prepare, through
from elastomorph.physics import Load, Material
from elastomorph.rig import Rig
from elastomorph.sequence import MeshSequence

__all__ = [
    "BakeError",
    "BendCurve",
    "Curve",
    "CurveError",
    "CurveNetwork",
    "ElastomorphError",
    "ElastomorphWarning",
    "Evaluation",
    "FileError",
    "Fit",
    "FormatError",
    "Load",
    "Material",
    "Mesh",
    "MeshError",
    "MeshSequence",
    "Method",
    "MissingExtraError",
    "Morph",
    "ParameterError",
    "ResonanceError",
    "Rig",
    "Suggestion",
    "TimeLawWarning",
    "TopologyError",
    "bake",
    "edge_loops",
    "evaluate",
    "extract_curves",
    "fit",
    "interpolate",
    "prepare",
    "read",
    "read_rig",
    "read_sequence",
    "suggest_inbetweens",
    "through",
    "write",
    "write_sequence",
]
