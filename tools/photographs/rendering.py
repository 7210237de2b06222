"""A photograph of a posed head: rays, soft light, skin."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from photographs.backdrop import Backdrop
from photographs.cameras import Shot
from photographs.lengths import lengths
from photographs.skin import Skin

__all__ = ["Scene", "Seen", "Surface"]

_BLOCK = 1 << 14  # points shaded at a time: their arrays stay in the cache of a core
_AMBIENT, _FROM_ABOVE = 0.45, 0.15
# Large lamps: where to, how bright; light reaches around the surface as from a soft box.
_LAMPS = (((0.0, 0.5, 0.866), 0.30), ((0.85, 0.25, 0.46), 0.22), ((-0.85, 0.25, 0.46), 0.22))
_AROUND = 0.4
_GLOSS, _SHARPNESS = 0.6, 25
_REACH = 5.0  # cm within which a surface takes light from another
_RAYS = 32
_PATCH = 1.0  # cm around a vertex that a normal is taken of
_MARGIN = 8  # pixels around the vertices: a lens bends the straight edges between them


@dataclass(frozen=True, eq=False)
class Surface:
    """What does not change from pose to pose.

    Attributes:
        rest: (V, 3) vertices of the neutral, to which the texture is fixed.
        triangles: (T, 3).
        materials: (T,) of each triangle, as `photographs.skin` numbers them.
        tints: (V, 2) share of lip and of brow.
    """

    rest: NDArray[np.float64]
    triangles: NDArray[np.int32]
    materials: NDArray[np.int8]
    tints: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Seen:
    """What each sample of a photograph sees.

    Attributes:
        triangle: (H, W) int32, -1 where it is the background.
        weights: (H, W, 3) of the corners of the triangle.
    """

    triangle: NDArray[np.int32]
    weights: NDArray[np.float32]


class Scene:
    """A posed head in front of a backdrop, ready to be photographed from anywhere.

    Args:
        surface: The head.
        vertices: (V, 3) where its vertices are in the world.
        skin: Its texture.
        backdrop: What is behind.
    """

    def __init__(
        self, surface: Surface, vertices: NDArray[np.float64], skin: Skin, backdrop: Backdrop
    ) -> None:
        self.surface, self.skin, self.backdrop = surface, skin, backdrop
        self.vertices = vertices
        self._rays = EmbreeScene()
        TriangleMesh(self._rays, vertices.astype(np.float32), surface.triangles.astype(np.int32))
        self._normals = _normals(vertices, surface.triangles)
        # The last is the light around, of vertices that were photographed before.
        attributes = [surface.rest, self._normals, surface.tints, np.zeros((len(vertices), 1))]
        self._attributes = np.concatenate(attributes, axis=1).astype(np.float32)
        self._lit = np.zeros(len(vertices), dtype=bool)

    def _light(self, chosen: NDArray[np.integer]) -> None:
        """Work out the share of the light around that reaches vertices, cosine-weighted."""
        new = chosen[~self._lit[chosen]]
        vertices, normals = self.vertices[new], self._normals[new]
        sphere = np.random.default_rng(0).normal(size=(_RAYS, 3))
        sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
        start = (vertices + 0.01 * normals).astype(np.float32)
        free = np.zeros(len(vertices))
        for way in sphere:
            toward = normals + 0.999 * way
            toward /= lengths(toward)[:, None]
            distance = self._rays.run(start, toward.astype(np.float32), query="DISTANCE")
            free += np.minimum(np.asarray(distance, dtype=float) / _REACH, 1)
        self._attributes[new, -1] = free / _RAYS
        self._lit[new] = True

    def facing(self, shot: Shot, chosen: list[int], behind: float) -> NDArray[np.float64]:
        """(n,) cosine between the face around vertices and the way to a camera; -1 where hidden.

        Args:
            shot: The camera.
            chosen: (n,) vertices.
            behind: How far behind something else a vertex still counts as seen, in cm.
        """
        ways = self.vertices[chosen] - shot.position
        distances = np.linalg.norm(ways, axis=1)
        ways /= distances[:, None]
        start = np.broadcast_to(shot.position, ways.shape).astype(np.float32)
        first = self._rays.run(start, ways.astype(np.float32), query="DISTANCE")
        # The normal of a face around it, for one in a corner of an eye or a mouth looks anywhere.
        around = [
            self._normals[np.linalg.norm(self.vertices - self.vertices[one], axis=1) < _PATCH]
            for one in chosen
        ]
        normals = np.array([own.mean(axis=0) / np.linalg.norm(own.mean(axis=0)) for own in around])
        cosines = -np.einsum("na,na->n", ways, normals)
        return np.where(first > distances - behind, cosines, -1.0)

    def seen(self, shot: Shot, samples: int = 1) -> Seen:
        """What every sample of every pixel of a photograph sees."""
        return self._looked(shot, samples)[1]

    def _looked(self, shot: Shot, samples: int) -> tuple[NDArray[np.float32], Seen]:
        """(H·W, 3) ways through every sample into the world, and what each meets.

        Rays are only sent where the head is: within the box of its vertices in the photograph.
        """
        directions = shot.lens.directions(samples)
        shape = directions.shape[:2]
        ways = directions.reshape(-1, 3) @ shot.rotation.astype(np.float32)
        pixels = shot.project(self.vertices)
        low = np.floor(pixels.min(axis=0) - _MARGIN).astype(int) * samples
        high = np.ceil(pixels.max(axis=0) + _MARGIN).astype(int) * samples
        box = tuple(slice(max(0, int(low[axis])), max(0, int(high[axis]))) for axis in (1, 0))
        own = ways.reshape(*shape, 3)[box]
        triangle = np.full(shape, -1, dtype=np.int32)
        weights = np.zeros((*shape, 3), dtype=np.float32)
        rays = own.reshape(-1, 3)
        met, inside = self.met(np.broadcast_to(shot.position, rays.shape), rays)
        triangle[box], weights[box] = met.reshape(own.shape[:2]), inside.reshape(own.shape)
        return ways, Seen(triangle, weights)

    def met(
        self, starts: NDArray[np.floating], ways: NDArray[np.floating]
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """(n,) triangle that each ray meets first, -1 for none, and (n, 3) weights in it."""
        rays = (np.ascontiguousarray(part, dtype=np.float32) for part in (starts, ways))
        hits = self._rays.run(*rays, query="INTERSECT", output=True)
        weights = np.stack([1 - hits["u"] - hits["v"], hits["u"], hits["v"]], axis=-1)
        return hits["primID"], weights

    def unlit(
        self, triangle: NDArray[np.int32], weights: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """(n, 3) colour of points of triangles without light and shine."""
        corners = self._attributes[self.surface.triangles[triangle]]
        own = np.einsum("nc,nca->na", weights, corners)
        rest, tints = np.ascontiguousarray(own[:, :3]), own[:, 6:8]
        return self.skin.colours(rest, self.surface.materials[triangle], tints)[0]

    def photograph(self, shot: Shot, samples: int = 1) -> NDArray[np.float32]:
        """(H, W, 3) red, green and blue in linear light, samples of a pixel averaged."""
        ways, seen = self._looked(shot, samples)
        triangle, weights = seen.triangle.ravel(), seen.weights.reshape(-1, 3)
        shown = np.zeros(len(self.surface.triangles), dtype=bool)
        shown[triangle[triangle >= 0]] = True
        self._light(np.unique(self.surface.triangles[shown]))
        picture = np.empty((len(ways), 3), dtype=np.float32)
        for block in _blocks(triangle < 0):
            picture[block] = self.backdrop.colours(shot.position, ways.take(block, axis=0))
        for block in _blocks(triangle >= 0):
            own = (part.take(block, axis=0) for part in (triangle, weights, ways))
            picture[block] = self._shaded(*own)
        width, height = shot.lens.size
        if samples == 1:
            return picture.reshape(height, width, 3)
        each = picture.reshape(height, samples, width, samples, 3)
        parts = [each[:, down, :, across] for down in range(samples) for across in range(samples)]
        return sum(parts[1:], parts[0]) / np.float32(len(parts))

    def _shaded(
        self,
        triangle: NDArray[np.int32],
        weights: NDArray[np.float32],
        ways: NDArray[np.float32],
    ) -> NDArray[np.float32]:
        """(n, 3) light from points of triangles toward a camera that looks along ``ways``."""
        corners = self._attributes[self.surface.triangles[triangle]]
        rest, normals, tints, light = np.split(
            np.einsum("nc,nca->na", weights, corners), [3, 6, 8], axis=1
        )
        kinds = self.surface.materials[triangle]
        colour, shine = self.skin.colours(np.ascontiguousarray(rest), kinds, tints)
        return _lit(colour, shine, normals, -ways, light[:, 0])


def _normals(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.float64]:
    """(V, 3) unit normals of vertices, triangles weighted by area."""
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    faces = np.repeat(np.cross(b - a, c - a)[:, None], 3, axis=1).reshape(-1, 3)
    at = triangles.ravel()
    summed = np.stack([np.bincount(at, axis, len(vertices)) for axis in faces.T], axis=1)
    unit: NDArray[np.float64] = summed / np.maximum(
        np.linalg.norm(summed, axis=1, keepdims=True), 1e-12
    )
    return unit


def _blocks(chosen: NDArray[np.bool_]) -> Iterator[NDArray[np.int64]]:
    """Numbers of the chosen points, as many at a time as are shaded together."""
    numbers = np.flatnonzero(chosen)
    for first in range(0, len(numbers), _BLOCK):
        yield numbers[first : first + _BLOCK]


def _lit(
    colour: NDArray[np.float32],
    shine: NDArray[np.float32],
    normals: NDArray[np.float32],
    back: NDArray[np.float32],
    light: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Light off a surface: around, from lamps, and what shines."""
    normals = normals / lengths(normals)[:, None]
    back = back / lengths(back)[:, None]
    facing = np.einsum("na,na->n", normals, back)
    normals = np.where(facing[:, None] < 0, -normals, normals)
    level = _AMBIENT + _FROM_ABOVE * normals[:, 1]
    gloss = np.zeros(len(colour), dtype=np.float32)
    for toward, strength in _LAMPS:
        lamp = np.array(toward, dtype=np.float32)
        level += strength * np.maximum((normals @ lamp + _AROUND) / (1 + _AROUND), 0)
        half = lamp + back
        cosine = np.einsum("na,na->n", normals, half) / lengths(half)
        gloss += np.maximum(cosine, 0) ** _SHARPNESS
    lit: NDArray[np.float32] = colour * (level * light)[:, None]
    return lit + (_GLOSS * shine * gloss * light)[:, None]
