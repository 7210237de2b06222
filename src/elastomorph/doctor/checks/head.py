"""Does a target move the whole head? Then it was not stabilised."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.stillness import steady_motion, stillest_quarter, without_motion
from elastomorph.doctor.words import percent
from elastomorph.model.mesh import Mesh
from elastomorph.model.rigid import fit_rigid

__all__ = ["Steadied", "align", "examine_head"]


@dataclass(frozen=True, eq=False)
class Steadied:
    """A target with the motion of the head taken out.

    Attributes:
        mesh: The target as it should be.
        findings: What was found.
        moved: Whether it differs from the target as it was.
    """

    mesh: Mesh
    findings: tuple[Finding, ...] = ()
    moved: bool = False


def examine_head(
    neutral: Mesh, target: Mesh, file: str, *, allowed: float, steadier: float
) -> Steadied:
    """Look for a rigid motion that most of a target follows.

    Args:
        neutral: The neutral.
        target: A target in its order, unit and axes.
        file: Its file.
        allowed: How far the stillest quarter of the vertices may move, as a fraction of D.
        steadier: What a rigid motion may leave of that, as a part.
    """
    here, there, scale = neutral.vertices, target.vertices, neutral.diameter or 1.0
    before = stillest_quarter(here, there)
    if before <= allowed * scale or len(here) < 8:
        return Steadied(target)
    motion = steady_motion(here, there, 1e-5 * scale)
    steady = without_motion(there, motion)
    after = stillest_quarter(here, steady)
    if after > steadier * before:
        return Steadied(target)
    shift = float(np.linalg.norm(motion.at(1.0, here) - here, axis=1).mean())
    message = (
        f"the head moves by {percent(shift / scale)} of D and turns by "
        f"{np.degrees(motion.angle):.2g}°; the stillest quarter of the vertices moves by up to "
        f"{percent(before / scale)}, and by {percent(after / scale)} without that motion"
    )
    found = finding("moves-the-head", file, message)
    return Steadied(target.with_vertices(steady), (found,), True)


def align(neutral: Mesh, target: Mesh, still: NDArray[np.int64]) -> Mesh:
    """The target after the rigid motion that best brings chosen vertices back to the neutral.

    Args:
        neutral: The neutral.
        target: A target in its order.
        still: (N,) vertices that should not move, three or more and not on a line.
    """
    motion, _ = fit_rigid(neutral.vertices[still], target.vertices[still])
    return target.with_vertices(without_motion(target.vertices, motion))
