"""Where the lips meet, found again in photographs of the neutral.

What photographs say of a surface along its normals does not say where along the skin a vertex is:
the lips of the template may end a millimetre above or below those of the subject, and skin of one
would go with the other as soon as the mouth opens. But between closed lips, and within those that
part a little, every photograph is dark. The dark line is looked for across the line where a camera
sees the lips of the template meet, all along the mouth at once (by dynamic programming). The lip
that stands before the other there ends where the line begins on its side, by the steepest change.

Lengths are parts of the width of the mouth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import View
from elastomorph.capturing.geometry.sampling import sampled
from elastomorph.capturing.geometry.surface import Hits, Surface
from elastomorph.capturing.geometry.table import Table

Points = NDArray[np.float64]
Rows = NDArray[np.int64]

_NAMES = ("mouth_right", "mouth_left", "upper_lip", "lower_lip")
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
_NEAR, _AGREE, _FEWEST = 0.05, 0.03, 3


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
        if len(values) >= _FEWEST:
            kept[number] = abs(ends.higher[number] - np.median(values)) < _AGREE
    return ends.chosen(kept)
