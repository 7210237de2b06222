"""The colours of a scan: images on its triangles, or colours at its vertices."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import CaptureError, ElastomorphError
from elastomorph.model.appearance import Material, Texture
from elastomorph.model.mesh import Mesh

Points = NDArray[np.float64]

# Pixels of an image that is decoded, and on a side of what is kept of it.
_MOST_PIXELS, _SIDE = 16384**2, 4096


@dataclass(frozen=True, eq=False)
class Skin:
    """Colours of triangles.

    Attributes:
        images: each (H, W, 3) uint8, red first.
        image: (T,) which of them a triangle shows.
        places: (T, 3, 2) where its corners lie in it, in parts of width and height, from the top.
    """

    images: tuple[NDArray[np.uint8], ...]
    image: NDArray[np.int64]
    places: Points

    def only(self, kept: NDArray[np.bool_]) -> Skin:
        """The colours of some triangles."""
        return replace(self, image=self.image[kept], places=self.places[kept])

    def turned(self) -> Skin:
        """With the corners the other way round."""
        return replace(self, places=self.places[:, ::-1])

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
        return found


_WRAP = 3  # cv2.BORDER_WRAP


def skin_of(mesh: Mesh, corners: NDArray[np.integer], name: str) -> Skin | None:
    """The colours of a mesh, for triangles of (T, 3) corners; None where it has none.

    Raises:
        CaptureError: An image is missing or cannot be shown.
    """
    if mesh.uv is None or not mesh.appearance or mesh.materials is None:
        return None
    label = mesh.materials.of_face[mesh.faces.corner_faces[corners[:, 0]]]
    images: list[NDArray[np.uint8]] = []
    image = np.full(len(corners), -1)
    places = np.zeros((len(corners), 3, 2))
    for number, material in enumerate(mesh.materials.names):
        own = np.flatnonzero(label == number)
        look = mesh.appearance.get(material)
        if look is None or not len(own):
            continue
        used = mesh.uv.corners[corners[own]]
        pixels = _pixels(look, name) if (used >= 0).any() else None
        if look.texture is None or pixels is None:
            continue
        coordinates = mesh.uv.coordinates[np.maximum(used, 0), :2]
        places[own] = _placed(look.texture, coordinates)
        image[own] = len(images)
        images.append(pixels)
    if not images:
        return None
    # What has no image of its own shows a plain grey, in which nothing can be followed.
    image[image < 0] = len(images)
    return Skin((*images, np.full((2, 2, 3), 128, dtype=np.uint8)), image, places)


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
