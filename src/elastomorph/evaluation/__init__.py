"""How an interpolated face is judged against a recorded one."""

from elastomorph.evaluation.curve_errors import CurveVertices, curve_errors, free_timing
from elastomorph.evaluation.evaluation import DEFAULT_METHODS, evaluate, every_method, left_out
from elastomorph.evaluation.inbetweens import Suggestion, suggest_inbetweens
from elastomorph.evaluation.movements import Movement, find_movements, resting_pose
from elastomorph.evaluation.results import Evaluation, MethodResult
from elastomorph.evaluation.rigid_bodies import Rigidity, rigidity
from elastomorph.evaluation.shape import Shape, ShapeProbe
from elastomorph.evaluation.target_paths import TargetPath, TargetPaths, target_paths

__all__ = [
    "DEFAULT_METHODS",
    "CurveVertices",
    "Evaluation",
    "MethodResult",
    "Movement",
    "Rigidity",
    "Shape",
    "ShapeProbe",
    "Suggestion",
    "TargetPath",
    "TargetPaths",
    "curve_errors",
    "evaluate",
    "every_method",
    "find_movements",
    "free_timing",
    "left_out",
    "resting_pose",
    "rigidity",
    "suggest_inbetweens",
    "target_paths",
]
