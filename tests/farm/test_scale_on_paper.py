"""The simulated farm of the benchmark: where its answer is known."""

from __future__ import annotations

from dataclasses import replace

import pytest

from farm_scale import Machines, Work, simulate

WORK = Work(seconds=0.05, unit_seconds=0.1, bytes=1e5, arrays=8)
EVEN = Machines(machines=3, cores=4, requests=1e9, tasks=1e9, spread=0.0, slow=0.0, lost_hours=1e9)


def unit_seconds(farm: Machines, unit: int) -> float:
    drawing = WORK.unit_seconds + unit * WORK.seconds
    bandwidth = min(farm.stream * WORK.arrays, farm.network / farm.cores)
    return drawing + 2 * farm.latency + unit * WORK.bytes / bandwidth


@pytest.mark.parametrize("units", [1, 11, 12, 13, 120])
def test_even_cores_take_whole_rounds(units: int) -> None:
    run = simulate(WORK, EVEN, units * 64, 64)
    rounds = -(-units // 12)
    assert run.hours * 3600 == pytest.approx(rounds * unit_seconds(EVEN, 64), rel=1e-6)
    assert run.ideal * 3600 == pytest.approx(units / 12 * unit_seconds(EVEN, 64))
    assert run.lost == 0


def test_a_store_that_answers_slowly_sets_the_pace() -> None:
    slow = replace(EVEN, requests=2.0)
    run = simulate(WORK, slow, 200 * 64, 64)
    alone = 200 * 9 / 2.0
    assert alone <= run.hours * 3600 <= alone + 2 * unit_seconds(slow, 64)
    assert run.requests == pytest.approx(2.0, rel=0.02)


def test_a_scheduler_that_answers_slowly_sets_the_pace() -> None:
    slow = replace(EVEN, tasks=0.5)
    run = simulate(WORK, slow, 200 * 64, 64)
    assert 400 <= run.hours * 3600 <= 400 + 2 * unit_seconds(slow, 64)


def test_what_is_lost_is_made_again() -> None:
    lossy = replace(EVEN, lost_hours=0.05, back=10.0)
    even, run = (simulate(WORK, farm, 6000 * 64, 64) for farm in (EVEN, lossy))
    # A machine that is lost takes half a unit of each core with it, on average, and its way back.
    unit = unit_seconds(EVEN, 64)
    lost = (unit / 2 + 10.0) / (0.05 * 3600)
    assert run.hours / even.hours == pytest.approx(1 + lost, rel=0.1)
    assert run.lost == pytest.approx(unit / 2 / (0.05 * 3600) / (1 + lost), rel=0.4)


def test_slow_machines_do_less_of_the_work() -> None:
    """All of them slow: everything takes as much longer; the drawing alone."""
    slow = replace(EVEN, slow=1.0, slowness=3.0)
    run = simulate(WORK, slow, 120 * 64, 64)
    drawing = WORK.unit_seconds + 64 * WORK.seconds
    assert run.hours * 3600 == pytest.approx(10 * (unit_seconds(EVEN, 64) + 2 * drawing), rel=1e-6)
