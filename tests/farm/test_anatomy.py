"""Without a recipe, faces keep to what a face can do, on rigs with the names of ARKit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.farm.sampling.columns import LEVELS, Column, Columns
from elastomorph.farm.sampling.controls import Anatomy
from small_head import bare_head

FACES = 4000


def tiny(*names: str) -> em.Rig:
    points = np.eye(3)
    mesh = em.Mesh(points, [[0, 1, 2]])
    return em.Rig(mesh, {n: mesh.with_vertices(points * 1.1) for n in names}, method="linear")


def weights_of(rig: em.Rig, recipe: object = None) -> dict[str, np.ndarray]:
    values = em.FaceSampler(rig, recipe, seed=5).values(0, FACES)
    return dict(zip(rig.names, values.T[: len(rig.names)], strict=True))


def looks(face: dict[str, np.ndarray], side: str, way: str, other: str) -> np.ndarray:
    return face[f"eyeLook{way}_{side}"] - face[f"eyeLook{other}_{side}"]


@pytest.fixture(scope="module")
def drawn() -> dict[str, np.ndarray]:
    return weights_of(bare_head())


def test_both_eyes_look_to_one_place(drawn: dict[str, np.ndarray]) -> None:
    """To the left is out for the left eye and in for the right; every way is looked as often."""
    left = looks(drawn, "L", "Out", "In")
    np.testing.assert_array_equal(left, looks(drawn, "R", "In", "Out"))
    up = looks(drawn, "L", "Up", "Down")
    np.testing.assert_array_equal(up, looks(drawn, "R", "Up", "Down"))
    for way in (left, up):
        ahead, back = np.mean(way > 0), np.mean(way < 0)
        assert ahead > 0.08
        assert abs(ahead - back) < 0.04
    for side in "LR":
        assert not np.any((drawn[f"eyeLookOut_{side}"] > 0) & (drawn[f"eyeLookIn_{side}"] > 0))
        assert not np.any((drawn[f"eyeLookUp_{side}"] > 0) & (drawn[f"eyeLookDown_{side}"] > 0))


def test_lips_are_shut_by_no_more_than_the_jaw_is_open(drawn: dict[str, np.ndarray]) -> None:
    """And mouthClose is drawn as often as without the rule: the jaw comes along."""
    assert np.all(drawn["mouthClose"] <= drawn["jawOpen"])
    free = weights_of(bare_head(), {})
    assert np.mean(free["mouthClose"] > free["jawOpen"]) > 0.07
    assert np.mean(drawn["mouthClose"] > 0) > 0.85 * np.mean(free["mouthClose"] > 0)


@pytest.mark.parametrize(
    "pair",
    [
        ("eyeBlink_L", "eyeWide_L"),
        ("eyeWide_R", "eyeSquint_R"),
        ("mouthSmile_R", "mouthFrown_R"),
        ("jawLeft", "jawRight"),
        ("mouthLeft", "mouthRight"),
        ("cheekPuff", "jawOpen"),
        ("browDown_L", "browOuterUp_L"),
        ("mouthPress_L", "jawOpen"),
    ],
)
def test_antagonists_do_not_pull_at_once(
    drawn: dict[str, np.ndarray], pair: tuple[str, str]
) -> None:
    first, second = (drawn[name] for name in pair)
    assert not np.any((first > 0) & (second > 0))
    assert min(np.mean(first > 0), np.mean(second > 0)) > 0.03


def test_a_recipe_has_the_rules_where_it_asks_for_them(tmp_path: Path) -> None:
    """In a file too; the text that a data set keeps makes the same faces again."""
    rig = bare_head()
    file = tmp_path / "recipe.toml"
    file.write_text('anatomy = true\n[[mixture]]\nkind = "uniform"\n')
    sampler = em.FaceSampler(rig, file, seed=5)
    face = dict(zip(rig.names, sampler.values(0, FACES).T, strict=True))
    assert np.all(face["mouthClose"] <= face["jawOpen"])
    assert "anatomy = true" in sampler.recipe.text()
    again = em.FaceSampler.restored(rig, sampler.recipe.text(), sampler.tables)
    np.testing.assert_array_equal(again.codes(0, 100), sampler.codes(0, 100))
    assert "eyes look one way" in sampler.describe()
    plain = em.FaceSampler(rig, {"mixture": [{"kind": "uniform"}]})
    assert "anatomy" not in plain.recipe.text() + plain.describe()


def test_rigs_of_other_names_and_identities_are_left_alone() -> None:
    rig = tiny("first", "second")
    np.testing.assert_array_equal(
        em.FaceSampler(rig, None).codes(0, 99), em.FaceSampler(rig, {}).codes(0, 99)
    )
    known = tiny("jawLeft", "jawRight")
    assert not np.any(np.prod(em.FaceSampler(known).values(0, 999), axis=1))
    recipe = {"anatomy": True, "identity": {"sliders": ["jawLeft"], "range": [0, 1]}}
    free = em.FaceSampler(known, recipe).values(0, 999)
    assert np.any(np.prod(free, axis=1))


def test_exclusions_hold_beside_the_rules() -> None:
    """What mouthClose brings along is excluded afterwards, and mouthClose with it."""
    rig = tiny("mouthClose", "jawOpen", "tongue")
    recipe = {
        "anatomy": True,
        "mixture": [{"kind": "uniform"}],
        "exclude": [{"sliders": ["jawOpen", "tongue"], "most": 0.5}],
    }
    close, jaw, tongue = em.FaceSampler(rig, recipe).values(0, FACES).T
    assert np.all(close <= jaw)
    assert np.all(jaw + tongue <= 0.5 + 1e-9)


def test_weights_are_compared_not_codes() -> None:
    """With limits, one code stands for two weights: half of 2 is 1, and all of 0.5 is 0.5."""
    columns = Columns((Column("mouthClose", 0, 0.5), Column("jawOpen", 0, 2)))
    anatomy = Anatomy.of(columns.columns, frozenset())
    codes = columns.encode([[0.5, 0.0], [0.4, 0.3], [0.2, 1.9]])
    anatomy.open(codes)
    anatomy.close(codes)
    values = columns.decode(codes)
    np.testing.assert_allclose(values, [[0.5, 0.5], [0.4, 0.4], [0.2, 1.9]], atol=3 / LEVELS)
    assert np.all(values[:, 0] <= values[:, 1])
