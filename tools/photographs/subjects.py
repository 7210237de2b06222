"""Whose head is photographed, and the face of somebody else that is given as the template.

``ict`` is the neutral of the ICT rig (``ELASTOMORPH_DATA``), ``small`` the head of the tests with
other proportions, refined. Templates have the topology of the subject's face and the shape of
another person.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.interpolate import interp1d

import elastomorph as em
from elastomorph.capturing.landmarks import known_landmarks
from elastomorph.model.mesh import part_of
from elastomorph.model.polygons import Polygons
from photographs import skin
from photographs.clicks import ict_lip_line
from photographs.rendering import Surface
from photographs.subdivision import refined

sys.path.append(str(Path(__file__).parents[2] / "tests"))

from small_head import head, landmarks, recorded_motion, shapes

__all__ = ["SUBJECTS", "Subject", "other_person", "subject"]

Vertices = NDArray[np.float64]
_ICT_FACE = 9409  # its first vertices: the face, with the neck and without the back of the head
# Materials of the ICT head; what is not named here is left out: lashes, and shells before the eyes.
_ICT_KINDS = {
    "M_Face": skin.SKIN,
    "M_BackHead": skin.SKIN,
    "M_GumsTongue": skin.GUMS,
    "M_Teeth": skin.TEETH,
    "M_ScleraLeft": skin.EYE,
    "M_ScleraRight": skin.EYE,
    "M_IrisLeft": skin.IRIS,
    "M_IrisRight": skin.IRIS,
}
_SMALL_KINDS = {
    **dict.fromkeys(("skin", "brows", "lashes", "lids", "nostrils", "lips"), skin.SKIN),
    **dict.fromkeys(("mouth", "gums", "tongue"), skin.GUMS),
    **dict.fromkeys(("eye_L", "eye_R"), skin.EYE),
    **dict.fromkeys(("iris_L", "iris_R"), skin.IRIS),
    **dict.fromkeys(("pupil_L", "pupil_R"), skin.PUPIL),
    "teeth": skin.TEETH,
}
# On the jaw, nearer to the ears than its corners: the front that results are judged by ends there.
_ICT_JAW = {"right_jaw": 1052, "left_jaw": 3272}
_SMALL_JAW = {"right_jaw": 2840, "left_jaw": 738}
_FACE_GROUPS = ("skin", "brows", "lashes", "lids", "nostrils", "lips", "mouth")
_IRIS, _PUPIL = 0.92, 0.985  # cosines from the axis of an eye whose iris is painted on


@dataclass(frozen=True, eq=False)
class Subject:
    """A head that can be posed and photographed.

    Attributes:
        name: As the command line calls it.
        neutral: The whole head at rest.
        shapes: Its targets, by name; each is read when it is asked for.
        template: The face of somebody else.
        expressions: Makes the targets of that face, by name.
        of_template: (N,) the vertex of `surface` at each vertex of the template.
        surface: What is photographed.
        refine: Matrix from vertices of the neutral to those of `surface`.
        landmarks: Vertices of the whole head, by name.
        lip_line: (S, 2) vertices at the ends of the pieces of the line where the lips meet.
        aim: (3,) where cameras look, in cm.
        distance: From there to the cameras, in cm.
        movements: Weights of targets, by name of the movement.
        frames: Vertices of the whole head at even times of the movement ``recorded``, if there is
            one.
    """

    name: str
    neutral: em.Mesh
    shapes: Callable[[str], em.Mesh]
    template: em.Mesh
    expressions: Callable[[], dict[str, em.Mesh]]
    of_template: NDArray[np.int64]
    surface: Surface
    refine: sparse.csr_array
    landmarks: dict[str, int]
    lip_line: NDArray[np.int64]
    aim: tuple[float, float, float]
    distance: float
    movements: dict[str, dict[str, float]]
    frames: Vertices | None = None

    def target(self, weights: dict[str, float]) -> em.Mesh:
        """The neutral with targets added to it."""
        vertices = self.neutral.vertices.copy()
        for name, weight in weights.items():
            vertices += weight * (self.shapes(name).vertices - self.neutral.vertices)
        return self.neutral.with_vertices(vertices)

    def poses(self, movement: str, times: NDArray[np.float64]) -> list[Vertices]:
        """Vertices of `surface` on the nonlinear path of a movement, at times from 0 to 1.

        ``recorded`` is the motion of the small head, an anatomical model: straight between frames.
        """
        if movement == "recorded" and self.frames is not None:
            last = len(self.frames) - 1
            along = interp1d(np.linspace(0, 1, last + 1), self.frames, axis=0)
            return [self.refine @ along(float(t)) for t in times]
        path = em.interpolate(self.neutral, self.target(self.movements[movement]), "rotation")
        return [self.refine @ path.at(float(t)) for t in times]


def other_person(
    vertices: Vertices, seed: int, stretch: tuple[float, float, float], waves: float = 0.16
) -> Callable[[Vertices], Vertices]:
    """A smooth change of space that makes of one face the face of another person.

    Args:
        vertices: Of the one: their mean is what stays where it is.
        seed: Of the waves.
        stretch: Factors along x, y and z.
        waves: Their height in cm; twelve of them, 7 to 16 cm long.
    """
    random = np.random.default_rng(seed)
    middle = vertices.mean(axis=0)
    ways = random.normal(size=(12, 3))
    ways *= 2 * np.pi / random.uniform(7, 16, (12, 1)) / np.linalg.norm(ways, axis=1, keepdims=True)
    phases = random.uniform(0, 6.28, 12)
    heights = random.normal(size=(12, 3)) * waves

    def changed(points: Vertices) -> Vertices:
        swing: Vertices = np.sin(points @ ways.T + phases) @ heights
        return (points - middle) * np.array(stretch) + swing + middle

    return changed


def subject(name: str, seed: int = 0) -> Subject:
    """A subject by name.

    Args:
        name: One of `SUBJECTS`.
        seed: Other proportions of the small head.
    """
    return SUBJECTS[name](seed)


def _ict(seed: int) -> Subject:
    """As it is; its template is warped by waves, whatever the seed."""
    del seed
    data = os.environ.get("ELASTOMORPH_DATA")
    folder = (Path(data) if data else Path(__file__).parents[3] / "shared" / "data") / "ict-facekit"
    neutral = em.read(folder / "generic_neutral_mesh.obj")
    assert neutral.materials is not None
    kinds = np.array([_ICT_KINDS.get(name, -1) for name in neutral.materials.names])
    of_face = kinds[neutral.materials.of_face]
    triangles, of_triangle = _triangles(neutral.faces, of_face)
    painted = _irises(neutral.vertices, triangles, of_triangle)
    surface = Surface(
        neutral.vertices, triangles, painted, np.zeros((len(neutral.vertices), 2), np.float32)
    )
    face = part_of(neutral, np.arange(_ICT_FACE))
    warp = other_person(face.vertices, 5, (0.94, 1.05, 1.04))
    template = em.Mesh(warp(face.vertices), face.faces)
    return Subject(
        name="ict",
        neutral=neutral,
        shapes=lambda shape: em.read(folder / f"{shape}.obj"),
        template=template,
        expressions=lambda: {
            path.stem: template.with_vertices(warp(em.read(path).vertices[:_ICT_FACE]))
            for path in sorted(folder.glob("*.obj"))
            if path.stem != "generic_neutral_mesh"
        },
        of_template=np.arange(_ICT_FACE),
        surface=surface,
        refine=sparse.csr_array(sparse.eye_array(len(neutral.vertices))),
        landmarks=known_landmarks(folder, neutral) | _ICT_JAW,
        lip_line=ict_lip_line(folder),
        aim=(0.0, -1.5, 1.0),
        distance=57.0,
        movements={
            "smile": {"jawOpen": 1.0, "mouthSmile_L": 0.8, "mouthSmile_R": 0.8},
            "pucker": {"mouthPucker": 1.0, "browInnerUp_L": 0.7, "browInnerUp_R": 0.7},
            "sneer": {"noseSneer_L": 1.0, "noseSneer_R": 0.6, "mouthUpperUp_L": 0.6},
        },
    )


def _small(seed: int) -> Subject:
    """With other proportions, refined twice; its template is the head as it is."""
    original = head()
    assert original.groups is not None
    warp = other_person(original.vertices, 100 + seed, (1.06, 0.95, 0.96), waves=0.055)
    neutral = original.with_vertices(warp(original.vertices))
    once, quads = refined(original.faces, len(original.vertices))
    twice, finest = refined(quads, once.shape[0])
    refine = sparse.csr_array(twice @ once)
    names = np.array(original.groups.names)
    label = original.groups.of_face[original.faces.corner_faces]
    label = np.repeat(label, 4)
    kinds = np.array([_SMALL_KINDS[name] for name in names], dtype=np.int8)
    triangles, of_triangle = _triangles(finest, kinds[label])
    tints = np.stack([_share(finest, names[label] == tint) for tint in ("lips", "brows")], axis=1)
    surface = Surface(refine @ neutral.vertices, triangles, of_triangle, tints)
    groups = np.isin(names, _FACE_GROUPS)[original.groups.of_face]
    own = np.unique(original.faces.indices[groups[original.faces.corner_faces]])
    template = part_of(original, own)
    return Subject(
        name="small",
        neutral=neutral,
        shapes=lambda shape: neutral.with_vertices(warp(shapes()[shape].vertices)),
        template=template,
        expressions=lambda: {
            name: template.with_vertices(shape.vertices[own]) for name, shape in shapes().items()
        },
        of_template=own,
        surface=surface,
        refine=refine,
        landmarks=landmarks() | _SMALL_JAW,
        lip_line=_between(original, "lips", "mouth"),
        aim=(0.0, -2.5, 1.0),
        distance=46.0,
        movements={
            "smile": {"jawOpen": 0.8, "mouthSmile_L": 0.8, "mouthSmile_R": 0.6},
            "pucker": {"mouthPucker": 1.0, "browInnerUp": 0.8},
            "sneer": {"noseSneer_L": 1.0, "noseSneer_R": 0.6, "mouthUpperUp_L": 0.6},
        },
        frames=np.array([warp(frame) for frame in recorded_motion().frames]),
    )


SUBJECTS: dict[str, Callable[[int], Subject]] = {"ict": _ict, "small": _small}


def _between(mesh: em.Mesh, one: str, other: str) -> NDArray[np.int64]:
    """(S, 2) edges that polygons of two groups share."""
    assert mesh.groups is not None
    sets = []
    following = mesh.faces.indices[mesh.faces.next_corners]
    for name in (one, other):
        own = mesh.groups.of_face[mesh.faces.corner_faces] == mesh.groups.names.index(name)
        ends = np.sort(np.stack([mesh.faces.indices[own], following[own]], axis=1), axis=1)
        sets.append(set(map(tuple, ends.tolist())))
    return np.array(sorted(sets[0] & sets[1]))


def _triangles(
    faces: Polygons, kinds: NDArray[np.integer]
) -> tuple[NDArray[np.int32], NDArray[np.int8]]:
    """Triangles of what is photographed, and the material of each."""
    of_triangle = np.repeat(kinds, faces.sizes - 2)
    kept = of_triangle >= 0
    return faces.triangles()[kept], of_triangle[kept].astype(np.int8)


def _share(faces: Polygons, chosen: NDArray[np.bool_]) -> NDArray[np.float32]:
    """(V,) share of the corners at each vertex that belong to chosen polygons."""
    weight = chosen[faces.corner_faces].astype(float)
    at = faces.indices
    share: NDArray[np.float32] = (np.bincount(at, weight) / np.maximum(np.bincount(at), 1)).astype(
        np.float32
    )
    return share


def _irises(
    vertices: Vertices, triangles: NDArray[np.int32], kinds: NDArray[np.int8]
) -> NDArray[np.int8]:
    """Materials with iris and pupil painted on the eyeballs, whose own lie behind the white."""
    kinds = kinds.copy()
    middles = vertices[triangles].mean(axis=1)
    for side in (middles[:, 0] > 0, middles[:, 0] < 0):
        ball = np.flatnonzero((kinds == skin.EYE) & side)
        corners = vertices[np.unique(triangles[ball])]
        way = middles[ball] - (corners.min(axis=0) + corners.max(axis=0)) / 2
        forward = way[:, 2] / np.linalg.norm(way, axis=1)
        kinds[ball[forward > _IRIS]] = skin.IRIS
        kinds[ball[forward > _PUPIL]] = skin.PUPIL
    return kinds
