"""Surface and correspondence are two figures: a mesh that slides along the skin has one of them."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.capturing.geometry import Surface
from elastomorph.capturing.tracking import Matches
from elastomorph.capturing.work.capture import skin_agreement, surface_agreement
from needs import extra

extra("embreex", "capture")

SIDE = 41


def sheet(bend: float = 0.0, slide: float = 0.0) -> Surface:
    """A sheet of 2 by 2, bent to a cylinder, whose vertices may slide round that."""
    across, up = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
    along = across.reshape(-1) + slide
    x, z = (np.sin(bend * along) / bend, (np.cos(bend * along) - 1) / bend) if bend else (along, 0)
    vertices = np.stack([x, up.reshape(-1), z + 0 * along], axis=1)
    place = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (
        own.reshape(-1) for own in (place[:-1, :-1], place[:-1, 1:], place[1:, 1:], place[1:, :-1])
    )
    return Surface(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def skin(count: int = 400) -> np.ndarray:
    """Places on the sheet that features were found at, away from its border."""
    return np.random.default_rng(2).uniform(-0.8, 0.8, (count, 2))


def on(places: np.ndarray, bend: float, height: float = 0.0) -> np.ndarray:
    """Where these are in the bent sheet, and at a height above it."""
    along, up = places.T
    if not bend:
        return np.stack([along, up, np.full(len(up), height)], axis=1)
    radius = 1 / bend + height
    return np.stack(
        [radius * np.sin(bend * along), up, radius * np.cos(bend * along) - 1 / bend], axis=1
    )


@pytest.mark.parametrize("height", [0.0, 0.01])
def test_skin_that_went_with_the_mesh_agrees(height: float) -> None:
    """Also of points above the surface, where features lie: the distance goes along."""
    matches = Matches(on(skin(), 0.0, height), on(skin(), 0.7, height))
    found = skin_agreement(sheet(), sheet(0.7), matches, 2.8)
    assert found["matches"] == 400
    assert found["p95"] < 2e-4  # straight edges of a bent surface


def test_a_mesh_that_slides_lies_on_the_surface_and_not_on_its_skin() -> None:
    slid = sheet(0.7, slide=0.05)
    points = on(skin(), 0.7)
    surface = surface_agreement(points, slid, 2.8)
    skin_of = skin_agreement(sheet(), slid, Matches(on(skin(), 0.0), points), 2.8)
    assert surface["points"] == 400
    assert surface["p95"] < 2e-4
    assert skin_of["median"] == pytest.approx(0.05 / 2.8, rel=0.01)


def test_a_distance_is_that_along_the_normal() -> None:
    found = surface_agreement(on(skin(), 0.0, 0.014), sheet(), 2.8)
    assert found == {"points": 400, "median": pytest.approx(0.005), "p95": pytest.approx(0.005)}


def test_other_skin_and_the_background_do_not_count() -> None:
    rng = np.random.default_rng(5)
    neutral, pose = on(skin(), 0.0), on(skin(), 0.7)
    pose[:40] += rng.normal(0, 0.3, (40, 3))
    found = skin_agreement(sheet(), sheet(0.7), Matches(neutral, pose), 2.8)
    assert 340 <= found["matches"] <= 372
    assert found["p95"] < 2e-3
    far = np.concatenate([on(skin(), 0.0), [[0, 0, 5.0]] * 100])
    assert surface_agreement(far, sheet(), 2.8)["points"] == 400


def test_of_too_few_nothing_is_said() -> None:
    few = on(skin(19), 0.0)
    assert surface_agreement(few, sheet(), 2.8) == {}
    assert skin_agreement(sheet(), sheet(), Matches(few, few), 2.8) == {}
    assert surface_agreement(few[:0], sheet(), 2.8) == {}
    far = on(skin(), 0.0) + [0, 0, 9.0]
    assert surface_agreement(far, sheet(), 2.8) == {}
    assert skin_agreement(sheet(), sheet(), Matches(far, far), 2.8) == {}
