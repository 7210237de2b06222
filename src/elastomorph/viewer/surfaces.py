"""Surfaces as the page of landmarks reads them: what is drawn, and the author's vertices."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.model.appearance import Texture
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

_MOST_EDGES = 400_000  # more of them would cover the surface


@dataclass(frozen=True, eq=False)
class PackedSurface:
    """A surface to be sent.

    Attributes:
        content: A header in JSON with its length before it, then arrays, little-endian: positions
            about an origin, texture coordinates, the author's vertex of each of ours, triangles,
            edges, colours.
        images: Contents of the image files that its parts show, by number.
    """

    content: bytes
    images: tuple[bytes, ...]


def pack_surface(
    mesh: Mesh, *, edges: bool, colours: NDArray[np.uint8] | None = None
) -> PackedSurface:
    """A mesh with its textures.

    Args:
        mesh: With polygons.
        edges: Whether the edges of its polygons are sent too.
        colours: (V, 3) of the vertices, red first.

    Raises:
        MeshError: There are no polygons.
    """
    if not len(mesh.faces):
        raise MeshError(f"{mesh.name} has points but no polygons: there is no surface to click on")
    sources, corners, uv = _split(mesh)
    images, image_of_face = _images(mesh)
    corner_triangles = Polygons(np.arange(mesh.faces.indices.size), mesh.faces.offsets).triangles()
    image_of_triangle = image_of_face[mesh.faces.corner_faces[corner_triangles[:, 0]]]
    order = np.argsort(image_of_triangle, kind="stable")
    triangles = corners[corner_triangles[order]]
    used = mesh.vertices[mesh.faces.indices]
    origin = (used.min(axis=0) + used.max(axis=0)) / 2
    lines = _lines(mesh, sources) if edges else np.empty((0, 2), np.uint32)
    header = {
        "vertices": len(sources),
        "triangles": len(triangles),
        "edges": len(lines),
        "origin": origin.tolist(),
        "uv": uv is not None,
        "colours": colours is not None,
        "parts": _parts(image_of_triangle[order]),
    }
    arrays = [(mesh.vertices[sources] - origin).astype("<f4")]
    arrays += [] if uv is None else [uv.astype("<f4")]
    arrays += [sources.astype("<u4"), triangles.astype("<u4"), lines.astype("<u4")]
    if colours is not None:
        arrays.append(np.c_[colours, np.full(len(colours), 255)].astype(np.uint8)[sources])
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    content = struct.pack("<I", len(text)) + text + b"".join(each.tobytes() for each in arrays)
    return PackedSurface(content, images)


def _split(
    mesh: Mesh,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64] | None]:
    """Vertices once for each of their texture coordinates: of the author's, by corner, and these.

    Coordinates are those on the image, after the transform of its material; None where no image is
    shown.
    """
    indices = mesh.faces.indices.astype(np.int64)
    textures = _textures(mesh)
    if mesh.uv is None or mesh.materials is None or not any(textures):
        return np.arange(len(mesh.vertices)), indices, None
    chosen = mesh.uv.corners.astype(np.int64)
    coordinates = np.vstack([mesh.uv.coordinates[:, :2], [[0.0, 0.0]]])[chosen]
    # Materials may show the same coordinates at different places of their images.
    labels = mesh.materials.of_face[mesh.faces.corner_faces].astype(np.int64)
    for label, texture in enumerate(textures):
        if texture is not None:
            own = labels == label
            coordinates[own] = _transformed(texture, coordinates[own])
    pairs = indices * (len(mesh.uv.coordinates) + 1) + chosen
    pairs = pairs * (len(textures) + 1) + labels
    _, first, corners = np.unique(pairs, return_index=True, return_inverse=True)
    return indices[first], corners.reshape(-1), coordinates[first]


def _transformed(texture: Texture, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where coordinates are on the image, v from its bottom."""
    cos, sin = np.cos(texture.rotation), np.sin(texture.rotation)
    from_top = np.c_[uv[:, 0], 1 - uv[:, 1]] * texture.scale
    turned = from_top @ np.array([[cos, -sin], [sin, cos]]) + texture.offset
    return np.stack([turned[:, 0], 1 - turned[:, 1]], axis=1)


def _textures(mesh: Mesh) -> list[Texture | None]:
    """The texture of each material, where its image is at hand."""
    if mesh.materials is None or not mesh.appearance:
        return []
    looks = [mesh.appearance.get(name) for name in mesh.materials.names]
    return [
        look.texture if look and look.texture and look.texture.image else None for look in looks
    ]


def _images(mesh: Mesh) -> tuple[tuple[bytes, ...], NDArray[np.int64]]:
    """The images of a mesh, each once, and which of them each polygon shows; -1 for none."""
    images: dict[bytes, int] = {}
    textures = _textures(mesh)
    number = [
        -1 if texture is None else images.setdefault(texture.image, len(images))
        for texture in textures
    ]
    of_face = np.full(len(mesh.faces), -1)
    if number and mesh.materials is not None and mesh.uv is not None:
        of_face = np.array([*number, -1])[mesh.materials.of_face]
    return tuple(images), of_face


def _parts(image_of_triangle: NDArray[np.int64]) -> list[dict[str, int]]:
    """Corners in a row that show one image."""
    starts = np.flatnonzero(np.diff(image_of_triangle, prepend=-2))
    ends = np.append(starts[1:], len(image_of_triangle))
    return [
        {
            "start": int(3 * start),
            "count": int(3 * (end - start)),
            "image": int(image_of_triangle[start]),
        }
        for start, end in zip(starts, ends, strict=True)
    ]


def _lines(mesh: Mesh, sources: NDArray[np.int64]) -> NDArray[np.int64]:
    """Edges of the polygons, between vertices of ours."""
    if len(mesh.edges) > _MOST_EDGES:
        return np.empty((0, 2), np.int64)
    own = np.zeros(len(mesh.vertices), np.int64)
    own[sources] = np.arange(len(sources))
    return own[mesh.edges]
