"""The built-in head, read from the array file that ``tools/sculpt_head.py`` writes.

Positions are whole multiples of ``unit``, a power of two of a centimetre: 4e-10 of the head's size,
and the same bits on every processor. Faces other than the neutral are kept as the vertices of the
left half that they move and how far, and the same of their mirror images.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.mesh import FaceLabels, Mesh
from elastomorph.model.polygons import Polygons
from elastomorph.model.sequence import MeshSequence


@cache
def head() -> Mesh:
    """The built-in neutral head: an original, procedural sculpture, the same on every call.

    About 5,000 vertices, nearly all polygons quads, centimetres, +Y up, +Z out of the face. The
    left side of the character ("_L") is +x, as in the ICT rig. Polygon groups name the skin, the
    scalp, brows, lids, lips, the mouth bag, teeth and the parts of the eyeballs.
    """
    stored = _stored("neutral", "unit", "corners", "sizes", "group_names", "group_of_polygon")
    return Mesh(
        stored["neutral"] * stored["unit"],
        Polygons(stored["corners"], np.append(0, np.cumsum(stored["sizes"], dtype=np.int64))),
        groups=FaceLabels(
            names=tuple(stored["group_names"].tolist()),
            of_face=stored["group_of_polygon"].astype(np.int32),
        ),
    )


def shapes() -> dict[str, Mesh]:
    """The head's single blendshapes, each at full strength, by their ARKit names.

    "_L" is the character's left, +x.
    """
    return dict(_faces()["shape"])


def expressions() -> dict[str, Mesh]:
    """The five expressions of the paper on the built-in head.

    Returns:
        "sad", "angry", "confused", "grinning" and "puff", with the topology of ``head()``.
    """
    return dict(_faces()["expression"])


@cache
def recorded_motion() -> MeshSequence:
    """Eleven poses of the head, from the neutral into a wide laugh, at times 0, 0.1, … 1.

    The jaw opens by 23° about the axis along x through (0, −0.9, 1.2), which glides forwards and
    down by up to 0.35 and 0.105 cm; the lower teeth follow rigidly. Each lid vertex turns about
    the centre of its eyeball. The first frame is ``head()``, bit for bit.
    """
    neutral = head()
    frames = [neutral, *_faces()["frame"].values()]
    return MeshSequence(
        neutral, np.stack([each.vertices for each in frames]), np.arange(len(frames)) / 10.0
    )


def _stored(*names: str) -> dict[str, NDArray[Any]]:
    """Some arrays of the file."""
    source = files("elastomorph.samples").joinpath("head.npz")
    with source.open("rb") as file, np.load(file) as arrays:
        return {name: arrays[name] for name in names}


@cache
def _faces() -> dict[str, dict[str, Mesh]]:
    """Meshes by kind ("shape", "expression" or "frame") and name."""
    neutral = head()
    stored = _stored("unit", "kinds", "names", "partner", "halves", "counts", "moved", "deltas")
    ends = np.cumsum(stored["counts"], dtype=np.int64)[:-1]
    moved, partner = np.split(stored["moved"], ends), stored["partner"]
    deltas = np.split(stored["deltas"] * stored["unit"], ends)
    found: dict[str, dict[str, Mesh]] = {}
    for kind, name, (left, right) in zip(
        stored["kinds"].tolist(), stored["names"].tolist(), stored["halves"].tolist(), strict=True
    ):
        moves = np.zeros_like(neutral.vertices)
        moves[partner[moved[right]]] = deltas[right] * [-1.0, 1.0, 1.0]
        moves[moved[left]] = deltas[left]
        found.setdefault(kind, {})[name] = neutral.with_vertices(neutral.vertices + moves)
    return found
