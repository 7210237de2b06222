"""Part of a face moves by a method, the rest plainly, and nothing tears between."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.evaluation import rigidity
from elastomorph.model.mesh import FaceLabels
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
