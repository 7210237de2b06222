"""What a painter of heads works with: points under texels, light in creases, soft strokes, PNG."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw
from scipy.interpolate import CubicSpline
from scipy.ndimage import distance_transform_edt

from elastomorph.model.mesh import FaceLabels, Mesh, UVMap

__all__ = [
    "Floats", "chosen", "corners_of", "drawn", "encoded", "mix", "openness", "picture_of", "places",
    "rasterised", "shrunk", "spline", "step", "stroke", "texture_coordinates",
]  # fmt: skip

Floats = NDArray[np.float64]

FINER = 4  # pixels of a drawing for one of the image, so that hairs have soft edges
RAYS, FAR, LIFT = 96, 3.0, 0.02  # a vertex; how far and from how high in cm they look


def texture_coordinates(mesh: Mesh) -> UVMap:
    """Take those of a mesh that has some."""
    if mesh.uv is None:
        raise ValueError("the mesh has no texture coordinates")
    return mesh.uv


def chosen(part: FaceLabels, *names: str) -> NDArray[np.bool_]:
    """(F,) which polygons have one of these labels."""
    known = np.array([name in names for name in part.names])
    return np.asarray(known[part.of_face])


def corners_of(mesh: Mesh, polygons: NDArray[np.bool_]) -> NDArray[np.int32]:
    """(N,) the vertices at the corners of polygons."""
    return np.asarray(mesh.faces.indices[polygons[mesh.faces.corner_faces]])


def places(mesh: Mesh, vertices: tuple[int, ...]) -> Floats:
    """(N, 2) texture coordinates of vertices that have but one each."""
    uv = texture_coordinates(mesh)
    first = [int(np.flatnonzero(mesh.faces.indices == vertex)[0]) for vertex in vertices]
    return np.asarray(uv.coordinates[uv.corners[first], :2])


def rasterised(
    mesh: Mesh, polygons: NDArray[np.bool_], values: Floats, side: int, *, filled: bool = True
) -> Floats:
    """(side, side, K) values (V, K) of vertices where polygons lie in their tile of an image.

    Beside them is what is nearest, so that smaller images mix nothing else in at a seam; without
    ``filled`` there is no number.
    """
    uv, corners = texture_coordinates(mesh), mesh.faces.triangle_corners()
    own = corners[polygons[mesh.faces.corner_faces[corners[:, 0]]]]
    at = uv.coordinates[uv.corners[own], :2]
    at = (at - [np.floor(at[..., 0].min()), 0]) * [side, -side] + [-0.5, side - 0.5]
    found = np.full((side, side, values.shape[1]), np.nan)
    for (a, b, c), known in zip(at, values[mesh.faces.indices[own]], strict=True):
        low = np.maximum(np.ceil(np.minimum(np.minimum(a, b), c)), 0).astype(int)
        high = np.minimum(np.floor(np.maximum(np.maximum(a, b), c)), side - 1).astype(int)
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if (high < low).any() or area == 0:
            continue
        x, y = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        s = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
        t = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
        inside = (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1 + 1e-9)
        s, t = s[inside], t[inside]
        found[y[inside], x[inside]] = np.stack([1 - s - t, s, t], axis=1) @ known
    if filled:
        beside = np.isnan(found[..., 0])
        near = distance_transform_edt(beside, return_distances=False, return_indices=True)
        found = found[near[0], near[1]]
    return found


def openness(mesh: Mesh, seen: NDArray[np.bool_], solid: NDArray[np.bool_], seed: int) -> Floats:
    """(V,) how much of the light from around reaches vertices, from 0 to 1; 1 where not asked.

    Args:
        mesh: Its unit is the centimetre.
        seen: (F,) the polygons whose vertices are asked for.
        solid: (F,) the polygons that light does not pass.
        seed: Of the directions.
    """
    corners = mesh.faces.triangle_corners()
    triangles = mesh.faces.indices[corners[solid[mesh.faces.corner_faces[corners[:, 0]]]]]
    scene = EmbreeScene()
    vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float32)
    TriangleMesh(scene, vertices, np.ascontiguousarray(triangles, dtype=np.int32))
    a, b, c = mesh.vertices[triangles].swapaxes(0, 1)
    normals = np.zeros_like(mesh.vertices)
    for corner in triangles.T:
        np.add.at(normals, corner, np.cross(b - a, c - a))
    own = np.unique(corners_of(mesh, seen))
    ahead = normals[own] / np.maximum(np.linalg.norm(normals[own], axis=1), 1e-12)[:, None]
    starts = (mesh.vertices[own] + LIFT * ahead).astype(np.float32)
    random, free = np.random.default_rng([seed]), np.zeros(len(own))
    for _ in range(RAYS):  # normal and a point of the unit sphere add up to as a cosine lets in
        aim = random.normal(size=(len(own), 3))
        aim = ahead + 0.999 * aim / np.linalg.norm(aim, axis=1)[:, None]
        aim /= np.linalg.norm(aim, axis=1)[:, None]
        reach = np.full(len(own), FAR, dtype=np.float32)
        free += scene.run(starts, aim.astype(np.float32), dists=reach) < 0
    found = np.ones(len(mesh.vertices))
    found[own] = free / RAYS
    return found


def picture_of(side: int) -> tuple[Image.Image, ImageDraw.ImageDraw]:
    """A black drawing for an image of so many pixels, and what draws on it."""
    picture = Image.new("L", (side * FINER, side * FINER))
    return picture, ImageDraw.Draw(picture)


def shrunk(picture: Image.Image) -> Floats:
    """(side, side) from 0 to 1 of a drawing."""
    side = picture.width // FINER
    return np.asarray(picture.resize((side, side), Image.Resampling.BOX)) / 255.0


def drawn(at: Floats, picture: Image.Image) -> list[tuple[float, float]]:
    """Texture coordinates as pixels of a drawing."""
    side = picture.width
    return [(x * side, (1 - y) * side) for x, y in at.tolist()]


def stroke(
    picture: Image.Image, start: Floats, ahead: Floats, bend: Floats, width: float, fill: int
) -> None:
    """Draw a hair from its root to its point, in texture coordinates; bend moves the middle."""
    t = np.linspace(0, 1, 7)[:, None]
    middle = start + t * ahead + 4 * t * (1 - t) * bend
    along = np.gradient(middle, axis=0)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across /= np.maximum(np.linalg.norm(across, axis=1)[:, None], 1e-12)
    across *= width / 2 / picture.width * (1 - t**1.5) * np.minimum(0.3 + 4 * t, 1)
    outline = np.concatenate([middle + across, (middle - across)[::-1]])
    ImageDraw.Draw(picture).polygon(drawn(outline, picture), fill=fill)


def spline(points: Floats, count: int, *, closed: bool = False) -> Floats:
    """(count, 2) points of a smooth curve through some."""
    if closed:
        points = np.concatenate([points, points[:1]])
    lengths = np.append(0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    curve = CubicSpline(lengths, points, bc_type="periodic" if closed else "natural")
    return np.asarray(curve(np.linspace(0, lengths[-1], count)))


def mix(one: ArrayLike, other: ArrayLike, share: ArrayLike) -> Floats:
    """Colours (…, 3) between two, by a share (…)."""
    first, weight = np.asarray(one, dtype=np.float64), np.asarray(share)[..., None]
    return np.asarray(first + (np.asarray(other) - first) * weight)


def step(values: Floats, start: float, stop: float) -> Floats:
    """0 before start, 1 beyond stop, smooth between."""
    s = np.clip((values - start) / (stop - start), 0.0, 1.0)
    return np.asarray(s * s * (3 - 2 * s))


def encoded(image: Floats, name: str) -> bytes:
    """The content of an image file, by its name, of (H, W, 3 or 4) numbers from 0 to 255."""
    file = BytesIO()
    picture = Image.fromarray(np.clip(np.rint(image), 0, 255).astype(np.uint8))
    if name.endswith(".jpg"):
        picture.save(file, "JPEG", quality=92, subsampling=0, optimize=True)
    else:
        picture.save(file, "PNG", optimize=True, compress_level=9)
    return file.getvalue()
