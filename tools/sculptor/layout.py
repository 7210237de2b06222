"""Which polygons the head has: a grid around the skull with rings laid around its openings.

The left half (+x) is laid out first. Its grid has rows from the crown down to the neck and
columns from the front midline round to the back. Rectangles of that grid are replaced by
concentric rings around the eye, the mouth, the nostril and the ear, so that edge loops follow
the muscles; a quad patch closes the crown. The other half is the mirror image, welded at x = 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sculptor import groups

__all__ = ["CAP", "COLUMNS", "EAR", "EYE", "MOUTH", "NOSTRIL", "ROWS", "Block", "Half", "half"]

Indices = NDArray[np.int64]

ROWS = 40
COLUMNS = 32
CAP = (8, 16)  # half width and length of the patch that closes the crown, in cells


@dataclass(frozen=True)
class Block:
    """A rectangle of the grid that rings replace.

    Attributes:
        top: Its first row.
        bottom: Its last row.
        front: Its first column; 0 is the midline.
        back: Its last column.
        rings: How many rings lie inside its outline.
        filled: Whether the last ring is closed by a patch of quads.
    """

    top: int
    bottom: int
    front: int
    back: int
    rings: int
    filled: bool

    def outline(self) -> list[tuple[int, int]]:
        """(row, column) along the outline, clockwise seen from outside.

        A block that touches the midline is open: it runs from the upper to the lower midline.
        """
        top = [(self.top, c) for c in range(self.front, self.back)]
        back = [(r, self.back) for r in range(self.top, self.bottom)]
        bottom = [(self.bottom, c) for c in range(self.back, self.front, -1)]
        if self.front == 0:
            return [*top, *back, *bottom, (self.bottom, 0)]
        return [*top, *back, *bottom, *((r, self.front) for r in range(self.bottom, self.top, -1))]

    def inside(self, row: int, column: int) -> bool:
        """Whether a grid vertex lies inside the outline."""
        inner = column < self.back and (column > self.front or self.front == 0)
        return self.top < row < self.bottom and inner

    def covers(self, row: int, column: int) -> bool:
        """Whether the grid cell below and behind a vertex belongs to the block."""
        return self.top <= row < self.bottom and self.front <= column < self.back


EYE = Block(top=8, bottom=12, front=4, back=13, rings=9, filled=False)
MOUTH = Block(top=22, bottom=26, front=0, back=7, rings=13, filled=False)
NOSTRIL = Block(top=18, bottom=20, front=1, back=3, rings=2, filled=True)
EAR = Block(top=8, bottom=17, front=17, back=22, rings=8, filled=True)


@dataclass
class Half:
    """Vertices and polygons of the left half of the skin, before it is mirrored.

    Attributes:
        size: Number of vertices.
        grid: (ROWS + 1, COLUMNS + 1) vertex indices, -1 inside blocks.
        cap: (half width + 1, length + 1) vertex indices of the crown patch.
        eye, mouth, nostril, ear: (rings + 1, n) vertex indices; row 0 is the outline.
        nostril_floor, ear_floor: (rows, columns) indices of the patches that close these blocks.
        midline: Vertices with x = 0.
        faces: Polygons, counter-clockwise seen from outside.
        face_groups: Group name of each polygon.
    """

    size: int = 0
    grid: Indices = field(default_factory=lambda: np.full((ROWS + 1, COLUMNS + 1), -1))
    cap: Indices = field(default_factory=lambda: np.full((CAP[0] + 1, CAP[1] + 1), -1))
    eye: Indices = field(default_factory=lambda: np.empty((0, 0), dtype=np.int64))
    mouth: Indices = field(default_factory=lambda: np.empty((0, 0), dtype=np.int64))
    nostril: Indices = field(default_factory=lambda: np.empty((0, 0), dtype=np.int64))
    ear: Indices = field(default_factory=lambda: np.empty((0, 0), dtype=np.int64))
    nostril_floor: Indices = field(default_factory=lambda: np.empty((0, 0), dtype=np.int64))
    ear_floor: Indices = field(default_factory=lambda: np.empty((0, 0), dtype=np.int64))
    midline: list[int] = field(default_factory=list)
    faces: list[list[int]] = field(default_factory=list)
    face_groups: list[str] = field(default_factory=list)

    def new(self, count: int) -> Indices:
        """Indices of fresh vertices."""
        self.size += count
        return np.arange(self.size - count, self.size)

    def add(self, face: list[int], group: str) -> None:
        """Add a polygon."""
        self.faces.append([int(v) for v in face])
        self.face_groups.append(group)


@cache
def half() -> Half:
    """The layout of the left half of the skin, mouth and lids included."""
    out = Half()
    _lay_grid(out)
    _lay_cap(out)
    out.eye, _ = _lay_rings(out, EYE, groups.eye_ring)
    out.nostril, out.nostril_floor = _lay_rings(out, NOSTRIL, groups.nostril_ring)
    out.ear, out.ear_floor = _lay_rings(out, EAR, groups.ear_ring)
    out.mouth, _ = _lay_rings(out, MOUTH, groups.mouth_ring)
    _close_throat(out)
    return out


def _lay_grid(out: Half) -> None:
    blocks = (EYE, MOUTH, NOSTRIL, EAR)
    for row in range(ROWS + 1):
        for column in range(COLUMNS + 1):
            if not any(block.inside(row, column) for block in blocks):
                out.grid[row, column] = out.new(1)[0]
                if column in (0, COLUMNS):
                    out.midline.append(int(out.grid[row, column]))
    grid = out.grid
    for row in range(ROWS):
        for column in range(COLUMNS):
            if not any(block.covers(row, column) for block in blocks):
                out.add(
                    [
                        grid[row, column],
                        grid[row + 1, column],
                        grid[row + 1, column + 1],
                        grid[row, column + 1],
                    ],
                    groups.SKIN,
                )


def _lay_cap(out: Half) -> None:
    wide, long = CAP
    cap = out.cap
    cap[:, 0] = out.grid[0, : wide + 1]
    cap[wide, :] = out.grid[0, wide : wide + long + 1]
    cap[:, long] = out.grid[0, wide + long :][::-1]
    for k in range(1, long):
        cap[:wide, k] = out.new(wide)
        out.midline.append(int(cap[0, k]))
    for i in range(wide):
        for k in range(long):
            out.add([cap[i, k], cap[i + 1, k], cap[i + 1, k + 1], cap[i, k + 1]], groups.SKIN)


def _lay_rings(out: Half, block: Block, group_of: groups.RingGroups) -> tuple[Indices, Indices]:
    outline = np.array([out.grid[place] for place in block.outline()])
    closed = block.front > 0
    rings = np.vstack([outline, *(out.new(len(outline)) for _ in range(block.rings))])
    if not closed:
        out.midline.extend(int(v) for v in rings[1:, [0, -1]].ravel())
    following = np.roll(rings, -1, axis=1) if closed else rings[:, 1:]
    for ring in range(block.rings):
        for k in range(following.shape[1]):
            out.add(
                [rings[ring, k], rings[ring + 1, k], following[ring + 1, k], following[ring, k]],
                group_of(ring, k),
            )
    if not block.filled:
        return rings, np.empty((0, 0), dtype=np.int64)
    shape = (block.bottom - block.top + 1, block.back - block.front + 1)
    floor = np.full(shape, -1)
    for (row, column), vertex in zip(block.outline(), rings[-1], strict=True):
        floor[row - block.top, column - block.front] = vertex
    floor[1:-1, 1:-1] = out.new((shape[0] - 2) * (shape[1] - 2)).reshape(shape[0] - 2, -1)
    for r in range(shape[0] - 1):
        for c in range(shape[1] - 1):
            out.add(
                [floor[r, c], floor[r + 1, c], floor[r + 1, c + 1], floor[r, c + 1]],
                group_of(block.rings, 0),
            )
    return rings, floor


def _close_throat(out: Half) -> None:
    last = out.mouth[-1]
    corner = len(last) // 2
    for k in range(corner):
        face = [last[k], last[-1 - k], last[-2 - k], last[k + 1]]
        out.add(face if k + 1 < corner else face[:3], groups.MOUTH)
