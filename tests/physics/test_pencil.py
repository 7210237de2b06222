"""The sparse eigenproblem: slices of the spectrum against all of it at once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_array, diags_array, eye_array, kron

from elastomorph.errors import ParameterError
from elastomorph.physics.plate import Pencil


def strip(count: int) -> csc_array:
    """The graph Laplacian of a path."""
    ends = np.full(count, 2.0)
    ends[[0, -1]] = 1.0
    return csc_array(
        diags_array([-np.ones(count - 1), ends, -np.ones(count - 1)], offsets=[-1, 0, 1])
    )


def sheet(columns: int, rows: int) -> csc_array:
    return csc_array(kron(strip(columns), eye_array(rows)) + kron(eye_array(columns), strip(rows)))


@pytest.fixture(scope="module")
def pencil() -> Pencil:
    """Two alike sheets, so that eigenvalues come in pairs, and a smaller one; masses uneven."""
    matrix = csc_array(block_diag([sheet(19, 17), sheet(19, 17), sheet(9, 8)]))
    piece_of = np.repeat([0, 1, 2], [19 * 17, 19 * 17, 72])
    uneven = np.random.default_rng(0).uniform(0.5, 2, 19 * 17)
    mass = np.concatenate([uneven, uneven, np.ones(72)]) / 700
    return Pencil(matrix, mass, piece_of, 1.0)


@pytest.fixture(scope="module")
def exact(pencil) -> np.ndarray:
    root = np.sqrt(pencil.mass)
    return np.linalg.eigvalsh(pencil.matrix.toarray() / np.outer(root, root))[3:]


@pytest.mark.parametrize("count", [1, 7, 64, 150, 230])
def test_slices_of_the_spectrum_miss_no_mode(pencil, exact, count):
    values, vectors = pencil.lowest(count)
    assert values == pytest.approx(exact[:count], rel=1e-8)
    gram = vectors.T @ (pencil.mass[:, None] * vectors)
    assert gram == pytest.approx(np.eye(count), abs=1e-8)
    residual = pencil.matrix @ vectors - pencil.mass[:, None] * vectors * values
    assert np.abs(residual).max() < 1e-6 * np.abs(pencil.matrix @ vectors).max()


def test_inertia_counts_the_modes(pencil, exact):
    for value in (exact[0] / 2, exact[11] * 1.0001, exact[200] * 1.0001, 2 * exact[-1]):
        assert pencil.count_below(value) == np.count_nonzero(exact < value)


def test_the_nearest_modes(pencil, exact):
    target = 0.5 * (exact[39] + exact[42])
    values, _ = pencil.nearest(target, 10)
    assert values == pytest.approx(np.sort(exact[np.argsort(np.abs(exact - target))[:10]]))


@pytest.mark.parametrize("shift", [-1.0, 3.0, 2 + 5j, 2 - 5j])
def test_shifted_solves(pencil, shift):
    b = np.random.default_rng(1).standard_normal((len(pencil.mass), 3))
    for right in (b, b + 1j * b[::-1]):
        x = pencil.factor(shift)(right)
        back = pencil.matrix @ x - shift * pencil.mass[:, None] * x
        assert np.abs(back - right).max() < 1e-9


def test_means_are_those_of_the_pieces(pencil):
    values = np.random.default_rng(2).standard_normal((len(pencil.mass), 2))
    means = pencil.mean(values)
    for piece in range(3):
        inside = pencil.piece_of == piece
        expected = np.average(values[inside], axis=0, weights=pencil.mass[inside])
        assert means[inside] == pytest.approx(np.tile(expected, (inside.sum(), 1)))


def test_a_shift_that_is_an_eigenvalue_is_named():
    single = Pencil(csc_array(diags_array([1.0, 2.0])), np.ones(2), np.full(2, -1), 1.0)
    with pytest.raises(ParameterError, match="singular at 2"):
        single.factor(2.0)


@pytest.mark.parametrize("wrong", [10**6, 1, 0, -3], ids=lambda by: f"{by:+}")
@pytest.mark.parametrize("right", [0, 1, 2])
def test_a_wrong_count_ends_in_one_error(pencil, monkeypatch, wrong, right):
    """By so many modes, or as if there were none, from the first count or from a later one."""
    count, calls = Pencil.count_below, []

    def falsified(self: Pencil, value: float) -> int:
        calls.append(value)
        if len(calls) <= right:
            return count(self, value)
        return len(calls) * wrong if wrong > 0 else wrong

    monkeypatch.setattr(Pencil, "count_below", falsified)
    with pytest.raises(ParameterError, match="modes of the surface cannot be computed") as caught:
        pencil.lowest(150)
    assert "\n" not in str(caught.value)
