"""What the bench times makes the faces it says."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.evaluation.speed import PAPER_MILLISECONDS, DirectBlend, face_speeds
from elastomorph.rig import Rig


def strip() -> tuple[em.Mesh, list[em.Mesh]]:
    x = np.arange(12.0)
    points = np.concatenate([np.stack([x, 0 * x + row, 0 * x], axis=1) for row in range(3)])
    faces = [[r * 12 + i, r * 12 + i + 1, r * 12 + i + 13, r * 12 + i + 12]
             for r in range(2) for i in range(11)]  # fmt: skip
    neutral = em.Mesh(points, faces)
    random = np.random.default_rng(0)
    return neutral, [
        neutral.with_vertices(points + random.normal(size=points.shape)) for _ in range(3)
    ]


def test_direct_blend_is_the_rig() -> None:
    neutral, targets = strip()
    direct = DirectBlend(neutral, targets, em.Method.parse("beam:3:rest"))
    to = em.prepare(neutral, "beam:3:rest")
    rig = Rig(neutral, {str(i): to(mesh) for i, mesh in enumerate(targets)})
    weights = np.array([0.2, 0.7, 0.4])
    expected = rig.batch(weights[None], 0.6, dtype=np.float64)[0]
    np.testing.assert_allclose(direct.face(weights, 0.6), expected, atol=1e-12)


def test_every_row_is_timed() -> None:
    neutral, targets = strip()
    count, rows = face_speeds(neutral, targets, levels=3, repeats=1)
    assert count == 26
    names = [row.name for row in rows]
    assert {"the paper", "rig.batch", "bare numpy.matmul", "memory copy"} <= set(names)
    assert all(row.seconds_a_face > 0 for row in rows)
    assert abs(rows[0].seconds_a_face - PAPER_MILLISECONDS / 1e3) < 1e-12
    assert round(PAPER_MILLISECONDS, 2) == 9.36


def test_the_paper_s_smaller_set_is_timed_where_there_are_as_many_faces() -> None:
    """259 faces in 2.46 s; 7³ - 1 = 342 combinations have as many."""
    neutral, targets = strip()
    names = [row.name for row in face_speeds(neutral, targets, levels=7, repeats=1)[1]]
    assert {"the paper, 259 faces", "rig.batch, 259 faces"} <= set(names)
    few = [row.name for row in face_speeds(neutral, targets, levels=2, repeats=1)[1]]
    assert not [name for name in few if "259" in name]


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
@pytest.mark.parametrize("method", ["linear", "ease:3", "plate:2", "arc"])
def test_a_method_without_beams_is_timed(method: str) -> None:
    """Its faces beside Eq. 39 of a beam."""
    neutral, targets = strip()
    _, rows = face_speeds(neutral, targets, method=method, levels=2, repeats=1)
    assert len(rows) > 4
