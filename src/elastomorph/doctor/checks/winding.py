"""Polygons that run the other way round than elsewhere in the rig."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.words import counted, listed
from elastomorph.model.mesh import Mesh

__all__ = ["common_turn", "reversed_finding"]


def common_turn(turned: Sequence[NDArray[np.bool_]]) -> NDArray[np.bool_] | None:
    """The polygons that most targets, all alike, run the other way round: the neutral is wrong.

    Args:
        turned: (F,) for each target, which polygons of the neutral it runs the other way round.

    Returns:
        (F,) those of more than half of the targets, two at least; None where there are none.
    """
    alike: dict[bytes, int] = {}
    for own in turned:
        alike[own.tobytes()] = alike.get(own.tobytes(), 0) + 1
    most = max(alike, key=lambda key: alike[key], default=b"")
    if not most or alike[most] < 2 or 2 * alike[most] <= len(turned):
        return None
    wrong = np.frombuffer(most, dtype=bool)
    return wrong if wrong.any() else None


def reversed_finding(
    mesh: Mesh, file: str, polygons: NDArray[np.integer], others: str = "in the neutral"
) -> Finding:
    """The finding for polygons of a mesh that run the other way round.

    Args:
        mesh: The mesh.
        file: Its file.
        polygons: Which, rising.
        others: Than where, in words.
    """
    if len(polygons) == len(mesh.faces):
        which = "every polygon runs the other way round: its normals point inwards"
    else:
        which = (
            f"{counted(polygons, 'polygon runs', 'polygons run')} the other way round than "
            f"{others}: {listed(polygons)}"
        )
    lines = mesh.source.face_lines if mesh.source else None
    corners = np.isin(mesh.faces.corner_faces, polygons)
    return finding(
        "reversed-winding",
        file,
        which,
        line=None if lines is None else int(lines[polygons[0]]),
        vertices=np.unique(mesh.faces.indices[corners]).tolist(),
    )
