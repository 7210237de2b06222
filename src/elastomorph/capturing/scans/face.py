"""The face that scans are given: a template, or a rig with its expressions, without seams."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.landmarks.known_landmarks import known_landmarks
from elastomorph.capturing.scans.correspondence import outer
from elastomorph.capturing.scans.expressions import Expressions
from elastomorph.capturing.work.template import mesh_or_rig
from elastomorph.errors import CaptureError, FormatError
from elastomorph.model.geometry import component_of, moved_extent, sides_of
from elastomorph.model.mesh import Mesh
from elastomorph.model.surface import triangulate
from elastomorph.paths.welding import Welding
from elastomorph.rig import Rig

Points = NDArray[np.float64]

# A part of at least this much of the largest one's area is skin; eyes, brows and lashes are less.
_SKIN = 0.15


@dataclass(frozen=True, eq=False)
class Face:
    """A template, prepared.

    Attributes:
        mesh: As it was given; the poses have its vertices and polygons.
        place: (V,) which vertex of the face without seams each of its vertices is.
        first: (W,) a vertex of the mesh for each of the face.
        vertices: (W, 3).
        triangles: (T, 3).
        size: Extent of what its targets move, or of all of it: the unit of errors.
        skin: (W,) which vertices a scan can show: outside, and of the largest parts.
        expressions: Its targets, if it is a rig.
        landmarks: Landmark → vertex, where they come with it.
    """

    mesh: Mesh
    place: NDArray[np.int64]
    first: NDArray[np.int64]
    vertices: Points
    triangles: NDArray[np.int64]
    size: float
    skin: NDArray[np.bool_]
    expressions: Expressions | None
    landmarks: Mapping[str, int]

    def vertices_of(self, landmarks: Mapping[str, int], where: str) -> Mapping[str, int]:
        """Landmark → vertex of the face, from those of the mesh, or what comes with it.

        Raises:
            FormatError: The mesh has no such vertex.
        """
        count = len(self.mesh.vertices)
        for name, vertex in landmarks.items():
            if vertex >= count:
                raise FormatError(
                    where,
                    f"{name} is vertex {vertex:,} of a template with {count:,}: the landmarks were"
                    " placed on another template",
                )
        own = landmarks or self.landmarks
        return {name: int(self.place[vertex]) for name, vertex in own.items()}


def read_face(source: str | Path | Mesh | Rig) -> Face:
    """A template from a file, a folder of meshes, ``built-in``, a mesh or a rig.

    Raises:
        FileError: It is missing or cannot be read.
        CaptureError: It has no surface.
    """
    given = source if isinstance(source, Mesh | Rig) else mesh_or_rig(source)
    mesh = given.neutral if isinstance(given, Rig) else given
    deltas = (
        {name: morph.delta for name, morph in given.morphs.items()}
        if isinstance(given, Rig)
        else {}
    )
    if not len(mesh.faces):
        raise CaptureError(f"the template {mesh.name} has no polygons: a template is a surface")
    targets = [mesh.vertices + delta for delta in deltas.values()]
    # Moved as a whole, every vertex counts; what no target tells apart at one place is one.
    welding = Welding.of(mesh, [*targets, mesh.vertices + mesh.diameter])
    work, first = welding.neutral, welding.first
    triangles = triangulate(work)[0].astype(np.int64)
    surface = Surface(work.vertices, triangles)
    expressions = None
    if deltas:
        own = np.array([delta[first] for delta in deltas.values()])
        expressions = Expressions(tuple(deltas), own)
    known = mesh.name if isinstance(source, Mesh | Rig) else source
    return Face(
        mesh,
        welding.place,
        first,
        work.vertices,
        triangles,
        moved_extent(mesh.vertices, targets) or mesh.diameter,
        outer(surface) & _skin(surface),
        expressions,
        known_landmarks(known, mesh),
    )


def _skin(surface: Surface) -> NDArray[np.bool_]:
    """(W,) vertices of the large parts."""
    count, own = len(surface.vertices), surface.triangles
    part = component_of(count, sides_of(own))
    areas = np.linalg.norm(surface.face_normals, axis=1)
    area = np.bincount(part[own[:, 0]], areas, minlength=int(part.max()) + 1)
    return np.asarray((area > _SKIN * area.max())[part])
