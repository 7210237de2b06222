"""Pictures of faces of one rig, with labels that are right to the pixel.

The colour picture of a view has materials under a lamp and under light from all around, shadows of
the lamp, hollows that are dark, smooth edges, and what shines through on top.

One posed subject before one camera: where both and the lamp are, and what rays meet.

The world is that of the rig at rest, looking along +Z with +Y up. A camera's own axes are x to the
right, y down and z away from it (as in OpenCV); pixel centres are at whole numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from elastomorph.capturing.geometry import Surface
from elastomorph.draw.materials import encoded, linear
from elastomorph.errors import ParameterError
from elastomorph.farm.pictures.settings import ARRAYS, LARGEST, SETTINGS
from elastomorph.farm.pictures.subject import MASKED, OPAQUE, PARTS, Subject
from elastomorph.rig.build import extent_of
from elastomorph.rig.rig import Rig

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


Colours = NDArray[np.float32]

_EXPOSURE = 0.9
_GROUND = 0.5  # of the light from all around that comes from below
_SOFT = np.isin(PARTS, ("skin", "lips", "gum", "tongue", "mouth", "nostril"))
_AROUND = np.array([0.28, 0.14, 0.10], dtype=np.float32)
"""How far light comes around the edge of what is lit, in skin: red farthest."""
_GLOSS = 0.55


def clothed(view: View, points: Points) -> Colours:
    """(N, 4) linear colour and opacity of points in even light, without highlights."""
    subject = view.subject
    cloth = subject.cloth[points.triangle]
    colours = np.stack([own.colour for own in subject.cloths])[cloth]
    for number, own in enumerate(subject.cloths):
        mine = np.flatnonzero(cloth == number) if own.texels is not None else cloth[:0]
        if own.texels is None or not len(mine):
            continue
        triangle = points.triangle[mine]
        places = subject.places[triangle]
        level = own.texels.level(_texels_a_pixel(view, triangle, own.texels.levels[0].shape))
        colours[mine] = own.texels.at(mixed(points.weights[mine], places), level)
    return np.asarray(colours)


def radiance(
    view: View, points: Points, lit: NDArray[np.float32], open_: NDArray[np.float32]
) -> tuple[Colours, NDArray[np.float32]]:
    """(N, 3) linear light from points to the camera, and (N,) their opacity.

    Args:
        view: What they are on.
        points: N of them.
        lit: (N,) how much of the lamp they see, see `shadows`.
        open_: (N,) how much of the light from all around, see `hollows`.
    """
    scene, subject = view.scene, view.subject
    colours = clothed(view, points)
    lamp, above = scene.lamp.astype(np.float32), scene.above.astype(np.float32)
    facing = points.normal @ lamp
    soft = np.where(_SOFT[subject.part[points.triangle]][:, None], _AROUND, np.float32(0))
    # Light that enters skin leaves it elsewhere: beyond the edge of what is lit too.
    around = np.clip((facing[:, None] + soft) / (1 + soft), 0, 1) ** (1 + soft)
    direct = around * lit[:, None] * scene.light.astype(np.float32)
    sky = (1 + _GROUND + (1 - _GROUND) * (points.normal @ above)) / 2
    even = (sky * open_)[:, None] * scene.ambient.astype(np.float32)
    shown = colours[:, :3] * (direct + even)
    shown += (_highlight(view, points, lamp) * lit)[:, None] * scene.light.astype(np.float32)
    unlit = np.array([own.unlit for own in subject.cloths])[subject.cloth[points.triangle]]
    shown = np.where(unlit[:, None], colours[:, :3], np.float32(_EXPOSURE) * shown)
    return shown, colours[:, 3]


def _highlight(view: View, points: Points, lamp: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N,) Blinn and Phong: how much of the lamp is mirrored to the camera."""
    cloth = view.subject.cloth[points.triangle]
    shine = np.array([own.shine for own in view.subject.cloths], dtype=np.float32)[cloth]
    polish = np.array([own.polish for own in view.subject.cloths], dtype=np.float32)[cloth]
    length = np.sqrt(np.einsum("ni,ni->n", points.position, points.position))
    half = lamp - points.position / length[:, None]
    half /= np.maximum(np.sqrt(np.einsum("ni,ni->n", half, half)), np.float32(1e-6))[:, None]
    mirrored = np.maximum(np.einsum("ni,ni->n", half, points.normal), 0) ** (2 * polish)
    before = np.clip(4 * (points.normal @ lamp), 0, 1)
    return np.asarray(np.float32(_GLOSS) * shine * mirrored * before)


