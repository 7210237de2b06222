"""A small rig with curved paths, for the tests."""

from __future__ import annotations

import numpy as np

import elastomorph as em
from elastomorph.rig import Rig

NAMES = ("jawOpen", "browInnerUp_L", "browInnerUp_R", "mouthClose")


def small_rig() -> Rig:
    """Four sliders on six vertices; all paths ease as t², and mouthClose only with the jaw open."""
    x, y = np.meshgrid([0.0, 1, 2], [0.0, 1])
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    neutral = em.Mesh(points, [[0, 1, 4, 3], [1, 2, 5, 4]])
    random = np.random.default_rng(7)
    morphs = {}
    for name in NAMES:
        target = neutral.with_vertices(points + random.normal(size=points.shape))
        morphs[name] = em.interpolate(neutral, target, "ease:2")
    return Rig(neutral, morphs, correctives={"mouthClose": ("jawOpen", "mouthClose")})
