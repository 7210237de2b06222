"""What is to be drawn of a rig, and how it looks: what stays the same from face to face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.draw.dressed import Dress, dresses_of, welded_corners
from elastomorph.draw.materials import LOOKS, parts_of
from elastomorph.draw.normals import corner_pairs
from elastomorph.draw.textures import linear
from elastomorph.errors import MeshError
from elastomorph.farm.pictures.texels import Texels
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import polygon_normals

__all__ = ["BLENDED", "MASKED", "OPAQUE", "PARTS", "Cloth", "Subject"]

PARTS = ("background", *LOOKS, "other")
"""What the numbers of parts mean, in every data set; "other" is what `parts_of` calls hidden."""

OPAQUE, MASKED, BLENDED = range(3)
_CREASE = np.cos(np.radians(70.0))  # edges of teeth, lids and lips stay edges


@dataclass(frozen=True, eq=False)
class Cloth:
    """What one material adds to the light.

    Attributes:
        colour: (4,) linear, with opacity, where there is no image.
        texels: Its image, if any.
        shine: Of the highlight, from 0 to 1.
        polish: Its Phong exponent.
        unlit: Whether light and shade leave it as it is.
        cutoff: The opacity from which labels count it as there.
    """

    colour: NDArray[np.float32]
    texels: Texels | None
    shine: float
    polish: float
    unlit: bool
    cutoff: float


class Subject:
    """Triangles of a mesh, with their parts and materials, for pictures of so many pixels.

    Attributes:
        triangles: (T, 3) vertices.
        vertices: (U,) those that are drawn.
        corners: (T, 3) corners of the polygons, of which there are normals.
        part: (T,) uint8, numbers of `PARTS`.
        cloth: (T,) index into `cloths`.
        cloths: Materials.
        opacity: (T,) `OPAQUE`, `MASKED` or `BLENDED`.
        one_sided: (T,) whether they are seen from the front alone.
        places: (T, 3, 2) where their corners lie in the images.
    """

    def __init__(self, mesh: Mesh, pixels: int) -> None:
        if not len(mesh.faces):
            raise MeshError(f"{mesh.name} has no polygons, so there is no surface to draw")
        self._mesh = mesh
        dresses = dresses_of(mesh)
        of_face = np.full(len(mesh.faces), -1)
        for number, dress in enumerate(dresses):
            of_face[dress.polygons] = number
        every = mesh.faces.triangle_corners()
        face = mesh.faces.corner_faces[every[:, 0]]
        drawn = of_face[face] >= 0
        self.corners, face = every[drawn], face[drawn]
        self.triangles = mesh.faces.indices[self.corners].astype(np.int64)
        self.vertices = np.unique(self.triangles)
        self.cloth = of_face[face]
        self.part = _part_numbers(mesh)[face]
        self.cloths = tuple(_cloth(dress, pixels) for dress in dresses)
        self.opacity = np.array(list(map(_opacity, dresses, self.cloths)))[self.cloth]
        one_sided = [bool(own.material and not own.material.double_sided) for own in dresses]
        self.one_sided = np.array(one_sided)[self.cloth]
        self.places = _places(mesh, dresses)[self.corners]
        self._smoothing = _smoothing(mesh)

    def normals(self, vertices: NDArray[np.float64]) -> NDArray[np.float32]:
        """(C, 3) unit normals of the corners of the polygons, of (V, 3) vertices; 0 for none."""
        total = self._smoothing @ polygon_normals(vertices, self._mesh.faces)
        lengths = np.sqrt(np.einsum("ij,ij->i", total, total))
        total /= np.maximum(lengths, np.finfo(float).tiny)[:, None]
        return np.asarray(total, dtype=np.float32)


def _smoothing(mesh: Mesh) -> sparse.csr_array:
    """(C, F) which polygons each corner averages: all at its vertex that no crease parts from it.

    Creases are those of the mesh as it stands. Who cuts vertices apart along seams does so along
    sharp edges too, and only there.
    """
    faces = mesh.faces
    dressed = mesh.appearance is not None
    first, second = corner_pairs(faces, welded_corners(mesh) if dressed else None)
    normals = polygon_normals(mesh.vertices, faces)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    units = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    one, other = faces.corner_faces[first], faces.corner_faces[second]
    alike = np.einsum("ij,ij->i", units[one], units[other]) > _CREASE
    alike |= first == second
    if dressed:
        alike |= faces.indices[first] == faces.indices[second]
    shape = (faces.indices.size, len(faces))
    ones = np.ones(np.count_nonzero(alike))
    return sparse.coo_array((ones, (first[alike], other[alike])), shape=shape).tocsr()


def _part_numbers(mesh: Mesh) -> NDArray[np.uint8]:
    numbers = np.zeros(len(mesh.faces), dtype=np.uint8)
    for name, polygons in parts_of(mesh).items():
        numbers[polygons] = PARTS.index(name if name in LOOKS else "other")
    return numbers


def _cloth(dress: Dress, pixels: int) -> Cloth:
    colour = np.append(linear(np.array(dress.look.colour)), 1.0)
    own = dress.material
    if own is not None and own.opacity != "opaque":
        colour[3] = own.colour[3]
    return Cloth(
        colour=colour.astype(np.float32),
        texels=Texels.of(dress, pixels),
        shine=dress.look.shine,
        polish=dress.look.polish,
        unlit=own is not None and own.unlit,
        cutoff=own.cutoff if own is not None and own.opacity == "mask" else 0.5,
    )


def _opacity(dress: Dress, cloth: Cloth) -> int:
    """How a material is drawn: what its image nowhere lets through is solid, whatever is said."""
    kinds = {"opaque": OPAQUE, "mask": MASKED, "blend": BLENDED}
    said = OPAQUE if dress.material is None else kinds[dress.material.opacity]
    alpha = cloth.colour[3] if cloth.texels is None else cloth.texels.levels[0][..., 3].min() / 255
    return OPAQUE if alpha >= (cloth.cutoff if said == MASKED else 1.0) else said


def _places(mesh: Mesh, dresses: list[Dress]) -> NDArray[np.float32]:
    """(C, 2) of all corners of the mesh."""
    places = np.zeros((mesh.faces.indices.size, 2), dtype=np.float32)
    for dress in dresses:
        if dress.places is not None:
            places[np.isin(mesh.faces.corner_faces, dress.polygons)] = dress.places
    return places
