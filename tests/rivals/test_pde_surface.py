from __future__ import annotations

import numpy as np
import pytest
from sheets import between

import elastomorph as em
from elastomorph.curves import Curve, CurveNetwork
from elastomorph.rivals import PdeSurface
from elastomorph.rivals.pde_surface import strips, surface


def horn(u: np.ndarray, size: int, ratio: float) -> np.ndarray:
    """(U, M, 3) a surface whose coordinates solve the equation, by their own formulas."""
    turn = 2 * np.pi * np.arange(size) / size
    one, two = (2 * np.pi * number * ratio for number in (1, 2))
    x = np.exp(one * u)[:, None] * np.cos(turn)
    y = np.cosh(two * (u - 0.3))[:, None] * np.sin(2 * turn) + 0.5
    z = 2.0 - 3.0 * u[:, None] + np.sinh(one * u)[:, None] * np.sin(turn)
    return np.stack([x, y, z], axis=2)


@pytest.mark.parametrize("size", [9, 16])
def test_a_known_surface_is_found_from_its_two_boundary_curves(size: int) -> None:
    u = np.linspace(0, 1, 6)
    known = horn(u, size, 0.4)
    np.testing.assert_allclose(surface(known[0], known[-1], u, 0.4, True), known, atol=1e-12)


def test_along_open_curves_too() -> None:
    v = (np.arange(7) + 0.5) / 7
    u = np.linspace(0, 1, 5)
    wave = np.pi * 2 * 0.7
    known = np.exp(-wave * u)[:, None, None] * np.cos(2 * np.pi * v)[:, None] * np.ones(3)
    np.testing.assert_allclose(surface(known[0], known[-1], u, 0.7, False), known, atol=1e-12)


def test_waves_are_the_fourier_series_cut_off() -> None:
    """With two harmonics what has three is missed by exactly the third."""
    turn = 2 * np.pi * np.arange(12)[:, None] / 12
    low = np.concatenate([np.cos(turn), np.sin(2 * turn), 0 * turn + 1.0], axis=1)
    high = np.concatenate([0.2 * np.sin(3 * turn)] * 3, axis=1)
    ends = np.array([0.0, 1.0])
    found = surface(low + high, low - high, ends, 1.0, True, harmonics=2)
    np.testing.assert_allclose(found, [low, low], atol=1e-12)


def test_stiff_waves_do_not_overflow_and_narrow_strips_are_ruled() -> None:
    first, last = np.random.default_rng(0).normal(size=(2, 10, 3))
    u = np.array([0.0, 0.25, 1.0])
    steep = surface(first, last, u, 1e4, True)
    np.testing.assert_allclose(steep[[0, 2]], [first, last], atol=1e-12)
    mean = 0.75 * first.mean(axis=0) + 0.25 * last.mean(axis=0)
    np.testing.assert_allclose(steep[1], np.broadcast_to(mean, (10, 3)), atol=1e-12)
    ruled = surface(first, last, u, 0.0, True)
    np.testing.assert_allclose(ruled[1], 0.75 * first + 0.25 * last, atol=1e-12)


def test_strips_are_rows_of_the_grid_in_line(sheet: em.Mesh) -> None:
    """In whatever order and direction the curves are given."""
    row = np.arange(6)
    turned = [6 * i + (row[::-1] if i % 2 else row) for i in (3, 0, 5, 1, 4, 2)]
    across = tuple(Curve(own, False) for own in turned)
    ((rows, closed),) = strips(sheet, CurveNetwork(across, 36))
    assert not closed
    grid = np.arange(36).reshape(6, 6)
    ways = (grid, grid[::-1], grid[:, ::-1], grid[::-1, ::-1])
    assert any((rows == way).all() for way in ways)


def test_rows_that_close_in_a_circle_are_a_strip() -> None:
    """A torus has no first curve; each row is there once."""
    i, j = np.meshgrid(np.arange(8), np.arange(6), indexing="ij")
    ring, tube = 2 * np.pi * i / 8, 2 * np.pi * j / 6
    out = 3 + np.cos(tube)
    vertices = np.stack([out * np.cos(ring), out * np.sin(ring), np.sin(tube)], 2).reshape(-1, 3)
    at = lambda a, b: (a % 8) * 6 + b % 6  # noqa: E731
    faces = [
        [at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)] for a in range(8) for b in range(6)
    ]
    torus = em.Mesh(vertices, faces)
    found = strips(torus, em.extract_curves(torus))
    assert sum(rows.size for rows, _ in found) == 48
    assert max(len(rows) for rows, _ in found) >= 6


def test_it_misses_what_it_is_given_and_is_never_nearer_than_linear(sheet: em.Mesh) -> None:
    """The paper's objection, Sec. 4.3: at both ends linear is exact, and between them as far."""
    times = np.linspace(0, 1, 5)
    x, y = sheet.vertices[:, 0], sheet.vertices[:, 1]
    up = np.stack([0 * x, 0 * x, np.cos(3 * x) * np.cos(2 * y)], axis=1)
    truth = em.MeshSequence(sheet, sheet.vertices + (times**2)[:, None, None] * up, times)
    found = np.linalg.norm(PdeSurface().poses(truth, times) - truth.frames, axis=2)
    line = (1 - times)[:, None, None] * truth.frames[0] + times[:, None, None] * truth.frames[-1]
    linear = np.linalg.norm(line - truth.frames, axis=2)
    assert found[0].max() > 0.01
    assert found[-1].max() > 0.1
    assert (found.max(axis=1) >= linear.max(axis=1)).all()


def test_on_boundary_curves_it_is_linear(sheet: em.Mesh) -> None:
    """With nothing between boundaries all of it."""
    end = sheet.vertices + np.random.default_rng(0).normal(size=sheet.vertices.shape)
    found = PdeSurface(within=0).poses(between(sheet, end), [0.0, 0.25, 1.0])
    expected = [sheet.vertices, 0.75 * sheet.vertices + 0.25 * end, end]
    np.testing.assert_allclose(found, expected, atol=1e-12)
