"""The rig against Eq. 39 as the paper states it: constants of Eq. 32 per mode, per face."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.rig import Rig
from small_head import expressions, head

M, C, K = 0.9, 1.3, 0.02
pytestmark = pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")


def series(values: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fourier coefficients of (M, 3) values on a closed curve by plain sums, no transform."""
    size = len(values)
    u = np.arange(size) / size
    waves = 2 * np.pi * np.outer(np.arange(1, count + 1), u)
    share = np.full(count, 2 / size)
    if size % 2 == 0 and count == size // 2:
        share[-1] = 1 / size
    cosines = share[:, None] * (np.cos(waves) @ values)
    sines = share[:, None] * (np.sin(waves) @ values)
    return values.mean(axis=0), cosines, sines


def equation_39(curve: np.ndarray, weights: list[float], targets: list[np.ndarray],
                t: float) -> np.ndarray:  # fmt: skip
    """Eq. 37 for each target with the constants that Eq. 4 fixes, blended by Eq. 38.

    The mean has zero initial velocity, the third condition that the paper leaves open.
    """
    size = len(curve)
    count = size // 2
    u = np.arange(size) / size
    n = np.arange(1, count + 1)
    b = 16 * K * np.pi**4 * n**4
    blended = np.zeros((size, 3))
    mean0, cos0, sin0 = series(curve, count)
    for zeta, target in zip(weights, targets, strict=True):
        mean1, cos1, sin1 = series(target, count)
        # Mean: b0 + b1 t + b2 t² + b3 t³ with b3 = e/(3c), b2 = -m e/c², b1 = 0.
        e = (mean1 - mean0) / (1 / (3 * C) - M / C**2)
        face = np.tile(mean0 - M * e / C**2 * t**2 + e / (3 * C) * t**3, (size, 1))
        waves = 2 * np.pi * np.outer(u, n)
        for wave, start, end in ((np.cos(waves), cos0, cos1), (np.sin(waves), sin0, sin1)):
            # g(t) = ê/B - 2mě/B² + 2c²ě/B³ - 2cě t/B² + ě t²/B through both shapes.
            law = 1 / b - 2 * C / b**2
            check = (end - start) / law[:, None]
            hat = (start + (2 * M / b**2 - 2 * C**2 / b**3)[:, None] * check) * b[:, None]
            g = (
                hat / b[:, None]
                - (2 * M / b**2 - 2 * C**2 / b**3)[:, None] * check
                - (2 * C / b**2)[:, None] * check * t
                + check * t**2 / b[:, None]
            )
            face += wave @ g
        blended += zeta * face
    return blended


@pytest.mark.parametrize("t", [0.0, 0.3, 0.75, 1.0])
def test_pose_blend_and_batch_are_equation_39(t: float) -> None:
    """On the closed curves of the head, face by face, to 1e-12 of D."""
    neutral = head()
    network = em.extract_curves(neutral)
    closed = [curve for curve in network if curve.closed][:25]
    targets = list(expressions().values())
    to = em.prepare(
        neutral, "beam:2", curves=network, closure="rest", material=em.Material(M, C, K)
    )
    rig = Rig(neutral, {f"e{i}": to(mesh) for i, mesh in enumerate(targets)})
    random = np.random.default_rng(2)
    for weights in random.random((4, 5)):
        weights /= weights.sum()
        zeta = {f"e{i}": float(w) for i, w in enumerate(weights)}
        blended = rig.blend(zeta, t)
        batched = rig.batch(weights[None], t, dtype=np.float64)[0]
        np.testing.assert_allclose(batched, blended, atol=1e-12 * neutral.diameter)
        for curve in closed:
            expected = equation_39(
                neutral.vertices[curve.vertices],
                weights.tolist(),
                [mesh.vertices[curve.vertices] for mesh in targets],
                t,
            )
            np.testing.assert_allclose(
                blended[curve.vertices], expected, atol=1e-12 * neutral.diameter
            )


def test_pose_is_equation_39_with_one_time_for_each_face() -> None:
    """V₀ + Σ (w^j(t_j) - V₀), each w^j by Eq. 37."""
    neutral = head()
    network = em.extract_curves(neutral)
    curve = max((c for c in network if c.closed), key=len)
    targets = expressions()
    to = em.prepare(
        neutral, "beam:2", curves=network, closure="rest", material=em.Material(M, C, K)
    )
    rig = Rig(neutral, {name: to(mesh) for name, mesh in targets.items()})
    times = {"sad": 0.2, "grinning": 0.9, "puff": 0.55}
    rest = neutral.vertices[curve.vertices]
    expected = rest.copy()
    for name, t in times.items():
        expected += equation_39(rest, [1.0], [targets[name].vertices[curve.vertices]], t) - rest
    posed = rig.pose(times)[curve.vertices]
    np.testing.assert_allclose(posed, expected, atol=1e-12 * neutral.diameter)
