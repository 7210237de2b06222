"""Has a target the unit and the axes of the neutral?"""

from __future__ import annotations

from dataclasses import dataclass

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.frames import frame_between
from elastomorph.mesh import Mesh

__all__ = ["InFrame", "examine_frame"]


@dataclass(frozen=True, eq=False)
class InFrame:
    """A target in the unit and axes of the neutral.

    Attributes:
        mesh: The target, or None where its unit is not known.
        findings: What was different.
        repair: What was done, in a few words.
    """

    mesh: Mesh | None
    findings: tuple[Finding, ...] = ()
    repair: str = ""


def examine_frame(neutral: Mesh, target: Mesh, file: str, scale: float) -> InFrame:
    """Compare unit and axes, and bring the target back where they differ.

    Args:
        neutral: The neutral.
        target: A target in its order.
        file: Its file.
        scale: Factors up to this are no change of unit.
    """
    frame = frame_between(neutral.vertices, target.vertices, scale)
    found, repairs = [], []
    if frame.factor != 1.0:
        larger = frame.factor > 1
        times = frame.factor if larger else 1 / frame.factor
        meaning = f", {frame.unit}" if frame.unit else ", which is no factor between two units"
        message = f"{times:.6g} times {'larger' if larger else 'smaller'} than the neutral{meaning}"
        found.append(finding("different-units", file, message))
        repairs.append("unit")
    if not frame.same_axes:
        name = "mirrored" if frame.mirrored else "different-axes"
        message = f"its axes hold {frame.describe_axes()} of the neutral"
        if frame.mirrored and frame.axes == (0, 1, 2) and sum(frame.signs) == 1:
            message = f"{'xyz'[frame.signs.index(-1)]} has the other sign"
        found.append(finding(name, file, message))
        repairs.append("axes")
    if not found:
        return InFrame(target)
    if not frame.known:
        return InFrame(None, tuple(found))
    mesh = target.with_vertices(frame.back(target.vertices))
    return InFrame(mesh, tuple(found), f"{' and '.join(repairs)} of the neutral")
