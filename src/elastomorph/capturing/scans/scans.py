"""Scans as scanners leave them: any topology, units and orientation, with what lies around.

What a surface of triangles needs is mended here: vertices that were cut apart for the texture are
joined, triangles without area or there twice are left out, and so are crumbs.

The colours of a scan: images on its triangles, or colours at its vertices.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Surface
from elastomorph.capturing.scans.correspondence import inside_out
from elastomorph.capturing.work.template import KNOWN, read_template
from elastomorph.errors import CaptureError, ElastomorphError, FormatError, warn
from elastomorph.io.atomic import require_name
from elastomorph.io.mtl import library_of
from elastomorph.io.scan_colours import dressed, vertex_colours
from elastomorph.model.geometry import component_of, sides_of
from elastomorph.model.mesh import Material, Mesh, Texture
from elastomorph.model.polygons import Polygons

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


# A piece of less than this part of the largest one's area is a crumb.
_CRUMB = 0.002
# Two pieces are two heads if their areas, and their sides, are alike by this factor.
_ALIKE = 0.5


@dataclass(frozen=True, eq=False)
class Scan:
    """A surface of triangles in the scanner's own units and axes.

    Attributes:
        name: of the file, or what else it is called.
        surface: of triangles that show their outside.
        piece: (T,) number of the piece of each triangle, the largest first.
        skin: Its colours, if it has any.
        inside_out: Whether its file has the triangles the other way round, as mirrored scans do.
    """

    name: str
    surface: Surface
    piece: NDArray[np.int64]
    skin: Skin | None
    inside_out: bool

    def content(self) -> Iterator[Any]:
        """The arrays that poses are made of: its surface and its colours."""
        yield from (self.surface.vertices, self.surface.triangles)
        if self.skin is not None:
            yield from (*self.skin.images, self.skin.image, self.skin.places, self.skin.corners)

    def only(self, kept: NDArray[np.bool_]) -> Scan:
        """The triangles for which (T,) `kept` says so."""
        surface = Surface(self.surface.vertices, self.surface.triangles[kept])
        skin = None if self.skin is None else self.skin.only(kept)
        return replace(self, surface=surface, piece=self.piece[kept], skin=skin)


def read_scan(source: str | Path | Mesh, *, texture: bool = True) -> Scan:
    """The scan in a file, or a mesh taken as one.

    Args:
        source: .obj (with its .mtl and images, or colours of vertices), .ply (with these), .glb,
            .gltf, .usdz and what else holds a mesh; or a mesh.
        texture: Whether its colours are wanted.

    Raises:
        FileError: It is missing or cannot be read.
        FormatError: It is damaged.
        CaptureError: It has no surface, or lacks an image that it names.
    """
    mesh = mesh_in(source)
    name = str(source) if not isinstance(source, Mesh) else mesh.name
    if not len(mesh.faces):
        raise CaptureError(
            f"{name} has {len(mesh.vertices):,} points and no polygons: make a surface of them"
            " first, as MeshLab and most scanners' own programs do"
        )
    corners = Polygons(
        np.arange(len(mesh.faces.indices), dtype=np.int32), mesh.faces.offsets
    ).triangles()
    place = _joined(mesh.vertices)
    triangles = place[mesh.faces.indices[corners]]
    vertices = np.empty((int(place.max()) + 1, 3))
    vertices[place] = mesh.vertices
    kept = _sound(vertices, triangles)
    if not kept.any():
        raise CaptureError(f"{name} has no surface: none of its polygons has an area")
    piece = _pieces(vertices, triangles, kept)
    kept &= piece >= 0
    surface = Surface(vertices, triangles[kept])
    turned = inside_out(surface)
    skin = _skin(mesh, corners[kept], name) if texture else None
    if turned:
        surface = Surface(vertices, surface.triangles[:, ::-1])
        skin = None if skin is None else skin.turned()
    return Scan(name, surface, piece[kept], skin, turned)


def require_one_head(scan: Scan) -> None:
    """Refuse two pieces of like size beside each other.

    Raises:
        CaptureError: There are two.
    """
    if scan.piece.max() < 1:
        return
    area = np.linalg.norm(scan.surface.face_normals, axis=1)
    corners = [
        scan.surface.vertices[scan.surface.triangles[scan.piece == number]].reshape(-1, 3)
        for number in (0, 1)
    ]
    low, high = (np.array([f(own, axis=0) for own in corners]) for f in (np.min, np.max))
    apart = (low.max(axis=0) > high.min(axis=0)).any()
    sides = np.sort(high - low, axis=1)
    sizes = [area[scan.piece == number].sum() for number in (0, 1)]
    alike = sides.min(axis=0) > _ALIKE * sides.max(axis=0)
    if apart and alike.all() and sizes[1] > _ALIKE * sizes[0]:
        raise CaptureError(
            f"{scan.name} has two pieces of like size beside each other: leave one head in it, or"
            " give landmarks on the one that is meant"
        )


def mesh_in(source: str | Path | Mesh) -> Mesh:
    """The mesh in a file, the neutral of a rig in one; or a mesh as it is.

    Raises:
        FileError: It is missing or cannot be read.
        FormatError: It is damaged, or no such file.
    """
    if isinstance(source, Mesh):
        return source
    require_name(source)
    if Path(source).suffix.lower() not in KNOWN:
        raise FormatError(source, f"a scan is a file with one of the suffixes {', '.join(KNOWN)}")
    return read_template(source)


def _skin(mesh: Mesh, corners: NDArray[np.integer], name: str) -> Skin | None:
    """The colours of a scan: its images, and where it shows none those of its vertices."""
    skin = skin_of(dressed(mesh), corners, name, vertex_colours(mesh))
    if skin is None and mesh.material_library and mesh.uv is not None and not library_of(mesh):
        warn(
            f"{mesh.name}: its materials ({mesh.material_library}) are not beside it, so it has no"
            " colours by which skin could be followed"
        )
    return skin


def _joined(vertices: Points) -> NDArray[np.int64]:
    """(V,) the same number for vertices at the same place."""
    order = np.lexsort(vertices.T)
    ordered = vertices[order]
    new = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))
    number = np.empty(len(vertices), dtype=np.int64)
    number[order] = np.cumsum(new) - 1
    return number


def _sound(vertices: Points, triangles: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(T,) which triangles have an area, and are the first of their corners."""
    a, b, c = triangles.T
    kept = (a != b) & (b != c) & (c != a)
    area = np.linalg.norm(Surface(vertices, triangles).face_normals, axis=1)
    kept = kept & (area > 0)
    ordered = np.sort(triangles, axis=1)
    order = np.lexsort(ordered.T)
    repeated = (ordered[order[1:]] == ordered[order[:-1]]).all(axis=1)
    kept[order[1:][repeated]] = False
    return np.asarray(kept)


def _pieces(
    vertices: Points, triangles: NDArray[np.int64], kept: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """(T,) number of the piece of each triangle, by falling area; -1 of crumbs and the rest."""
    own = triangles[kept]
    part = component_of(len(vertices), sides_of(own))[own[:, 0]]
    area = np.bincount(part, np.linalg.norm(Surface(vertices, own).face_normals, axis=1))
    order = np.argsort(-area, kind="stable")
    rank = np.empty(len(area), dtype=np.int64)
    rank[order] = np.arange(len(area))
    rank[area < _CRUMB * area.max()] = -1
    found = np.full(len(triangles), -1)
    found[kept] = rank[part]
    return found
