"""The edges of a mesh drawn over a photograph, as its own camera sees them.

Whether a surface is where the face is, and its vertices where features are, is seen at a glance;
lines that the surface hides are left out. Needs what the extra ``capture`` brings.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.capturing.geometry import Camera, Surface
from elastomorph.draw.pictures import RGB, Image, colour_bytes
from elastomorph.model.mesh import Mesh

Box = tuple[int, int, int, int]
"""Left, top, right and bottom of a part of a photograph in pixels, the last two outside."""

LINE = (0.25, 0.88, 1.0)
_PIECE = 3.0  # pixels between the places at which a line is looked for
_NEAR = 2e-3  # of the size of the mesh: what lies on the surface is not behind it
_DENSE, _OPEN = 4.0, 14.0  # pixels of an edge from which lines would cover the skin, or are few
_FAINTEST, _STRONGEST = 0.3, 0.85
_SHADES = 16  # of colours between vertices
_BORDER = 4  # pixels
_SHIFT = 4  # bits of a pixel that OpenCV draws lines to


def over_photograph(
    photograph: Image,
    camera: Camera,
    mesh: Mesh,
    *,
    colours: ArrayLike | None = None,
    line: RGB = LINE,
    strength: float | None = None,
    width: int = 1,
    box: Box | None = None,
) -> Image:
    """A photograph with the edges of a mesh over it.

    Args:
        photograph: (H, W, 3) uint8 without distortion, as from
            `elastomorph.capturing.geometry.open_colours`.
        camera: That took it.
        mesh: In the frame of the camera's world.
        colours: (V, 3) red, green, blue of each vertex from 0 to 1, as from
            `elastomorph.draw.heat_colours`; edges have the mean of their ends'.
        line: Colour of the lines where vertices have none.
        strength: How much lines cover, from 0 to 1; by default less where edges are short.
        width: Of the lines in pixels.
        box: The part of the photograph that is wanted, as from `box_of`.

    Returns:
        (H, W, 3) uint8, the photograph or the part of it.
    """
    import cv2

    left, top, right, bottom = box or (0, 0, *camera.size)
    picture = photograph[top:bottom, left:right].copy()
    starts, ends, edges = _seen_pieces(camera, mesh)
    if strength is None:
        strength = _strength(camera, mesh)
    painted = np.broadcast_to((np.array(line) * 255).round().astype(np.uint8), (len(edges), 3))
    if colours is not None:
        ends_of = colour_bytes(colours, len(mesh.vertices))[mesh.edges[edges]].mean(axis=1)
        painted = (np.round(ends_of / 255 * _SHADES) * (255 / _SHADES)).round().astype(np.uint8)
    # OpenCV counts from the middle of the first pixel, as cameras here do. It draws lines otherwise
    # where it cuts them off.
    pieces = np.stack([starts, ends], axis=1) - (left, top) + _BORDER
    pieces = np.round(pieces * (1 << _SHIFT)).astype(np.int32)
    flat = picture.reshape(-1, 3)
    shades, of_piece = np.unique(painted, axis=0, return_inverse=True)
    for number, shade in enumerate(shades):
        cover = np.zeros(np.array(picture.shape[:2]) + 2 * _BORDER, np.uint8)
        own = list(pieces[of_piece.reshape(-1) == number])
        cv2.polylines(cover, own, False, 255, width, cv2.LINE_AA, _SHIFT)
        inner = cover[_BORDER:-_BORDER, _BORDER:-_BORDER].ravel()
        drawn = np.flatnonzero(inner)
        share = (strength / 255) * inner[drawn, None]
        flat[drawn] = np.round(flat[drawn] * (1 - share) + shade * share).astype(np.uint8)
    return picture


def box_of(camera: Camera, points: NDArray[np.float64], margin: float = 0.06) -> Box:
    """The part of a photograph in which points are seen, and a margin around it.

    Args:
        camera: Of the photograph.
        points: (N, 3); those behind the camera do not count.
        margin: As a fraction of the longer side of the box.
    """
    pixels, depths = camera.project(points)
    pixels = pixels[depths > 0]
    last = np.array(camera.size)
    if not len(pixels):
        return 0, 0, int(last[0]), int(last[1])
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    border = margin * float((high - low).max())
    left, top = np.clip(np.floor(low - border), 0, last - 1).astype(int)
    right, bottom = np.clip(np.ceil(high + border) + 1, [left + 1, top + 1], last).astype(int)
    return int(left), int(top), int(right), int(bottom)


def _seen_pieces(
    camera: Camera, mesh: Mesh
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Pixels where the visible pieces of edges start and end, and the edge of each."""
    pixels, depths = camera.project(mesh.vertices)
    ahead = depths > 0
    edges = np.flatnonzero(ahead[mesh.edges].all(axis=1))
    edges = edges[_within(camera, pixels[mesh.edges[edges]])]
    one, other = mesh.vertices[mesh.edges[edges]].swapaxes(0, 1)
    lengths = np.linalg.norm(np.diff(pixels[mesh.edges[edges]], axis=1)[:, 0], axis=1)
    longest = float(max(camera.size))
    count = np.ceil(np.minimum(lengths, longest) / _PIECE).astype(np.int64) + 1
    first = np.cumsum(count + 1) - (count + 1)
    number = np.repeat(np.arange(len(edges)), count + 1)
    step = np.arange(len(number)) - first[number]
    share = (step / count[number])[:, None]
    points = (1 - share) * one[number] + share * other[number]
    seen = _unhidden(camera, mesh, points)
    places = camera.project(points)[0]
    joined = (step[1:] > 0) & seen[1:] & seen[:-1]
    return places[:-1][joined], places[1:][joined], edges[number[1:][joined]]


def _within(camera: Camera, ends: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which (E, 2, 2) lines may be in the photograph."""
    low, high = ends.min(axis=1), ends.max(axis=1)
    return np.asarray(((high >= 0) & (low <= np.array(camera.size) - 1)).all(axis=1))


def _unhidden(camera: Camera, mesh: Mesh, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points on the surface nothing stands before."""
    if not len(points):
        return np.zeros(0, bool)
    surface = Surface(mesh.vertices, mesh.faces.triangles())
    away = points - camera.position
    far = np.linalg.norm(away, axis=1)
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    hits = surface.cast(camera.position, away / far[:, None])
    return np.asarray(hits.depths > far - _NEAR * size)


def _strength(camera: Camera, mesh: Mesh) -> float:
    """Less where edges are short in the photograph, for the skin to be seen between them."""
    pixels, depths = camera.project(mesh.vertices)
    edges = mesh.edges[(depths > 0)[mesh.edges].all(axis=1)]
    if not len(edges):
        return _STRONGEST
    length = float(np.median(np.linalg.norm(pixels[edges[:, 0]] - pixels[edges[:, 1]], axis=1)))
    share = np.clip((length - _DENSE) / (_OPEN - _DENSE), 0, 1)
    return float(_FAINTEST + share * (_STRONGEST - _FAINTEST))
