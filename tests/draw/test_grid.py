"""Grids hold their pictures unchanged, beside legible words."""

from __future__ import annotations

import matplotlib
import numpy as np
import pytest
from numpy.typing import NDArray

from elastomorph.draw.grid import ColourScale, picture_grid, stack, text_size_for
from elastomorph.errors import ParameterError


def _patch(seed: int, size: tuple[int, int] = (40, 60)) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(0, 256, (*size, 3), dtype=np.uint8)


def _place_of(patch: NDArray[np.uint8], sheet: NDArray[np.uint8]) -> tuple[int, int]:
    """Row and column at which a picture lies in a sheet, found by looking everywhere."""
    height, width = patch.shape[:2]
    corners = (sheet[: -height + 1, : -width + 1] == patch[0, 0]).all(axis=2)
    for row, column in zip(*np.nonzero(corners), strict=True):
        if np.array_equal(sheet[row : row + height, column : column + width], patch):
            return int(row), int(column)
    raise AssertionError("the picture is not in the sheet")


def test_pictures_lie_in_their_rows_and_columns_unchanged() -> None:
    rows = [[_patch(0), _patch(1)], [_patch(2), _patch(3)]]
    sheet = picture_grid(
        rows,
        row_labels=["first", "second\nrow"],
        column_labels=["t = 0", "t = 1"],
        captions=[["a", "b"], ["c", "d"]],
        title="A title",
        scale=ColourScale(2.0, "% of D"),
    )
    (a, b), (c, d) = [[_place_of(patch, sheet) for patch in row] for row in rows]
    assert a[0] == b[0] < c[0] == d[0]
    assert a[1] == c[1] < b[1] == d[1]


def test_words_take_room_beside_the_pictures_and_never_cover_them() -> None:
    patch = np.full((40, 60, 3), 255, dtype=np.uint8)
    bare = picture_grid([[patch]])
    assert (bare == 255).all()
    for words in (
        {"row_labels": ["a long label"]},
        {"column_labels": ["a column label that is wide"]},
        {"captions": [["a caption that is far too long for its picture"]]},
        {"title": "A title far wider than the picture below it"},
    ):
        sheet = picture_grid([[patch]], **words)  # type: ignore[arg-type]
        assert sheet.size > bare.size
        ink = (sheet < 128).any(axis=2)
        assert ink.any()
        # nothing is cut off at the edges of the sheet
        assert not np.concatenate([ink[0], ink[-1], ink[:, 0], ink[:, -1]]).any()


def test_the_last_row_may_be_shorter() -> None:
    sheet = picture_grid([[_patch(0), _patch(1)], [_patch(2)]])
    assert _place_of(_patch(2), sheet)[1] == _place_of(_patch(0), sheet)[1]


def test_the_legend_runs_from_the_first_colour_to_the_last() -> None:
    patch = np.full((40, 300, 3), 255, dtype=np.uint8)
    sheet = picture_grid([[patch]], scale=ColourScale(3.0, "error", "viridis"))
    for share in (0.0, 0.5, 1.0):
        colour = np.rint(np.array(matplotlib.colormaps["viridis"](share)[:3]) * 255)
        assert (np.abs(sheet - colour).max(axis=2) <= 3).any(), share


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([], {}),
        ([[_patch(0), _patch(1, (10, 10))]], {}),
        ([[_patch(0)]], {"row_labels": ["a", "b"]}),
        ([[_patch(0)]], {"column_labels": ["a", "b"]}),
        ([[_patch(0)]], {"captions": [["a"], ["b"]]}),
        ([[_patch(0)]], {"captions": [["a", "b"]]}),
    ],
)
def test_what_does_not_fit_together_is_refused(rows: object, words: dict[str, object]) -> None:
    with pytest.raises(ParameterError):
        picture_grid(rows, **words)  # type: ignore[arg-type]


def test_sheets_are_stacked_in_the_middle() -> None:
    wide, narrow = _patch(0, (10, 80)), _patch(1, (20, 40))
    whole = stack(wide, narrow, gap=6)
    assert whole.shape == (36, 80, 3)
    assert _place_of(narrow, whole) == (16, 20)


def test_letters_grow_with_the_pictures_within_limits() -> None:
    sizes = [text_size_for(width) for width in (50, 200, 300, 2000)]
    assert sizes == sorted(sizes)
    assert sizes[0] >= 12
