"""Pieces whose polygons all run the wrong way round, in all files alike: normals point inwards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.half_edges import HalfEdges
from elastomorph.doctor.words import counted, listed
from elastomorph.model.components import component_of
from elastomorph.model.mesh import Mesh

__all__ = ["inside_out", "inside_out_finding"]

# 36 π V² / A³ is 1 of a ball and 0 of a sheet. Sheets have no inside; a face mask has 0.05 and
# more, sockets of eyes 0.014, gums 0.0002.
_HOLDS = 0.005


def inside_out(mesh: Mesh) -> NDArray[np.bool_]:
    """(F,) polygons of pieces that enclose a volume and are wound towards it.

    Borders are closed by a fan to their middle. Only the largest piece and closed ones are looked
    at: a mouth socket that is open is rightly seen from within.
    """
    wrong = np.zeros(len(mesh.faces), dtype=bool)
    if not len(mesh.faces):
        return wrong
    points, half = mesh.vertices, HalfEdges.of(mesh.faces, len(mesh.vertices))
    part_of = component_of(len(points), mesh.edges)
    number = int(part_of.max()) + 1
    centres = np.stack([np.bincount(part_of, points[:, i], number) for i in range(3)], axis=1)
    arms = points - (centres / np.bincount(part_of, minlength=number)[:, None])[part_of]
    triangles = mesh.faces.triangles()
    a, b, c = (arms[triangles[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    piece = part_of[triangles[:, 0]]
    areas = np.bincount(piece, np.linalg.norm(across, axis=1), number) / 2.0
    volumes = np.bincount(piece, (a * across).sum(axis=1), number) / 6.0
    border = half.proper & (half.alike + half.against == 1)
    start, end = half.start[border], half.end[border]
    if start.size:
        loop = component_of(len(points), np.stack([start, end], axis=1))[start]
        size = np.maximum(np.bincount(loop), 1)
        middles = np.stack([np.bincount(loop, arms[start][:, i]) for i in range(3)], axis=1)
        fans = ((middles / size[:, None])[loop] * np.cross(arms[end], arms[start])).sum(axis=1)
        volumes += np.bincount(part_of[start], fans, number) / 6.0
    closed = np.bincount(part_of[half.start[half.alike + half.against != 2]], minlength=number) == 0
    closed[int(np.argmax(areas))] = True
    holds = 36.0 * np.pi * volumes**2 > _HOLDS * areas**3
    bad = closed & holds & (volumes < 0)
    return np.asarray(bad[part_of[mesh.faces.indices[mesh.faces.offsets[:-1]]]])


def inside_out_finding(mesh: Mesh, file: str, wrong: NDArray[np.bool_]) -> Finding:
    """The finding for polygons that are wound inwards.

    Args:
        mesh: The neutral.
        file: Its file.
        wrong: (F,) as `inside_out` gives it.
    """
    which = np.flatnonzero(wrong)
    lines = mesh.source.face_lines if mesh.source else None
    corners = mesh.faces.indices[wrong[mesh.faces.corner_faces]]
    message = (
        f"{counted(which, 'polygon shows its', 'polygons show their')} back, in all files alike: "
        f"{listed(which)}"
    )
    return finding(
        "inside-out",
        file,
        message,
        line=None if lines is None else int(lines[which[0]]),
        vertices=np.unique(corners).tolist(),
    )
