"""Where every vertex of the left half of the skin lies."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sculptor import ears, guide, lids, lips
from sculptor.anatomy import skin
from sculptor.implicit import Points, cast, settle
from sculptor.layout import CAP, EYE, MOUTH, NOSTRIL, Half, half

if TYPE_CHECKING:
    from scipy import sparse

__all__ = ["half_skin"]

_RELAXATIONS = 10  # rounds of even spacing on the skin
_SMOOTHINGS = 2  # last rounds, free to leave it
_BROW = slice(0, 10)  # places of the eyebrow in the rings around the eye


@cache
def half_skin() -> Points:
    """(N, 3) positions of the vertices of :func:`layout.half`."""
    lay = half()
    points = np.full((lay.size, 3), np.nan)
    start, end = guide.rays()
    used = lay.grid >= 0
    points[lay.grid[used]] = cast(skin, start[used], end[used])
    _crown(points, lay)
    _eyes(points, lay)
    _mouth(points, lay)
    _nostrils(points, lay)
    _ears(points, lay)
    points[lay.midline, 0] = 0.0
    _relax(points, lay)
    _nostrils(points, lay)
    points.flags.writeable = False
    return points


def _crown(points: Points, lay: Half) -> None:
    """The patch on top: its outline blended across, then cast from the middle of the skull."""
    wide, long = CAP
    cap = lay.cap
    u = (np.arange(wide + 1) / wide)[:, None, None]
    v = (np.arange(long + 1) / long)[None, :, None]
    outer = points[cap[wide]][None]
    middle_front, middle_back = points[cap[0, 0]], points[cap[0, -1]]
    middle = ((1 - v) * middle_front + v * middle_back) * [0.0, 1.0, 1.0]
    across = (1 - u) * middle + u * outer
    front, back = points[cap[:, 0]][:, None], points[cap[:, long]][:, None]
    along = (1 - v) * front + v * back
    corners = (1 - u) * ((1 - v) * middle_front + v * middle_back) + u * (
        (1 - v) * points[cap[wide, 0]] + v * points[cap[wide, long]]
    )
    patch = (across + along - corners)[:wide, 1:long].reshape(-1, 3)
    centre = np.array([0.0, 2.0, -0.8])
    points[cap[:wide, 1:long].ravel()] = cast(
        skin, centre + 2.2 * (patch - centre), np.broadcast_to(centre, patch.shape)
    )


def _onto_skin(points: Points) -> Points:
    """Points moved along z onto the skin."""
    return cast(skin, points * [1, 1, 0] + [0, 0, 16.0], points * [1, 1, 0])


def _eyes(points: Points, lay: Half) -> None:
    outline = points[lay.eye[0]]
    rings = lids.lid_rings()
    points[lay.eye[lids.CREASE :]] = rings
    fold = rings[0]
    loops = [outline + share * (fold - outline) for share in (0.22, 0.5)]
    top, bottom = _brow()
    for loop, edge in zip(loops, (top, bottom), strict=True):
        loop[_BROW] = edge
        for place in (_BROW.stop, len(loop) - 1):  # ease from the ends of the brow into the loop
            loop[place] = 0.5 * (loop[place - 1] + loop[(place + 1) % len(loop)])
    loops.append(loops[1] + 0.62 * (fold - loops[1]))
    for ring, loop in enumerate(loops, start=1):
        points[lay.eye[ring]] = _onto_skin(loop)


def _brow() -> tuple[Points, Points]:
    """Upper and lower edge of the eyebrow, seen from the front (z is left at 0)."""
    share = np.linspace(0.0, 1.0, 10)
    x = 1.5 + 3.85 * share
    middle = 1.82 + 0.36 * np.sin(np.pi * share**1.35) - 0.08 * share
    thick = 0.50 * (1.0 - share**2.2) ** 0.75 + 0.08
    thick[0] *= 0.8
    zero = np.zeros_like(x)
    lean = 0.08 * (1.0 - share)  # the inner end leans towards the nose
    return (
        np.stack([x - lean, middle + 0.5 * thick, zero], axis=1),
        np.stack([x + lean, middle - 0.5 * thick, zero], axis=1),
    )


def _mouth(points: Points, lay: Half) -> None:
    outline = points[lay.mouth[0]]
    rings = lips.lip_rings()
    points[lay.mouth[lips.BORDER - 1 :]] = rings
    for ring, share in ((1, 0.33), (2, 0.66)):
        points[lay.mouth[ring]] = _onto_skin(outline + share * (rings[0] - outline))


def _nostrils(points: Points, lay: Half) -> None:
    outline = points[lay.nostril[0]]
    centre = outline.mean(axis=0)
    across, up = 0.5 * (outline[3] - outline[7]), 0.5 * (outline[1] - outline[5])
    turn = np.radians(135.0 - 45.0 * np.arange(8))[:, None]
    oval = np.cos(turn) * across + np.sin(turn) * up
    inwards = np.array([0.0, 0.85, -0.4])
    points[lay.nostril[1]] = centre + 0.78 * oval
    points[lay.nostril[2]] = centre + 0.62 * oval + 0.40 * inwards
    points[lay.nostril_floor[1:-1, 1:-1]] = centre + 0.7 * inwards


def _ears(points: Points, lay: Half) -> None:
    points[lay.ear[1:]] = ears.ear_rings()
    points[lay.ear_floor] = ears.ear_floor(points[lay.ear_floor])


def _wings(points: Points, lay: Half) -> NDArray[np.int64]:
    """Lay the loop that ends the nose into the fold around its wing; returns its vertices."""
    fold = np.array(
        [
            (1.80, -3.55), (1.94, -3.95), (1.97, -4.33), (1.90, -4.68), (1.68, -4.93),
            (1.36, -5.04), (1.02, -5.04), (0.68, -5.04), (0.34, -5.08), (0.0, -5.10),
        ]
    )  # fmt: skip
    last, column = MOUTH.top - 1, NOSTRIL.back + 2
    loop = [lay.grid[row, column] for row in range(last - 5, last)]
    loop += [lay.grid[last, c] for c in range(column - 1, -1, -1)]
    points[loop] = _onto_skin(np.c_[fold, np.zeros(len(fold))])
    return np.array(loop)


def _relax(points: Points, lay: Half) -> None:
    """Even out the spacing of the loops, each vertex staying on the skin."""
    free = np.zeros(lay.size, dtype=bool)
    free[lay.grid[lay.grid >= 0]] = True
    free[lay.cap.ravel()] = True
    free[lay.eye[1:4, _BROW.stop + 1 : -1].ravel()] = True
    free[lay.mouth[1:3].ravel()] = True
    free[lay.grid[-1]] = False
    wings = _wings(points, lay)
    free[wings] = False
    nose = lay.grid[EYE.bottom + 1 : MOUTH.top, : NOSTRIL.back + 3]
    pace = np.full((lay.size, 1), 0.5)
    average = _neighbours(lay)
    for step in range(_RELAXATIONS + _SMOOTHINGS):
        if step == _RELAXATIONS:
            pace[nose[nose >= 0]] = 0.15
            free[wings] = True
        points[free] += pace[free] * (average[free] @ points - points[free])
        points[lay.midline, 0] = 0.0
        if step < _RELAXATIONS:
            points[free] = settle(skin, points[free], steps=1)
            points[lay.midline, 0] = 0.0


def _neighbours(lay: Half) -> sparse.csr_array:
    """The matrix that averages each vertex's neighbours, mirrored ones included."""
    from scipy import sparse

    corners = [(f[k], f[k - 1]) for f in lay.faces for k in range(len(f))]
    pairs = np.unique(np.sort(np.array(corners), axis=1), axis=0)
    i = np.concatenate([pairs[:, 0], pairs[:, 1]])
    j = np.concatenate([pairs[:, 1], pairs[:, 0]])
    middle = np.zeros(lay.size, dtype=bool)
    middle[lay.midline] = True
    weight: NDArray[np.float64] = np.where(middle[i] & ~middle[j], 2.0, 1.0)
    matrix = sparse.csr_array((weight, (i, j)), shape=(lay.size, lay.size))
    return sparse.csr_array(sparse.diags_array(1.0 / matrix.sum(axis=1)) @ matrix)
