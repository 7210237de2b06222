"""A small rig with paths that bend, for data sets of a few kilobytes."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em

NAMES = (
    *("jawOpen", "mouthSmile_L", "mouthSmile_R", "cheekPuff"),
    *("browDown_L", "browDown_R", "noseSneer_L", "noseSneer_R"),
)


@pytest.fixture(scope="session")
def rig() -> em.Rig:
    """Eight sliders and a corrective on a bent sheet of 8 x 9 quads; one row stays still."""
    x, y = np.meshgrid(np.linspace(0, 1, 10), np.linspace(0, 1, 9))
    vertices = np.stack([x, y, 0.3 * x**2], axis=-1).reshape(-1, 3)
    corner = (np.arange(8)[:, None] * 10 + np.arange(9)).reshape(-1)
    sheet = em.Mesh(vertices, np.stack([corner, corner + 1, corner + 11, corner + 10], axis=1))
    random = np.random.default_rng(5)
    morphs = {}
    for name in (*NAMES, "jawSmile"):
        moved = 0.2 * y.reshape(-1, 1) * random.normal(size=(len(vertices), 3))
        bends = 0.1 * y.reshape(-1, 1) * random.normal(size=(1, len(vertices), 3))
        target = sheet.with_vertices(vertices + moved)
        morphs[name] = em.Morph(sheet, target, bends, (em.BendCurve.power(2),))
    return em.Rig(sheet, morphs, correctives={"jawSmile": ("jawOpen", "mouthSmile_L")})
