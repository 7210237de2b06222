"""The whole head: the mirrored skin, the eyeballs and the teeth in one mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.mesh import FaceLabels, Mesh
from sculptor import eyeballs, layout, sculpt, teeth
from sculptor.implicit import Points

__all__ = ["Head", "build", "head"]

_MIRROR = np.array([-1.0, 1.0, 1.0])
_MIRROR.flags.writeable = False


@dataclass(frozen=True, eq=False)
class Head:
    """The head and what its vertices are.

    Attributes:
        mesh: The neutral.
        lay: Layout of the left half of the skin; its indices are indices of the mesh.
        partner: (V,) the mirror image of each vertex.
        part: (V,) "skin", "eye_L", "eye_R", "upper_teeth", "lower_teeth" or "tongue".
    """

    mesh: Mesh
    lay: layout.Half
    partner: NDArray[np.int64]
    part: NDArray[np.str_]


class _Assembly:
    """Pieces put together, each followed by its mirror image."""

    def __init__(self) -> None:
        self.vertices: list[Points] = []
        self.partner: list[NDArray[np.int64]] = []
        self.part: list[str] = []
        self.faces: list[list[int]] = []
        self.groups: list[str] = []

    def add_pair(
        self,
        points: Points,
        faces: list[list[int]],
        names: tuple[list[str], list[str]],
        parts: tuple[str, str],
        midline: list[int] | None = None,
    ) -> None:
        """Add a left piece and its mirror image, welded at the vertices of the midline."""
        first, count = len(self.part), len(points)
        welded = np.zeros(count, dtype=bool)
        welded[midline or []] = True
        image = np.arange(first, first + count)
        image[~welded] = first + count + np.arange(int((~welded).sum()))
        self.vertices += [points, points[~welded] * _MIRROR]
        self.partner += [image, first + np.flatnonzero(~welded)]
        self.part += [parts[0]] * count + [parts[1]] * int((~welded).sum())
        self.faces += [[first + v for v in face] for face in faces]
        self.faces += [[int(image[v]) for v in reversed(face)] for face in faces]
        self.groups += [*names[0], *names[1]]


@cache
def build() -> Head:
    """The head with its layout, for the rooms that move it."""
    lay = layout.half()
    whole = _Assembly()
    skin = sculpt.half_skin()
    whole.add_pair(
        skin, lay.faces, (lay.face_groups, lay.face_groups), ("skin", "skin"), lay.midline
    )
    ball, faces, left = eyeballs.eyeball("L")
    whole.add_pair(ball, faces, (left, eyeballs.eyeball("R")[2]), ("eye_L", "eye_R"))
    for part, points, quads, names, midline in teeth.pieces():
        whole.add_pair(points, quads, (names, names), (part, part), midline)
    order = tuple(dict.fromkeys(whole.groups))
    number = {name: k for k, name in enumerate(order)}
    labels = np.array([number[name] for name in whole.groups], dtype=np.int32)
    mesh = Mesh(
        np.vstack(whole.vertices), whole.faces, groups=FaceLabels(names=order, of_face=labels)
    )
    return Head(mesh, lay, np.concatenate(whole.partner), np.array(whole.part))


def head() -> Mesh:
    """The built-in neutral head: an original, procedural sculpture, the same on every call.

    About 5,000 vertices, nearly all polygons quads, centimetres, +Y up, +Z out of the face. The
    left side of the character ("_L") is +x, as in the ICT rig. Polygon groups name the skin, the
    scalp, brows, lids, lips, the mouth bag, teeth and the parts of the eyeballs.
    """
    return build().mesh
