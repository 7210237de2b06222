"""Features lie where the photograph shows them, whatever size they were looked for at."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from elastomorph.capturing.cameras.features import Features, find_features
from elastomorph.capturing.photographs import Photograph
from needs import extra

extra("pycolmap", "capture")


def photographed(
    folder: Path, size: tuple[int, int], width: float
) -> tuple[Photograph, np.ndarray]:
    """A photograph of dark spots whose centres are known, and these."""
    random = np.random.default_rng(3)
    columns, rows = (np.linspace(0.1 * side, 0.9 * side, 6) for side in size)
    places = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    places += random.uniform(-3, 3, size=places.shape)
    x, y = np.arange(size[0]), np.arange(size[1])
    grey = np.full(size[::-1], 200.0)
    for column, row in places:
        across = np.exp(-0.5 * ((x - column) / width) ** 2)
        grey -= 150 * np.exp(-0.5 * ((y - row) / width) ** 2)[:, None] * across
    grey += random.normal(size=grey.shape) * 0.3
    path = folder / "a.png"
    Image.fromarray(np.clip(np.round(grey), 0, 255).astype(np.uint8)).save(path)
    return Photograph(path, size, None, "", "X", "0"), places


def nearest(features: Features, places: np.ndarray) -> np.ndarray:
    """(N, 2) from each place to the feature nearest to it."""
    off = features.places[None] - places[:, None]
    return off[np.arange(len(places)), np.linalg.norm(off, axis=2).argmin(axis=1)]


# Enlarged, as it is, and reduced: pixel centres have to stay at integers in each.
@pytest.mark.parametrize(
    ("size", "width"), [((700, 500), 4.0), ((1600, 900), 4.0), ((3600, 900), 9.0)]
)
def test_features_are_where_spots_are(tmp_path, size, width):
    photograph, places = photographed(tmp_path, size, width)
    (features,) = find_features([photograph])
    off = nearest(features, places)
    assert np.linalg.norm(off, axis=1).max() < 0.25
    np.testing.assert_allclose(off.mean(axis=0), 0, atol=0.06)
    assert features.descriptors.shape == (len(features), 128)
    np.testing.assert_allclose(np.linalg.norm(features.unit, axis=1), 1, rtol=1e-5)


def test_a_mask_keeps_what_is_white(tmp_path):
    photograph, places = photographed(tmp_path, (700, 500), 4.0)
    white = np.zeros((500, 700), dtype=np.uint8)
    white[:, :350] = 255
    Image.fromarray(white).save(tmp_path / "mask.png")
    masked = Photograph(
        photograph.path, photograph.size, None, "", "X", "0", mask=tmp_path / "mask.png"
    )
    both, left = (find_features([each])[0] for each in (photograph, masked))
    assert (both.places[:, 0] > 360).any()
    assert len(left) == np.count_nonzero(np.rint(both.places[:, 0]) < 350)
    inside = places[places[:, 0] < 340]
    assert np.linalg.norm(nearest(left, inside), axis=1).max() < 0.25


def test_features_are_the_same_each_time_and_in_order(tmp_path, capfd):
    first, _ = photographed(tmp_path, (700, 500), 4.0)
    (tmp_path / "b").mkdir()
    second, _ = photographed(tmp_path / "b", (500, 700), 5.0)
    done: list[int] = []
    found = find_features([first, second, first], done=done.append)
    assert done == [1, 2, 3]
    for name in ("places", "shapes", "descriptors"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[2], name))
    assert found[1].places[:, 1].max() > 500
    assert capfd.readouterr().err == ""