def _texels_a_pixel(view: View, triangle: NDArray[np.int64], shape: tuple[int, ...]) -> float:
    """How many texels of an image one pixel covers, over some seen triangles."""
    corners = view.places[view.subject.triangles[triangle]]
    pixels = _areas(corners).sum()
    texels = _areas(view.subject.places[triangle].astype(np.float64)).sum() * shape[0] * shape[1]
    return float(texels / max(pixels, 1e-12))


def _areas(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) / 2)


Shares = NDArray[np.float32]

_LAMP = 0.07
"""Radius of the lamp over its distance."""
_RAYS, _TILE = 3, 3
_GOLDEN = np.pi * (3 - np.sqrt(5))
_LIFT, _LIFT_TURNED = 0.003, 0.05  # of D
_DARK = -0.35
"""Cosine below which no light comes round the edge of what is lit, see `shading`."""
_REACH = 0.11
"""How far hollows are felt, in D: mouth, nostrils and the corners of the eyes are dark."""
_DIRECTIONS = 16
_DARKNESS, _LEVEL = 1.1, 0.02


def shadows(
    view: View, points: Points, pixel: NDArray[np.int64], width: int, extent: float
) -> Shares:
    """(N,) how much of the lamp each point sees, from 0 to 1.

    Rays start a little off the surface, farther where it is turned from the lamp, for smooth
    normals reach beyond the polygons they are of. Each of three by three pixels asks other places
    of the lamp, so that their mean has seen all of it.

    Args:
        view: What the points are on.
        points: N of them.
        pixel: (N,) row · width + column, where they are seen.
        width: Of the picture.
        extent: D.
    """
    lamp = view.scene.lamp
    across = np.cross(lamp, [0.0, 1.0, 0.0] if abs(lamp[1]) < 0.9 else [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    along = np.cross(lamp, across)
    facing = points.normal @ lamp.astype(np.float32)
    asked = np.flatnonzero(facing > _DARK)
    lifted = _LIFT + _LIFT_TURNED * np.clip(0.3 - facing[asked], 0, 0.6)
    start = points.position[asked] + points.normal[asked] * (extent * lifted)[:, None]
    own = pixel[asked] % width % _TILE + _TILE * (pixel[asked] // width % _TILE)
    seen = np.zeros(len(facing), dtype=np.float32)
    # Places on the lamp: turns by the golden angle, evenly spread in the disc.
    places = np.arange(_RAYS * _TILE**2)
    radius = _LAMP * np.sqrt((places + 0.5) / len(places))
    aside = np.stack([radius * turn(places * _GOLDEN) for turn in (np.cos, np.sin)], axis=1)
    ways = lamp + aside[:, :1] * across + aside[:, 1:] * along
    for ray in range(_RAYS):
        seen[asked] += view.solid.free(start, ways[own + ray * _TILE**2])
    return seen / np.float32(_RAYS)


def smoothed(shares: Shares, depth: NDArray[np.float32], step: float) -> Shares:
    """(H, W) means of three by three pixels, of those within a step in depth.

    Where there is nothing, which is at a depth of infinity, of all that are there.
    """
    height, width = shares.shape
    around = np.pad(shares, 1)
    beyond = np.pad(depth, 1, constant_values=np.inf)
    total, count = np.zeros_like(shares), np.zeros_like(shares)
    nothing = ~np.isfinite(depth)
    here = np.where(nothing, 0, depth)
    for down in range(3):
        for right in range(3):
            box = np.s_[down : down + height, right : right + width]
            alike = (np.abs(beyond[box] - here) < step) | (nothing & np.isfinite(beyond[box]))
            total += np.where(alike, around[box], 0)
            count += alike
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), 1))


