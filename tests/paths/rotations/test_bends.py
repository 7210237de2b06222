"""Bends of arcs and edges are what they say, and polynomials follow them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, polar
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.paths.bake import bake_polynomial
from elastomorph.paths.rotations import ArcBend, EdgeBend
from elastomorph.paths.rotations.bends import PolynomialBend, at_nodes, moments_needed

TIMES = (0.0, 0.1, 0.25, 0.5, 0.8, 1.0)


@given(
    st.integers(0, 10**6),
    st.one_of(st.just(0.0), st.floats(1e-9, 4.1)),
    st.floats(0, 1),
)
def test_an_arc_is_the_steady_turn_about_an_axis(seed: int, angle: float, t: float) -> None:
    """x₀ + t d + bend = Rot(tθ)(x₀ - c) + c + t·slide·a, for every axis, angle and slide."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    start, centre, slide = rng.normal(size=(8, 3)), rng.normal(size=3), rng.normal()

    def true(part: float) -> np.ndarray:
        turned = Rotation.from_rotvec(part * angle * axis).apply(start - centre)
        return np.asarray(turned + centre + part * slide * axis)

    chords = true(1.0) - start
    found = start + t * chords + ArcBend.of(chords, angle * axis).at(t)
    np.testing.assert_allclose(found, true(t), atol=1e-11)


def test_a_quarter_turn_by_hand() -> None:
    """(1, 0) to (0, 1) about z passes (1, 1)/√2 halfway, not the middle of the chord."""
    bend = ArcBend.of(np.array([[-1.0, 1.0, 0.0]]), np.array([0.0, 0.0, np.pi / 2])).at(0.5)
    np.testing.assert_allclose(bend, [[np.sqrt(0.5) - 0.5, np.sqrt(0.5) - 0.5, 0.0]], atol=1e-15)


def test_small_angles_bend_by_an_eighth_of_the_angle() -> None:
    """The sagitta of a chord d tends to θd/8, without cancellation."""
    angle = 1e-9
    bend = ArcBend.of(np.array([[1.0, 0.0, 0.0]]), np.array([0.0, 0.0, angle])).at(0.5)
    np.testing.assert_allclose(bend, [[0.0, -angle / 8, 0.0]], rtol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_edges_turn_with_the_polar_path_of_their_map(seed: int) -> None:
    """e(t) = exp(t log R)((1 - t)I + tS)e₀, by matrix exponential and polar decomposition."""
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(rng.normal(size=3))
    stretch = np.diag(rng.uniform(0.3, 2.0, 3))
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    linear = turn.as_matrix() @ frame @ stretch @ frame.T
    rotation, symmetric = polar(linear)
    np.testing.assert_allclose(rotation, turn.as_matrix(), atol=1e-12)
    x, y, z = turn.as_rotvec()
    logarithm = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    edges = rng.normal(size=(6, 3))
    bend = EdgeBend.of(edges, edges @ linear.T, turn.as_rotvec())
    for t in TIMES:
        expected = expm(t * logarithm) @ ((1 - t) * np.eye(3) + t * symmetric) @ edges.T
        straight = (1 - t) * edges + t * edges @ linear.T
        np.testing.assert_allclose(straight + bend.at(t), expected.T, atol=1e-12)


def test_both_bends_vanish_at_both_ends_and_without_turn() -> None:
    """To the last bit, whatever the vectors."""
    rng = np.random.default_rng(3)
    first, second, vectors = rng.normal(size=(3, 40, 3))
    for bend in (ArcBend.of(first, vectors), EdgeBend.of(first, second, vectors)):
        assert not bend.at(0.0).any()
        assert not bend.at(1.0).any()
        assert bend.at(0.5).any()
    none = np.zeros(3)
    for bend in (ArcBend.of(first, none), EdgeBend.of(first, second, none)):
        for t in TIMES:
            assert not bend.at(t).any()


def test_a_polynomial_bend_is_reproduced() -> None:
    """Every t(1 - t)·q(t) with q of a degree below the number of nodes."""
    powers = np.random.default_rng(0).normal(size=(4, 5, 3))

    def bend(t: float) -> np.ndarray:
        return t * (1 - t) * np.tensordot(t ** np.arange(4.0), powers, axes=1)

    found = PolynomialBend(at_nodes(bend, 4), np.ones(5, bool))
    for t in np.linspace(0, 1, 11):
        np.testing.assert_allclose(found.at(t), bend(t), atol=1e-13)


@pytest.mark.parametrize("degrees", [1, 25, 90, 170, 240])
def test_enough_moments_for_every_turn(degrees: float) -> None:
    """Turning and stretching edges, to 1e-8 of their length."""
    rng = np.random.default_rng(degrees)
    first, second = rng.normal(size=(2, 50, 3))
    axes = rng.normal(size=(50, 3))
    angles = np.radians(degrees) / np.linalg.norm(axes, axis=1)
    edges = EdgeBend.of(first, second, angles[:, None] * axes)
    found = PolynomialBend(
        at_nodes(edges.at, moments_needed(np.radians(degrees))), np.ones(50, bool)
    )
    for t in np.linspace(0, 1, 21):
        assert np.abs(found.at(t) - edges.at(t)).max() < 3e-8


def test_only_vertices_that_bend_are_kept_and_baking_agrees_with_a_bake_of_the_path() -> None:
    """The same bends as `bake`, which looks at the path at 50 moments."""
    rng = np.random.default_rng(3)
    bent = np.array([True, False, True, True, False])
    arms = rng.normal(size=(3, 3))

    def bend(t: float) -> np.ndarray:
        return np.sin(np.pi * t) * arms

    neutral = em.Mesh(rng.normal(size=(5, 3)))
    target = neutral.with_vertices(neutral.vertices + 0.1)
    found = PolynomialBend(at_nodes(bend, 14), bent)

    def path(t: float) -> np.ndarray:
        offsets = np.zeros((5, 3))
        offsets[bent] = bend(t)
        return neutral.vertices + 0.1 * t + offsets

    for tolerance in (1e-2, 1e-6):
        slow = em.bake(path, neutral, target, tolerance=tolerance)
        fast = bake_polynomial(
            found.coefficients, found.bent, neutral, target, tolerance=tolerance, method="baked"
        )
        assert len(fast.bends) == len(slow.bends) > 0
        np.testing.assert_allclose(fast.bends, slow.bends, atol=1e-8)
        assert fast.bake_error == pytest.approx(slow.bake_error, rel=1e-3)
        assert not fast.bends[:, ~bent].any()


def test_the_stated_error_is_the_largest_of_all_vertices() -> None:
    """Few vertices are tried for it, so the worst one is put where bounds alone would not look."""
    rng = np.random.default_rng(8)
    coefficients = rng.normal(size=(6, 500, 3)) / 4.0 ** np.arange(6)[:, None, None]
    neutral = em.Mesh(rng.normal(size=(500, 3)))
    bend = PolynomialBend(coefficients, np.ones(500, bool))
    for tolerance in (1e-1, 1e-2, 1e-3):
        morph = bake_polynomial(
            bend.coefficients, bend.bent, neutral, neutral, tolerance=tolerance, method="baked"
        )
        checks = (1 - np.cos(np.pi * np.arange(1, 34) / 34)) / 2
        off = [np.linalg.norm(morph.at(t) - neutral.vertices - bend.at(t), axis=1) for t in checks]
        assert np.max(off) / neutral.diameter == pytest.approx(morph.bake_error, rel=1e-9)
        assert morph.bake_error <= tolerance
