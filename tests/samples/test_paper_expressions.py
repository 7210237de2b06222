"""The five expressions from a rig's shapes."""

from __future__ import annotations

import numpy as np

import elastomorph as em
from elastomorph.samples.paper_expressions import EXPRESSIONS, compose_expressions


def test_sums_of_weighted_displacements_of_both_sides() -> None:
    neutral = em.Mesh(np.zeros((3, 3)))
    shapes = {
        "mouthFrown_L": [[1.0, 0, 0], [0, 0, 0], [0, 0, 0]],
        "mouthFrown_R": [[0, 0, 0], [1.0, 0, 0], [0, 0, 0]],
        "mouthShrugLower": [[0, 0, 0], [0, 0, 0], [0, 2.0, 0]],
    }
    targets = {name: neutral.with_vertices(v) for name, v in shapes.items()}
    found = compose_expressions(neutral, targets)
    assert list(found) == ["sad"]
    np.testing.assert_allclose(found["sad"].vertices, [[1, 0, 0], [1, 0, 0], [0, 0.8, 0]])


def test_there_are_five() -> None:
    assert list(EXPRESSIONS) == ["sad", "angry", "confused", "grinning", "puff"]