def hollows(
    position: NDArray[np.float32], normal: NDArray[np.float32], pixels: float, extent: float
) -> Shares:
    """(H, W) how much of the light from all around reaches each pixel, from 0 to 1.

    What stands around within reach takes light away (McGuire et al., the Alchemy screen-space
    ambient obscurance algorithm, 2011).

    Args:
        position: (H, W, 3) in the camera's axes; far away where there is nothing.
        normal: (H, W, 3) unit.
        pixels: How many of them D takes in the picture.
        extent: D.
    """
    height, width = position.shape[:2]
    reach = max(2, round(_REACH * pixels))
    padded = np.pad(position, ((reach, reach), (reach, reach), (0, 0)), mode="edge")
    taken = np.zeros((height, width), dtype=np.float32)
    least = np.float32((_LEVEL * extent) ** 2)
    for step in range(_DIRECTIONS):
        radius = reach * np.sqrt((step + 0.5) / _DIRECTIONS)
        angle = step * _GOLDEN
        x, y = (reach + round(float(radius * turn(angle))) for turn in (np.cos, np.sin))
        way = padded[y : y + height, x : x + width] - position
        squared = np.einsum("hwk,hwk->hw", way, way)
        above = np.einsum("hwk,hwk->hw", way, normal) - np.float32(0.004 * extent)
        taken += np.maximum(above, 0) / (squared + least)
    share = taken * np.float32(_DARKNESS * 2 * _REACH * extent / _DIRECTIONS)
    # Means of three by three pixels, at the border of those that there are.
    return uniform_filter(np.maximum(1 - share, 0), 3, mode="nearest")


_FINER = 2
"""Samples across a pixel at an edge; elsewhere its middle tells its colour."""
_STEP = 0.01
"""In D: neighbours farther apart in depth have an edge between them."""
_BEND = 0.85
"""Least cosine of the normals of neighbours without an edge between them."""
_FAR = 1e6
_CODES = np.rint(255 * encoded(np.linspace(0, 1, 4096))).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class _Middles:
    """What the middles of pixels show, (H, W).

    Attributes:
        depth: Along the camera's axis; infinite where nothing is.
        edges: Whether a pixel differs from one beside it.
        lit: How much of the lamp it sees, see `shadows`.
        open_: How much of the light from all around, see `hollows`.
    """

    depth: NDArray[np.float32]
    edges: NDArray[np.bool_]
    lit: NDArray[np.float32]
    open_: NDArray[np.float32]


def colour_picture(
    view: View, found: Seen, pixel: NDArray[np.int64], size: tuple[int, int], extent: float
) -> NDArray[np.uint8]:
    """(H, W, 3) sRGB.

    Args:
        view: The subject before the camera.
        found: What rays through the middles of pixels meet.
        pixel: (N,) row · width + column of each of those rays.
        size: Height and width.
        extent: D.
    """
    own, far = pixel[found.ray], _STEP * extent
    middles = _middles(view, found.points, own, size, extent)
    inner = ~middles.edges.reshape(-1)[own]
    fine_pixel, fine = _refined(view, middles.edges)
    every = Points.joined([found.points.only(inner), fine])
    of_pixel = np.concatenate([own[inner], fine_pixel])
    count = len(of_pixel) - len(fine_pixel)
    behind = np.zeros(len(of_pixel))
    behind[count:] = fine.position[:, 2] - middles.depth.reshape(-1)[fine_pixel]
    lit, open_ = (
        _taken(each, of_pixel, behind > far, behind < -far) for each in (middles.lit, middles.open_)
    )
    shown = radiance(view, every, lit, open_)[0]
    picture = np.tile(view.scene.background.astype(np.float32), (size[0] * size[1], 1))
    picture[own[inner]] = shown[:count]
    _average(picture, fine_pixel, shown[count:])
    for veil in reversed(found.veils):
        where = pixel[veil.ray]
        veiled = shadows(view, veil.points, where, size[1], extent)
        colour, opacity = radiance(view, veil.points, veiled, middles.open_.reshape(-1)[where])
        picture[where] += opacity[:, None] * (colour - picture[where])
    codes = np.rint(np.clip(picture, 0, 1) * np.float32(len(_CODES) - 1)).astype(np.int64)
    return np.asarray(_CODES[codes].reshape(*size, 3))


