"""Have neutral and targets one unit and the same axes?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.frames import Frame
from elastomorph.model.mesh import Mesh

__all__ = ["InFrame", "common_frame", "in_frame"]


@dataclass(frozen=True, eq=False)
class InFrame:
    """A mesh in unit and axes of the others.

    Attributes:
        mesh: The mesh, or None where its unit is not known.
        findings: What was different.
        repair: What was done, in a few words.
    """

    mesh: Mesh | None
    findings: tuple[Finding, ...] = ()
    repair: str = ""


def common_frame(frames: Sequence[Frame]) -> Frame | None:
    """How most targets differ from the neutral, all alike: then it is the neutral that differs.

    Args:
        frames: How each target differs from the neutral.

    Returns:
        The frame of more than half of the targets, two at least; None where there is none, or
        where they have that of the neutral.
    """
    alike = [sum(one.is_like(other) for other in frames) for one in frames]
    most = max(alike, default=0)
    if most < 2 or 2 * most <= len(frames):
        return None
    frame = frames[alike.index(most)]
    return None if frame.is_same else frame


def in_frame(mesh: Mesh, frame: Frame, file: str, others: str) -> InFrame:
    """Say how a mesh differs from others in unit and axes, and bring it back.

    Args:
        mesh: The mesh.
        frame: How its positions differ from those of the others.
        file: Its file.
        others: What it is compared with, in words.
    """
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
        return InFrame(mesh)
    if not frame.known:
        return InFrame(None, tuple(found))
    back = mesh.with_vertices(frame.back(mesh.vertices))
    return InFrame(back, tuple(found), f"{' and '.join(repairs)} of {others}")
