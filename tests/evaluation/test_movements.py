"""Movements of a take, evaluated one by one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.evaluation.every_method import every_method
from elastomorph.evaluation.movements import evaluate_movements, mean_lines
from elastomorph.io.curve_file import read_curves
from elastomorph.io.marker_take import read_marker_take

CURVES = Path(__file__).parents[2] / "benchmarks" / "animface_curves.json"


def smooth_take() -> em.MeshSequence:
    """Twice from rest to an apex and back, along a straight line, in smooth steps."""
    rise = (1 - np.cos(np.pi * np.arange(31) / 30)) / 2
    level = np.concatenate([np.zeros(40), rise, np.ones(20), rise[::-1], np.zeros(40)] * 2)
    rest = np.random.default_rng(0).normal(size=(6, 3))
    moved = np.random.default_rng(1).normal(size=(6, 3)) * 0.3
    return em.MeshSequence(em.Mesh(rest), rest + level[:, None, None] * moved)


def test_two_onsets_and_two_offsets_are_judged_alike() -> None:
    """The movements are the same forwards and backwards, so are their errors."""
    take = smooth_take()
    network = em.CurveNetwork([em.Curve(np.arange(6), False)], 6)
    judged = evaluate_movements(take, network, lambda _: ["linear", "cosine"])
    assert [one.movement.kind for one in judged] == ["onset", "offset"] * 2
    errors = [one.evaluation["linear"].lme * one.evaluation.diameter for one in judged]
    np.testing.assert_allclose(errors, errors[0], rtol=1e-6)
    means = mean_lines(judged)
    assert list(means) == ["Mean over 2 onsets", "Mean over 2 offsets", "Mean over 4 movements"]
    first, second = (judged[i].evaluation["linear"].lme for i in (0, 2))
    assert means["Mean over 2 onsets"][0].lme == pytest.approx((first + second) / 2)
    assert means["Mean over 4 movements"][0].path_lme < 1e-9


def test_a_still_take_is_refused() -> None:
    rest = np.random.default_rng(0).normal(size=(6, 3))
    take = em.MeshSequence(em.Mesh(rest), np.stack([rest] * 90))
    network = em.CurveNetwork([em.Curve(np.arange(6), False)], 6)
    with pytest.raises(em.ParameterError, match="no movement"):
        evaluate_movements(take, network, lambda _: ["linear"])


@pytest.mark.slow
@pytest.mark.realdata
def test_in_betweens_pay_on_real_captures(data_dir: Path) -> None:
    """One and two suggested in-betweens divide the mean LME of linear by 2 and 3 at least.

    Free timing never makes an error larger: it is one of many timings, and so are recorded times.
    """
    lme: dict[str, list[float]] = {"linear": [], "through 1": [], "through 2": []}
    kinds = []
    for name in ("jaw", "eyebrows"):
        take = read_marker_take(data_dir / "animface" / f"{name}.npz")
        curves = read_curves(CURVES, len(take.names), take.names)
        network = em.CurveNetwork(curves, len(take.names))
        judged = evaluate_movements(
            take.motion, network, lambda part, network=network: every_method(part, network)
        )
        for one in judged:
            kinds.append(one.movement.kind)
            for result in one.evaluation.results:
                assert result.path_lme <= result.lme * (1 + 1e-12)
                assert result.path_lae <= result.lae * (1 + 1e-12)
            for label, values in lme.items():
                values.append(one.evaluation[label].lme)
    assert kinds.count("onset") >= 4
    assert kinds.count("offset") >= 4
    linear, one_key, two_keys = (np.mean(values) for values in lme.values())
    assert linear / one_key > 2.0
    assert linear / two_keys > 3.0


@pytest.mark.slow
@pytest.mark.realdata
def test_the_path_of_auto_is_never_worse_than_the_straight_line(data_dir: Path) -> None:
    """By more than 0.02 % of D, on any recorded movement."""
    for name in ("jaw", "eyebrows"):
        take = read_marker_take(data_dir / "animface" / f"{name}.npz")
        network = em.CurveNetwork(read_curves(CURVES, len(take.names), take.names), len(take.names))
        for one in evaluate_movements(take.motion, network, lambda _: ["linear", "auto"]):
            auto, straight = one.evaluation["auto"], one.evaluation["linear"]
            assert auto.path_lme <= straight.path_lme + 2e-4
