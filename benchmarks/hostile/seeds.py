"""Small files of every format with all that a format can hold, for the others to damage."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig import Rig

__all__ = ["face", "motion", "rig", "written"]


@cache
def face() -> Mesh:
    """Seven vertices, two quads and a triangle, with all the labels a mesh can have."""
    return Mesh(
        [[0, 0, 0], [1, 0, 0.1], [1, 1, -0.0], [0, 1, 0], [2, 0, 1 / 3], [2, 1, 0.5], [3, 0, 0]],
        [[0, 1, 2, 3], [1, 4, 5, 2], [4, 6, 5]],
        uv=UVMap(
            np.array([[0, 0], [0.5, 0], [0.5, 1], [0, 1], [0.6, 0], [0.6, 1], [1, 0], [1, 1]]),
            np.array([0, 1, 2, 3, 4, 6, 7, 5, 6, 6, 7], dtype=np.int32),
        ),
        materials=FaceLabels(("skin", "teeth"), np.array([1, 0, -1], dtype=np.int32)),
        groups=FaceLabels(("left", "upper part"), np.array([0, 0, 1], dtype=np.int32)),
        material_library="face.mtl",
    )


@cache
def rig() -> Rig:
    """Three morphs, one curved, one of pieces, one straight; a corrective and a group."""
    mesh = face()
    up = mesh.with_vertices(mesh.vertices * [1, 1, 3] + [0, 0, 1])
    bends = np.stack([mesh.vertices / 3, mesh.vertices[:, [1, 2, 0]] / 5])
    pieces = BendCurve([0.0, 0.5, 1.0], [[0.0, 2.0], [1.0, -2.0]])
    return Rig(
        mesh,
        {
            "jawOpen": Morph(mesh, up, bends, (BendCurve.power(2), BendCurve.power(3)), "beam"),
            "smile": Morph(mesh, up, bends[:1], (pieces,)),
            "Lächeln": Morph(mesh, up, bends[:0], ()),
        },
        correctives={"Lächeln": ["jawOpen", "smile"]},
        groups={"both": ["jawOpen", "smile"]},
    )


@cache
def motion() -> MeshSequence:
    """Three frames, the second a little late."""
    mesh = face()
    frames = [mesh.vertices, mesh.vertices * 2, mesh.vertices + 1]
    return MeshSequence(mesh, frames, [0.0, 0.6, 1.0], ["a.1", "a.2", "a.3"], ["a.0"])


def written(name: str, write: Callable[..., Any], thing: Any, **options: Any) -> bytes:
    """What a writer writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        write(path, thing, **options)
        return path.read_bytes()
