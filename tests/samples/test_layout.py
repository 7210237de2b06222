"""The grid and its rings: every cell is there once, and poles are only where they are meant."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from elastomorph.samples import groups
from elastomorph.samples.layout import CAP, COLUMNS, EAR, EYE, MOUTH, NOSTRIL, ROWS, half

BLOCKS = {"eye": EYE, "mouth": MOUTH, "nostril": NOSTRIL, "ear": EAR}


def test_every_vertex_is_used_and_no_polygon_repeats_one():
    lay = half()
    used = np.unique(np.concatenate([np.array(face) for face in lay.faces]))
    np.testing.assert_array_equal(used, np.arange(lay.size))
    assert all(len(set(face)) == len(face) for face in lay.faces)


@pytest.mark.parametrize("name", BLOCKS)
def test_rings_have_the_length_of_the_outline_they_replace(name):
    block, rings = BLOCKS[name], getattr(half(), name)
    height, width = block.bottom - block.top, block.back - block.front
    around = 2 * (height + width) if block.front else height + 2 * width + 1
    assert rings.shape == (block.rings + 1, around)
    assert len(np.unique(rings)) == rings.size


def test_the_number_of_cells_follows_from_the_layout():
    lay = half()
    cells = ROWS * COLUMNS + CAP[0] * CAP[1]
    for block in BLOCKS.values():
        covered = (block.bottom - block.top) * (block.back - block.front)
        spans = len(block.outline()) - (block.front == 0)
        cells += spans * block.rings + (covered if block.filled else 0) - covered
    throat = len(MOUTH.outline()) // 2
    assert len(lay.faces) == cells + throat == len(lay.face_groups)


def test_poles_are_only_at_the_corners_of_blocks_and_of_the_crown():
    lay = half()
    valence = Counter(v for face in lay.faces for v in face)
    border = set(lay.midline) | set(lay.grid[-1].tolist()) | set(lay.eye[-1].tolist())
    border |= set(lay.mouth[-1].tolist())
    irregular = {v for v, count in valence.items() if count != 4} - border
    corners = {
        int(lay.grid[row, column])
        for block in BLOCKS.values()
        for row in (block.top, block.bottom)
        for column in (block.front, block.back)
    }
    inner = {
        int(floor[r, c])
        for floor in (lay.nostril_floor, lay.ear_floor)
        for r in (0, -1)
        for c in (0, -1)
    }
    crown = {int(lay.cap[-1, 0]), int(lay.cap[-1, -1])}
    assert irregular == (corners | inner | crown) - border


def test_group_names_are_the_published_ones():
    published = {
        value
        for key, value in vars(groups).items()
        if key.isupper() and key != "EYES" and isinstance(value, str)
    }
    assert set(half().face_groups) <= published
