"""The surface of the neutral, in the vertices of a template."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import (
    Camera,
    Deformation,
    Hits,
    Parts,
    Surface,
    Table,
    View,
    along_normals,
    correlation,
    flow_engine,
    open_colours,
    pixel_grid,
    robust,
    sampled,
    to_places,
    to_points,
)
from elastomorph.capturing.landmarks import fit_landmarks, typical_face
from elastomorph.errors import CaptureError
from elastomorph.model.mesh import Mesh

# The part of a photograph that shows the head, as fine as is asked for.

Points = NDArray[np.float64]

# Pixels around the head that are kept, and the least that the head itself has to have.
_BORDER, _LEAST = 24, 32


def cropped(view: View, points: Points) -> View | None:
    """What a photograph shows of (N, 3) points and a little around; None: next to nothing."""
    pixels, depths = view.camera.project(points)
    pixels = pixels[depths > 0]
    if not len(pixels):
        return None
    start, stop = np.floor(pixels.min(axis=0)), np.ceil(pixels.max(axis=0)) + 1
    if (np.minimum(stop, view.camera.size) - np.maximum(start, 0) < _LEAST).any():
        return None
    low = np.maximum(start - _BORDER, 0).astype(int)
    high = np.minimum(stop + _BORDER, view.camera.size).astype(int)
    width, height = (int(side) for side in high - low)
    part = np.s_[low[1] : high[1], low[0] : high[0]]
    camera = replace(view.camera, size=(width, height), centre=view.camera.centre - low)
    # Copies, so that the photograph itself need not stay in memory.
    mask = None if view.mask is None else view.mask[part].copy()
    return View(camera, view.grey[part].copy(), mask)


def no_finer(view: View, density: float, middle: Points) -> View:
    """A photograph with no more than `density` pixels to a unit of length at (3,) the middle."""
    away = float(np.linalg.norm(middle - view.camera.position))
    factor = density * away / view.camera.focal
    return view if factor > 0.95 else view.scaled(factor)


# A finer surface through the same vertices, curved as their normals say.


def curved(surface: Surface) -> Surface:
    """The surface with each triangle made four; its own vertices come first and stay.

    A template has few vertices for a round face: its flat triangles run below the skin between
    them, by more than photographs can tell. The middle of each edge is put on the curve that
    leaves both ends at right angles to their normals (the edges of Vlachos et al., Curved PN
    triangles, I3D 2001):

        m = (a + b)/2 − ((e·n_a) n_a − (e·n_b) n_b)/8,  e = b − a
    """
    count = len(surface.vertices)
    triangles = surface.triangles
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, numbers = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    middles = count + numbers.reshape(-1, 3)
    (a, b), (first, second) = (
        np.moveaxis(values[edges], 1, 0) for values in (surface.vertices, surface.normals)
    )
    at_first = np.einsum("ij,ij->i", b - a, first)[:, None] * first
    at_second = np.einsum("ij,ij->i", b - a, second)[:, None] * second
    points = (a + b) / 2 - (at_first - at_second) / 8
    corner, middle = triangles.T, middles.T
    fine: list[tuple[NDArray[np.int64], ...]] = [
        (corner[k], middle[k], middle[k - 1]) for k in range(3)
    ]
    fine.append((middle[0], middle[1], middle[2]))
    return Surface(
        np.concatenate([surface.vertices, points]),
        np.concatenate([np.stack(each, axis=1) for each in fine]),
    )


Single = NDArray[np.float32]

# Where a surface is, from pairs of photographs that are compared through it.
#
# The photograph of one camera is drawn as a second camera would have taken it if the surface were
# right. What has moved between the drawn and the real photograph, by optical flow, says how far
# the surface is off at each vertex. Nothing is searched for along lines, as in stereo without a
# surface: both photographs look the same but for a few pixels, however differently the cameras
# stand.

# Angle between the cameras of a pair, as seen from the head, in degrees.
_LEAST_ANGLE, _MOST_ANGLE = 4.0, 45.0
# A vertex is looked at if it is turned away from the camera by less than about 78°.
_LEAST_STEREO_COSINE = 0.2
# How well photographs have to correlate after the flow.
_LEAST_CORRELATION = 0.6
# Pixels: the longest flow, and how far the rays of what was matched may pass each other.
_LONGEST_FLOW, _WIDEST_GAP = 40.0, 1.5
# Side of the square around a pixel that both photographs have to show; a wide one would leave none
# of the lids, which end there in one of them.
_AROUND_PIXEL = 3
# Rays are sent through every second pixel; between them depths are interpolated.
_STEP = 2
# Part of its depth by which a point that is hidden lies behind what hides it.
_BEHIND = 0.003
_FEWEST_PAIRS = 50


@dataclass(frozen=True, eq=False)
class Offsets(Table):
    """How far a surface is off, as single pairs of photographs show it.

    Attributes:
        vertices: (K,) int64 at which.
        offsets: (K,) along its normal, in the units of the surface.
        weights: (K,) larger than 0 and at most 1.
    """

    vertices: NDArray[np.int64]
    offsets: Points
    weights: Points


@dataclass(frozen=True, eq=False)
class _Seen:
    """A photograph and the surface in it.

    Attributes:
        crop: the photograph.
        depth: (h, w) along the axis, through every _STEP-th pixel; 0 where nothing is met.
        visible: (V,) which vertices it shows.
        cosines: (V,) between their normals and the directions to the camera.
    """

    crop: View
    depth: Single
    visible: NDArray[np.bool_]
    cosines: Points


def pairs_of(cameras: Sequence[Camera], middle: Points, each: int) -> list[tuple[int, int]]:
    """For each camera the `each` nearest others by angle, as seen from (3,) middle of the head."""
    towards = np.array([camera.position for camera in cameras]) - middle
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    angles = np.degrees(np.arccos(np.clip(towards @ towards.T, -1, 1)))
    found: list[tuple[int, int]] = []
    for first, mine in enumerate(angles):
        fit = (mine > _LEAST_ANGLE) & (mine < _MOST_ANGLE)
        others = [int(second) for second in np.argsort(mine, kind="stable") if fit[second]]
        found += [(first, second) for second in others[:each]]
    return found


def offsets_from(
    crops: Sequence[View],
    surface: Surface,
    chosen: NDArray[np.bool_],
    pairs: Sequence[tuple[int, int]],
    tolerance: float,
) -> Offsets:
    """How far vertices of a surface are off, from photographs.

    Args:
        crops: photographs.
        surface: near what they show, with all that may hide it.
        chosen: (V,) the vertices that are asked about.
        pairs: of photographs, as indices; the second is drawn as the first would see it.
        tolerance: how far before a vertex something may stand without hiding it, in the units of
            the surface.
    """
    fine = curved(surface)
    seen = [_see(crop, surface, fine, chosen, tolerance) for crop in crops]
    engine = flow_engine()
    found = []
    for first, group in groupby(sorted(pairs), key=lambda pair: pair[0]):
        reference = seen[first]
        places, met = _places(reference)
        for _, second in group:
            both = np.flatnonzero(reference.visible & seen[second].visible)
            if len(both) >= _FEWEST_PAIRS:
                found.append(_compared(reference, seen[second], places, met, both, surface, engine))
    none = Offsets(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0))
    return Offsets.join([none, *found])


def _see(
    crop: View, surface: Surface, fine: Surface, chosen: NDArray[np.bool_], tolerance: float
) -> _Seen:
    hits = fine.cast(crop.camera.position, crop.camera.directions(_STEP))
    depth = np.where(hits.met, hits.depths, 0).astype(np.float32)
    some = np.flatnonzero(chosen)
    visible = np.zeros(len(chosen), dtype=bool)
    cosines = np.zeros(len(chosen))
    points = surface.vertices[some]
    visible[some], cosines[some] = surface.visible(
        crop.camera,
        points,
        surface.normals[some],
        least_cosine=_LEAST_STEREO_COSINE,
        tolerance=tolerance,
    )
    if crop.mask is not None:
        mine = np.flatnonzero(visible)
        visible[mine] = crop.usable(crop.camera.project(surface.vertices[mine])[0])
    return _Seen(crop, depth, visible, cosines)


def _places(seen: _Seen) -> tuple[Points, NDArray[np.bool_]]:
    """(H, W, 3) what each pixel of a photograph looks at, and (H, W) where that is the surface."""
    import cv2

    camera = seen.crop.camera
    width, height = camera.size
    x, y = (each / np.float32(_STEP) for each in pixel_grid(width, height))
    # Beside the surface a depth lies between that of the surface and nothing, and is not used.
    depth: Any = cv2.remap(seen.depth, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    share: Any = cv2.remap(
        (seen.depth > 0).astype(np.float32), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    met = share > 0.999
    places = camera.directions() * np.where(met, depth, 1)[..., None] + camera.position
    return places, met


def _compared(
    first: _Seen,
    second: _Seen,
    places: Points,
    met: NDArray[np.bool_],
    some: NDArray[np.int64],
    surface: Surface,
    engine: Any,
) -> Offsets:
    """What one pair of photographs says of some vertices."""
    import cv2

    drawn, where, known = _drawn(second, places, met)
    real = np.where(met, first.crop.grey, 0).astype(np.uint8)
    # Where the second camera sees nothing of it, the photograph itself stands in: nothing moves.
    drawn[met & ~known] = real[met & ~known]
    moved: Any = engine.calc(real, drawn, None)
    start = first.crop.camera.project(surface.vertices[some])[0]
    step = sampled(moved, start)
    width, height = first.crop.camera.size
    x, y = pixel_grid(width, height)
    again: Any = cv2.remap(drawn, x + moved[..., 0], y + moved[..., 1], cv2.INTER_LINEAR)
    alike = sampled(correlation(real, again), start)
    sure = sampled(
        cv2.erode(known.astype(np.uint8), np.ones((_AROUND_PIXEL, _AROUND_PIXEL))).astype(
            np.float32
        ),
        start,
    )
    goal = sampled(where, start + step)
    found, gap = _crossing(first.crop.camera, start, second.crop.camera, goal)
    good = (alike > _LEAST_CORRELATION) & (gap < _WIDEST_GAP) & (sure > 0.999)
    good &= np.abs(step).max(axis=1) < _LONGEST_FLOW
    some, found = some[good], found[good]
    offsets = np.einsum("ij,ij->i", found - surface.vertices[some], surface.normals[some])
    apart = _sine(first.crop.camera, second.crop.camera, surface.vertices[some])
    weights = alike[good] * first.cosines[some] * second.cosines[some] * apart
    return Offsets(some, offsets, weights)


def _drawn(
    seen: _Seen, places: Points, met: NDArray[np.bool_]
) -> tuple[NDArray[np.uint8], Single, NDArray[np.bool_]]:
    """A photograph as another camera would have taken it, where from, and where it shows that."""
    import cv2

    pixels, depths = seen.crop.camera.project(places)
    where = np.where(met[..., None], pixels, -9).astype(np.float32)
    drawn: Any = cv2.remap(seen.crop.grey, where[..., 0], where[..., 1], cv2.INTER_LINEAR)
    coarse = where / np.float32(_STEP)
    front: Any = cv2.remap(seen.depth, coarse[..., 0], coarse[..., 1], cv2.INTER_NEAREST)
    known = met & (front > 0) & (depths < front * (1 + _BEHIND))
    return np.asarray(drawn), where, np.asarray(known)


def _crossing(a: Camera, in_a: Points, b: Camera, in_b: Points) -> tuple[Points, Points]:
    """(N, 3) points on rays of a that are nearest to rays of b, and how far off in b, px."""
    along, other = a.through(in_a), b.through(in_b)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    other /= np.linalg.norm(other, axis=1, keepdims=True)
    between = a.position - b.position
    cosine = np.einsum("ij,ij->i", along, other)
    far = cosine * (other @ between) - along @ between
    far /= np.maximum(1 - cosine**2, 1e-12)
    points = a.position + far[:, None] * along
    return points, np.linalg.norm(b.project(points)[0] - in_b, axis=1)


def _sine(a: Camera, b: Camera, points: Points) -> Points:
    """(N,) of the angles between the directions from (N, 3) points to two cameras."""
    to_a, to_b = a.position - points, b.position - points
    lengths = np.linalg.norm(to_a, axis=1) * np.linalg.norm(to_b, axis=1)
    sines: Points = np.linalg.norm(np.cross(to_a, to_b), axis=1) / lengths
    return sines


Rows = NDArray[np.int64]

_NAMES = ("mouth_right", "mouth_left", "upper_lip", "lower_lip")
# Where the lips meet, found again in photographs of the neutral.
#
# What photographs say of a surface along its normals does not say where along the skin a vertex
# is: the lips of the template may end a millimetre above or below those of the subject, and skin
# of one would go with the other as soon as the mouth opens. But between closed lips, and within
# those that part a little, every photograph is dark. The dark line is looked for across the line
# where a camera sees the lips of the template meet, all along the mouth at once (by dynamic
# programming). The lip that stands before the other there ends where the line begins on its side,
# by the steepest change.
#
# Lengths are parts of the width of the mouth.

# Of the angle between where the mouth looks and the direction to a camera; pixels of its width.
_LEAST_COSINE, _LEAST_WIDTH = 0.5, 20.0
# Places along the mouth that are looked at, without the ends, where lips are one.
_STATIONS, _ENDS = 48, 0.06
# How far above and below the corners lips are looked for, and how far from their line the dark one.
_AROUND, _SEARCHED = 0.5, 0.12
# Steps across the line, and half its width; both at least so many pixels.
_FINE, _HALF, _LEAST_FINE, _LEAST_HALF = 0.004, 0.03, 0.25, 1.5
# Grey values by which it is darker than what is beside it, and what it costs when its distance
# from the template's changes by its own width from place to place.
_DARKER, _BENT = 6.0, 3.0
# Difference of depth below which neither lip stands before the other.
_TOUCH = 0.01
# Places of several photographs that are compared, and how far one may be from their median.
_NEAR, _AGREE, _FEWEST_OF_LINE = 0.05, 0.03, 3


@dataclass(frozen=True, eq=False)
class _Ends(Table):
    """Where photographs show that lips end.

    Attributes:
        corners: (N, 3) vertices of the triangle of the surface that ends there.
        weights: (N, 3) of those.
        upper: (N,) whether it is of the upper lip.
        along: (N,) place on the mouth, 0 the right corner and 1 the left one.
        higher: (N,) by how much higher than the surface has it.
    """

    corners: Rows
    weights: Points
    upper: NDArray[np.bool_]
    along: Points
    higher: Points


@dataclass(frozen=True, eq=False)
class Lips:
    """The lips of a template.

    Attributes:
        corners: (4,) vertices: right and left corner, above the upper lip and below the lower.
        side: (V,) 1 for the half of the skin nearer to the upper lip along it, −1 for the other, 0
            for what is not skin.
    """

    corners: NDArray[np.int64]
    side: Rows

    @classmethod
    def of(cls, whole: Surface, landmarks: Mapping[str, int]) -> Lips | None:
        """Those of a template; None where its landmarks do not tell."""
        from scipy.sparse.csgraph import dijkstra

        if any(name not in landmarks for name in _NAMES):
            return None
        corners = np.array([landmarks[name] for name in _NAMES])
        above, below = dijkstra(whole.ways, directed=False, indices=corners[2:])
        return cls(corners, np.isfinite(above) * np.where(above < below, 1, -1))

    def moved(self, crops: Sequence[View], whole: Surface) -> tuple[Points, Points, Points]:
        """How photographs move the ends of the lips.

        Args:
            crops: of the neutral.
            whole: the template as it is so far, eyes and teeth too.

        Returns:
            (3,) the way up; (V,) lengths along it and (V,) their weights, at most 1.
        """
        frame = _Frame.of(whole.vertices[self.corners])
        parts = [each for crop in crops for each in _seen(crop, whole, self.side, frame)]
        total = np.zeros((2, len(self.side)))
        if parts:
            ends = _agreeing(_Ends.join(parts))
            values = np.stack([ends.weights, ends.weights * ends.higher[:, None]])
            for corner in range(3):
                for which in range(2):
                    np.add.at(total[which], ends.corners[:, corner], values[which, :, corner])
        higher = frame.width * total[1] / np.maximum(total[0], 1e-9)
        return frame.up, higher, np.minimum(total[0], 1.0)


@dataclass(frozen=True, eq=False)
class _Frame:
    """Of a mouth: its corners, the ways up and outwards, and its width."""

    right: Points
    left: Points
    up: Points
    out: Points
    width: float

    @classmethod
    def of(cls, corners: Points) -> _Frame:
        right, left, above, below = corners
        width = float(np.linalg.norm(left - right))
        across = (left - right) / width
        up = above - below - ((above - below) @ across) * across
        up /= np.linalg.norm(up)
        return cls(right, left, up, np.cross(across, up), width)


def _seen(crop: View, whole: Surface, side: Rows, frame: _Frame) -> list[_Ends]:
    """Where one photograph shows that the upper and the lower lip end, if it shows the mouth."""
    grid, step, pixels = _grid(crop, frame)
    if grid is None:
        return []
    hits = whole.cast(crop.camera.position, crop.camera.through(grid))
    halves = np.sign(side[whole.triangles[hits.triangles]].sum(axis=2)) * hits.met
    grey = sampled(crop.grey, grid.reshape(-1, 2)).reshape(halves.shape).astype(np.float64)
    split = _split(halves)
    half = round(max(_HALF * pixels, _LEAST_HALF) / step)
    valley, darker = _darkest(grey, split, half, round(_SEARCHED * pixels / step))
    rows = np.arange(len(split))
    above, below = _beside(halves, split)
    there = (above >= 0) & (below >= 0) & (darker > _DARKER)
    deeper = (hits.depths[rows, above] - hits.depths[rows, below]) / frame.width
    slope = np.gradient(grey, axis=1)
    found = []
    for sign, end in ((1, above), (-1, below)):
        window = np.clip(valley[:, None] + sign * np.arange(2 * half), 0, grey.shape[1] - 1)
        steepest = (sign * np.take_along_axis(slope, window, axis=1)).argmax(axis=1)
        higher = (valley + sign * steepest - end) * step / pixels
        # A lip that the other hides ends elsewhere.
        good = there & (sign * deeper < _TOUCH)
        found.append(_ends(hits, whole, frame, (rows[good], end[good]), sign > 0, higher[good]))
    return found


def _ends(
    hits: Hits,
    whole: Surface,
    frame: _Frame,
    where: tuple[Rows, Rows],
    upper: bool,
    higher: Points,
) -> _Ends:
    corners, weights = whole.triangles[hits.triangles[where]], hits.weights[where]
    places = np.einsum("ni,nij->nj", weights, whole.vertices[corners])
    along = (places - frame.right) @ (frame.left - frame.right) / frame.width**2
    return _Ends(corners, weights, np.full(len(higher), upper), along, higher)


def _grid(crop: View, frame: _Frame) -> tuple[Points | None, float, float]:
    """(N, H, 2) pixels across the mouth, from low to high; of a step, and of a width upwards."""
    camera = crop.camera
    middle = (frame.right + frame.left) / 2
    away = camera.position - middle
    start, stop = camera.project(np.stack([frame.right, frame.left]))[0]
    raised = camera.jacobian(middle[None])[0] @ frame.up
    rise = float(np.linalg.norm(raised))
    pixels = frame.width * rise
    step = max(_FINE * pixels, _LEAST_FINE)
    count = round(_AROUND * pixels / step)
    parts = np.linspace(_ENDS, 1 - _ENDS, _STATIONS)[:, None]
    lines = start + parts * (stop - start)
    grid = lines[:, None] + step * np.arange(-count, count + 1)[:, None] * raised / rise
    shown = bool(away @ frame.out > _LEAST_COSINE * np.linalg.norm(away))
    shown = shown and bool(np.linalg.norm(stop - start) > _LEAST_WIDTH)
    shown = shown and bool(camera.inside(grid, 2).all())
    if shown and crop.mask is not None:
        shown = bool(sampled(crop.mask.astype(np.uint8), grid.reshape(-1, 2)).all())
    return grid if shown else None, step, pixels


def _split(halves: Rows) -> Rows:
    """(N,) where in rows (N, H), from low to high, the lower half ends and the upper begins."""
    right = np.cumsum((halves == -1).astype(int) - (halves == 1), axis=1)
    best = right == right.max(axis=1, keepdims=True)
    last = halves.shape[1] - 1 - best[:, ::-1].argmax(axis=1)
    found: Rows = (best.argmax(axis=1) + last) // 2
    return found


def _beside(halves: Rows, split: Rows) -> tuple[Rows, Rows]:
    """(N,) the first of the upper half above the split, and the last of the lower; −1: none."""
    places = np.arange(halves.shape[1])
    above = (halves == 1) & (places >= split[:, None])
    below = (halves == -1) & (places <= split[:, None])
    last = len(places) - 1 - below[:, ::-1].argmax(axis=1)
    return np.where(above.any(axis=1), above.argmax(axis=1), -1), np.where(
        below.any(axis=1), last, -1
    )


def _darkest(grey: Points, split: Rows, half: int, reach: int) -> tuple[Rows, Points]:
    """(N,) where the dark line is in rows (N, H), and by how many grey values it is darker.

    The line that is darkest altogether, whose distance from the split changes little.
    """
    wide = np.pad(grey, ((0, 0), (half, half)), mode="edge")
    darker = np.minimum(wide[:, : -2 * half], wide[:, 2 * half :]) - grey
    offsets = np.arange(-reach, reach + 1)
    places = np.clip(split[:, None] + offsets, 0, grey.shape[1] - 1)
    gain = np.take_along_axis(darker, places, axis=1)
    bent = _BENT * ((offsets[:, None] - offsets) / (2 * half)) ** 2
    cost = -gain / max(float(np.median(gain.max(axis=1))), 1.0)
    before = np.zeros(cost.shape, dtype=np.int64)
    for number in range(1, len(cost)):
        ways = cost[number - 1] + bent
        before[number] = ways.argmin(axis=1)
        cost[number] += ways.min(axis=1)
    chosen = np.zeros(len(cost), dtype=np.int64)
    chosen[-1] = cost[-1].argmin()
    for number in range(len(cost) - 1, 0, -1):
        chosen[number - 1] = before[number, chosen[number]]
    rows = np.arange(len(cost))
    return places[rows, chosen], gain[rows, chosen]


def _agreeing(ends: _Ends) -> _Ends:
    """Those that are near the median of what photographs show of the same lip beside them."""
    near = (np.abs(ends.along[:, None] - ends.along) < _NEAR) & (ends.upper[:, None] == ends.upper)
    kept = np.zeros(len(near), dtype=bool)
    for number, others in enumerate(near):
        values = ends.higher[others]
        if len(values) >= _FEWEST_OF_LINE:
            kept[number] = abs(ends.higher[number] - np.median(values)) < _AGREE
    return ends.chosen(kept)


# The surface of the neutral, in the vertices of a template, from its photographs.
#
# The template is placed by landmarks, bent to them, drawn to the sparse points of the cameras,
# and then moved to where pairs of photographs agree with each other through it (`stereo`), from
# coarse photographs to fine ones. What no two photographs show follows what they do.
#
# Lengths are parts of the face, which is the root mean square distance of the landmarks from
# their middle, or pixels; weights have no unit. So neither the units of the template nor its axes
# matter.

# Called with what is being done and the part of it that is done, from 0 to 1.
Say = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class NeutralSurface:
    """The template on the surface that photographs show.

    Attributes:
        vertices: (V, 3) in the frame of the cameras.
        covered: (V,) int64 how many pairs of photographs agree on it; 0 where it follows others.
        spread: (V,) by how much they differ along the normal, as a standard deviation, in the
            units of the vertices; infinite where none agree.
    """

    vertices: Points
    covered: NDArray[np.int64]
    spread: Points


@dataclass(frozen=True)
class _Round:
    """One comparison of photographs. Lengths are parts of the face or pixels.

    Attributes:
        density: pixels on the length of the face; photographs with more are made smaller.
        reach: largest offset of a vertex, part of the face.
        bending: stiffness.
    """

    density: float
    reach: float
    bending: float


@dataclass(frozen=True)
class _Step:
    """How the template is drawn to points. Lengths are parts of the face.

    Attributes:
        reach: farther points do nothing.
        width: of the robust weight of a distance.
        landmarks: their weight.
        arap: stiffness.
        bending: stiffness.
    """

    reach: float
    width: float
    landmarks: float
    arap: float
    bending: float


_STEPS = (
    _Step(0.5, 0.1, 3.0, 0.02, 1.0),
    _Step(0.15, 0.05, 1.0, 0.02, 0.3),
    _Step(0.1, 0.02, 0.3, 0.01, 0.05),
)
_ROUNDS = (_Round(60, 0.15, 0.05), _Round(120, 0.12, 0.02), _Round(240, 0.1, 0.01))
_ARAP = 0.005
# Pixels: the median deviation up to which observations agree, and the width of their mean.
_DEVIATION, _WIDTH = 0.8, 0.45
_FEWEST, _EACH = 3, 2
# Most weight of a vertex: many pairs share their errors.
_MOST_WEIGHT = 1.5
# Parts of the face from landmarks within which points of the cameras are looked at first. Once
# the face is in place, the template stands nearer to a scalp than the hair on it does.
_FROM_LANDMARKS = 0.8
# Part of the face that may stand before a vertex without hiding it.
_BEFORE = 0.015


def neutral_surface(
    views: Sequence[View],
    cloud: Points,
    template: Points,
    triangles: NDArray[np.integer],
    landmarks: Mapping[str, int],
    places: Mapping[str, Points],
    *,
    say: Say = lambda text, part: None,
) -> NeutralSurface:
    """Bring a template onto the surface that photographs show.

    Args:
        views: photographs of the neutral, opened one after the other.
        cloud: (N, 3) points of the surface and of anything else, from their cameras.
        template: (V, 3) positions, of any person, size and orientation.
        triangles: (T, 3) of the template.
        landmarks: landmark → vertex of the template.
        places: landmark → (3,) in the frame of the cameras.
        say: called with what is being done and the part of it that is done.

    Raises:
        CaptureError: Landmarks are too few or exchanged, they are on no face, or too few
            photographs show it.
    """
    names = [name for name in landmarks if name in places]
    typical_face({name: template[vertex] for name, vertex in landmarks.items()}, "the template")
    marked = {name: template[landmarks[name]] for name in names}
    rest = fit_landmarks(marked, places, "the photographs")(template)
    vertices = {name: landmarks[name] for name in names}
    goals = np.array([places[name] for name in names])
    return _Neutral(views, cloud, rest, triangles, vertices, goals, say).surface()


class _Neutral:
    """The template on its way to the surface."""

    def __init__(
        self,
        views: Sequence[View],
        cloud: Points,
        rest: Points,
        triangles: NDArray[np.integer],
        landmarks: Mapping[str, int],
        goals: Points,
        say: Say,
    ) -> None:
        self.say = say
        marks = np.array(list(landmarks.values()))
        self.triangles = np.asarray(triangles, dtype=np.int64)
        self.parts = Parts.of(rest, self.triangles, marks)
        on_skin = self.parts.place[marks] >= 0
        self.marks, self.goals = self.parts.place[marks[on_skin]], goals[on_skin]
        self.middle = self.goals.mean(axis=0)
        self.face = float(np.sqrt(((self.goals - self.middle) ** 2).sum(axis=1).mean()))
        self.deformation = Deformation(rest[self.parts.skin], self.parts.triangles)
        self.skin = rest[self.parts.skin]
        self.lips = Lips.of(Surface(rest, self.triangles), landmarks)
        self.cloud = cloud[_near(cloud, rest, self.face)]
        finest = _ROUNDS[-1].density / self.face
        crops = [cropped(view, rest) for view in views]
        self.crops = [no_finer(crop, finest, self.middle) for crop in crops if crop is not None]
        if len(self.crops) < 2:
            raise CaptureError(
                f"{len(self.crops)} of {len(views)} photographs show the face where its landmarks "
                "are: were they clicked in other photographs than these?"
            )

    def surface(self) -> NeutralSurface:
        self.say("the template to the landmarks", 0.0)
        self._solve(self._landmarks(100.0), arap=0.02, bending=5.0, rounds=4)
        self._to_cloud()
        count, spread = self._by_stereo()
        vertices = self.parts.carried(self.skin)
        covered = np.zeros(len(vertices), dtype=np.int64)
        spreads = np.full(len(vertices), np.inf)
        covered[self.parts.skin], spreads[self.parts.skin] = count, spread
        return NeutralSurface(vertices, covered, spreads)

    def _to_cloud(self) -> None:
        """Draw the skin to the points of the cameras: first the face, then what is around it."""
        near = _distances(self.cloud, self.goals) < _FROM_LANDMARKS * self.face
        for number, step in enumerate(_STEPS):
            points = self.cloud[near] if number == 0 else self.cloud
            shown = self._shown()
            for turn in range(3):
                self.say("the template to the cameras' points", (3 * number + turn) / 9)
                width, reach = step.width * self.face, step.reach * self.face
                drawn = to_points(self._own(), points, shown, width=width, reach=reach)
                terms = _sum(drawn, self._landmarks(step.landmarks))
                self._solve(terms, arap=step.arap, bending=step.bending, rounds=3)

    def _by_stereo(self) -> tuple[NDArray[np.int64], Points]:
        """Move the skin to where photographs agree: how many do at each vertex, and how well."""
        pairs = pairs_of([crop.camera for crop in self.crops], self.middle, _EACH)
        for number, each in enumerate(_ROUNDS):
            self.say("the template to the photographs", number / len(_ROUNDS))
            density = each.density / self.face
            crops = [no_finer(crop, density, self.middle) for crop in self.crops]
            pixel = 1 / min(density, float(np.median([self._density(c.camera) for c in crops])))
            vertices = self.parts.carried(self.skin)
            whole = Surface(vertices, self.triangles)
            found = offsets_from(crops, whole, self.parts.place >= 0, pairs, _BEFORE * self.face)
            own = self.parts.place[found.vertices]
            agreed = _agreed(own, found.offsets, found.weights, len(self.skin), pixel)
            agreed.drop(np.abs(agreed.offsets) > each.reach * self.face)
            surface = self._own()
            terms = along_normals(surface, agreed.weights, agreed.offsets)
            # Photographs tell more than single points, where they tell anything.
            rest = self._shown() & (agreed.counts == 0)
            width, reach = 0.01 * self.face, 0.1 * self.face
            drawn = to_points(surface, self.cloud, rest, width=width, reach=reach)
            terms = _sum(terms, drawn, 0.3)
            terms = _sum(terms, self._landmarks(0.2))
            if self.lips is not None:
                terms = _sum(terms, self._ends_of_lips(self.lips, crops, whole))
            self._solve(terms, arap=_ARAP, bending=each.bending, rounds=3)
        return agreed.counts, agreed.spread

    def _density(self, camera: Camera) -> float:
        """Pixels to a unit of length at the face."""
        return camera.focal / float(np.linalg.norm(self.middle - camera.position))

    def _own(self) -> Surface:
        return Surface(self.skin, self.parts.triangles)

    def _shown(self) -> NDArray[np.bool_]:
        """(S,) which vertices of the skin any photograph shows."""
        whole = Surface(self.parts.carried(self.skin), self.triangles)
        shown = np.zeros(len(self.skin), dtype=bool)
        for crop in self.crops:
            shown |= whole.visible(
                crop.camera,
                self.skin,
                whole.normals[self.parts.skin],
                least_cosine=0.0,
                tolerance=_BEFORE * self.face,
            )[0]
        return shown

    def _landmarks(self, weight: float) -> tuple[Points, Points]:
        return to_places(len(self.skin), self.marks, self.goals, weight)

    def _ends_of_lips(
        self, lips: Lips, crops: Sequence[View], whole: Surface
    ) -> tuple[Points, Points]:
        up, higher, weights = lips.moved(crops, whole)
        higher, weights = higher[self.parts.skin], weights[self.parts.skin]
        return (
            weights[:, None, None] * np.outer(up, up),
            (weights * (self.skin @ up + higher))[:, None] * up,
        )

    def _solve(
        self, terms: tuple[Points, Points], *, arap: float, bending: float, rounds: int
    ) -> None:
        self.skin = self.deformation.solve(
            self.skin, *terms, arap=arap, bending=bending, rounds=rounds
        )


@dataclass(eq=False)
class _Agreed:
    """What observations say of each vertex together.

    Attributes:
        offsets: (S,) along the normal.
        weights: (S,) 0 where too few observations agree.
        counts: (S,) int64 observations that agree.
        spread: (S,) their standard deviation; infinite where too few agree.
    """

    offsets: Points
    weights: Points
    counts: NDArray[np.int64]
    spread: Points

    def drop(self, some: NDArray[np.bool_]) -> None:
        """Forget what was observed at some vertices."""
        self.offsets[some] = self.weights[some] = 0
        self.counts[some] = 0
        self.spread[some] = np.inf


def _agreed(
    vertices: NDArray[np.int64], offsets: Points, weights: Points, count: int, pixel: float
) -> _Agreed:
    """The mean of the observations of each of `count` vertices that agree with their median."""
    middles = _medians(vertices, offsets, count)
    away = offsets - middles[vertices]
    deviations = _medians(vertices, np.abs(away), count)
    weights = weights * robust(away, _WIDTH * pixel)
    total = np.bincount(vertices, weights, count)
    mean = np.bincount(vertices, weights * offsets, count) / np.maximum(total, 1e-30)
    near = np.abs(away) < 2 * _WIDTH * pixel
    counts = np.bincount(vertices[near], minlength=count)
    found = _Agreed(mean, np.minimum(total, _MOST_WEIGHT), counts, 1.4826 * deviations)
    found.drop((counts < _FEWEST) | (deviations > _DEVIATION * pixel))
    return found


def _medians(vertices: NDArray[np.int64], values: Points, count: int) -> Points:
    """(count,) median of the values at each vertex; 0 where there are none."""
    order = np.lexsort((values, vertices))
    ordered = np.append(values[order], 0.0)
    times = np.bincount(vertices, minlength=count)
    first = np.cumsum(times) - times
    low, high = first + np.maximum(times - 1, 0) // 2, first + times // 2
    return np.where(times > 0, (ordered[low] + ordered[np.minimum(high, len(values))]) / 2, 0.0)


def _near(cloud: Points, rest: Points, face: float) -> NDArray[np.bool_]:
    """(N,) which points are in the box of the placed template, and half a face around it."""
    low, high = rest.min(axis=0) - face / 2, rest.max(axis=0) + face / 2
    return np.asarray(((cloud > low) & (cloud < high)).all(axis=1))


def _distances(points: Points, others: Points) -> Points:
    """(N,) from (N, 3) points to the nearest of (M, 3) others."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(others).query(points)[0])


