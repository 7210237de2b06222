"""Scale by distances that were measured."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastomorph.capturing.geometry import Similarity
from elastomorph.capturing.landmarks import (
    Landmarks,
    factor_of,
    fit_to_scale,
    read_landmarks,
    write_landmarks,
)
from elastomorph.errors import CaptureError, FormatError

RANDOM = np.random.default_rng(6)
NAMES = ("nose_tip", "left_eye_outer", "right_eye_outer", "chin", "mouth_left")
TEMPLATE = {name: RANDOM.normal(size=3) * 6 for name in NAMES}
# Photographs of a head a tenth larger than the template, in a unit of their own.
SEEN = Similarity(0.05, Rotation.from_rotvec([1.0, 0.4, -0.2]).as_matrix(), RANDOM.normal(size=3))
FOUND = {name: SEEN(1.1 * point) for name, point in TEMPLATE.items()}
EYES = 1.1 * float(np.linalg.norm(TEMPLATE["left_eye_outer"] - TEMPLATE["right_eye_outer"]))
RULER = {"ruler_start": SEEN(np.zeros(3)), "ruler_end": SEEN(np.array([0.0, 6.0, 8.0]))}


def test_without_distances_the_head_is_as_large_as_the_template():
    found = fit_to_scale(TEMPLATE, FOUND, (), "neutral")
    assert found.scale == pytest.approx(20 / 1.1)


@pytest.mark.parametrize(
    "distances",
    [
        (("left_eye_outer", "right_eye_outer", EYES),),
        (("ruler_start", "ruler_end", 10.0),),
        (("left_eye_outer", "right_eye_outer", EYES), ("ruler_end", "ruler_start", 10.0)),
    ],
)
def test_with_distances_it_is_as_large_as_it_is(distances):
    found = fit_to_scale(TEMPLATE, FOUND | RULER, distances, "neutral")
    assert found.scale == pytest.approx(20.0)
    brought = np.array([found(point) for point in FOUND.values()])
    points = np.array(list(TEMPLATE.values()))
    np.testing.assert_allclose(brought.mean(axis=0), points.mean(axis=0), atol=1e-9)
    larger = 1.1 * (points - points.mean(axis=0))
    np.testing.assert_allclose(brought - brought.mean(axis=0), larger, atol=1e-9)


def test_distances_are_averaged_by_least_squares():
    points = {"a": np.zeros(3), "b": np.array([1.0, 0, 0]), "c": np.array([0, 2.0, 0])}
    found = factor_of(points, [("a", "b", 10.1), ("a", "c", 20.0), ("a", "x", 1.0)], "n")
    assert found == pytest.approx((10.1 + 2 * 20.0) / 5)


@pytest.mark.parametrize(
    ("distances", "message"),
    [
        ([("ruler_start", "nose", 3.0)], "not both are clicked"),
        ([("ruler_start", "ruler_end", 10.0), ("left_eye_outer", "right_eye_outer", 2.0)], "again"),
        ([("ruler_start", "ruler_end", 100.0)], "in the template's unit"),
    ],
)
def test_distances_that_cannot_be_are_refused(distances, message):
    with pytest.raises(CaptureError, match=rf"^neutral: .*{message}"):
        fit_to_scale(TEMPLATE, FOUND | RULER, distances, "neutral")
    same = {"a": np.zeros(3), "b": np.zeros(3)}
    with pytest.raises(CaptureError, match="same place"):
        factor_of(same, [("a", "b", 1.0)], "n")


def test_distances_are_in_the_file_of_landmarks(tmp_path):
    path = tmp_path / "landmarks.json"
    write_landmarks(path, Landmarks({"chin": 3}, distances=(("a", "b", 10.0),)))
    assert read_landmarks(path).distances == (("a", "b", 10.0),)
    write_landmarks(path, Landmarks({"chin": 3}))
    assert "distances" not in path.read_text()
    assert read_landmarks(path).distances == ()


@pytest.mark.parametrize(
    "wrong", ['{"a": 1}', '[["a", "b"]]', '[["a", "b", "c"]]', '[["a", "a", 1]]', '[["a", "b", 0]]']
)
def test_distances_of_another_form_are_refused(tmp_path, wrong):
    path = tmp_path / "landmarks.json"
    path.write_text(f'{{"version": 1, "distances": {wrong}}}')
    with pytest.raises(FormatError, match="distances"):
        read_landmarks(path)
