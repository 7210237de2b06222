"""Where a target is: displacements in place of positions, unit and axes, motion of the head."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Outcome, finding, percent
from elastomorph.doctor.frames import Frame, frame_between
from elastomorph.doctor.neutral import STILL_SHARE
from elastomorph.doctor.settings import Thresholds
from elastomorph.model.geometry import Screw, fit_rigid
from elastomorph.model.mesh import Mesh

Positions = NDArray[np.float64]

# A shape that is no neutral however it is moved, scaled and turned leaves this part of its extent.
_UNLIKE = 0.3
# Vertices are weighed by (r² + s²)^(-3/4), which lets the many that agree outvote the few that
# move far; s falls from the size of the motion to that of noise, by this factor a round.
_FALL = 0.8
_ROUNDS = 60
_SAMPLE = 6000
_NOISE = 1e-5


def saved_as_deltas(neutral: Mesh, target: Mesh, file: str, limits: Thresholds) -> Outcome | None:
    """Whether a target in its order holds displacements, and the shape they make.

    No mesh where displacements are so large that they are of another unit, and nothing says of
    which; None for a shape.
    """
    scale, points = neutral.diameter, target.vertices
    if not scale or len(points) < 4:
        return None
    lengths = np.linalg.norm(points, axis=1)
    at_origin = float((lengths <= limits.nothing * scale).mean())
    largest = float(lengths.max()) / scale
    small = largest < limits.deltas
    resting = at_origin >= limits.resting
    if not (small and resting) and not ((small or resting) and _is_unlike(neutral, target)):
        return None
    if not small:
        message = (
            "its coordinates are displacements from the neutral, no positions, and in another "
            f"unit: the largest is {percent(largest)} of D, farther than any expression reaches; "
            "nothing says which unit, so it is not repaired"
        )
        return Outcome(None, (finding("saved-as-deltas", file, message),))
    shape = target.with_vertices(neutral.vertices + points)
    if not frame_between(neutral.vertices, shape.vertices, limits.scale).is_same:
        return None
    message = (
        f"its coordinates are displacements from the neutral, no positions: {percent(at_origin)} "
        "of its vertices are at the origin"
    )
    return Outcome(shape, (finding("saved-as-deltas", file, message),), "added to the neutral")


def _is_unlike(neutral: Mesh, target: Mesh) -> bool:
    """Whether a target is not the neutral in another unit either."""
    here, there = (mesh.vertices - mesh.vertices.mean(axis=0) for mesh in (neutral, target))
    sizes = [float(np.sqrt((points**2).sum())) for points in (here, there)]
    if min(sizes) == 0:
        return False
    _, left = fit_rigid(here / sizes[0], there / sizes[1])
    return bool((left**2).sum() / 2.0 > _UNLIKE)


def common_frame(frames: Sequence[Frame]) -> Frame | None:
    """How more than half of the targets, two at least, differ from the neutral, all alike.

    Then it is the neutral that differs. None where they do not.
    """
    alike = [sum(one.is_like(other) for other in frames) for one in frames]
    most = max(alike, default=0)
    if most < 2 or 2 * most <= len(frames):
        return None
    frame = frames[alike.index(most)]
    return None if frame.is_same else frame


def in_frame(mesh: Mesh, frame: Frame, file: str, others: str) -> Outcome:
    """Say how a mesh differs from others (in words) in unit and axes, and bring it back."""
    found, repairs = [], []
    if frame.factor != 1.0:
        larger = frame.factor > 1
        times = frame.factor if larger else 1 / frame.factor
        meaning = f", {frame.unit}" if frame.unit else ", which is no factor between two units"
        message = f"{times:.6g} times {'larger' if larger else 'smaller'} than {others}{meaning}"
        found.append(finding("different-units", file, message))
        repairs.append("unit")
    if not frame.same_axes:
        name = "mirrored" if frame.mirrored else "different-axes"
        message = f"its axes hold {frame.describe_axes()} of {others}"
        if frame.mirrored and frame.axes == (0, 1, 2) and sum(frame.signs) == 1:
            message = f"{'xyz'[frame.signs.index(-1)]} has the other sign"
        found.append(finding(name, file, message))
        repairs.append("axes")
    if not found:
        return Outcome(mesh)
    if not frame.known:
        return Outcome(None, tuple(found))
    back = mesh.with_vertices(frame.back(mesh.vertices))
    return Outcome(back, tuple(found), f"{' and '.join(repairs)} of {others}")


def steadied(neutral: Mesh, target: Mesh, file: str, limits: Thresholds) -> Outcome:
    """A target without a rigid motion that most of it follows, if there is one."""
    here, there, scale = neutral.vertices, target.vertices, neutral.diameter or 1.0
    before = _still_quarter(here, there)
    if before <= limits.head * scale or len(here) < 8:
        return Outcome(target)
    motion = _most_common_motion(here, there, _NOISE * scale)
    steady = _without(motion, there)
    after = _still_quarter(here, steady)
    if after > limits.steadier * before:
        return Outcome(target)
    shift = float(np.linalg.norm(motion.at(1.0, here) - here, axis=1).mean())
    message = (
        f"the head moves by {percent(shift / scale)} of D and turns by "
        f"{np.degrees(motion.angle):.2g}°; the stillest quarter of the vertices moves by up to "
        f"{percent(before / scale)}, and by {percent(after / scale)} without that motion"
    )
    found = finding("moves-the-head", file, message)
    return Outcome(target.with_vertices(steady), (found,), "motion of the head taken out")


def align(neutral: Mesh, target: Mesh, still: NDArray[np.int64]) -> Mesh:
    """The target after the rigid motion that best brings (N,) vertices back to the neutral."""
    motion, _ = fit_rigid(neutral.vertices[still], target.vertices[still])
    return target.with_vertices(_without(motion, target.vertices))


def _still_quarter(before: Positions, after: Positions) -> float:
    """How far the stillest quarter of the vertices moves at most."""
    return float(np.quantile(np.linalg.norm(after - before, axis=1), STILL_SHARE))


def _without(motion: Screw, points: Positions) -> Positions:
    """(N, 3) points before a motion that ended where they are."""
    return Screw(motion.axis, -motion.angle, motion.centre, -motion.slide).at(1.0, points)


def _most_common_motion(before: Positions, after: Positions, noise: float) -> Screw:
    """The rigid motion that as many vertices as possible follow.

    Least squares reweighted so that Σ (r² + s²)^(1/4) of the distances r left over falls; s goes
    down from the median motion to the noise, up to which vertices agree.
    """
    step = -(-len(before) // _SAMPLE)
    before, after = before[::step], after[::step]
    motion, left = fit_rigid(before, after)
    soft = max(float(np.median(left)), noise)
    for _ in range(_ROUNDS):
        motion, left = fit_rigid(before, after, (left**2 + soft**2) ** -0.75)
        if soft == noise:
            break
        soft = max(_FALL * soft, noise)
    return motion