def _sum(
    terms: tuple[Points, Points], others: tuple[Points, Points], share: float = 1.0
) -> tuple[Points, Points]:
    return terms[0] + share * others[0], terms[1] + share * others[1]


# The colours of the neutral in the texture coordinates of the template, from its photographs.
#
# Each texel is a point of the surface. Photographs that see it, as rays tell, are blended: one
# counts by how many of its pixels a piece of skin has there, which is by angle and distance, and
# less where something that hides skin begins. Their exposures are brought together first, and
# colours that most do not share, such as highlights, count less. Light and shade that all have in
# common stay.


_COLOUR_COSINE = 0.2
_HIDING = 0.002  # of the diameter: what may stand before skin without hiding it, for rounding
_SHARPER = 2  # power by which more pixels count more
_FEATHER = 12  # texels over which a photograph fades out towards what is hidden from it
_EDGE = 2.0  # texels from there that it does not count for: its pixels show what hides them too
_UNUSED = 4.0  # px of a photograph that are not used
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
        self.before = _HIDING * float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))

    def add(self, camera: Camera, photograph: Path) -> None:
        """What a photograph shows."""
        import cv2

        original, scale = camera, min(1.0, _LONGEST / max(camera.size))
        camera = original.without_distortion(scale)
        visible, cosines = self.surface.visible(
            camera,
            self.points,
            self.normals,
            least_cosine=_COLOUR_COSINE,
            tolerance=self.before,
            border=_UNUSED,
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
