"""Random damage to a whole file of any format gives something sound, or one error of ours.

The inputs are those of ``benchmarks/hostile_files.py``, which tries far more of them and measures
time and memory. Formats that are read in a process of their own have tests beside their readers.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="module", autouse=True)
def _benchmarks_can_be_imported() -> Iterator[None]:
    sys.path.insert(0, str(BENCHMARKS))
    yield
    sys.path.remove(str(BENCHMARKS))


def hostile(module: str) -> Any:
    return importlib.import_module(f"hostile.{module}")


@pytest.mark.parametrize(
    "name",
    [
        *("OBJ", "PLY ascii", "PLY binary LE", "PLY binary BE"),
        *("NPZ mesh", "NPZ rig", "NPZ take", "NPZ markers", "GLB", "glTF + .bin"),
        *("CSV performance", "CSV Live Link", "JSON curves", "JSON region", "TOML settings"),
        *("numbered frames", "MDD cache", "PC2 cache"),
    ],
)
@given(seed=st.integers(0, 2**64 - 1))
@settings(
    max_examples=80,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_random_damage(tmp_path: Path, name: str, seed: int) -> None:
    known = hostile("trial").find_format(name)
    folder = tmp_path / "trial"
    path = known.random(Random(seed)).write(folder)
    thing, message = hostile("judge").judged(known.read, path, folder)
    assert (thing is None) == bool(message)
    if thing is not None:
        known.judge(thing)


def test_every_format_is_tried_here_or_in_a_process_of_its_own() -> None:
    formats = {known.name for known in hostile("formats").FORMATS if not known.isolated}
    (marks,) = (mark for mark in test_random_damage.pytestmark if mark.name == "parametrize")
    assert formats == set(marks.args[1])
