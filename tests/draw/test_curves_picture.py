"""The curve network is drawn with neighbours in different colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.draw.curves_picture import (
    PALETTE,
    curve_colours,
    curves_picture,
    network_lines,
)
from elastomorph.errors import CurveError
from scenes import ball, joined


def test_curves_side_by_side_differ(rings: CurveNetwork) -> None:
    mesh = ball()
    colours = curve_colours(mesh, rings)
    assert colours.shape == (len(rings), 3)
    sides = rings.curve_of[mesh.edges]
    for one, other in np.unique(sides[sides[:, 0] != sides[:, 1]], axis=0):
        assert (colours[one] != colours[other]).any()


def test_every_colour_is_used_before_one_is_overworked() -> None:
    """Curves without neighbours share the colours out evenly."""
    mesh = ball()
    network = CurveNetwork([Curve([v]) for v in range(0, 260, 2)], len(mesh.vertices))
    used = np.unique(curve_colours(mesh, network), axis=0, return_counts=True)[1]
    assert len(used) == len(PALETTE)
    assert np.ptp(used) <= 1


def test_closed_curves_return_to_their_start_and_are_wider(rings: CurveNetwork) -> None:
    open_lines, closed_lines = network_lines(ball(), rings)
    assert len(open_lines.paths) == 0  # the poles are curves of one vertex
    assert len(closed_lines.paths) == 11
    assert all(path[0] == path[-1] and len(path) == 25 for path in closed_lines.paths)
    assert closed_lines.width > open_lines.width


def test_curves_of_hidden_pieces_are_left_out() -> None:
    mesh = joined(skin=ball(), EyeOcclusion=ball(0.5))
    loops = [Curve(np.arange(24), True), Curve(np.arange(24) + 266, True)]
    lines = network_lines(mesh, CurveNetwork(loops, len(mesh.vertices)))[1]
    assert len(lines.paths) == 1
    assert lines.paths[0].max() < 266


def test_the_picture_shows_the_colours_of_the_curves(rings: CurveNetwork, tmp_path: Path) -> None:
    mesh = ball()
    path = tmp_path / "curves.png"
    image = curves_picture(mesh, rings, path, size=(200, 200), width=3.0)
    np.testing.assert_array_equal(np.asarray(Image.open(path)), image)
    # seen from the front, the parallels of the near half are circles round the middle
    near = np.unique(curve_colours(mesh, rings)[:5], axis=0)
    for colour in near:
        close = np.abs(image - np.rint(colour * 255)).max(axis=2) < 40
        assert close.sum() > 20


def test_curves_of_another_mesh_are_refused() -> None:
    with pytest.raises(CurveError, match="266"):
        curves_picture(ball(), CurveNetwork([Curve([0, 1])], 5))
