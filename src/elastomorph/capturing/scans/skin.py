"""The colours of a scan: images on its triangles, or colours at its vertices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import CaptureError, ElastomorphError
from elastomorph.model.appearance import Material, Texture
from elastomorph.model.mesh import Mesh

Points = NDArray[np.float64]

# Pixels on a side of what is kept of an image.
_SIDE = 4096


@dataclass(frozen=True, eq=False)
class Skin:
    """Colours of triangles.

    Attributes:
        images: each (H, W, 3) uint8, red first.
        image: (T,) which of them a triangle shows.
        places: (T, 3, 2) where its corners lie in it, in parts of width and height, from the top.
        corners: (T, 3, 3) uint8, colours of the corners of triangles that show no image (-1).
    """

    images: tuple[NDArray[np.uint8], ...]
    image: NDArray[np.int64]
    places: Points
    corners: NDArray[np.uint8]

    def only(self, kept: NDArray[np.bool_]) -> Skin:
        """The colours of some triangles."""
        return replace(
            self, image=self.image[kept], places=self.places[kept], corners=self.corners[kept]
        )

    def turned(self) -> Skin:
        """With the corners the other way round."""
        return replace(self, places=self.places[:, ::-1], corners=self.corners[:, ::-1])

    def at(self, triangles: NDArray[np.integer], weights: Points) -> NDArray[np.uint8]:
        """(H, W, 3) colours at points of (H, W) triangles with (H, W, 3) weights of corners.

        Between pixels they are mixed; triangles below 0 are black.
        """
        import cv2

        there = np.maximum(triangles, 0)
        place = np.einsum("hwk,hwkj->hwj", weights, self.places[there])
        found = np.zeros((*triangles.shape, 3), dtype=np.uint8)
        for number, image in enumerate(self.images):
            own = (triangles >= 0) & (self.image[there] == number)
            if own.any():
                high, wide = image.shape[:2]
                x, y = (place % 1.0).astype(np.float32).transpose(2, 0, 1)
                shown = cv2.remap(
                    image, x * wide - 0.5, y * high - 0.5, cv2.INTER_LINEAR, borderMode=_WRAP
                )
                found[own] = shown[own]
        own = (triangles >= 0) & (self.image[there] < 0)
        if own.any():
            mixed = np.einsum("nk,nkc->nc", weights[own], self.corners[there[own]])
            found[own] = np.clip(np.round(mixed), 0, 255)
        return found


_WRAP = 3  # cv2.BORDER_WRAP


def skin_of(
    mesh: Mesh,
    corners: NDArray[np.integer],
    name: str,
    colours: NDArray[np.uint8] | None = None,
) -> Skin | None:
    """The colours of a mesh; None where it has none, or one and the same everywhere.

    Args:
        mesh: With its materials.
        corners: (T, 3) corners of the triangles, by their places in the polygons.
        name: For messages.
        colours: (V, 3) of the vertices, red first: shown where no image is.

    Raises:
        CaptureError: An image is missing or cannot be shown.
    """
    images: list[NDArray[np.uint8]] = []
    image = np.full(len(corners), -1)
    places = np.zeros((len(corners), 3, 2))
    for material, own in _dressed_parts(mesh, corners):
        used = None if material.texture is None else _used(mesh, corners[own])
        pixels = None if used is None else _pixels(material, name)
        if material.texture is None or used is None or pixels is None:
            continue
        places[own] = _placed(material.texture, used)
        image[own] = len(images)
        images.append(pixels)
    # What has no colour of its own shows a plain grey, in which nothing can be followed.
    at = np.full((len(corners), 3, 3), 128, dtype=np.uint8)
    if colours is not None:
        at = colours[mesh.faces.indices[corners]]
    if not images and not np.ptp(at.reshape(-1, 3), axis=0).any():
        return None
    return Skin(tuple(images), image, places, at)


def _dressed_parts(
    mesh: Mesh, corners: NDArray[np.integer]
) -> Iterator[tuple[Material, NDArray[np.intp]]]:
    """Each material whose looks are known, and the triangles of it."""
    if mesh.uv is None or not mesh.appearance or mesh.materials is None:
        return
    label = mesh.materials.of_face[mesh.faces.corner_faces[corners[:, 0]]]
    for number, name in enumerate(mesh.materials.names):
        own = np.flatnonzero(label == number)
        if len(own) and name in mesh.appearance:
            yield mesh.appearance[name], own


def _used(mesh: Mesh, corners: NDArray[np.integer]) -> Points | None:
    """(T, 3, 2) texture coordinates of triangles; None where none of them has any."""
    if mesh.uv is None:
        return None
    used = mesh.uv.corners[corners]
    return mesh.uv.coordinates[np.maximum(used, 0), :2] if (used >= 0).any() else None


def _placed(texture: Texture, coordinates: Points) -> Points:
    """Where (..., 2) texture coordinates lie in an image, from its top."""
    u, v = coordinates[..., 0], 1 - coordinates[..., 1]
    across, down = u * texture.scale[0], v * texture.scale[1]
    cosine, sine = np.cos(texture.rotation), np.sin(texture.rotation)
    return np.stack(
        [
            texture.offset[0] + cosine * across + sine * down,
            texture.offset[1] - sine * across + cosine * down,
        ],
        axis=-1,
    )


def _pixels(look: Material, name: str) -> NDArray[np.uint8] | None:
    """The image of a material, if it has one."""
    if look.texture is None:
        return None
    if not look.texture.image:
        raise CaptureError(
            f"{name}: its texture {look.texture.name!r} cannot be read"
            f" ({look.texture.problem or 'it is empty'}): put the image beside the scan, or"
            " register without texture"
        )
    try:
        return decoded(look.texture.image)
    except ElastomorphError as problem:
        raise CaptureError(f"{name}: its texture {look.texture.name!r} {problem}") from None


def decoded(content: bytes) -> NDArray[np.uint8]:
    """(H, W, 3) the pixels of an image file, red first, made smaller where it is very large."""
    import cv2

    try:
        found: Any = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_COLOR_RGB)
    except cv2.error as problem:
        raise CaptureError(f"cannot be decoded: {problem}") from problem
    if found is None:
        raise CaptureError("is no PNG, JPEG or WebP image")
    factor = _SIDE / max(found.shape[:2])
    if factor < 1:
        found = cv2.resize(found, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    return np.asarray(found, dtype=np.uint8)
