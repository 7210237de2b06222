"""The template: the mesh whose vertices all poses get, from wherever it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Similarity
from elastomorph.capturing.landmarks import known_landmarks
from elastomorph.errors import CaptureError, FormatError
from elastomorph.io.atomic import is_folder, require_name
from elastomorph.io.npz.members import open_npz
from elastomorph.io.registry import BUILT_IN, MESH_FORMATS, RIG_FORMATS, known_suffixes, read
from elastomorph.io.rig_folder import find_neutral, rig_as_stored
from elastomorph.model.mesh import Mesh
from elastomorph.paths.welding import Welding
from elastomorph.rig import Rig

KNOWN = tuple(dict.fromkeys([*known_suffixes(MESH_FORMATS), *known_suffixes(RIG_FORMATS)]))
"""Suffixes of all files that hold a mesh or a rig."""

_FEWEST = 100


@dataclass(frozen=True, eq=False)
class Template:
    """A template and how it is worked on: without seams.

    Attributes:
        mesh: As it is in its file; the poses have its vertices and polygons.
        work: The same surface, each place of a seam one vertex.
        first: (W,) int64, the vertex of the mesh that each vertex of ``work`` is.
        place: (V,) int64, the vertex of ``work`` that each vertex of the mesh is.
        triangles: (T, 3) int64 of ``work``, as they are wound in its file.
        known: Landmark → vertex of ``work``, where they come with the template.
    """

    mesh: Mesh
    work: Mesh
    first: NDArray[np.int64]
    place: NDArray[np.int64]
    triangles: NDArray[np.int64]
    known: Mapping[str, int] = field(default_factory=dict)

    @classmethod
    def named(cls, named: Mesh | str | Path) -> Template:
        """A mesh as template, or what `read_template` finds under a name."""
        mesh = read_template(named)
        found = cls.of(mesh)
        # What a mesh was read from tells whose landmarks it has.
        known = known_landmarks(mesh.name if isinstance(named, Mesh) else named, mesh)
        return replace(found, known=found.vertices_of(known, "the landmarks known of the template"))

    @classmethod
    def of(cls, mesh: Mesh) -> Template:
        """A mesh as template, of which no landmarks are known.

        Raises:
            CaptureError: It has no surface, or so few vertices that it is no face.
        """
        if len(mesh.faces) == 0 or len(mesh.vertices) < _FEWEST:
            raise CaptureError(
                f"the template {mesh.name} has {len(mesh.vertices):,} vertices and "
                f"{len(mesh.faces):,} polygons; expected the surface of a face"
            )
        everywhere = np.arange(len(mesh.vertices))
        work, first, place = mesh, everywhere, everywhere
        if mesh.source is not None and mesh.source.split:
            # Vertices are one where no shape tells them apart; a template has one shape only.
            welding = Welding.of(mesh, [mesh.vertices + mesh.diameter])
            work, first, place = welding.neutral, welding.first, welding.place
        return cls(mesh, work, first, place, work.faces.triangles().astype(np.int64))

    def facing(self, face: Similarity) -> Template:
        """It with triangles whose normals point outwards, whichever way its polygons do.

        Args:
            face: From the typical face to its landmarks.
        """
        local = face.inverse()(self.work.vertices)[self.triangles]
        normals = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
        near = np.linalg.norm(local.mean(axis=1), axis=1) < 1
        if normals[near, 2].sum() >= 0:
            return self
        return replace(self, triangles=np.ascontiguousarray(self.triangles[:, ::-1]))

    def vertices_of(self, landmarks: Mapping[str, int], file: str) -> dict[str, int]:
        """Landmark → vertex of ``work``, from vertices of the mesh.

        Raises:
            CaptureError: The mesh has no such vertex.
        """
        count = len(self.mesh.vertices)
        for name, vertex in landmarks.items():
            if vertex >= count:
                raise CaptureError(
                    f"{file}: {name} is vertex {vertex:,}, but the template has {count:,} (0 to "
                    f"{count - 1:,}): the landmarks were placed on another template"
                )
        return {name: int(self.place[vertex]) for name, vertex in landmarks.items()}


def read_template(named: Mesh | str | Path) -> Mesh:
    """The mesh that a template is: itself, ``built-in``, that in a file, or the neutral of a rig.

    Raises:
        FileError: There is no such file or folder, or it cannot be read.
        FormatError: Its suffix is unknown, or its content is not what the format allows.
    """
    if isinstance(named, Mesh):
        return named
    if str(named) != BUILT_IN and is_folder(named):
        return read(find_neutral(named))
    found = mesh_or_rig(named)
    return found if isinstance(found, Mesh) else found.neutral


def mesh_or_rig(named: str | Path) -> Mesh | Rig:
    """The mesh in a file of one mesh, else the rig that is ``built-in``, in a file or a folder.

    Raises:
        FileError: There is no such file or folder, or it cannot be read.
        FormatError: Its suffix is unknown, or its content is not what the format allows.
    """
    require_name(named)
    suffix = Path(named).suffix.lower()
    whole = str(named) == BUILT_IN or is_folder(named)
    if not whole and suffix not in KNOWN:
        found = f"unknown suffix '{suffix}'" if suffix else "there is no such folder"
        raise FormatError(
            named, f"{found}; expected 'built-in', a folder, or one of {', '.join(KNOWN)}"
        )
    if whole or suffix not in known_suffixes(MESH_FORMATS):
        return rig_as_stored(named)
    return rig_as_stored(named) if suffix == ".npz" and _holds_rig(named) else read(named)


def _holds_rig(path: str | Path) -> bool:
    with open_npz(path) as members:
        return "rig_version" in members.names
