"""Materials and loads are recovered from motions that have them, and not from those that do not."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest

import elastomorph as em
from elastomorph.curves import CurveNetwork
from elastomorph.errors import CurveError, MeshError, ParameterError, TopologyError
from material_fit import fit
from material_results import EXCURSION, Fit

Synthesis = Callable[..., list[em.MeshSequence]]

pytestmark = pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")

# Damping and mass near the stiffness of the softest modes, π⁴ and 16π⁴.
QUADRATIC = em.Method("beam", load=em.Load([0.3, 0.7]), material=em.Material(1, 8, 1))
CUBIC = em.Method("beam", load=em.Load([0.3, 0.5, 0.2]), material=em.Material(6, 9, 1))
QUARTIC = em.Method("beam", load=em.Load([0.3, 0.2, 0.3, 0.2]), material=em.Material(4, 7, 1))


def brute_force(
    motions: list[em.MeshSequence], method: em.Method, network: CurveNetwork
) -> np.ndarray:
    """Squared distances of all curve vertices in the inner frames, over the squared D."""
    at = np.flatnonzero(network.curve_of >= 0)
    distances = [
        (
            (
                em.interpolate(m.neutral, m.target, method, curves=network).at(m.times[1:-1])
                - m.frames[1:-1]
            )[:, at]
            ** 2
        ).sum(axis=-1)
        for m in motions
    ]
    return np.concatenate([d.ravel() for d in distances]) / motions[0].mesh.diameter ** 2


@pytest.mark.parametrize("truth", [QUADRATIC, CUBIC, QUARTIC], ids=["t²", "t³", "t⁴"])
def test_exact_motions_give_their_material_and_load_back(
    truth: em.Method, synthesis: Synthesis, network: CurveNetwork
) -> None:
    found = fit(synthesis(truth), network)
    assert found.degree == truth.external_load.order
    assert found.chosen == "leave-one-out"
    np.testing.assert_allclose(found.load.coefficients, truth.external_load.coefficients, rtol=1e-4)
    assert found.damping.value == pytest.approx(truth.material.damping, rel=1e-4)
    assert found.damping.low < truth.material.damping < found.damping.high
    if found.degree > 2:
        assert found.mass.value == pytest.approx(truth.material.mass, rel=1e-4)
    else:
        assert not found.mass.identified  # a quadratic load knows no mass
    assert found.damping.refits == pytest.approx([truth.material.damping] * 2, rel=1e-4)
    assert found.in_sample[2].rms < 1e-8
    assert found.beats_linear
    assert found.beats_ease


@pytest.mark.parametrize("closure", ["unforced", "rest", "compatible", "linear"])
def test_every_closure_can_be_fitted(
    closure: str, synthesis: Synthesis, network: CurveNetwork
) -> None:
    """The means add to what is known of the mass, even with a quadratic load."""
    truth = em.Method(
        "beam", load=em.Load([0.6, 0.4]), material=em.Material(2, 9, 1), closure=closure
    )
    found = fit(synthesis(truth, count=1), network, degree=2, closure=closure)
    assert found.damping.value == pytest.approx(9, rel=1e-4)
    assert found.mass.identified == (closure != "linear")
    if found.mass.identified:
        assert found.mass.value == pytest.approx(2, rel=1e-4)
    assert found.method.closure == closure


def test_with_noise_the_truth_lies_in_the_intervals(
    synthesis: Synthesis, network: CurveNetwork
) -> None:
    """95 % of independent intervals hold it: of 16, thirteen or more do with odds of 140 to 1."""
    held = []
    for seed in range(4):
        motions = synthesis(CUBIC, count=3, frames=20, noise=2e-4, seed=seed)
        found = fit(motions, network, degree=3, starts=3)
        held.append(found.damping.low < CUBIC.material.damping < found.damping.high)
        held.append(found.mass.low < CUBIC.material.mass < found.mass.high)
        held += [
            low < p < high
            for p, (low, high) in zip(
                CUBIC.external_load.coefficients[1:], found.load_intervals[1:], strict=True
            )
        ]
        assert found.damping.high < 2 * found.damping.low  # they say something
    assert sum(held) >= 13


def test_more_noise_gives_wider_intervals(synthesis: Synthesis, network: CurveNetwork) -> None:
    widths = []
    for noise in (1e-4, 1e-3):
        found = fit(synthesis(QUADRATIC, noise=noise), network, degree=2)
        widths.append(found.damping.high - found.damping.low)
    assert widths[1] == pytest.approx(10 * widths[0], rel=0.25)


@pytest.mark.parametrize("degree", [None, 2, 3])
def test_ease_says_nothing_about_the_material(
    degree: int | None, synthesis: Synthesis, network: CurveNetwork
) -> None:
    motions = synthesis(em.Method("ease", order=2))
    found = fit(motions, network, degree=degree)
    np.testing.assert_allclose(
        found.load.coefficients[:3], [0, 1, 0][: len(found.load.coefficients)], atol=1e-6
    )
    assert found.material is None
    for ratio in (found.damping, found.mass):
        assert ratio.value is None
        assert ratio.low == 0
        assert not ratio.identified
    assert found.damping.high < 0.01
    assert found.method.name == "ease"
    assert found.beats_linear
    assert not found.beats_ease
    assert "not identified" in found.text()
    assert "the material adds nothing to the timing" in found.text().replace("\n", " ")


def test_linear_motions_are_not_beaten(synthesis: Synthesis, network: CurveNetwork) -> None:
    found = fit(synthesis(em.Method("linear"), noise=0.01), network)
    assert found.degree == 1
    assert found.beats_linear is False
    assert "does not beat linear interpolation" in found.text().replace("\n", " ")


def test_repetitions_of_different_timing_do_not_predict_each_other(
    synthesis: Synthesis, network: CurveNetwork
) -> None:
    """One motion runs ahead, one behind: what fits one is worse than linear on the other."""
    slow = synthesis(em.Method("ease", order=2), count=1)
    fast = synthesis(em.Method("ease", load=em.Load([2, -1])), count=1, seed=2)
    found = fit(slow + fast, network)
    assert found.degree_errors[2] > 1.5 * found.degree_errors[1]
    assert found.degree == 1
    assert "does not beat linear" in found.text().replace("\n", " ")
    forced = fit(slow + fast, network, degree=2)
    assert forced.left_out[2].rms > 1.5 * forced.left_out[0].rms
    assert "does not beat linear" in forced.text().replace("\n", " ")


def test_errors_are_those_of_interpolate(synthesis: Synthesis, network: CurveNetwork) -> None:
    motions = synthesis(QUADRATIC, count=2, noise=0.002)
    found = fit(motions, network, degree=2)
    squared = brute_force(motions, found.method, network)
    assert found.in_sample[2].rms == pytest.approx(np.sqrt(squared.mean()), rel=1e-9)
    scales = [motion.mesh.diameter / motions[0].mesh.diameter for motion in motions]
    largest = [
        scale * np.sqrt(brute_force([motion], found.method, network).max())
        for motion, scale in zip(motions, scales, strict=True)
    ]
    assert found.in_sample[2].lme == pytest.approx(np.mean(largest), rel=1e-9)
    for i, motion in enumerate(motions):
        other = fit(motions[1 - i], network, degree=2)
        alone = scales[i] * np.sqrt(brute_force([motion], other.method, network).mean())
        assert found.left_out_rms[i, 2] == pytest.approx(alone, rel=1e-5)


def test_no_nearby_material_is_better(synthesis: Synthesis, network: CurveNetwork) -> None:
    motions = synthesis(QUADRATIC, noise=0.002)
    found = fit(motions, network, degree=2)
    best = brute_force(motions, found.method, network).sum()
    random = np.random.default_rng(0)
    for _ in range(20):
        share = 1 + 0.05 * random.normal(size=3)
        other = em.Method(
            "beam",
            load=em.Load(np.array(found.load.coefficients) * share[:2]),
            material=em.Material(1.0, found.damping.value * share[2], 1.0),
        )
        assert brute_force(motions, other, network).sum() >= best


def test_scale_and_rigid_motion_change_nothing(synthesis: Synthesis, network: CurveNetwork) -> None:
    motions = synthesis(QUADRATIC, noise=0.002)
    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    moved = [
        em.MeshSequence(
            m.mesh.with_vertices(3.0 * m.frames[0] @ turn + 7.0),
            3.0 * m.frames @ turn + 7.0,
            m.times,
        )
        for m in motions
    ]
    one, other = (fit(each, network, degree=2) for each in (motions, moved))
    assert other.damping.value == pytest.approx(one.damping.value, rel=1e-5)
    assert other.damping.high == pytest.approx(one.damping.high, rel=1e-3)
    np.testing.assert_allclose(other.load.coefficients, one.load.coefficients, rtol=1e-6)
    assert other.in_sample[2].rms == pytest.approx(one.in_sample[2].rms, rel=1e-6)
    assert other.diameter == pytest.approx(3 * one.diameter)


def test_laws_stay_within_the_range(synthesis: Synthesis, network: CurveNetwork) -> None:
    """A motion that runs back by 80 % has no law inside: the fit says it is at the border."""
    back = em.Method("ease", load=em.Load([-4, 5]))
    found = fit(synthesis(back, count=1), network, degree=2)
    assert 0.095 < found.excursion <= EXCURSION
    assert "the border of the range" in found.text().replace("\n", " ")


def test_curves_of_different_material_are_told_apart(
    synthesis: Synthesis, network: CurveNetwork
) -> None:
    mixed = []
    for one in synthesis(QUADRATIC, count=2):
        frames = one.frames.copy()
        at = network[3].vertices
        path = em.interpolate(one.neutral, one.target, "ease:2")
        frames[:, at] = path.at(one.times)[:, at]
        mixed.append(em.MeshSequence(one.mesh, frames, one.times))
    found = fit(mixed, network, degree=2, per_curve=True, starts=4)
    assert [one.name for one in found.per_curve] == [f"curve {i}" for i in range(5)]
    np.testing.assert_allclose(found.per_curve[3].load.coefficients, [0, 1], atol=1e-5)
    assert not found.per_curve[3].damping.identified
    assert found.per_curve[2].damping.value == pytest.approx(8, rel=1e-3)
    assert all(one.rms < 1e-4 < one.linear_rms for one in found.per_curve)
    assert all(one.left_out_rms < 1e-4 for one in found.per_curve)
    assert "Every curve alone" in found.text()


def test_a_curve_that_stays_is_said_to(synthesis: Synthesis, network: CurveNetwork) -> None:
    motion = synthesis(QUADRATIC, count=1)[0]
    frames = motion.frames.copy()
    frames[:, network[0].vertices] = frames[0, network[0].vertices]
    found = fit(
        em.MeshSequence(motion.mesh, frames, motion.times), network, degree=2, per_curve=True
    )
    assert found.per_curve[0].load is None
    assert found.per_curve[1].load is not None
    assert "does not move" in found.text()


def test_one_motion_cannot_be_left_out(synthesis: Synthesis, network: CurveNetwork) -> None:
    found = fit(synthesis(QUADRATIC, count=1, noise=0.001)[0], network)
    assert found.left_out == ()
    assert found.beats_linear is None
    assert found.chosen == "BIC"
    assert found.degree == 2
    assert "Leave-one-out needs two motions" in found.text()


def test_the_method_is_ready(synthesis: Synthesis, network: CurveNetwork) -> None:
    motion = synthesis(CUBIC, count=1)[0]
    found = fit(motion, network, degree=3)
    path = em.interpolate(motion.neutral, motion.target, found.method, curves=network)
    on_curves = network.curve_of >= 0
    np.testing.assert_allclose(
        path.at(motion.times)[:, on_curves], motion.frames[:, on_curves], atol=1e-7
    )


def test_facts_are_strict_json(synthesis: Synthesis, network: CurveNetwork) -> None:
    found = fit(synthesis(QUADRATIC, count=2), network, degree=2, per_curve=True)
    facts = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert facts["damping"]["value"] == found.damping.value
    assert facts["mass"] == {
        "value": None,
        "low": 0.0,
        "high": None,
        "identified": False,
        "reproducible": False,
        "refits": None,
    }
    assert facts["load"] == list(found.load.coefficients)
    assert len(facts["per_curve"]) == 5


def test_text_keeps_to_its_width(synthesis: Synthesis, network: CurveNetwork) -> None:
    found: Fit = fit(synthesis(QUADRATIC, noise=0.01), network, degree=2)
    assert max(map(len, found.text(80).splitlines())) <= 80
    assert str(found) == found.text()


class TestWhatCannotBeFitted:
    def test_no_motion(self) -> None:
        with pytest.raises(ParameterError, match="no motion"):
            fit([])

    def test_no_sequence(self, network: CurveNetwork) -> None:
        with pytest.raises(ParameterError, match=r"motion 1 must be a MeshSequence.*, found str"):
            fit(["take.npz"], network)  # type: ignore[list-item]

    def test_a_motion_that_ends_where_it_starts(
        self, synthesis: Synthesis, network: CurveNetwork
    ) -> None:
        good = synthesis(QUADRATIC, count=1)[0]
        there_and_back = em.MeshSequence(
            good.mesh, np.concatenate([good.frames, good.frames[-2::-1]])
        )
        with pytest.raises(MeshError, match="motion 2 does not move"):
            fit([good, there_and_back], network)

    def test_motions_of_different_meshes(self, synthesis: Synthesis, network: CurveNetwork) -> None:
        good = synthesis(QUADRATIC, count=1)[0]
        less = em.MeshSequence(em.Mesh(good.frames[0, :-1]), good.frames[:, :-1])
        with pytest.raises(TopologyError, match="motion 2 is of another mesh"):
            fit([good, less], network)

    def test_fewer_frames_than_parameters(
        self, synthesis: Synthesis, network: CurveNetwork
    ) -> None:
        short = synthesis(CUBIC, frames=5, count=1)
        with pytest.raises(ParameterError, match=r"3 frames .* fewer than the 4 parameters"):
            fit(short, network, degree=3)
        assert set(fit(short, network).degree_errors) == {1, 2}
        with pytest.raises(ParameterError, match="0 frames"):
            fit(synthesis(CUBIC, frames=2), network)
        with pytest.raises(ParameterError, match="when one motion is left out"):
            fit(synthesis(CUBIC, frames=3, count=2), network)

    def test_curves_of_another_mesh(self, synthesis: Synthesis) -> None:
        motion = synthesis(QUADRATIC, count=1)
        with pytest.raises(CurveError, match="a mesh of 4 vertices"):
            fit(motion, CurveNetwork([], 4))
        with pytest.raises(CurveError, match="there is none"):
            fit(motion, CurveNetwork([], 30))

    @pytest.mark.parametrize(
        "settings",
        [{"degree": 0}, {"degree": 7}, {"degree": True}, {"closure": "x"}, {"starts": -1}],
    )
    def test_settings_out_of_range(
        self, settings: dict[str, object], synthesis: Synthesis, network: CurveNetwork
    ) -> None:
        with pytest.raises(ParameterError, match="must be"):
            fit(synthesis(QUADRATIC, count=1), network, **settings)  # type: ignore[arg-type]
