from __future__ import annotations

import numpy as np

import elastomorph as em
from elastomorph.rivals import VertexCubic

TIMES = np.array([0.0, 0.2, 0.45, 0.7, 1.0])


def test_a_cubic_motion_comes_out_exactly(sheet: em.Mesh) -> None:
    """Also between the frames that it was told."""
    own = np.random.default_rng(0).normal(size=(3, *sheet.vertices.shape))

    def at(times: np.ndarray) -> np.ndarray:
        powers = times[:, None] ** np.array([1, 2, 3])
        return sheet.vertices + np.tensordot(powers, own, axes=1)

    asked = np.linspace(0, 1, 7)
    found = VertexCubic().poses(em.MeshSequence(sheet, at(TIMES), TIMES), asked)
    np.testing.assert_allclose(found, at(asked), atol=1e-12)


def test_no_other_cubic_through_both_ends_is_nearer(sheet: em.Mesh) -> None:
    """Not one whose bends differ by any small amount, in the mean square."""
    rng = np.random.default_rng(1)
    frames = np.cumsum(rng.normal(size=(5, *sheet.vertices.shape)), axis=0)
    recording = em.MeshSequence(sheet, frames, TIMES)
    found = VertexCubic().poses(recording, TIMES)
    np.testing.assert_allclose(found[[0, -1]], frames[[0, -1]], atol=1e-13)
    for power in (2, 3):
        other = (TIMES**power - TIMES)[:, None, None] * rng.normal(size=sheet.vertices.shape)
        slope = ((found - frames) * other).sum()
        assert abs(slope) < 1e-9 * np.linalg.norm(other) * np.linalg.norm(found - frames)


def test_ends_alone_leave_a_straight_line(sheet: em.Mesh) -> None:
    end = sheet.vertices + 1.0
    found = VertexCubic().poses(em.MeshSequence(sheet, [sheet.vertices, end]), [0.25])
    np.testing.assert_allclose(found[0], sheet.vertices + 0.25, atol=1e-14)
