"""Faces by number: the same however the work is split, and distributed as the recipe says."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from farm_rigs import NAMES, RIG
from hypothesis import given, settings
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.farm.sampling.columns import Column, Columns
from elastomorph.farm.sampling.lanes import random_lanes


def test_a_face_depends_on_seed_and_number_alone() -> None:
    sampler = em.FaceSampler(RIG, seed=3)
    whole = sampler.codes(0, 5000)
    assert (em.FaceSampler(RIG, seed=3).codes(1234, 4321) == whole[1234:4321]).all()


def test_seeds_have_nothing_to_do_with_each_other() -> None:
    recipe = {"mixture": [{"kind": "uniform"}]}
    one, other = (em.FaceSampler(RIG, recipe, seed=seed).values(0, 20_000) for seed in (3, 4))
    across = np.corrcoef(one.T, other.T)[:57, 57:]
    assert np.abs(across).max() < 5 / np.sqrt(20_000)


RICH = {
    "limits": {"jawOpen": [0.1, 0.8], "late": [-1, 1]},
    "mixture": [
        {"kind": "sparse", "share": 3, "power": 1.5},
        {"kind": "dirichlet", "sliders": ["mouth*"], "concentration": 0.4},
        {"kind": "grid", "sliders": ["jaw*"], "levels": 3},
        {"kind": "uniform"},
    ],
    "exclude": [{"sliders": ["mouthPress*", "jawOpen"], "most": 0.9}],
    "identity": {"sliders": ["late"]},
    "timing": {"law": "cosine"},
    "head": {},
}


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from([{}, RICH]),
    st.lists(st.integers(0, 3000), min_size=1, max_size=6),
    st.integers(0, 2**40),
)
def test_any_split_of_any_range_is_the_whole(
    recipe: dict[str, object], cuts: list[int], first: int
) -> None:
    sampler = em.FaceSampler(RIG, recipe, seed=1)
    whole = sampler.codes(first, first + 3000)
    ends = sorted({0, *cuts, 3000})
    parts = [sampler.codes(first + a, first + b) for a, b in reversed(list(pairwise(ends)))]
    assert (np.concatenate(parts[::-1]) == whole).all()


@given(st.integers(0, 2**64 - 1), st.integers(0, 2**70), st.integers(1, 3))
def test_random_bits_are_those_of_the_generator(seed: int, face: int, steps: int) -> None:
    """As written down in the paper, Sec. 4.3, from the counter after that of the face."""
    lanes = random_lanes(seed, face, face + 2, 16 * steps).ravel().tolist()
    words = [word for step in range(2 * steps) for word in philox(face * steps + step + 1, seed)]
    assert lanes == [word >> 16 * lane & 0xFFFF for word in words for lane in range(4)]


def philox(counter: int, seed: int) -> list[int]:
    """Philox-4x64-10 of a counter, with whole numbers of Python."""
    word = 2**64
    x = [counter >> 64 * place & (word - 1) for place in range(4)]
    keys = [seed, int.from_bytes(b"elasto", "big")]
    for _ in range(10):
        high0, low0 = divmod(0xD2E7470EE14C6C93 * x[0], word)
        high1, low1 = divmod(0xCA5A826395121157 * x[2], word)
        x = [high1 ^ x[1] ^ keys[0], low1, high0 ^ x[3] ^ keys[1], low0]
        keys = [(keys[0] + 0x9E3779B97F4A7C15) % word, (keys[1] + 0xBB67AE8584CAA73B) % word]
    return x


def test_as_many_sliders_are_on_as_the_recipe_says() -> None:
    recipe = {"mixture": [{"kind": "sparse", "active": 9, "symmetric": 0}]}
    on = em.FaceSampler(RIG, recipe).values(0, 40_000) > 0
    # Sums of independent coins: the means lie within 4.5 deviations.
    chance = 9 / 57
    assert on.sum(axis=1).mean() == pytest.approx(9, abs=4.5 * np.sqrt(9 * (1 - chance) / 40_000))
    assert on.mean(axis=0) == pytest.approx(
        chance, abs=4.5 * np.sqrt(chance * (1 - chance) / 40_000)
    )


def test_the_text_of_a_recipe_makes_the_same_faces() -> None:
    limits = {"jawOpen": [0, 0.8], "mouth*": [0, 0.5], "late": [-1, 2]}
    sampler = em.FaceSampler(RIG, {"limits": limits}, seed=7)
    again = em.FaceSampler.restored(RIG, sampler.recipe.text(), sampler.tables)
    assert (again.codes(0, 100) == sampler.codes(0, 100)).all()
    assert again.columns == sampler.columns
    assert again.recipe.text() == sampler.recipe.text()
    values = sampler.values(0, 3000)
    low, high = values.min(axis=0), values.max(axis=0)
    assert 0.79 < high[NAMES.index("jawOpen")] <= 0.8
    assert 0.49 < high[NAMES.index("mouthClose")] <= 0.5
    assert -1 <= low[52:].min() < -0.99
    assert 1.98 < high[52:].max() <= 2
    assert (values[:, 52:] == 0).mean() > 0.8


def test_what_people_are_told() -> None:
    lines = em.FaceSampler(RIG, RICH, seed=5).describe().splitlines()
    assert lines[0] == "any number of faces of 57 sliders, t, head; seed 5"
    assert lines[1].startswith("  50 % sparse: of 52 sliders ")
    assert lines[1].endswith("; 18 pairs of sides")
    assert lines[-1] == "  mouthPress*, jawOpen: together at most 0.9"
    grid = {"mixture": [{"kind": "grid", "sliders": ["jaw*"], "levels": 2}]}
    (first, second) = em.FaceSampler(RIG, grid).describe().splitlines()
    assert first == "15 faces of 57 sliders; seed 0"
    assert second.endswith("at most 4")


class TestColumns:
    def test_codes_come_back(self) -> None:
        columns = Columns((Column("a"), Column.within("b", -0.3, 1.1), Column("c", 2, 2)))
        codes = np.arange(65536, dtype=np.uint16)[:, None].repeat(3, axis=1)
        codes[:, 2] = 0
        values = columns.decode(codes)
        assert (columns.encode(values) == codes).all()
        assert (values[:, 2] == 2).all()
        assert values[13107, 0] == 0.2
        assert -0.3 <= values[:, 1].min() < -0.29999
        assert values[columns.rest[1], 1] == 0
        assert 1.09999 < values[:, 1].max() <= 1.1
        assert columns.listed()[0] == ["a", 0.0, 1.0]

    @pytest.mark.parametrize(
        ("low", "high"),
        [(-1, 1), (-1e-5, 1), (-1, 1e-5), (-1e-9, 1000), (-0.001, 1), (-1000, 1e-9), (-0.3, 1.1)],
    )
    def test_a_range_on_both_sides_of_0_loses_less_than_a_step(
        self, low: float, high: float
    ) -> None:
        own = Column.within("a", low, high)
        step = (high - low) / 65535
        assert low <= own.low < low + step
        assert high - step < own.high <= high
        assert own.low <= 0 <= own.high
        columns = Columns((own,))
        assert columns.decode([[own.rest]]).item() == 0
        assert columns.encode([[0.0]]).item() == own.rest

    def test_values_out_of_range_become_its_ends(self) -> None:
        columns = Columns((Column("a", 0.2, 0.8),))
        assert columns.encode([[0.0], [1.0], [0.4]]).ravel().tolist() == [0, 65535, 21845]
