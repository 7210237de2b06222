"""A rig as USD: UsdSkel blend shapes whose in-betweens follow the curved paths.

The file holds, in whatever program opens it, /Face (a SkelRoot), /Face/Mesh with its blend shapes
and subsets below it, /Face/Skeleton of one joint, /Face/Animation with the weights, and
/Face/Materials. +Y is up.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import replacing_path
from elastomorph.io.blend_shapes import driven_weights, require_turn
from elastomorph.io.usd.exact import checksum, prim_names
from elastomorph.io.usd.inbetweens import place_inbetweens
from elastomorph.io.usd.library import SETTINGS, SLIDERS, naming_failure, pxr
from elastomorph.io.usd.prims import (
    codes_of,
    define_animation,
    define_blend_shape,
    define_mesh,
    define_skeleton,
    define_subsets,
    extent_of,
    set_text,
    sparse_shapes,
)
from elastomorph.io.usd.turning import turn_joint
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn

__all__ = ["SUFFIXES", "BlendShapeReport", "UsdReport", "require_usd_settings", "write_usd"]

SUFFIXES = (".usd", ".usda", ".usdc")
_ROOT = "/Face"


@dataclass(frozen=True)
class BlendShapeReport:
    """How one morph stands in the file.

    Attributes:
        name: Name of the morph in the rig.
        prim_name: Its name in the file, where spaces, dots and accents are not allowed.
        inbetweens: Weights of its in-betweens, rising between 0 and 1.
        error: Largest distance between the straight pieces that UsdSkel plays and the curved
            path, as a fraction of D, for weights from 0 to 1 and besides the rounding to float32.
        straight_error: What it would be without in-betweens.
        points: Vertices that it moves.
    """

    name: str
    prim_name: str
    inbetweens: tuple[float, ...]
    error: float
    straight_error: float
    points: int


@dataclass(frozen=True)
class UsdReport:
    """What was written.

    Attributes:
        path: The file.
        size: Its size in bytes.
        tolerance: The error asked for, as a fraction of D.
        shapes: One entry a morph, in the order of the rig.
    """

    path: Path
    size: int
    tolerance: float
    shapes: tuple[BlendShapeReport, ...]

    @property
    def error(self) -> float:
        """The largest error of all morphs, as a fraction of D."""
        return max((shape.error for shape in self.shapes), default=0.0)

    @property
    def above_tolerance(self) -> tuple[BlendShapeReport, ...]:
        """The morphs for which the in-betweens allowed did not suffice."""
        return tuple(shape for shape in self.shapes if shape.error > self.tolerance)


def write_usd(
    path: str | Path,
    rig: Rig,
    *,
    tolerance: float = 1e-3,
    most_inbetweens: int = 3,
    animation: tuple[ArrayLike, ArrayLike, str] | None = None,
    fps: float = 30.0,
    meters_per_unit: float = 0.01,
    settings: Mapping[str, Any] | None = None,
    turn: HeadTurn | None = None,
) -> UsdReport:
    """Write a rig as UsdSkel blend shapes.

    UsdSkel in-betweens are piecewise linear in the weight. Each morph gets the fewest that keep
    it within the tolerance of its curved path, where they help most. The curved paths are kept
    too, and `read_usd` gives them back; correctives become shapes of their own, and other
    programs must drive them.

    Args:
        path: The file: .usda is text, .usdc and .usd are binary.
        rig: The rig.
        tolerance: Distance between the two paths that is small enough, as a fraction of D.
        most_inbetweens: Largest number of in-betweens of a morph.
        animation: Times (T,) in seconds, rising; slider weights (T, S) in the order of
            ``rig.names``, 1 the target; and a name. All weights are 0 where it is left out.
        fps: Time codes in a second.
        meters_per_unit: Length of a unit in metres; by default that of files that state none.
        settings: How the rig was made, as JSON; `elastomorph.io.registry` gives it back.
        turn: How the joint that holds the face, then in its neck, turns with the animation.

    Returns:
        The in-betweens and the remaining error of each morph, and the size of the file.

    Raises:
        MissingExtraError: usd-core is not installed.
        ParameterError: An argument is out of its range, or not a rig.
        FormatError: Another suffix, a coordinate too large for float32, or a name that is no text.
        FileError: The file cannot be written.
    """
    if not isinstance(rig, Rig):
        raise ParameterError(f"expected a Rig to write, found {type(rig).__name__}")
    require_usd_settings(tolerance, most_inbetweens, fps, meters_per_unit)
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise FormatError(path, f"expected a name that ends in {', '.join(SUFFIXES)}")
    _require_texts(path, rig)
    motion = animation and (*driven_weights(rig, *animation[:2]), str(animation[2]))
    with replacing_path(path) as temporary, naming_failure(path):
        stage = pxr("Usd").Stage.CreateInMemory()
        pxr("UsdGeom").SetStageMetersPerUnit(stage, meters_per_unit)
        shapes = _author(path, stage, rig, tolerance, most_inbetweens, motion, fps, turn)
        if settings is not None:
            text = json.dumps(settings, ensure_ascii=False, allow_nan=False)
            set_text(stage.GetPrimAtPath(f"{_ROOT}/Mesh"), SETTINGS, text)
        kind, mode = ("usda" if suffix == ".usda" else "usdc"), temporary.stat().st_mode
        stage.GetRootLayer().Export(str(temporary), args={"format": kind})
        temporary.chmod(mode)
        size = temporary.stat().st_size
    return UsdReport(Path(path), size, tolerance, shapes)


def require_usd_settings(
    tolerance: float = 0.0,
    most_inbetweens: int = 0,
    fps: float = 30.0,
    meters_per_unit: float = 0.01,
) -> None:
    """Check options of `write_usd`."""
    for what, number in (("fps", fps), ("meters_per_unit", meters_per_unit)):
        if not (np.isfinite(number) and number > 0):
            raise ParameterError(f"{what} must be a number above 0, found {number!r}")
    if not (np.isfinite(tolerance) and tolerance >= 0):
        raise ParameterError(f"the tolerance must be a number of at least 0, found {tolerance!r}")
    if not isinstance(most_inbetweens, int) or most_inbetweens < 0:
        raise ParameterError(
            f"most_inbetweens must be a whole number of at least 0, found {most_inbetweens!r}"
        )


def _require_texts(path: str | Path, rig: Rig) -> None:
    """Refuse names with a NUL, at which USD would end them, or half a character."""
    labels = (rig.neutral.materials, rig.neutral.groups)
    for name in (*rig.morphs, *(name for own in labels if own is not None for name in own.names)):
        if "\0" in name or name.encode("utf-8", "replace").decode() != name:
            raise FormatError(path, f"the name {name!r} cannot be stored as text; rename it")


def _author(
    path: str | Path,
    stage: Any,
    rig: Rig,
    tolerance: float,
    most: int,
    animation: tuple[NDArray[np.float64], NDArray[np.float64], str] | None,
    fps: float,
    turn: HeadTurn | None,
) -> tuple[BlendShapeReport, ...]:
    require_turn(turn, 0 if animation is None else len(animation[0]))
    pxr("UsdGeom").SetStageUpAxis(stage, pxr("UsdGeom").Tokens.y)
    root = pxr("UsdSkel").Root.Define(stage, _ROOT)
    stage.SetDefaultPrim(root.GetPrim())
    pxr("Usd").ModelAPI(root.GetPrim()).SetKind(pxr("Kind").Tokens.component)
    mesh = define_mesh(path, stage, f"{_ROOT}/Mesh", rig.neutral)
    names = prim_names(rig.morphs)
    low, high = rig.neutral.vertices.copy(), rig.neutral.vertices.copy()
    reports = []
    for plain, (name, morph) in zip(names, rig.morphs.items(), strict=True):
        placement = place_inbetweens(morph, tolerance=tolerance, most=most)
        shapes = sparse_shapes(path, morph, placement)
        define_blend_shape(path, stage, f"{_ROOT}/Mesh/{plain}", name, morph, shapes)
        low[shapes.points] += np.minimum(shapes.offsets.min(axis=0), 0)
        high[shapes.points] += np.maximum(shapes.offsets.max(axis=0), 0)
        weights, errors = placement.weights.tolist(), (placement.error, placement.straight_error)
        reports.append(BlendShapeReport(name, plain, tuple(weights), *errors, len(shapes.points)))
    define_subsets(stage, mesh, rig.neutral, names, f"{_ROOT}/Materials")
    skeleton = define_skeleton(stage, f"{_ROOT}/Skeleton", mesh, len(low), names)
    define_animation(stage, f"{_ROOT}/Animation", skeleton, names, animation, fps)
    if turn is not None and animation is not None:
        turn_joint(stage, f"{_ROOT}/Animation", skeleton, turn, codes_of(animation[0], fps))
        reach = np.linalg.norm(np.maximum(high - turn.pivot, turn.pivot - low), axis=1).max()
        low, high = (np.array([turn.pivot + side * reach]) for side in (-1, 1))
    root.CreateExtentAttr(extent_of(low, high))
    sliders = {
        "version": 1,
        "morphs": list(rig.morphs),
        "correctives": {name: list(own) for name, own in rig.sliders.correctives.items()},
        "groups": {name: list(own) for name, own in rig.sliders.groups.items()},
        "materialLibrary": rig.neutral.material_library,
        "checksum": checksum([rig.neutral.vertices.astype(np.float32)]),
    }
    set_text(mesh.GetPrim(), SLIDERS, json.dumps(sliders))
    return tuple(reports)
