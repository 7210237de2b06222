"""One posed subject before one camera: where both and the lamp are, and what rays meet.

The world is that of the rig at rest, looking along +Z with +Y up. A camera's own axes are x to the
right, y down and z away from it (as in OpenCV); pixel centres are at whole numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.surface import Surface
from elastomorph.draw.textures import linear
from elastomorph.farm.pictures.settings import SETTINGS
from elastomorph.farm.pictures.subject import MASKED, OPAQUE, Subject

Matrix = NDArray[np.float64]

_TO_SRGB = np.array(  # linear sRGB of CIE XYZ (IEC 61966-2-1)
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)
_ADAPTED = 0.6
"""How far a camera's white balance follows the lamp: a photograph by a bulb is less yellow."""
_DAYLIGHT = 6504.0


@dataclass(frozen=True, eq=False)
class Frame:
    """What columns count from: the pivot of the head at rest, and D.

    Attributes:
        pivot: (3,) the middle of what the targets move.
        extent: D, in units of the rig.
        size: Height and width of pictures in pixels.
    """

    pivot: Matrix
    extent: float
    size: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Scene:
    """One picture before it is drawn.

    Attributes:
        head: (3, 4) from the rig's coordinates to the world's.
        camera: (3, 4) from the world's to the camera's.
        intrinsics: (3, 3) to pixels.
        lamp: (3,) unit vector to the lamp, in the camera's axes.
        above: (3,) the world's up, in the camera's axes.
        light: (3,) of the lamp, linear.
        ambient: (3,) from all around, linear.
        background: (3,) linear.
    """

    head: Matrix
    camera: Matrix
    intrinsics: Matrix
    lamp: Matrix
    above: Matrix
    light: Matrix
    ambient: Matrix
    background: Matrix

    def seen(self, positions: NDArray[np.floating]) -> Matrix:
        """(V, 3) in the camera's axes, of positions of the rig."""
        turn = self.camera[:, :3] @ self.head[:, :3]
        shift = self.camera[:, :3] @ self.head[:, 3] + self.camera[:, 3]
        # Sums of three, not a product of matrices, which libraries add up in orders of their own.
        x, y, z = positions.astype(np.float64).T
        return np.stack([x * row[0] + y * row[1] + z * row[2] for row in turn], axis=1) + shift

    def pixels(self, seen: Matrix) -> Matrix:
        """(V, 2) x and y in the picture of (V, 3) points in the camera's axes."""
        focal, (x, y) = self.intrinsics[0, 0], self.intrinsics[:2, 2]
        depth = np.where(seen[:, 2] > 0, seen[:, 2], np.nan)
        return np.stack([seen[:, 0] / depth * focal + x, seen[:, 1] / depth * focal + y], axis=1)

    def slopes(self, places: NDArray[np.floating]) -> Matrix:
        """(N, 2) right and down for each length of depth, of rays through (N, 2) places."""
        return np.asarray((places - self.intrinsics[:2, 2]) / self.intrinsics[0, 0])


def scene_of(frame: Frame, values: Mapping[str, float]) -> Scene:
    """The scene that the values of columns say; those that are missing are at rest."""
    said = {name: float(values.get(name, own.rest)) for name, own in SETTINGS.items()}

    def triple(section: str, *names: str) -> Matrix:
        return np.array([said[f"{section}.{name}"] for name in names])

    yaw, pitch, roll = np.radians(triple("head", "yaw", "pitch", "roll"))
    turn = _about(1, yaw) @ _about(0, -pitch) @ _about(2, -roll)
    place = frame.pivot + frame.extent * triple("head", "x", "y", "z")
    azimuth, elevation, tilt = np.radians(triple("camera", "azimuth", "elevation", "roll"))
    back = _towards(azimuth, elevation)
    right = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    axes = _about(2, tilt) @ np.stack([right, -np.cross(back, right), -back])
    distance = said["camera.distance"]
    eye = frame.pivot + distance * frame.extent * back
    height, width = frame.size
    x, y = triple("camera", "x", "y")
    focal = said["camera.fill"] * distance * height
    centre = (width - 1) / 2 + x * height, (height - 1) / 2 + y * height
    colour = lamp_colour(said["light.temperature"])
    lamp = _towards(*np.radians(triple("light", "azimuth", "elevation")))
    return Scene(
        head=np.column_stack([turn, place - turn @ frame.pivot]),
        camera=np.column_stack([axes, -axes @ eye]),
        intrinsics=np.array([[focal, 0, centre[0]], [0, focal, centre[1]], [0, 0, 1]]),
        lamp=axes @ lamp,
        above=axes[:, 1],
        light=said["light.strength"] * colour,
        # What comes from all around has come off walls: half of its tint is gone.
        ambient=said["light.ambient"] * (1 + colour) / 2,
        background=linear(triple("background", "red", "green", "blue")),
    )


