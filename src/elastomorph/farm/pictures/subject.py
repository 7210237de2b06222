"""What is to be drawn of a rig, and how it looks: what stays the same from face to face.

Images on surfaces are kept in linear light, at the size at which a picture shows them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.draw.materials import (
    LOOKS,
    Dress,
    corner_pairs,
    dresses_of,
    encoded,
    linear,
    parts_of,
    welded_corners,
)
from elastomorph.errors import MeshError
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import polygon_normals

Colours = NDArray[np.float32]
Bytes = NDArray[np.uint8]

_LINEAR = linear(np.arange(256) / 255).astype(np.float32)
_COARSEST = 4
_FINEST = 4
"""Texels of an image for one pixel of a picture, a side; what is finer is not kept."""


@dataclass(frozen=True, eq=False)
class Texels:
    """An image and its halves, quarters …: (H, W, 4) sRGB, opacity last.

    A texel shown by many pixels is mixed with those beside it; many shown by one are averaged
    first, in the level whose texels are about as large as pixels.
    """

    levels: tuple[Bytes, ...]
    wrap: str
    smooth: bool

    @classmethod
    def of(cls, dress: Dress, pixels: int) -> Texels | None:
        """Those of the image of a dress, if it has one, for pictures with such sides."""
        if dress.image is None:
            return None
        rows, columns = dress.image.shape[:2]
        image = np.full((rows, columns, 4), 255, dtype=np.uint8)
        image[..., : dress.image.shape[2]] = dress.image
        levels = [image]
        while dress.smooth and min(levels[-1].shape[:2]) >= 2 * _COARSEST:
            levels.append(_halved(levels[-1]))
        fit = [own for own in levels if max(own.shape) <= _FINEST * pixels]
        return cls(tuple(fit or levels[-1:]), dress.wrap, dress.smooth)

    def level(self, texels_a_pixel: float) -> int:
        """Which level to show, from how many texels of the whole image a pixel covers."""
        halvings = np.log2(max(texels_a_pixel, 1e-9)) / 2
        return int(np.clip(np.rint(halvings), 0, len(self.levels) - 1))

    def at(self, places: NDArray[np.floating], level: int = 0) -> Colours:
        """(N, 4) linear colours and opacity at (N, 2) places, the first row of the image at 0."""
        image = self.levels[level]
        rows, columns = image.shape[:2]
        x = places[:, 0].astype(np.float64) * columns - 0.5
        y = places[:, 1].astype(np.float64) * rows - 0.5
        if not self.smooth:
            x, y = np.rint(x), np.rint(y)
        total = np.zeros((len(places), 4), dtype=np.float32)
        for column, across in _beside(x):
            for row, up in _beside(y):
                share = (across * up).astype(np.float32)
                taken = image[self._wrapped(row, rows), self._wrapped(column, columns)]
                total[:, :3] += share[:, None] * _LINEAR[taken[:, :3]]
                total[:, 3] += share * (taken[:, 3] / np.float32(255))
        return total

    def _wrapped(self, index: NDArray[np.int64], count: int) -> NDArray[np.int64]:
        if self.wrap == "clamp":
            return np.clip(index, 0, count - 1)
        if self.wrap == "repeat":
            return index % count
        there = index % (2 * count)
        return np.minimum(there, 2 * count - 1 - there)


def _beside(
    along: NDArray[np.float64],
) -> list[tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """The texels before and after places, and their shares."""
    before = np.floor(along)
    part = along - before
    texel = before.astype(np.int64)
    return [(texel, 1 - part), (texel + 1, part)]


def _halved(image: Bytes) -> Bytes:
    """Means of four, of light; colours count as much as they are seen."""
    even = image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2]
    quarters = [even[row::2, column::2] for row in (0, 1) for column in (0, 1)]
    weights = [np.maximum(own[..., 3:], np.float32(0.1)) for own in quarters]
    light = sum(_LINEAR[own[..., :3]] * w for own, w in zip(quarters, weights, strict=True))
    opacity = sum(own[..., 3:].astype(np.float32) for own in quarters) / 4
    shown = encoded(np.asarray(light / sum(weights))) * 255
    codes = np.rint(np.concatenate([shown, opacity], axis=2)).astype(np.uint8)
    return np.asarray(codes)


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
