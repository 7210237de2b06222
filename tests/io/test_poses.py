"""Named poses in files: what is written comes back, and what is wrong is told by its line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.rig.performance import fitted_poses, through_poses, unknown_sliders
from elastomorph.rig.timing import blink, linear

SMILE = {"mouthSmileLeft": 0.7, "mouthSmileRight": 0.25}

_LETTERS = st.characters(exclude_categories=("Cc", "Cs"))
_NAMES = st.text(_LETTERS, min_size=1, max_size=12).filter(lambda name: name == name.strip())
_WEIGHTS = st.floats(allow_nan=False, allow_infinity=False)


def _poses(sliders: st.SearchStrategy[str]) -> st.SearchStrategy[dict[str, dict[str, float]]]:
    weights = st.dictionaries(sliders, _WEIGHTS, max_size=4)
    return st.dictionaries(_NAMES, weights, min_size=1, max_size=5)


@given(_poses(st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=12)))
def test_json_comes_back_as_it_is(
    tmp_path_factory: pytest.TempPathFactory, poses: dict[str, dict[str, float]]
) -> None:
    path = tmp_path_factory.mktemp("poses") / "a.json"
    em.write_poses(path, poses)
    assert em.read_poses(path) == poses
    assert list(em.read_poses(path)) == list(poses)


@given(_poses(_NAMES.filter(lambda name: ";" not in name and name.casefold() != "pose")))
def test_a_table_comes_back_without_its_zeros(
    tmp_path_factory: pytest.TempPathFactory, poses: dict[str, dict[str, float]]
) -> None:
    path = tmp_path_factory.mktemp("poses") / "a.csv"
    em.write_poses(path, poses)
    moved = {name: {s: w for s, w in own.items() if w} for name, own in poses.items()}
    assert em.read_poses(path) == moved


def test_the_forms_people_write(tmp_path: Path) -> None:
    """What the viewer saves, a plain object, and tables as spreadsheets of two countries save."""
    path = tmp_path / "a.json"
    listed = [{"name": "Smile", "weights": SMILE}, {"name": "Rest", "weights": {}}]
    path.write_text(json.dumps({"format": "elastomorph poses", "version": 1, "poses": listed}))
    assert em.read_poses(path) == {"Smile": SMILE, "Rest": {}}
    path.write_text(json.dumps({"Smile": SMILE}))
    assert em.read_poses(path) == {"Smile": SMILE}
    path.write_text(json.dumps({" Smile ": {"mouthSmile ": 1}}))  # a slider as its rig calls it
    assert em.read_poses(path) == {"Smile": {"mouthSmile ": 1}}
    with pytest.raises(em.ParameterError, match="in a table, a slider cannot be called 'mouth"):
        em.write_poses(tmp_path / "b.csv", em.read_poses(path))
    table = tmp_path / "a.csv"
    table.write_text("Pose,mouthSmileLeft,mouthSmileRight\n\nSmile,0.7,.25\nRest,,0\n")
    assert em.read_poses(table) == {"Smile": SMILE, "Rest": {}}
    table.write_text("pose;mouthSmileLeft;mouthSmileRight\nSmile;0,7;0,25\n")
    with pytest.warns(em.ElastomorphWarning, match="semicolons and decimals by commas"):
        assert em.read_poses(table) == {"Smile": SMILE}


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.json", "", "line 1: not JSON"),
        ("a.json", '{"poses": [\n{"name": 3}]}', "pose 1 has no name: expected"),
        ("a.json", '{"poses": []}', "no poses: expected"),
        ("a.json", '{"format": "curves", "poses": []}', "'curves', expected 'elastomorph poses'"),
        ("a.json", '{"version": 2, "poses": []}', "install a newer"),
        ("a.json", '{"version": 1}', "no list of poses"),
        ("a.json", "[1]", "no object with poses"),
        ("a.json", '{"A": 3}', "line 1: 'A' has no weights by name"),
        ("a.json", '{"A": {},\n"B": {"x": true}}', "line 2: the weight of 'x' in 'B' is nan"),
        ("a.json", '{"A": {},\n"B": {"x": "1"}}', "line 2: the weight of 'x' in 'B'"),
        ("a.json", '{"A": {"x": 1, "x": 2}}', "'A' names 'x' twice"),
        ("a.json", '{"A": {}, "A": {}}', "the pose 'A' is there twice"),
        ("a.json", '{"": {}}', "a pose cannot be called ''"),
        ("a.json", '{"A": {"x": NaN}}', "is nan, expected a finite number"),
        ("a.csv", "time,x\n0,1\n", "line 1: the first column is 'time', expected 'pose'"),
        ("a.csv", "pose,x\n", "no poses below the header"),
        ("a.csv", "pose,x\nA,1,2\n", "line 2: expected 2 columns as in the header, found 3"),
        ("a.csv", "pose,x\nA,1\nA,2\n", "line 3: the pose 'A' is there twice"),
        ("a.csv", "pose,x\nA,1\nB,half\n", "line 3: x is 'half', expected a finite number"),
        ("a.csv", "pose,x\n,1\n", "line 2: a pose cannot be called ''"),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(em.FormatError, match=message) as caught:
        em.read_poses(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_names_of_another_rig_find_its_sliders() -> None:
    """By the rules of takes; a slider that nothing stands for is named with the nearest."""
    rig = ("mouthSmile_L", "mouthSmile_R", "browInnerUp_L", "browInnerUp_R", "jawOpen")
    poses = {"A": {**SMILE, "browInnerUp": 0.5, "jawOpn": 1.0}, "B": {"jawOpn": 0.5}}
    fitted = fitted_poses(poses, rig)
    assert fitted.poses["A"] == {
        "mouthSmile_L": 0.7, "mouthSmile_R": 0.25, "browInnerUp_L": 0.5, "browInnerUp_R": 0.5
    }  # fmt: skip
    assert fitted.poses["B"] == {}
    assert fitted.unknown == ("jawOpn",)
    assert unknown_sliders(fitted.unknown, rig) == (
        "the rig has no slider 'jawOpn' (did you mean 'jawOpen'?)"
    )
    own = {"A": {"jawOpen": 0.0, "mouthSmile_L": 1.0}}
    assert fitted_poses(own, rig) == (own, ())


def test_a_performance_goes_through_poses() -> None:
    """Each is a frame at its time; between two the timing says how far the way has come."""
    poses = {"A": {"x": 1.0}, "B": {"y": 1.0}, "C": {}}
    take = through_poses(poses, rate=10)
    assert take.names == ("x", "y")
    np.testing.assert_allclose(take.times, np.arange(21) / 10)
    np.testing.assert_allclose(take.at([0, 0.5, 1, 2]), [[1, 0], [0.5, 0.5], [0, 1], [0, 0]])
    np.testing.assert_allclose(take.at([0.2])[0, 1], 0.2**2 * (3 - 2 * 0.2))  # smoothstep
    uneven = through_poses(poses, [0.05, 0.5, 1.0], timing=linear, rate=4)
    np.testing.assert_allclose(uneven.times, [0.05, 0.3, 0.5, 0.55, 0.8, 1.0])
    np.testing.assert_allclose(uneven.weights[3], [0, 0.9])
    with pytest.raises(em.ParameterError, match="2 poses need a time each, found 1"):
        through_poses({"A": {}, "B": {}}, [0])
    with pytest.raises(em.ParameterError, match="must rise, found 1, 1, 2"):
        through_poses(poses, [1, 1, 2])
    with pytest.raises(em.ParameterError, match="does not lead from one pose to the next"):
        through_poses(poses, timing=blink())
    with pytest.raises(em.ParameterError, match="more than 1,000,000 frames"):
        through_poses(poses, [0, 1, 1e9])
