"""Each kind of mixture has the law that it is named for; rules hold in every face."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from farm_rigs import NAMES, RIG, column
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

import elastomorph as em
from elastomorph.rig.naming import side_pairs
from elastomorph.rig.sliders import weight_combinations

JAW = ["jawForward", "jawRight", "jawLeft", "jawOpen", "mouthClose"]


def sampled(count: int = 20_000, **recipe: object) -> np.ndarray:
    return em.FaceSampler(RIG, recipe, seed=11).values(0, count)


def is_uniform(values: np.ndarray, low: float = 0.0, high: float = 1.0) -> bool:
    """Whether the test of chi-square in 64 bins does not deny it (at a thousandth)."""
    found = np.histogram(values, 64, (low, high))[0]
    return bool(stats.chisquare(found).pvalue > 1e-3)


def test_a_uniform_mixture_is_uniform_in_every_limit() -> None:
    values = sampled(mixture=[{"kind": "uniform"}], limits={"jawOpen": [0.2, 0.7], "neck": [-1, 1]})
    assert is_uniform(values[:, column("scar")])
    assert is_uniform(values[:, column("jawOpen")], 0.2, 0.7)
    assert is_uniform(values[:, column("neck")], -1, 1)
    # Sliders have nothing to do with each other, nor faces with the next one.
    of = np.corrcoef(values.T) - np.eye(57)
    assert np.abs(of).max() < 5 / np.sqrt(20_000)
    assert np.abs(np.corrcoef(values[1:, 0], values[:-1, 0])[0, 1]) < 5 / np.sqrt(20_000)


def test_sizes_in_a_sparse_mixture_follow_its_power() -> None:
    values = sampled(
        mixture=[{"kind": "sparse", "power": 2, "active": 30}], limits={"neck": [-0.5, 1]}
    )
    sizes = values[:, column("scar")]
    assert is_uniform(np.sqrt(sizes[sizes > 0]))
    both = values[:, column("neck")]
    # As many on each side of 0 as it is long.
    assert (both[both != 0] > 0).mean() == pytest.approx(2 / 3, abs=0.02)
    assert is_uniform(np.sqrt(both[both > 0]))
    assert is_uniform(np.sqrt(-2 * both[both < 0]))


def test_the_sides_of_a_face_are_alike_as_often_as_said() -> None:
    pairs = side_pairs(NAMES)
    named = {tuple(NAMES[i].replace("Left", "Right") for i in pair) for pair in pairs}
    assert len(pairs) == 18
    assert all(left == right for left, right in named)
    values = sampled(mixture=[{"kind": "sparse", "symmetric": 0.4, "active": 40}])
    alike = np.all([values[:, a] == values[:, b] for a, b in pairs], axis=0)
    assert alike.mean() == pytest.approx(0.4, abs=4.5 * np.sqrt(0.24 / 20_000))


@pytest.mark.parametrize("concentration", [0.2, 1.0, 7.0])
def test_dirichlet_has_the_moments_of_its_law(concentration: float) -> None:
    kind = {"kind": "dirichlet", "sliders": JAW, "concentration": concentration, "sum": 0.9}
    values = sampled(mixture=[kind])
    own = values[:, [column(name) for name in JAW]]
    assert np.delete(values, [column(name) for name in JAW], axis=1).max() == 0
    assert own.sum(axis=1) == pytest.approx(0.9, abs=5 / 65535)
    # Mean 1/K and variance (K - 1)/(K²(Kα + 1)) of each of K parts, for a sum of 1.
    variance = 0.81 * 4 / (25 * (5 * concentration + 1))
    assert own.mean(axis=0) == pytest.approx(0.18, abs=4.5 * np.sqrt(variance / 20_000))
    assert own.var(axis=0) == pytest.approx(variance, rel=0.06)


class TestGrid:
    KIND = {"kind": "grid", "sliders": JAW, "levels": 6}  # noqa: RUF012

    def test_alone_it_is_the_combinations_of_the_paper_in_order(self) -> None:
        sampler = em.FaceSampler(RIG, {"mixture": [self.KIND]})
        assert sampler.count == 7775
        values = sampler.values(0, 7775)
        assert (values[:, [column(name) for name in JAW]] == weight_combinations(5)).all()
        assert (sampler.values(700, 900) == values[700:900]).all()
        with pytest.raises(em.ParameterError, match="has 7,775 faces, and 7,776 were asked for"):
            sampler.codes(0, 7776)

    def test_normalized_its_weights_sum_to_one(self) -> None:
        values = sampled(7775, mixture=[{**self.KIND, "normalize": True}])
        expected = weight_combinations(5)
        expected /= expected.sum(axis=1, keepdims=True)
        own = values[:, [column(name) for name in JAW]]
        assert own == pytest.approx(expected, abs=1 / 65535)

    def test_a_slider_of_one_value_has_no_levels(self) -> None:
        grid = {**self.KIND, "levels": 3, "normalize": True}
        sampler = em.FaceSampler(RIG, {"mixture": [grid], "limits": {JAW[0]: 0, JAW[1]: 0.25}})
        assert sampler.count == 3**3 - 1
        own = sampler.values(0, 26)[:, [column(name) for name in JAW]]
        assert own[:, 2:].sum(axis=1) == pytest.approx(1, abs=3 / 65535)
        assert (own[:, 0] == 0).all()
        assert (own[:, 1] == 0.25).all()

    def test_beside_others_its_faces_are_drawn(self) -> None:
        values = sampled(mixture=[{**self.KIND, "levels": 2}, {"kind": "uniform"}])
        grid = values[(values[:, column("scar")] == 0)][:, [column(name) for name in JAW]]
        rows = (grid * [16, 8, 4, 2, 1]).sum(axis=1)
        assert len(grid) == pytest.approx(10_000, abs=320)
        assert stats.chisquare(np.bincount(rows.astype(int), minlength=32)[1:]).pvalue > 1e-3


def test_each_mixture_has_its_share() -> None:
    own = [
        {"kind": "uniform", "share": share, "sliders": [name]}
        for share, name in ((3, "scar"), (1, "age"), (4, "ears"))
    ]
    values = sampled(mixture=own)
    for share, name in ((3, "scar"), (1, "age"), (4, "ears")):
        expected = share / 8
        found = (values[:, column(name)] > 0).mean()
        assert found == pytest.approx(expected, abs=4.5 * np.sqrt(expected / 20_000))


class TestExclusions:
    LIPS = [column("mouthPressLeft"), column("mouthPressRight"), column("jawOpen")]  # noqa: RUF012

    @settings(max_examples=25, deadline=None)
    @given(st.floats(0, 2), st.floats(-1, 0.3), st.floats(0.31, 1.5), st.integers(0, 2**64 - 1))
    def test_sums_hold_in_every_face(self, most: float, low: float, high: float, seed: int) -> None:
        recipe = {
            "mixture": [{"kind": "uniform"}],
            "limits": {"jawOpen": [min(low, most), high], "scar": [-1, 1]},
            "exclude": [
                {"sliders": ["mouthPress*", "jawOpen"], "most": most},
                {"sliders": ["jawOpen", "jawLeft", "mouthPressLeft"], "most": most + 0.1},
                {"sliders": ["jawLeft", "scar"], "one": True},
            ],
        }
        sampler = em.FaceSampler(RIG, recipe, seed=seed)
        values = sampler.values(0, 300)
        assert np.abs(values[:, self.LIPS]).sum(axis=1).max() <= most + 1e-12
        also = [column("jawOpen"), column("jawLeft"), column("mouthPressLeft")]
        assert np.abs(values[:, also]).sum(axis=1).max() <= most + 0.1 + 1e-12
        assert ((values[:, [column("jawLeft"), column("scar")]] != 0).sum(axis=1) <= 1).all()
        low, high = (values[:, column("jawOpen")].min(), values[:, column("jawOpen")].max())
        assert min(low, most) <= low
        assert high <= sampler.columns[column("jawOpen")].high

    def test_sliders_are_scaled_down_together(self) -> None:
        free = sampled(mixture=[{"kind": "uniform"}])
        held = sampled(
            mixture=[{"kind": "uniform"}],
            exclude=[{"sliders": ["mouthPress*", "jawOpen"], "most": 1}],
        )
        total = free[:, self.LIPS].sum(axis=1, keepdims=True)
        expected = free[:, self.LIPS] * np.minimum(1, 1 / total)
        assert held[:, self.LIPS] == pytest.approx(expected, abs=1.01 / 65535)
        others = np.delete(np.arange(57), self.LIPS)
        assert (held[:, others] == free[:, others]).all()

    def test_the_largest_stays(self) -> None:
        free = sampled(2000, mixture=[{"kind": "uniform"}])
        held = sampled(
            2000, mixture=[{"kind": "uniform"}], exclude=[{"sliders": ["late"], "one": True}]
        )
        assert (held[:, 52:].max(axis=1) == free[:, 52:].max(axis=1)).all()
        assert ((held[:, 52:] > 0).sum(axis=1) == 1).all()


class TestSingles:
    def test_time_follows_its_law(self) -> None:
        sampler = em.FaceSampler(
            RIG, {"timing": {"range": [0.1, 0.9], "law": "minimum-jerk"}}, seed=2
        )
        assert sampler.columns.names[57:] == ("t",)
        times = sampler.values(0, 20_000)[:, 57]
        assert 0.1 <= times.min() < 0.101
        assert 0.899 < times.max() <= 0.9
        # P(t < x) is the time at which the law is at x.
        inverse = np.interp((times - 0.1) / 0.8, em.timing.minimum_jerk.at(GRID), GRID)
        assert is_uniform(inverse)

    def test_a_law_that_overshoots_has_a_wider_column(self) -> None:
        recipe = {"timing": {"law": "keys:0=0,0.5=1.2,1=1"}}
        assert em.FaceSampler(RIG, recipe).columns[57].high == pytest.approx(1.2, abs=1e-6)

    def test_the_identity_is_normal_and_no_mixture_moves_it(self) -> None:
        recipe = {
            "identity": {"sliders": ["late"], "range": [-1, 2], "deviation": 0.8, "mean": 0.5},
            "mixture": [{"kind": "sparse", "sliders": ["*"]}],
            "limits": {"neck": [0, 1]},
        }
        sampler = em.FaceSampler(RIG, recipe, seed=5)
        values = sampler.values(0, 20_000)
        law = stats.truncnorm(-1.5 / 0.8, 1.5 / 0.8, 0.5, 0.8)
        assert is_uniform(law.cdf(values[:, column("age")]))
        law = stats.truncnorm(-0.5 / 0.8, 0.5 / 0.8, 0.5, 0.8)
        assert is_uniform(law.cdf(values[:, column("neck")]))
        assert (values[:, :52] > 0).sum(axis=1).mean() == pytest.approx(6, abs=0.2)

    def test_pictures_have_all_columns_of_the_scene(self) -> None:
        recipe = em.FaceSampler(RIG, {"head": {"yaw": [-60, 60], "pitch": 5}}).recipe
        assert list(recipe.scene) == [f"head.{n}" for n in ("yaw", "pitch", "roll", "x", "y", "z")]
        sampler = em.FaceSampler(RIG, recipe.pictured(128))
        assert sampler.recipe.pictures is not None
        assert sampler.recipe.pictures.size == 128
        values = dict(zip(sampler.columns.names, sampler.values(0, 20_000).T, strict=True))
        assert is_uniform(values["head.yaw"], -60, 60)
        assert (values["head.pitch"] == 5).all()
        assert is_uniform(values["camera.distance"], 2.5, 6)
        assert (values["head.x"] == 0).all()
        again = em.FaceSampler.restored(RIG, sampler.recipe.text(), sampler.tables)
        assert (again.codes(7, 50) == sampler.codes(7, 50)).all()
        assert again.recipe == sampler.recipe


GRID = np.linspace(0, 1, 2001)


def test_time_does_not_undo_who_it_is(tmp_path: Path) -> None:
    """The identity is there in full at every time; the others are where t says, on their paths."""
    mesh = em.Mesh(np.eye(3), [[0, 1, 2]])
    bent = em.Morph(
        mesh, mesh.with_vertices(2 * np.eye(3)), [np.ones((3, 3))], [em.BendCurve.power(2)]
    )
    rig = em.Rig(mesh, {"who": bent, "jawOpen": bent})
    recipe = {"timing": {}, "identity": {"sliders": ["who"]}, "mixture": [{"kind": "uniform"}]}
    values = em.FaceSampler(rig, recipe, seed=3).values(0, 40)
    faces = em.make_faces(rig, tmp_path / "faces.zarr", 40, recipe=recipe, seed=3)[:]
    for face, (who, jaw, t) in zip(faces, values, strict=True):
        expected = rig.blend({"who": who, "jawOpen": jaw}, {"who": 1.0, "jawOpen": t})
        np.testing.assert_allclose(face, expected, atol=1e-5)
