"""The small head in metres, cut into the parts and split at the seams that exporters make."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from small_head import head, shapes

# ARKit names, as characters of the web have them: without an underscore before Left and Right.
NAMES = {
    "jawOpen": "jawOpen",
    "mouthSmileLeft": "mouthSmile_L",
    "eyeBlinkLeft": "eyeBlink_L",
    "eyeBlinkRight": "eyeBlink_R",
    "jawLeft": "jawLeft",
    "browInnerUp": "browInnerUp",
}
LOOK = "eyeLookDownLeft"  # the eyeball turns, which the shapes of the small head do not have
MATERIALS = {
    "head": ("skin", "lids", "nostrils", "lips", "mouth"),
    "eyes": ("pupil_L", "iris_L", "eye_L", "pupil_R", "iris_R", "eye_R"),
    "teeth": ("gums", "teeth", "tongue"),
    "lashes": ("lashes", "brows"),
}
_METRES, _HEIGHT = 0.01, 1.62
_FRONT, _BELOW = 2.0, -11.0  # cm: what no target moves of skull and neck is left out, for speed


@dataclass(frozen=True, eq=False)
class FacePart:
    """The vertices of one surface, split where normals or texture coordinates jump."""

    name: str
    positions: NDArray[np.float32]  # (V, 3) metres, +Y up, +Z front
    normals: NDArray[np.float32]  # (V, 3) unit
    texture: NDArray[np.float32]  # (V, 2), v from the top
    triangles: NDArray[np.int64]  # (T, 3)
    of_material: NDArray[np.int64]  # (T,) number within MATERIALS[name]
    moves: dict[str, NDArray[np.float32]]  # (V, 3) of every target, zero where it moves nothing
    turns: dict[str, NDArray[np.float32]]  # (V, 3) what each target adds to the normals

    @property
    def moved_by(self) -> list[str]:
        """Names of the targets that move any vertex."""
        return [name for name, moved in self.moves.items() if moved.any()]


@cache
def face_parts() -> dict[str, FacePart]:
    """The head, the eyes, the teeth with tongue and gums, and the lashes with brows."""
    mesh = head()
    labels = mesh.groups
    assert labels is not None
    offsets, corners = mesh.faces.offsets, mesh.faces.indices
    centres = np.add.reduceat(mesh.vertices[corners], offsets[:-1]) / np.diff(offsets)[:, None]
    near = (centres[:, 2] > _FRONT) & (centres[:, 1] > _BELOW)
    targets = {name: shapes()[own].vertices for name, own in NAMES.items()}
    targets[LOOK] = _looked_down(mesh.vertices)
    found = {}
    for name, materials in MATERIALS.items():
        triangles, of_material = [], []
        for number, material in enumerate(materials):
            for face in np.flatnonzero(near & (labels.of_face == labels.names.index(material))):
                own = corners[offsets[face] : offsets[face + 1]]
                for k in range(1, len(own) - 1):
                    triangles.append([own[0], own[k], own[k + 1]])
                    of_material.append(number)
        found[name] = _part(
            name, mesh.vertices, targets, np.array(triangles), np.array(of_material)
        )
    return found


def _looked_down(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """The left eyeball turned by 25° about the axis to its left, through its centre."""
    found = vertices.copy()
    centre = np.array([3.15, 0.0, 6.92])
    inside = np.linalg.norm(vertices - centre, axis=1) < 1.75
    angle = np.radians(25)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    ball = _component(inside, vertices)
    found[ball] = (vertices[ball] - centre) @ turn.T + centre
    return found


def _component(near: NDArray[np.bool_], vertices: NDArray[np.float64]) -> NDArray[np.int64]:
    """Those of some vertices that belong to polygons of the left eye."""
    mesh = head()
    labels = mesh.groups
    assert labels is not None
    left = [labels.names.index(name) for name in MATERIALS["eyes"][:3]]
    sizes = np.diff(mesh.faces.offsets)
    own = np.isin(np.repeat(labels.of_face, sizes), left)
    return np.intersect1d(np.unique(mesh.faces.indices[own]), np.flatnonzero(near))


def _part(
    name: str,
    vertices: NDArray[np.float64],
    targets: dict[str, NDArray[np.float64]],
    triangles: NDArray[np.int64],
    of_material: NDArray[np.int64],
) -> FacePart:
    used, own = np.unique(triangles, return_inverse=True)
    own = own.reshape(-1, 3)
    neutral = vertices[used]
    # Two islands of texture, of the left and the right: the middle of the face is a seam.
    right = neutral[own].mean(axis=1)[:, 0] < 0
    corner = np.stack([own.reshape(-1), np.repeat(right, 3)], axis=1)
    split, index = np.unique(corner, axis=0, return_inverse=True)
    place, side = split[:, 0], split[:, 1]
    low, high = neutral.min(axis=0), neutral.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    unit = (neutral[place] - low) / span
    texture = np.stack([0.5 * unit[:, 0] + np.where(side, -0.02, 0.02), 1 - unit[:, 1]], axis=1)
    normals = vertex_normals(neutral, own)
    world = (neutral * _METRES + [0, _HEIGHT, 0]).astype(np.float32)
    moves, turns = {}, {}
    for target, moved in targets.items():
        delta = (moved - vertices)[used] * _METRES
        delta[np.abs(delta).max(axis=1) < 1e-7] = 0
        moves[target] = delta[place].astype(np.float32)
        turned = vertex_normals(moved[used], own) - normals
        turned[np.abs(turned).max(axis=1) < 1e-6] = 0
        turns[target] = turned[place].astype(np.float32)
    return FacePart(
        name,
        world[place],
        normals[place].astype(np.float32),
        np.clip(texture, 0, 1).astype(np.float32),
        index.reshape(-1, 3).astype(np.int64),
        of_material,
        moves,
        turns,
    )


def vertex_normals(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(V, 3) unit normals, triangles counting by their area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    summed = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(summed, triangles[:, k], across)
    length = np.linalg.norm(summed, axis=1, keepdims=True)
    return np.where(length > 0, summed / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])