def _middles(
    view: View, points: Points, pixel: NDArray[np.int64], size: tuple[int, int], extent: float
) -> _Middles:
    row, column = pixel // size[1], pixel % size[1]
    position = np.full((*size, 3), _FAR * extent, dtype=np.float32)
    normal = np.zeros((*size, 3), dtype=np.float32)
    cloth, lit = np.full(size, -1), np.ones(size, dtype=np.float32)
    position[row, column], normal[row, column] = points.position, points.normal
    cloth[row, column] = view.subject.cloth[points.triangle]
    lit[row, column] = shadows(view, points, pixel, size[1], extent)
    depth = np.where(cloth >= 0, position[..., 2], np.inf)
    mean = float(points.position[:, 2].mean()) if len(pixel) else extent
    wide = float(view.scene.intrinsics[0, 0]) * extent / mean
    return _Middles(
        depth=depth,
        edges=_edges(position, normal, cloth, extent),
        lit=smoothed(lit, depth, _STEP * extent),
        open_=hollows(position, normal, wide, extent),
    )


def _edges(
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    cloth: NDArray[np.int64],
    extent: float,
) -> NDArray[np.bool_]:
    """(H, W) pixels that differ from the next one in material, depth or direction."""
    edges = np.zeros(cloth.shape, dtype=bool)
    depth = position[..., 2]
    for one, other in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        cosine = np.einsum("hwk,hwk->hw", normal[one], normal[other])
        apart = np.abs(depth[one] - depth[other]) > _STEP * extent
        differ = (cloth[one] != cloth[other]) | ((cloth[one] >= 0) & (apart | (cosine < _BEND)))
        edges[one] |= differ
        edges[other] |= differ
    return edges


def _refined(view: View, edges: NDArray[np.bool_]) -> tuple[NDArray[np.int64], Points]:
    """What is seen at finer samples of the pixels at edges, and the pixel that each is of."""
    row, column = np.nonzero(edges)
    inside = (np.arange(_FINER) + 0.5) / _FINER - 0.5
    down, right = (own.reshape(-1) for own in np.meshgrid(inside, inside, indexing="ij"))
    x, y = column[:, None] + right, row[:, None] + down
    found = view.look(np.column_stack([x.reshape(-1), y.reshape(-1)]))
    of_sample = (row * edges.shape[1] + column).repeat(_FINER**2)
    return of_sample[found.ray], found.points


