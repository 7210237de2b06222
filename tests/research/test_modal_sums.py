"""The sums over modes say the same as the vertices do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import elastomorph as em
from elastomorph.curves import CurveNetwork
from material_results import LawSums, ModalSums, Objective, curve_sums

Synthesis = Callable[..., list[em.MeshSequence]]

pytestmark = pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")


@pytest.mark.parametrize("closure", ["limit", "rest", "unforced", "compatible", "linear"])
@pytest.mark.parametrize("coefficients", [[1.0], [0.3, 0.7], [0.1, 0.5, 0.4], [2, -2, 0.5, 0.5]])
def test_the_objective_is_the_distance_of_interpolate(
    coefficients: list[float], closure: str, synthesis: Synthesis, network: CurveNetwork
) -> None:
    """For any material and load, over all motions: sum over modes = sum over vertices."""
    noise = np.random.default_rng(3)
    motions = synthesis(em.Method("ease", order=2), count=2, frames=7, noise=0.1)
    parts = [
        LawSums.of(ModalSums.joined(curve_sums(m, list(network))), len(coefficients) + 1)
        for m in motions
    ]
    objective = Objective(LawSums.together(parts), len(coefficients), closure)
    at = np.flatnonzero(network.curve_of >= 0)
    for _ in range(3):
        damping, mass = np.exp(noise.normal(size=2)).tolist()
        method = em.Method(
            "beam",
            load=em.Load(coefficients),
            material=em.Material(mass, damping, 1.0),
            closure=closure,
        )
        direct = 0.0
        for motion in motions:
            path = em.interpolate(motion.neutral, motion.target, method, curves=network)
            apart = (path.at(motion.times) - motion.frames)[:, at]
            direct += float((apart**2).sum())
        load = np.array(coefficients) / sum(coefficients)
        point = np.concatenate([np.log([damping, mass]), load[1:]])
        assert objective.sums.misfit(objective.laws(point)) == pytest.approx(direct, rel=1e-10)


def test_joining_loses_nothing(synthesis: Synthesis, network: CurveNetwork) -> None:
    motion = synthesis(em.Method("ease", order=2), count=1, noise=0.1)[0]
    parts = curve_sums(motion, list(network))
    whole = ModalSums.joined(parts)
    assert whole.displacement.sum() == pytest.approx(sum(p.displacement.sum() for p in parts))
    assert (np.diff(whole.stiffness) > 0).all()
    assert whole.vertices == 29
    at = np.flatnonzero(network.curve_of >= 0)
    moved = (motion.frames[1:-1] - motion.frames[0])[:, at]
    assert whole.total == pytest.approx((moved**2).sum())
    assert whole.displacement.sum() == pytest.approx(
        ((motion.frames[-1] - motion.frames[0])[at] ** 2).sum()
    )


def test_a_motion_without_inner_frames_adds_nothing(
    synthesis: Synthesis, network: CurveNetwork
) -> None:
    long, short = (
        ModalSums.joined(curve_sums(synthesis(em.Method("ease"), count=1, frames=n)[0], network))
        for n in (9, 2)
    )
    parts = [LawSums.of(sums, 3) for sums in (long, short)]
    laws = np.ones((len(long.stiffness), 3)) / 3
    both = LawSums.together(parts)
    assert both.misfit(laws) == pytest.approx(parts[0].misfit(laws), rel=1e-12)
    assert both.frames == 7


def test_a_single_vertex_has_a_mean_and_no_material() -> None:
    one = CurveNetwork([em.Curve([0]), em.Curve([1])], 3)
    mesh = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    times = np.linspace(0, 1, 6)
    frames = mesh.vertices + times[:, None, None] ** 2 * np.ones((3, 3))
    sums = ModalSums.joined(curve_sums(em.MeshSequence(mesh, frames), list(one)))
    objective = Objective(LawSums.of(sums, 4), 3, "limit")
    assert not objective.free[:2].any()
    assert objective.misfit(np.array([0.0, 0.0, 1.0, 0.0])) < 1e-14