def lamp_colour(kelvin: float) -> Matrix:
    """(3,) linear sRGB of a black body as a camera shows it, of the same brightness as white.

    The chromaticity is the cubic fit of Kim et al. (US patent 7,024,034), from 1,667 to 25,000 K.
    """
    own = _black_body(kelvin) / _black_body(_DAYLIGHT)
    own = np.maximum(own, 0.0) ** (1 - _ADAPTED)
    return np.asarray(own / (own @ [0.2126, 0.7152, 0.0722]))


def _black_body(kelvin: float) -> Matrix:
    t = 1000.0 / kelvin
    if kelvin <= 4000:
        x = -0.2661239 * t**3 - 0.2343589 * t**2 + 0.8776956 * t + 0.179910
    else:
        x = -3.0258469 * t**3 + 2.1070379 * t**2 + 0.2226347 * t + 0.240390
    if kelvin <= 2222:
        y = -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
    elif kelvin <= 4000:
        y = -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    return np.asarray(np.maximum(_TO_SRGB @ [x / y, 1.0, (1 - x - y) / y], 1e-3))


def _towards(azimuth: float, elevation: float) -> Matrix:
    """(3,) the direction so many radians to the face's left and up."""
    flat = np.cos(elevation)
    return np.array([np.sin(azimuth) * flat, np.sin(elevation), np.cos(azimuth) * flat])


def _about(axis: int, angle: float) -> Matrix:
    """(3, 3) the turn by an angle about x, y or z, by the right hand."""
    turn = np.eye(3)
    one, other = (axis + 1) % 3, (axis + 2) % 3
    turn[[one, other], [one, other]] = np.cos(angle)
    turn[other, one], turn[one, other] = np.sin(angle), -np.sin(angle)
    return turn


_MOST_LAYERS = 24
"""Of what lets rays through, one behind another; hair of cards has a dozen."""
_ON = 3e-6
"""Of the distance, by which a ray that goes on starts behind what it has met."""
_SOLID = 0.995  # opacity from which nothing is seen through what blends
_LABELLED = 0.5  # opacity from which labels are those of what blends