def _taken(
    shares: NDArray[np.float32],
    pixel: NDArray[np.int64],
    beyond: NDArray[np.bool_],
    before: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """(N,) of (H, W) shares of light at pixels, for samples beyond or before what these show.

    Those are of a surface that a pixel beside shows: the darkest beyond an edge, as in a nostril
    or between lips, the brightest before it.
    """
    found = shares.reshape(-1)[pixel]
    found[beyond] = minimum_filter(shares, 3).reshape(-1)[pixel[beyond]]
    found[before] = maximum_filter(shares, 3).reshape(-1)[pixel[before]]
    return np.asarray(found)


def _average(
    picture: NDArray[np.float32], pixel: NDArray[np.int64], shown: NDArray[np.float32]
) -> None:
    """Put the means of finer samples into their pixels; where nothing is seen is background."""
    hits = np.bincount(pixel, minlength=len(picture))
    touched = np.flatnonzero(hits)
    total = np.stack([np.bincount(pixel, own, len(picture))[touched] for own in shown.T], axis=1)
    free = (_FINER**2 - hits[touched])[:, None] * picture[touched]
    picture[touched] = (total + free) / _FINER**2


Label = tuple[tuple[int, ...], str, Mapping[str, Any]]
_PIXELS = "x right, y down, the middle of the first pixel at 0, 0"
_HIDDEN = 0.003
"""In D: how far behind what is seen a landmark still counts as seen; it is on the surface."""


class Painter:
    """Draws faces of a rig: the same bytes for the same input, in every process of a machine.

    Args:
        rig: Whose faces they are; its appearance and the names of its parts tell how they look.
        size: Height and width in pixels.
        landmarks: Vertex of each landmark by its name.
        arrays: Those of `ARRAYS` that are wanted; by default all.

    Attributes:
        labels: The arrays that `draw` returns: shape of one face, type, and what the numbers mean
            for those who read them without this package.
    """

    def __init__(
        self,
        rig: Rig,
        size: tuple[int, int],
        landmarks: Mapping[str, int] | None = None,
        arrays: Sequence[str] = ARRAYS,
    ) -> None:
        _check(rig, size, landmarks or {}, arrays)
        self._subject = Subject(rig.neutral, max(size))
        self._frame = _frame(rig, size)
        self._marks = np.array(list((landmarks or {}).values()), dtype=np.int64)
        self._arrays = tuple(arrays)
        self.labels = self._described(list(landmarks or {}))

    def draw(
        self, positions: NDArray[np.floating], values: Mapping[str, ArrayLike]
    ) -> dict[str, NDArray[Any]]:
        """The arrays of `labels`, (n, …) each.

        Args:
            positions: (n, V, 3) of the rig's vertices, in its own coordinates.
            values: (n,) of each column by its name, see `SETTINGS`; others are ignored.
        """
        count = len(positions)
        columns = {name: np.broadcast_to(own, count) for name, own in values.items()}
        made = {
            name: np.zeros((count, *shape), kind) for name, (shape, kind, _) in self.labels.items()
        }
        for face in range(count):
            scene = scene_of(self._frame, {name: own[face] for name, own in columns.items()})
            for name, values_of in self._drawn(positions[face], scene).items():
                made[name][face] = values_of
        return made

    def _drawn(self, positions: NDArray[np.floating], scene: Scene) -> dict[str, NDArray[Any]]:
        view = View(self._subject, positions, scene)
        size, extent = self._frame.size, self._frame.extent
        pixel = _pixels(view, size)
        found = view.look(np.column_stack([pixel % size[1], pixel // size[1]]))
        shown: dict[str, NDArray[Any]] = {"camera": scene.camera, "head": scene.head}
        shown["intrinsics"] = scene.intrinsics
        if "colour" in self.labels:
            shown["colour"] = colour_picture(view, found, pixel, size, extent)
        ray, points = view.labelled(found)
        parts = self._subject.part[points.triangle]
        codes = np.rint(127 * points.normal)
        for name, values in (
            ("depth", points.position[:, 2]),
            ("normals", codes),
            ("parts", parts),
        ):
            whole = np.zeros((size[0] * size[1], *values.shape[1:]), values.dtype)
            whole[pixel[ray]] = values
            shown[name] = whole.reshape(*size, *values.shape[1:])
        shown["landmarks"] = self._seen_marks(view)
        return {name: shown[name] for name in self.labels}

    def _seen_marks(self, view: View) -> NDArray[np.float64]:
        """(L, 3) x, y and whether the landmark is in the picture with nothing before it."""
        places, own = view.places[self._marks], view.seen[self._marks, 2]
        x, y = np.nan_to_num(places, nan=-1e9).T
        height, width = self._frame.size
        inside = (own > 0) & (x >= -0.5) & (x < width - 0.5) & (y >= -0.5) & (y < height - 0.5)
        ray, points = view.labelled(view.look(places[inside]))
        depth = np.full(np.count_nonzero(inside), np.inf)
        depth[ray] = points.position[:, 2]
        seen = inside.astype(np.float64)
        seen[inside] = own[inside] <= depth + _HIDDEN * self._frame.extent
        return np.column_stack([places, seen])

    def _described(self, landmarks: list[str]) -> Mapping[str, Label]:
        size = self._frame.size
        axes = "the camera's axes: x right, y down, z away from it"
        every: dict[str, Label] = {
            "colour": ((*size, 3), "uint8", {"colours": "sRGB"}),
            "depth": (
                size,
                "float32",
                {"unit": "of the rig, along the camera's axis", "nothing": 0},
            ),
            "normals": ((*size, 3), "int8", {"axes": axes, "scale": 1 / 127, "nothing": 0}),
            "parts": (size, "uint8", {"names": list(PARTS)}),
            "landmarks": (
                (len(landmarks), 3),
                "float32",
                {"names": landmarks, "columns": ["x", "y", "visible"], "pixels": _PIXELS},
            ),
            "camera": ((3, 4), "float64", {"maps": "world to camera", "axes": axes}),
            "head": ((3, 4), "float64", {"maps": "the rig's coordinates to the world"}),
            "intrinsics": ((3, 3), "float64", {"maps": "camera to pixels", "pixels": _PIXELS}),
        }
        if not landmarks:
            del every["landmarks"]
        wanted = {"head", "intrinsics"} if "camera" in self._arrays else set()
        wanted.update(self._arrays)
        return {name: label for name, label in every.items() if name in wanted}


def _pixels(view: View, size: tuple[int, int]) -> NDArray[np.int64]:
    """Numbers of the pixels in the box round the subject, rising."""
    used = view.places[view.subject.vertices]
    used = used[np.isfinite(used).all(axis=1)]
    last = np.array([size[1] - 1, size[0] - 1])
    if not len(used):
        return np.zeros(0, dtype=np.int64)
    low = np.clip(np.floor(used.min(axis=0)), 0, last + 1).astype(np.int64)
    high = np.clip(np.ceil(used.max(axis=0)), -1, last).astype(np.int64)
    rows, columns = np.arange(low[1], high[1] + 1), np.arange(low[0], high[0] + 1)
    return (rows[:, None] * size[1] + columns).reshape(-1)


def _frame(rig: Rig, size: tuple[int, int]) -> Frame:
    """The pivot is the middle of the box round what the targets move; else round everything."""
    vertices = rig.neutral.vertices
    moved = np.zeros(len(vertices), dtype=bool)
    for morph in rig.morphs.values():
        moved |= morph.delta.any(axis=1)
    own = vertices[moved] if moved.any() else vertices
    extent = extent_of(rig) or rig.neutral.diameter
    return Frame((own.min(axis=0) + own.max(axis=0)) / 2, extent, size)


def _check(
    rig: Rig, size: tuple[int, int], landmarks: Mapping[str, int], arrays: Sequence[str]
) -> None:
    if len(size) != 2 or not all(1 <= side <= LARGEST for side in size):
        raise ParameterError(f"a picture has 1 to {LARGEST} pixels on a side, found {size}")
    unknown = [name for name in arrays if name not in ARRAYS]
    if unknown or not arrays:
        raise ParameterError(
            f"pictures have the arrays {', '.join(ARRAYS)}; found {', '.join(unknown) or 'none'}"
        )
    count = len(rig.neutral.vertices)
    for name, vertex in landmarks.items():
        if not 0 <= vertex < count:
            raise ParameterError(
                f"landmark {name} is vertex {vertex}, but the rig has {count:,}: from 0 to "
                f"{count - 1:,}"
            )
