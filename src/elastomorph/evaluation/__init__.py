"""How an interpolated face is judged against a recorded one."""

from elastomorph.evaluation.curve_errors import CurveVertices, curve_errors
from elastomorph.evaluation.evaluation import DEFAULT_METHODS, evaluate
from elastomorph.evaluation.results import Evaluation, MethodResult
from elastomorph.evaluation.segments import Movement, find_movements, resting_pose
from elastomorph.evaluation.shape import Shape, ShapeProbe, polygon_normals
from elastomorph.evaluation.timing import free_timing

__all__ = [
    "DEFAULT_METHODS",
    "CurveVertices",
    "Evaluation",
    "MethodResult",
    "Movement",
    "Shape",
    "ShapeProbe",
    "curve_errors",
    "evaluate",
    "find_movements",
    "free_timing",
    "polygon_normals",
    "resting_pose",
]
