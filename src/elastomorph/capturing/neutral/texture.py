"""The colours of the neutral in the texture coordinates of the template, from its photographs.

Each texel is a point of the surface. Photographs that see it, as rays tell, are blended: one counts
by how many of its pixels a piece of skin has there, which is by angle and distance, and less where
something that hides skin begins. Their exposures are brought together first, and colours that most
do not share, such as highlights, count less. Light and shade that all have in common stay.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera, open_colours
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.model.mesh import Mesh

Points = NDArray[np.float64]

_LEAST_COSINE = 0.2
_BEFORE = 0.002  # of the diameter: what may stand before skin without hiding it, for rounding
_SHARPER = 2  # power by which more pixels count more
_FEATHER = 12  # texels over which a photograph fades out towards what is hidden from it
_EDGE = 2.0  # texels from there that it does not count for: its pixels show what hides them too
_BORDER = 4.0  # px of a photograph that are not used
_UNLIKE = 12.0  # of 255: a colour this far from the mean counts half
_COMPARED = 5000  # texels by which exposures are compared
_SIDES = (256, 2048)  # texels, smallest and largest
_LONGEST = 2400  # px of a photograph, as it is opened everywhere


@dataclass(frozen=True, eq=False)
class Painted:
    """An image in texture coordinates.

    Attributes:
        image: (S, S, 3) uint8 sRGB, the row of v = 1 first; filled in where nothing is seen.
        seen: (S, S) whether any camera saw the skin there.
        shown: (S, S) whether there is any skin.
    """

    image: NDArray[np.uint8]
    seen: NDArray[np.bool_]
    shown: NDArray[np.bool_]


def paint(
    mesh: Mesh,
    surface: Surface,
    place: NDArray[np.int64],
    cameras: Sequence[Camera],
    photographs: Mapping[str, Path],
    *,
    say: Callable[[str, float], None] = lambda text, part: None,
) -> dict[str, Painted]:
    """Material → its image; those that no camera sees are left out.

    Args:
        mesh: The template, with texture coordinates; without materials it is one, ''.
        surface: It, without seams, on the neutral.
        place: (V,) the vertex of the surface that each vertex of the mesh is.
        cameras: Of the neutral.
        photographs: Camera → its file.
        say: Told what is being done and the part of it that is done.
    """
    if mesh.uv is None:
        return {}
    corners = mesh.faces.triangle_corners()
    corners = corners[(mesh.uv.corners[corners] >= 0).all(axis=1)]
    label = np.zeros(len(corners), dtype=np.int64)
    names: Sequence[str] = ("",)
    if mesh.materials is not None:
        label = mesh.materials.of_face[mesh.faces.corner_faces[corners[:, 0]]].astype(np.int64)
        names = mesh.materials.names
    painted = {}
    # One after the other: the texels of all materials of a production head fill gigabytes.
    for number, name in enumerate(names):
        own = corners[label == number]
        if not len(own):
            continue
        uv = mesh.uv.coordinates[mesh.uv.corners[own]][..., :2]
        uv = uv - np.floor(uv.mean(axis=1, keepdims=True))  # images repeat: tiles are one
        chart = _Chart(uv, place[mesh.faces.indices[own]], surface, cameras)
        for k, camera in enumerate(cameras):
            say(f"colours of {name or 'the neutral'}", (number + k / len(cameras)) / len(names))
            chart.add(camera, photographs[camera.name])
        if chart.seen.any():
            painted[name] = chart.painted()
    return painted


class _Chart:
    """The texels of one material: where each is, and what photographs show of it."""

    def __init__(
        self,
        uv: Points,
        triangles: NDArray[np.int64],
        surface: Surface,
        cameras: Sequence[Camera],
    ) -> None:
        self.surface = surface
        flat, lying = Surface(surface.vertices, triangles), uv.reshape(-1, 2)
        self.side = _side(flat, lying, cameras)
        # Texels are where rays through their centres meet the triangles laid out flat.
        laid = np.zeros((len(lying), 3))
        laid[:, 0], laid[:, 1] = self.side * lying[:, 0], self.side * (1 - lying[:, 1])
        sheet = Surface(laid, np.arange(len(laid)).reshape(-1, 3))
        centres = np.stack(np.meshgrid(*[np.arange(self.side) + 0.5] * 2), axis=-1)
        starts = np.concatenate([centres, np.full((*centres.shape[:2], 1), -1.0)], axis=-1)
        hits = sheet.cast(starts, np.broadcast_to([0.0, 0.0, 1.0], starts.shape))
        self.shown = hits.met
        corners = triangles[hits.triangles[self.shown]].T
        weights = hits.weights[self.shown].T[..., None]
        self.points, normals = (
            sum(weight * values[own] for weight, own in zip(weights, corners, strict=True))
            for values in (surface.vertices, surface.normals)
        )
        self.normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        self.seen = np.zeros(len(self.points), dtype=bool)
        self.samples: list[tuple[NDArray[np.int32], NDArray[np.uint8], NDArray[np.float32]]] = []
        self.before = _BEFORE * float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))

    def add(self, camera: Camera, photograph: Path) -> None:
        """What a photograph shows."""
        import cv2

        original, scale = camera, min(1.0, _LONGEST / max(camera.size))
        camera = original.without_distortion(scale)
        visible, cosines = self.surface.visible(
            camera,
            self.points,
            self.normals,
            least_cosine=_LEAST_COSINE,
            tolerance=self.before,
            border=_BORDER,
        )
        open_to = np.ones((self.side, self.side), dtype=np.uint8)
        open_to[self.shown] = visible
        away = cv2.distanceTransform(open_to, cv2.DIST_L2, 3)[self.shown] - _EDGE
        which = np.flatnonzero(away > 0)
        if not len(which):
            return
        _, colours = open_colours(original, photograph, scale=scale)
        pixels, depths = camera.project(self.points[which])
        x, y = pixels.astype(np.float32).T
        # OpenCV takes rows of fewer than 2^15: texels are looked up 4,096 at a time.
        found = [
            cv2.remap(colours, x[None, part], y[None, part], cv2.INTER_LINEAR)[0]
            for part in np.array_split(np.arange(len(which)), len(which) // 4096 + 1)
        ]
        fine = cosines[which] * (camera.focal / depths) ** 2
        weights = fine**_SHARPER * np.minimum(away[which] / _FEATHER, 1.0)
        rgb = np.concatenate(found)
        self.samples.append((which.astype(np.int32), rgb, weights.astype(np.float32)))
        self.seen[which] = True

    def painted(self) -> Painted:
        """The photographs blended."""
        gains = self._gains()
        colours = self._mean(gains, self._mean(gains))
        image = np.zeros((self.side, self.side, 3), dtype=np.float32)
        image[self.shown] = colours
        seen = np.zeros((self.side, self.side), dtype=bool)
        seen[self.shown] = self.seen
        whole = np.clip(np.round(_filled(image, seen)), 0, 255).astype(np.uint8)
        return Painted(whole, seen, self.shown)

    def _gains(self) -> NDArray[np.float32]:
        """(N, 3) what brings photographs to one exposure and white balance, 1 in the middle.

        Where i and j show the same skin, log gᵢ - log gⱼ is the median of log cⱼ - log cᵢ.
        """
        count, step = len(self.samples), len(self.points) // _COMPARED + 1
        logs = np.full((count, len(self.points) // step + 1, 3), np.nan)
        for own, (which, colours, _) in zip(logs, self.samples, strict=True):
            some = which % step == 0
            own[which[some] // step] = np.log(np.maximum(colours[some], 1.0))
        rows, ratios = [np.ones(count)], [np.zeros(3)]
        for i, j in combinations(range(count), 2):
            both = np.isfinite(logs[i, :, 0] + logs[j, :, 0])
            if both.any():
                weight = np.sqrt(np.count_nonzero(both))
                rows.append(weight * (np.eye(count)[i] - np.eye(count)[j]))
                ratios.append(weight * np.median((logs[j] - logs[i])[both], axis=0))
        gains = np.exp(np.linalg.lstsq(np.array(rows), np.array(ratios), rcond=None)[0])
        return np.asarray(gains, dtype=np.float32)

    def _mean(
        self, gains: NDArray[np.float32], rough: NDArray[np.float32] | None = None
    ) -> NDArray[np.float32]:
        """(N, 3) colours of the texels; what is unlike a rough mean counts less."""
        total = np.zeros((len(self.points), 4), dtype=np.float32)
        for gain, (which, colours, weights) in zip(gains, self.samples, strict=True):
            own = colours * gain
            if rough is not None:
                weights = weights / (1 + ((own - rough[which]) ** 2).sum(axis=1) / _UNLIKE**2)
            total[which, :3] += weights[:, None] * own
            total[which, 3] += weights
        return np.asarray(total[:, :3] / np.maximum(total[:, 3:], 1e-30), dtype=np.float32)


def _side(flat: Surface, uv: Points, cameras: Sequence[Camera]) -> int:
    """Texels to a side, a power of two: about as fine as the photographs are."""
    area = np.linalg.norm(flat.face_normals, axis=1).sum()
    a, b, c = np.moveaxis(uv.reshape(-1, 3, 2), 1, 0)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    of_image = np.abs(ux * vy - uy * vx).sum()
    middle = flat.vertices[flat.triangles].mean(axis=(0, 1))
    finest = [camera.focal / np.linalg.norm(middle - camera.position) for camera in cameras]
    texels = np.median(finest) * np.sqrt(area / max(of_image, 1e-30))
    return int(np.clip(2 ** np.round(np.log2(max(texels, 1.0))), *_SIDES))


def _filled(image: NDArray[np.float32], known: NDArray[np.bool_]) -> NDArray[np.float32]:
    """What is not known of an image, from what is around it, coarser the farther that is."""
    import cv2

    if known.all() or not known.any() or len(image) < 2:
        return image
    weight = known.astype(np.float32)
    half = (len(image) // 2, len(image) // 2)
    counts: Any = cv2.resize(weight, half, interpolation=cv2.INTER_AREA)
    sums: Any = cv2.resize(image * weight[..., None], half, interpolation=cv2.INTER_AREA)
    means = np.asarray(sums / np.maximum(counts, 1e-6)[..., None], dtype=np.float32)
    small: Any = _filled(means, counts > 0)
    around: Any = cv2.resize(small, image.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    return np.where(known[..., None], image, around)