@dataclass(frozen=True, eq=False)
class Points:
    """Points of the subject.

    Attributes:
        triangle: (N,) of the subject.
        weights: (N, 3) float32 of its corners.
        position: (N, 3) in the camera's axes.
        normal: (N, 3) float32 unit normals there, towards the camera.
    """

    triangle: NDArray[np.int64]
    weights: NDArray[np.float32]
    position: NDArray[np.float64]
    normal: NDArray[np.float32]

    def only(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Points:
        """Those of (N,) that are chosen."""
        return Points(
            self.triangle[chosen], self.weights[chosen], self.position[chosen], self.normal[chosen]
        )

    @classmethod
    def joined(cls, points: Sequence[Points]) -> Points:
        """All of them, one after another."""
        fields = ("triangle", "weights", "position", "normal")
        return cls(*(np.concatenate([getattr(own, name) for own in points]) for name in fields))


@dataclass(frozen=True, eq=False)
class Veil:
    """What shines through, met first, second or third …: rays, rising, and a point for each."""

    ray: NDArray[np.int64]
    points: Points


@dataclass(frozen=True, eq=False)
class Seen:
    """What N rays meet.

    Attributes:
        ray: (M,) those that end on something solid, rising.
        points: M, where.
        veils: What is before that, from the nearest to the farthest.
    """

    ray: NDArray[np.int64]
    points: Points
    veils: tuple[Veil, ...]


@dataclass(frozen=True, eq=False)
class _Met:
    depth: NDArray[np.float64]
    triangle: NDArray[np.int64]
    weights: NDArray[np.float32]


def mixed(weights: NDArray[np.float32], values: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, K) means of (N, 3, K) values with (N, 3) weights."""
    return np.asarray(np.einsum("ni,nik->nk", weights, values))


class View:
    """A subject with (V, 3) positions of the rig, in a scene.

    Attributes:
        seen: (V, 3) positions in the camera's axes.
        places: (V, 2) x and y in the picture.
    """

    def __init__(self, subject: Subject, positions: NDArray[np.floating], scene: Scene) -> None:
        self.subject, self.scene = subject, scene
        self.seen = scene.seen(positions)
        self.places = scene.pixels(self.seen)
        self.normals = subject.normals(self.seen)
        self._solid = np.flatnonzero(subject.opacity == OPAQUE)
        self._thin = np.flatnonzero(subject.opacity != OPAQUE)
        self.solid = Surface(self.seen, subject.triangles[self._solid])
        self.thin = Surface(self.seen, subject.triangles[self._thin])

    def look(self, places: NDArray[np.floating]) -> Seen:
        """What is met by rays through (N, 2) places in the picture."""
        ways = np.column_stack([self.scene.slopes(places), np.ones(len(places))])
        first = self._next(self.solid, self._solid, ways, np.zeros(len(ways)))
        layers = self._layers(ways, first) if len(self._thin) else []
        ray = np.flatnonzero(first.triangle >= 0)
        solid = self._points(first.triangle[ray], first.weights[ray])
        return Seen(ray, solid, tuple(layers))

    def labelled(self, found: Seen) -> tuple[NDArray[np.int64], Points]:
        """(K,) rays, rising, and the points that labels are of: solid, or hardly seen through."""
        ray, points = found.ray, found.points
        for veil in reversed(found.veils):
            there = self.opacity(veil.points) >= _LABELLED
            whole = Points.joined([veil.points.only(there), points])
            # Of two on a ray, the first in this order is the nearer.
            ray, kept = np.unique(np.concatenate([veil.ray[there], ray]), return_index=True)
            points = whole.only(kept)
        return ray, points

    def opacity(self, points: Points) -> NDArray[np.float32]:
        """(N,) from 0 to 1."""
        found = np.ones(len(points.triangle), dtype=np.float32)
        cloth = self.subject.cloth[points.triangle]
        for number in np.unique(cloth).tolist():
            own, mine = self.subject.cloths[number], np.flatnonzero(cloth == number)
            found[mine] = own.colour[3]
            if own.texels is not None:
                places = self.subject.places[points.triangle[mine]]
                found[mine] = own.texels.at(mixed(points.weights[mine], places))[:, 3]
        return found

    def _layers(self, ways: NDArray[np.float64], first: _Met) -> list[Veil]:
        """What blends before the solid; what is cut out, or blends with nothing, becomes solid."""
        kinds, layers = self.subject.opacity, []
        alive, after = np.arange(len(ways)), np.zeros(len(ways))
        for _ in range(_MOST_LAYERS):
            met = self._next(self.thin, self._thin, ways[alive], after)
            before = met.depth < first.depth[alive]
            alive, after = alive[before], met.depth[before]
            triangle, weights = met.triangle[before], met.weights[before]
            if not len(alive):
                break
            points = self._points(triangle, weights)
            opacity = self.opacity(points)
            cut = kinds[triangle] == MASKED
            cutoff = np.array([own.cutoff for own in self.subject.cloths])
            least = np.where(cut, cutoff[self.subject.cloth[triangle]], _SOLID)
            ends, blends = opacity >= least, ~cut & (opacity < least) & (opacity > 0)
            first.depth[alive[ends]] = after[ends]
            first.triangle[alive[ends]] = triangle[ends]
            first.weights[alive[ends]] = weights[ends]
            layers.append(Veil(alive[blends], points.only(blends)))
            alive, after = alive[~ends], after[~ends]
        return layers

    def _next(
        self,
        surface: Surface,
        own: NDArray[np.int64],
        ways: NDArray[np.float64],
        after: NDArray[np.float64],
    ) -> _Met:
        """What rays meet next behind a depth, but for the backs of what has only a front."""
        count = len(ways)
        met = _Met(np.full(count, np.inf), np.full(count, -1), np.zeros((count, 3), np.float32))
        going, start = np.arange(count), after * (1 + _ON)
        for _ in range(_MOST_LAYERS):
            if not len(going) or not len(own):
                break
            hits = surface.cast(start[:, None] * ways[going], ways[going])
            triangle = np.where(hits.met, own[np.maximum(hits.triangles, 0)], -1)
            back = hits.met & self.subject.one_sided[triangle]
            back[back] = self._turned_away(triangle[back], ways[going[back]])
            depth = start + hits.depths
            done = hits.met & ~back
            met.depth[going[done]], met.triangle[going[done]] = depth[done], triangle[done]
            met.weights[going[done]] = hits.weights[done]
            going, start = going[back], depth[back] * (1 + _ON)
        return met

    def _turned_away(
        self, triangle: NDArray[np.int64], ways: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        a, b, c = self.seen[self.subject.triangles[triangle]].transpose(1, 0, 2)
        return np.asarray(np.einsum("ni,ni->n", np.cross(b - a, c - a), ways) > 0)

    def _points(self, triangle: NDArray[np.int64], weights: NDArray[np.float32]) -> Points:
        corners = self.seen[self.subject.triangles[triangle]]
        position = np.einsum("ni,nik->nk", weights.astype(np.float64), corners)
        normal = mixed(weights, self.normals[self.subject.corners[triangle]])
        length = np.sqrt(np.einsum("ni,ni->n", normal, normal))
        away = np.einsum("ni,ni->n", normal, position) > 0
        normal *= (np.where(away, -1, 1) / np.maximum(length, 1e-20)).astype(np.float32)[:, None]
        return Points(triangle, weights, position, normal)
