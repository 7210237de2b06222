"""The dark line between lips, painted where it is known to be."""

import numpy as np
import pytest
from painted import grid, photograph, ring

from elastomorph.capturing.geometry import Camera, Surface, View
from elastomorph.capturing.neutral import Lips, cropped
from needs import extra

extra("cv2", "capture")
extra("embreex", "capture")

COUNT = 41
HALF = 0.02
"""Half the height of the dark gap, in which a pixel is 0.007."""


def mouth() -> tuple[Surface, dict[str, int], np.ndarray]:
    """A flat square cut along y = 0 for |x| < 0.6; its landmarks; which vertices end there."""
    vertices, triangles = grid(COUNT, curve=0.0)
    row = np.flatnonzero((np.abs(vertices[:, 1]) < 1e-9) & (np.abs(vertices[:, 0]) < 0.59))
    renamed = np.arange(len(vertices))
    renamed[row] = np.arange(len(vertices), len(vertices) + len(row))
    above = vertices[triangles].mean(axis=1)[:, 1] > 0
    doubled = np.concatenate([vertices, vertices[row]])
    surface = Surface(doubled, np.where(above[:, None], renamed[triangles], triangles))
    places = {
        "mouth_right": (-0.6, 0),
        "mouth_left": (0.6, 0),
        "upper_lip": (0, 0.3),
        "lower_lip": (0, -0.3),
    }
    landmarks = {
        name: int(np.linalg.norm(vertices[:, :2] - place, axis=1).argmin())
        for name, place in places.items()
    }
    return surface, landmarks, np.concatenate([row, renamed[row]])


def line(x: np.ndarray) -> np.ndarray:
    """How much higher than the cut the gap lies."""
    return 0.03 + 0.03 * x


def lips(places: np.ndarray) -> np.ndarray:
    x, y, _ = np.moveaxis(places, -1, 0)
    dark = (np.abs(y - line(x)) < HALF) & (np.abs(x) < 0.6)
    return np.where(dark, 30.0, 140.0)


def skin(places: np.ndarray) -> np.ndarray:
    return np.full(places.shape[:-1], 140.0)


def crops(cameras: list[Camera], colour) -> list[View]:
    vertices, triangles = grid(5, curve=0.0)
    flat = Surface(vertices, triangles)
    views = [photograph(camera, flat, vertices, colour, seed=n) for n, camera in enumerate(cameras)]
    found = [cropped(view, vertices) for view in views]
    return [crop for crop in found if crop]


@pytest.fixture(scope="module")
def cameras() -> list[Camera]:
    return ring((400, 400), 5)


def test_lips_end_where_the_dark_line_begins(cameras):
    """The upper lip at the upper edge of the gap, the lower one at the lower: to two pixels."""
    surface, landmarks, ends = mouth()
    found = Lips.of(surface, landmarks)
    up, higher, weights = found.moved(crops(cameras, lips), surface)
    assert up == pytest.approx([0, 1, 0], abs=1e-9)
    inner = ends[np.abs(surface.vertices[ends, 0]) < 0.45]
    assert (weights[inner] > 0.5).all()
    goal = line(surface.vertices[inner, 0]) + HALF * found.side[inner]
    off = higher[inner] - goal
    assert np.abs(off).max() < 0.014
    assert abs(off.mean()) < 0.004
    # What is not beside the line stays.
    assert (weights[np.abs(surface.vertices[:, 1]) > 0.11] == 0).all()


def test_without_a_line_nothing_moves(cameras):
    surface, landmarks, _ = mouth()
    _, higher, weights = Lips.of(surface, landmarks).moved(crops(cameras, skin), surface)
    assert not weights.any()
    assert not higher.any()


def test_each_half_of_the_skin_is_nearer_to_its_lip():
    surface, landmarks, ends = mouth()
    side = Lips.of(surface, landmarks).side
    middle = np.abs(surface.vertices[:, 0]) < 0.5
    above = surface.vertices[:, 1] > 1e-6
    below = surface.vertices[:, 1] < -1e-6
    assert (side[middle & above] == 1).all()
    assert (side[middle & below] == -1).all()
    # Both vertices at one place of the cut, each of its own lip.
    assert sorted(side[ends[np.abs(surface.vertices[ends, 0]) < 0.02]]) == [-1, 1]


@pytest.mark.parametrize("lacking", ["mouth_left", "upper_lip"])
def test_without_its_landmarks_there_are_no_lips(lacking):
    surface, landmarks, _ = mouth()
    del landmarks[lacking]
    assert Lips.of(surface, landmarks) is None
