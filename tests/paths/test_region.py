"""Regions blend into the rest, and one path is laid over part of another."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.errors import ParameterError
from elastomorph.evaluation import rigidity
from elastomorph.model.mesh import FaceLabels
from elastomorph.paths.region import laid_over
from small_meshes import grid

SIZE = 25


NEUTRAL = grid(SIZE, SIZE)
RAISED = NEUTRAL.with_vertices(NEUTRAL.vertices + [0, 0, 10.0])
INSIDE = np.array([r * SIZE + c for r in range(5, 20) for c in range(5, 20)])
OUTSIDE = np.setdiff1d(np.arange(SIZE**2), INSIDE)


def middle_row(positions: np.ndarray) -> np.ndarray:
    return positions.reshape(SIZE, SIZE, 3)[SIZE // 2, :, 2]


def test_outside_moves_straight_inside_follows_the_method() -> None:
    path = em.interpolate(NEUTRAL, RAISED, "ease:2", region=INSIDE)
    height = path.at(0.5)[:, 2]
    np.testing.assert_allclose(height[OUTSIDE], 5.0)
    assert height[SIZE * 12 + 12] == pytest.approx(2.5)
    np.testing.assert_array_equal(path.at(1), RAISED.vertices)


def test_no_jump_at_the_border() -> None:
    """With a falloff no neighbours differ by more than a part of what they would without one."""
    sharp = em.interpolate(NEUTRAL, RAISED, "ease:2", region=INSIDE, falloff=0).at(0.5)
    soft = em.interpolate(NEUTRAL, RAISED, "ease:2", region=INSIDE, falloff=5).at(0.5)
    assert np.abs(np.diff(middle_row(sharp))).max() == pytest.approx(2.5)
    assert np.abs(np.diff(middle_row(soft))).max() < 2.5 * 0.4


def test_neutral_rest_stays_and_the_inside_reaches_the_target() -> None:
    path = em.interpolate(NEUTRAL, RAISED, "beam:2", region=INSIDE, rest="neutral")
    for t in (0.3, 1.0):
        np.testing.assert_array_equal(path.at(t)[OUTSIDE], NEUTRAL.vertices[OUTSIDE])
    centre = SIZE * 12 + 12
    np.testing.assert_array_equal(path.at(1)[centre], RAISED.vertices[centre])
    assert np.abs(np.diff(middle_row(path.at(1)))).max() < 6


def test_the_whole_face_as_region_changes_nothing() -> None:
    everything = np.arange(SIZE**2)
    whole = em.interpolate(NEUTRAL, RAISED, "beam:3", region=everything)
    plain = em.interpolate(NEUTRAL, RAISED, "beam:3")
    np.testing.assert_allclose(whole.bends, plain.bends, atol=1e-12)


def test_part_of_a_curve_is_a_curve_of_its_own() -> None:
    """On the run inside the region the bends are those of the run solved alone."""
    count = 30
    neutral = em.Mesh(np.stack([np.arange(count), 0 * np.arange(count)] * 2, axis=1)[:, :3])
    bump = np.random.default_rng(0).normal(size=(count, 3))
    target = neutral.with_vertices(neutral.vertices + bump)
    network = em.CurveNetwork([em.Curve(np.arange(count), False)], count)
    run = np.arange(8, 21)
    path = em.interpolate(neutral, target, "beam:3", curves=network, region=run, falloff=0)
    alone = em.interpolate(
        em.Mesh(neutral.vertices[run]),
        em.Mesh(target.vertices[run]),
        "beam:3",
        curves=em.CurveNetwork([em.Curve(np.arange(13), False)], 13),
    )
    np.testing.assert_allclose(path.bends[:, run], alone.bends, atol=1e-13)
    assert not path.bends[:, :8].any()


class TestRegionByName:
    """The corners of the polygons of a group."""

    NAMED = em.Mesh(
        NEUTRAL.vertices,
        NEUTRAL.faces,
        groups=FaceLabels(
            ("lips", "lids", "brows"), np.where(np.arange((SIZE - 1) ** 2) < 48, 0, -1)
        ),
    )

    def test_is_the_region_of_its_vertices(self) -> None:
        """48 quads are two rows of 24: three rows of vertices."""
        target = self.NAMED.with_vertices(RAISED.vertices)
        named = em.interpolate(self.NAMED, target, "ease:2", region="lips", falloff=1)
        listed = em.interpolate(NEUTRAL, RAISED, "ease:2", region=np.arange(3 * SIZE), falloff=1)
        np.testing.assert_array_equal(named.bends, listed.bends)
        assert named.bends[0, : 3 * SIZE].any(axis=1).all()
        assert not named.bends[0, 3 * SIZE :].any()

    def test_an_unknown_one_names_the_nearest(self) -> None:
        with pytest.raises(em.ParameterError, match=r"no group 'lip': did you mean 'lips'"):
            em.prepare(self.NAMED, "ease", region="lip")
        with pytest.raises(em.ParameterError, match="'nose': it has lips, lids, brows"):
            em.prepare(self.NAMED, "ease", region="nose")
        with pytest.raises(em.ParameterError, match="have no groups; name the vertices"):
            em.prepare(NEUTRAL, "ease", region="lips")

    def test_is_a_body_too(self) -> None:
        """Raised without turning: as rigid as can be."""
        morph = em.interpolate(self.NAMED, self.NAMED.with_vertices(RAISED.vertices), "linear")
        assert rigidity(morph, "lips", [0.5]).ends < 1e-12


TRIANGLES = em.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
TARGET = TRIANGLES.with_vertices(np.array([[0, 0, 1], [1, 2, 0], [3, 1, 0], [0, 1, -1.0]]))
SHARES = st.lists(st.floats(0, 1), min_size=4, max_size=4).map(np.array)


def path(method: str) -> em.Morph:
    return em.interpolate(TRIANGLES, TARGET, method)


@given(SHARES, st.floats(-0.5, 1.5))
def test_every_vertex_is_where_its_share_of_both_paths_is(
    weights: NDArray[np.float64], t: float
) -> None:
    below, above = path("ease:3"), path("cosine")
    found = laid_over(below, above, weights, "both")
    share = weights[:, None]
    expected = (1 - share) * below.at(t) + share * above.at(t)
    np.testing.assert_allclose(found.at(t), expected, atol=1e-12)
    assert found.method == "both"


@given(SHARES)
def test_both_ends_are_exact(weights: NDArray[np.float64]) -> None:
    found = laid_over(path("ease:3"), path("beam:2"), weights, "both")
    assert (found.at(0.0) == TRIANGLES.vertices).all()
    assert (found.at(1.0) == TARGET.vertices).all()


def test_bends_of_one_curve_become_one() -> None:
    """An ease t³ has the curve t³ - t, a beam of order 3 that and t² - t."""
    half = np.full(4, 0.5)
    below, above = path("ease:3"), path("beam:3")
    assert len(laid_over(below, below, half, "").bends) == 1
    assert len(laid_over(below, path("ease:2"), half, "").bends) == 2
    assert len(laid_over(below, above, half, "").bends) == 1 + len(above.bends) - any(
        np.array_equal(curve.coefficients, below.bend_curves[0].coefficients)
        for curve in above.bend_curves
    )
    assert len(laid_over(path("linear"), path("linear"), half, "").bends) == 0


def test_neither_path_is_changed() -> None:
    below, above = path("ease:3"), path("ease:3")
    before = below.bends.copy(), above.bends.copy()
    laid_over(below, above, np.full(4, 0.5), "")
    np.testing.assert_array_equal(below.bends, before[0])
    np.testing.assert_array_equal(above.bends, before[1])


def test_the_larger_bake_error_stays() -> None:
    below, above = path("rotation"), path("linear")
    assert below.bake_error > 0
    for one, other in ((below, above), (above, below)):
        assert laid_over(one, other, np.ones(4), "").bake_error == below.bake_error


def test_paths_between_other_shapes_are_refused() -> None:
    elsewhere = em.interpolate(TRIANGLES, TRIANGLES.with_vertices(2 * TARGET.vertices), "cosine")
    with pytest.raises(ParameterError, match="same two shapes"):
        laid_over(path("linear"), elsewhere, np.ones(4), "")
