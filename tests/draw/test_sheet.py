"""Sheets hold their pictures unchanged, beside legible words."""

from __future__ import annotations

import matplotlib
import numpy as np
import pytest
from numpy.typing import NDArray

from elastomorph.curves import extract_curves
from elastomorph.draw.camera import camera_for
from elastomorph.draw.curves_picture import network_lines
from elastomorph.draw.pictures import ColourScale, colour_named
from elastomorph.draw.sheet import (
    Face,
    Style,
    face_sheet,
    legend_height,
    picture_grid,
    stack,
    text_size_for,
    with_legend,
)
from elastomorph.draw.stage import BACKGROUND, Stage
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh


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
    whole = stack(wide, narrow)
    assert whole.shape == (30, 80, 3)
    assert _place_of(narrow, whole) == (10, 20)


def test_letters_grow_with_the_pictures_within_limits() -> None:
    sizes = [text_size_for(width) for width in (50, 200, 300, 2000)]
    assert sizes == sorted(sizes)
    assert sizes[0] >= 12


SIZE = (80, 100)


def _drawn(mesh: Mesh, style: Style) -> NDArray[np.uint8]:
    with Stage(mesh, size=SIZE) as stage:
        return style.draw(stage, mesh.vertices)


def test_the_plain_style_is_the_plain_stage(sphere: Mesh) -> None:
    with Stage(sphere, size=SIZE) as stage:
        np.testing.assert_array_equal(_drawn(sphere, Style()), stage.picture())


def test_transparent_pictures_laid_on_a_colour_are_pictures_on_that_colour(sphere: Mesh) -> None:
    """Over paper: a C + (1 - a) B is what is drawn on B. Inside opaque, outside nothing."""
    cut = _drawn(sphere, Style(background=None))
    assert cut.shape == (*SIZE[::-1], 4)
    share = cut[..., 3:] / 255.0
    for colour in (BACKGROUND, (0.0, 0.3, 0.9)):
        laid = share * cut[..., :3] + (1 - share) * 255 * np.array(colour)
        drawn = _drawn(sphere, Style(background=colour))
        np.testing.assert_allclose(laid, drawn, atol=2.5)
    assert cut[50, 40, 3] == 255
    assert (cut[0, 0] == 0).all()
    assert ((cut[..., 3] > 0) & (cut[..., 3] < 255)).any()  # a smooth outline


def test_values_are_colours_of_the_scale(sphere: Mesh) -> None:
    none, much = np.zeros(len(sphere.vertices)), np.full(len(sphere.vertices), 2.0)
    faces = [Face(sphere.vertices, "none", none), Face(sphere.vertices, "much", much)]
    camera = camera_for(sphere, size=SIZE)
    sheet = face_sheet(sphere, [faces], camera, SIZE, scale=ColourScale(2.0, "distance"))
    middles = [sheet[54, x] for x in (44, 128)]
    assert middles[0].sum() > 500
    assert middles[1].sum() < 150


def test_lines_and_polygons_are_drawn(sphere: Mesh) -> None:
    plain = _drawn(sphere, Style()).astype(int)
    assert np.abs(_drawn(sphere, Style(wireframe=True)) - plain).mean() > 1
    lines = network_lines(sphere, extract_curves(sphere))
    lined = _drawn(sphere, Style(lines=lines)).astype(int)
    colourful = np.ptp(lined, axis=2) > 60
    assert colourful.sum() > 50
    assert not (np.ptp(plain, axis=2) > 60).any()


@pytest.mark.parametrize("width", [120, 480, 720, 1920])
def test_the_legend_adds_just_its_height(width: int) -> None:
    words = "distance from beam R=2, cm   (largest 0.369 cm = 1.2 % of D, D = 30.09 cm)"
    scale = ColourScale(0.4, words)
    face = np.full((60, width, 3), 100, dtype=np.uint8)
    whole = with_legend(face, scale)
    assert whole.shape == (60 + legend_height(width, scale), width, 3)
    np.testing.assert_array_equal(whole[:60], face)
    if width >= 480:  # the words do not run out of the picture
        assert (whole[60:, :2] == 255).all()
        assert (whole[60:, -2:] == 255).all()
    assert (whole[60:] < 128).any()


def test_without_a_scale_there_is_no_legend() -> None:
    face = np.zeros((4, 4, 3), dtype=np.uint8)
    assert with_legend(face, None) is face
    assert legend_height(400, None) == 0


def test_colours_by_name() -> None:
    assert colour_named("white") == (1.0, 1.0, 1.0)
    np.testing.assert_allclose(colour_named("#ff8000"), (1, 128 / 255, 0))
    with pytest.raises(ParameterError, match="blurple"):
        colour_named("blurple")
