"""The parts of a mesh whose file says what they look like: one for each material, with its image.

Exporters cut vertices apart where texture coordinates end. For light and shade such a seam is
none: corners at one place of the neutral count as corners of one vertex.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.actors import Part
from elastomorph.draw.materials import LOOKS, Look, part_of_name
from elastomorph.draw.textures import encoded, pixels_of, places_in, warn_of
from elastomorph.model.appearance import Material, Texture, Wrap
from elastomorph.model.mesh import Mesh

_MOST_ALIKE = 64
"""Corners at one place, beyond which it is no seam; their pairs would take too long."""


def dressed_parts(mesh: Mesh) -> list[Part]:
    """The parts by material, those that let others shine through last.

    A material that nothing is said of is white. An image that cannot be shown is warned of once.
    """
    looks = mesh.appearance or {}
    labels = np.full(len(mesh.faces), -1) if mesh.materials is None else mesh.materials.of_face
    names = () if mesh.materials is None else mesh.materials.names
    parts, problems = [], []
    for label in np.unique(labels).tolist():
        name = names[label] if label >= 0 else ""
        part, problem = _part(mesh, np.flatnonzero(labels == label), name, looks.get(name))
        parts.append(part)
        if problem:
            problems.append((name, problem))
    warn_of(problems, mesh.name)
    return sorted(parts, key=lambda part: part.blends)


def welded_corners(mesh: Mesh) -> NDArray[np.int64]:
    """(C,) a number for the place of each corner of the polygons: the same at one place."""
    same: NDArray[np.int64] = np.unique(mesh.vertices, axis=0, return_inverse=True)[1].reshape(-1)
    corners = same[mesh.faces.indices]
    crowded = np.bincount(corners)[corners] > _MOST_ALIKE
    return np.where(crowded, len(same) + mesh.faces.indices, corners)


def _part(
    mesh: Mesh, numbers: NDArray[np.int64], name: str, material: Material | None
) -> tuple[Part, str]:
    """The polygons of one material, and why it lacks its image."""
    own = material or Material()
    kind = LOOKS.get(part_of_name(name), LOOKS["skin"])
    red, green, blue = encoded(np.array(own.colour[:3])).tolist()
    part = Part(mesh.faces, numbers, Look((red, green, blue), kind.shine, kind.polish))
    image, problem = (None, "") if mesh.uv is None else pixels_of(own)
    if image is not None and own.texture is not None:
        places = _places(mesh, numbers, own.texture)
        if own.opacity == "opaque":
            image[..., 3] = 255
        image, places, wrap = _wrapped(own.texture, image, places)
        part.set_texture(image[::-1], places, wrap=wrap, smooth=own.texture.smooth)
    part.set_material(own)
    return part, problem


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
