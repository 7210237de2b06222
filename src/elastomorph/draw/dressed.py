"""What the surface of a mesh looks like: one dress for each material, with its image.

Where the file says what its materials look like, that; else the looks of the parts that their names
speak of. Exporters cut vertices apart where texture coordinates end. For light and shade such a
seam is none: corners at one place of the neutral count as corners of one vertex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.materials import (
    LOOKS,
    Look,
    eye_image,
    iris_coordinates,
    part_of_name,
    parts_of,
)
from elastomorph.draw.textures import encoded, pixels_of, places_in, warn_of
from elastomorph.model.appearance import Material, Texture, Wrap
from elastomorph.model.mesh import Mesh

_SMOOTH = 0.15
"""Roughness below which a surface has a small, bright highlight, whatever its name."""
_MOST_ALIKE = 64
"""Corners at one place, beyond which it is no seam; their pairs would take too long."""


@dataclass(frozen=True, eq=False)
class Dress:
    """What some polygons look like.

    Attributes:
        polygons: (F_dress,) their numbers, rising.
        look: Colour, where there is no image, and highlight.
        image: (H, W, 3 or 4) sRGB and opacity, the first row at 0, if any.
        places: (C_dress, 2) where the corners of the polygons lie in the image, from 0 to 1.
        wrap: What is beside the image.
        smooth: Whether colours between its pixels are mixed.
        material: What the file says of opacity, sides and light, if anything.
    """

    polygons: NDArray[np.int64]
    look: Look
    image: NDArray[np.uint8] | None = None
    places: NDArray[np.float64] | None = None
    wrap: Wrap = "clamp"
    smooth: bool = True
    material: Material | None = None


def dresses_of(mesh: Mesh) -> list[Dress]:
    """What is to be drawn of a mesh, each polygon once at most.

    With an appearance every material is, white where nothing is said of it; an image that cannot be
    shown is warned of once. Without one, all parts are but the hidden ones.
    """
    if mesh.appearance is None:
        return _plain(mesh)
    labels = np.full(len(mesh.faces), -1) if mesh.materials is None else mesh.materials.of_face
    names = () if mesh.materials is None else mesh.materials.names
    dresses, problems = [], []
    for label in np.unique(labels).tolist():
        name = names[label] if label >= 0 else ""
        own = mesh.appearance.get(name)
        dress, problem = _dress(mesh, np.flatnonzero(labels == label), name, own)
        dresses.append(dress)
        if problem:
            problems.append((name, problem))
    warn_of(problems, mesh.name)
    return dresses


def welded_corners(mesh: Mesh) -> NDArray[np.int64]:
    """(C,) a number for the place of each corner of the polygons: the same at one place."""
    same: NDArray[np.int64] = np.unique(mesh.vertices, axis=0, return_inverse=True)[1].reshape(-1)
    corners = same[mesh.faces.indices]
    crowded = np.bincount(corners)[corners] > _MOST_ALIKE
    return np.where(crowded, len(same) + mesh.faces.indices, corners)


def _plain(mesh: Mesh) -> list[Dress]:
    parts = parts_of(mesh)
    drawn = {
        name: Dress(numbers, LOOKS[name]) for name, numbers in parts.items() if name != "hidden"
    }
    if "sclera" in drawn:
        white = parts["sclera"]
        own = [parts[name] for name in ("iris", "pupil") if name in parts]
        places = iris_coordinates(mesh, white, np.concatenate([white[:0], *own]))
        drawn["sclera"] = Dress(white, LOOKS["sclera"], eye_image(), places)
    return list(drawn.values())


def _dress(
    mesh: Mesh, polygons: NDArray[np.int64], name: str, material: Material | None
) -> tuple[Dress, str]:
    """The dress of one material, and why it lacks its image."""
    own = material or Material()
    kind = LOOKS.get(part_of_name(name), LOOKS["skin"])
    red, green, blue = encoded(np.array(own.colour[:3])).tolist()
    shine, polish = kind.shine, kind.polish
    if own.finish is not None and own.finish.roughness < _SMOOTH:  # as wet as an eye
        shine, polish = 0.9, 150.0
    look = Look((red, green, blue), shine, polish)
    image, problem = (None, "") if mesh.uv is None else pixels_of(own)
    if image is None or own.texture is None:
        return Dress(polygons, look, material=own), problem
    places = _places(mesh, polygons, own.texture)
    if own.opacity == "opaque":
        image[..., 3] = 255
    image, places, wrap = _wrapped(own.texture, image, places)
    smooth = own.texture.smooth
    return Dress(polygons, look, image[::-1], places, wrap, smooth, own), problem


def _places(mesh: Mesh, numbers: NDArray[np.int64], texture: Texture) -> NDArray[np.float64]:
    """(C_part, 2) where the corners of a part lie in its image, from the left and the bottom."""
    if mesh.uv is None:
        return np.zeros((0, 2))
    used = mesh.uv.corners[np.isin(mesh.faces.corner_faces, numbers)]
    if not len(mesh.uv.coordinates):
        return np.zeros((len(used), 2))
    found = mesh.uv.coordinates[np.maximum(used, 0), :2]
    return places_in(texture, np.where(used[:, None] < 0, 0.0, found))


def _wrapped(
    texture: Texture, image: NDArray[np.uint8], places: NDArray[np.float64]
) -> tuple[NDArray[np.uint8], NDArray[np.float64], Wrap]:
    """Image and places for a renderer that wraps both directions alike."""
    if texture.wrap[0] == texture.wrap[1]:
        return image, places, texture.wrap[0]
    for direction, wrap in enumerate(texture.wrap):
        if wrap == "mirror":
            axis = 1 - direction
            image = np.concatenate([image, np.flip(image, axis)], axis)
            places = places * ([0.5, 1] if direction == 0 else [1, 0.5])
            if direction == 1:  # rows count from the top, places from the bottom
                places = places + [0, 0.5]
        if wrap == "clamp":
            edge = 0.5 / image.shape[1 - direction]
            places = places.copy()
            places[:, direction] = np.clip(places[:, direction], edge, 1 - edge)
    return image, places, "repeat"
