"""Faces drawn alike, on paper or on nothing."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from elastomorph.curves import extract_curves
from elastomorph.draw.curves_picture import network_lines
from elastomorph.draw.framing import camera_for
from elastomorph.draw.grid import ColourScale
from elastomorph.draw.portrait import (
    Finish,
    Portrait,
    colour_named,
    legend_height,
    with_legend,
)
from elastomorph.draw.stage import BACKGROUND, Stage
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh

SIZE = (80, 100)


def _portrait(mesh: Mesh, finish: Finish | None = None, **given: NDArray) -> NDArray[np.uint8]:
    with Portrait(mesh, camera_for(mesh, size=SIZE), SIZE, finish) as portrait:
        return portrait.picture(mesh.vertices, **given)


def test_the_plain_finish_is_the_plain_stage(sphere: Mesh) -> None:
    with Stage(sphere, size=SIZE) as stage:
        np.testing.assert_array_equal(_portrait(sphere), stage.picture())


def test_transparent_pictures_laid_on_a_colour_are_pictures_on_that_colour(sphere: Mesh) -> None:
    """Over paper: a C + (1 - a) B is what is drawn on B. Inside opaque, outside nothing."""
    cut = _portrait(sphere, Finish(background=None))
    assert cut.shape == (*SIZE[::-1], 4)
    share = cut[..., 3:] / 255.0
    for colour in (BACKGROUND, (0.0, 0.3, 0.9)):
        laid = share * cut[..., :3] + (1 - share) * 255 * np.array(colour)
        drawn = _portrait(sphere, Finish(background=colour))
        np.testing.assert_allclose(laid, drawn, atol=2.5)
    assert cut[50, 40, 3] == 255
    assert (cut[0, 0] == 0).all()
    assert ((cut[..., 3] > 0) & (cut[..., 3] < 255)).any()  # a smooth outline


def test_distances_are_colours_of_the_scale(sphere: Mesh) -> None:
    scale = ColourScale(2.0, "distance")
    none = _portrait(sphere, Finish(scale=scale), distances=np.zeros(len(sphere.vertices)))
    much = _portrait(sphere, Finish(scale=scale), distances=np.full(len(sphere.vertices), 2.0))
    assert none[50, 40].sum() > 500
    assert much[50, 40].sum() < 150
    with pytest.raises(ParameterError, match="scale"):
        _portrait(sphere, Finish(), distances=np.zeros(len(sphere.vertices)))


def test_lines_and_polygons_are_drawn(sphere: Mesh) -> None:
    plain = _portrait(sphere).astype(int)
    assert np.abs(_portrait(sphere, Finish(wireframe=True)) - plain).mean() > 1
    lines = network_lines(sphere, extract_curves(sphere))
    lined = _portrait(sphere, Finish(lines=lines)).astype(int)
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
