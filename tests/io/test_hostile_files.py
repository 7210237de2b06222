"""Hostile files of every format give something sound, or one error of ours.

The inputs are those of ``benchmarks/hostile_files.py``, which tries far more of them and measures
time and memory; here is also what shows that this command tells right from wrong. Formats that are
read in a process of their own have tests beside their readers.
"""

from __future__ import annotations

import dataclasses
import importlib
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastomorph.errors import FormatError, MeshError
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

pytestmark = pytest.mark.hostile

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"

linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is measured as on Linux")


@pytest.fixture(scope="module", autouse=True)
def _benchmarks_can_be_imported() -> Iterator[None]:
    sys.path.insert(0, str(BENCHMARKS))
    yield
    sys.path.remove(str(BENCHMARKS))


def hostile(module: str) -> Any:
    return importlib.import_module(f"hostile.{module}")


# Formats read here, and whether a file of the format that was cut off can never be whole.
FORMATS = {
    **dict.fromkeys(["OBJ", "PLY ascii", "CSV performance", "CSV Live Link"], False),
    **dict.fromkeys(["JSON poses", "CSV poses"], False),
    **dict.fromkeys(["JSON curves", "JSON region", "TOML settings", "numbered frames"], False),
    **dict.fromkeys(["PLY binary LE", "PLY binary BE", "MDD cache", "PC2 cache"], True),
    **dict.fromkeys(["NPZ mesh", "NPZ rig", "NPZ take", "NPZ markers", "NPZ performance"], True),
    **{"GLB": True, "glTF + .bin": False},
}
TEXTS = [name for name in FORMATS if name.split()[0] in ("OBJ", "PLY", "CSV", "JSON", "TOML")]
EACH = pytest.mark.parametrize("name", FORMATS)


def some(cases: list[Any], most: int) -> list[Any]:
    """As many as that, evenly spread."""
    return cases[:: 1 + len(cases) // most]


def read_case(known: Any, case: Any, folder: Path) -> str:
    """The message of the one error; empty for something sound."""
    try:
        path = case.write(folder)
    except (OSError, ValueError):  # a name that no file can have
        path = folder / "inside" / case.name
    thing, message = hostile("judge").judged(known.read, path, folder)
    assert (thing is None) == bool(message), case.label
    if thing is not None:
        known.judge(thing)
    assert case.wanted in ("either", "refused" if message else "loaded"), (case.label, message)
    return str(message)


@pytest.mark.parametrize("name", TEXTS)
def test_texts_made_by_hand(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Long ones are a third as long as the command makes them, which also measures the time."""
    for module in ("texts", "byte_changes"):
        monkeypatch.setattr(hostile(module), "MOST_BYTES", 300_000)
    known = hostile("trial").find_format(name)
    for case in known.fixed():
        read_case(known, case, tmp_path / "trial")


@EACH
def test_a_file_cut_off_anywhere(tmp_path: Path, name: str) -> None:
    """Binary files are refused wherever they are cut; text may be cut to a shorter whole text."""
    known = hostile("trial").find_format(name)
    for number, length in some(known.cuts(), 150):
        message = read_case(known, known.cut(number, length), tmp_path / "trial")
        assert message or not FORMATS[name], length


@EACH
def test_a_file_with_any_one_byte_turned_around(tmp_path: Path, name: str) -> None:
    known = hostile("trial").find_format(name)
    whole = known.whole()[0]
    for place in some(list(range(len(whole))), 150):
        turned = bytearray(whole)
        turned[place] ^= 0xFF
        case = dataclasses.replace(known.cut(0, 0), label=f"byte {place}")
        files = {file: bytes(turned) for file in case.files if case.files[file] == b""}
        case = dataclasses.replace(case, files={**case.files, **files})
        read_case(known, case, tmp_path / "trial")


@EACH
@given(seed=st.integers(0, 2**64 - 1))
@settings(
    max_examples=80,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_random_damage(tmp_path: Path, name: str, seed: int) -> None:
    known = hostile("trial").find_format(name)
    read_case(known, known.random(Random(seed)), tmp_path / "trial")


@EACH
@given(content=st.binary(max_size=200))
@settings(
    max_examples=40,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_random_bytes_behind_the_beginning_of_a_file(
    tmp_path: Path, name: str, content: bytes
) -> None:
    known = hostile("trial").find_format(name)
    case = known.cut(0, len(content))
    files = {
        file: entry + content if entry == known.whole()[0][: len(content)] else entry
        for file, entry in case.files.items()
    }
    read_case(known, dataclasses.replace(case, files=files), tmp_path / "trial")


def test_every_format_is_tried_here_or_in_a_process_of_its_own() -> None:
    assert {known.name for known in hostile("formats").FORMATS if not known.isolated} == set(
        FORMATS
    )


def told_of(read: Callable[[Path], Any], folder: Path, wanted: str = "either") -> dict[str, Any]:
    """What comes of a file of five bytes with a reader."""
    formats, trial = hostile("formats"), hostile("trial")
    case = hostile("case").Case("five", "a.x", {"a.x": b"12345"}, wanted)
    known = formats.Format("toys", "a.x", lambda: [b"12345"], read)
    told: dict[str, Any] = trial.tried(known, case, 1, folder / "trial")
    return told


def triangle(path: Path) -> Mesh:
    return Mesh(np.eye(3), [[0, 1, 2]])


def broken(mesh: Mesh) -> Mesh:
    """With a coordinate that no mesh can have."""
    vertices = mesh.vertices.copy()
    vertices[0, 0] = np.nan
    object.__setattr__(mesh, "vertices", vertices)
    return mesh


def refuse(path: Path) -> Any:
    raise FormatError(path, "no toys")


def refuse_without_name(path: Path) -> Any:
    raise MeshError("no toys")


def refuse_at_length(path: Path) -> Any:
    raise FormatError(path, "no" * 10_000)


def warn(path: Path) -> Any:
    warnings.warn("overflow", RuntimeWarning, stacklevel=1)
    return triangle(path)


def fill_memory(path: Path) -> Any:
    np.ones(40 << 20)
    return triangle(path)


def take_long(path: Path) -> Any:
    end = time.process_time() + 0.3
    while time.process_time() < end:
        pass
    return triangle(path)


def half_a_name(path: Path) -> Any:
    mesh = triangle(path)
    object.__setattr__(mesh, "material_library", "\ud800")
    return mesh


def test_what_loads_and_what_is_refused_is_told(tmp_path: Path) -> None:
    assert told_of(triangle, tmp_path)["outcome"] == "loaded"
    told = told_of(refuse, tmp_path)
    assert told["outcome"] == "refused"
    assert told["message"].endswith("a.x: no toys")
    assert told["seconds"] < 1
    rig = Rig(triangle(tmp_path), {})
    assert told_of(lambda path: rig, tmp_path)["outcome"] == "loaded"


@pytest.mark.parametrize(
    ("read", "problem"),
    [
        (lambda path: 1 / 0, "ZeroDivisionError"),
        (lambda path: [][0], "IndexError"),
        (lambda path: sys.exit(0), "SystemExit"),
        (lambda path: broken(triangle(path)), "numbers that are finite"),
        (half_a_name, "a name that can be written"),
        (refuse_without_name, "names no file of the folder"),
        (refuse_at_length, "too long"),
        (warn, "a warning of another library: RuntimeWarning: overflow"),
        (lambda path: "a text", "nothing is known about str"),
        pytest.param(fill_memory, "MB of memory", marks=linux),
    ],
)
def test_anything_else_is_a_failure(
    tmp_path: Path, read: Callable[[Path], Any], problem: str
) -> None:
    told = told_of(read, tmp_path)
    assert told["outcome"] == "failed"
    assert problem in told["problem"]


def test_a_reader_that_takes_long_each_time_is_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trial = hostile("trial")
    assert told_of(take_long, tmp_path)["outcome"] == "loaded"
    monkeypatch.setattr(trial, "MOST_SECONDS", 0.1)
    assert "took 0.3 s" in told_of(take_long, tmp_path)["problem"]


def test_a_file_that_must_load_or_must_not(tmp_path: Path) -> None:
    assert "must load" in told_of(refuse, tmp_path, "loaded")["problem"]
    assert "must be refused" in told_of(triangle, tmp_path, "refused")["problem"]


def test_the_same_seed_makes_the_same_inputs() -> None:
    trial = hostile("trial")
    known = trial.find_format("JSON region")
    made = trial.cases(known, 5)
    first = [next(made)[0] for _ in range(200)]
    assert first[150:] == [next(trial.cases(known, 5, n))[0] for n in range(150, 200)]
    other = [next(trial.cases(known, 6, n))[0] for n in range(150, 200)]
    assert first[150:] != other


@pytest.mark.slow
def test_the_command_prints_its_table_and_finds_nothing(tmp_path: Path) -> None:
    done = subprocess.run(
        [
            *(sys.executable, str(BENCHMARKS / "hostile_files.py"), "--seconds", "2"),
            *("--keep", str(tmp_path / "kept"), "--formats", "JSON region", "MDD cache"),
        ],
        capture_output=True,
        text=True,
        timeout=300,
        env=os.environ | {"PYTHONWARNINGS": "default"},
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert not (tmp_path / "kept").exists()
    rows = {line[:16].strip(): line[16:].split() for line in done.stdout.splitlines()}
    for name in ("JSON region", "MDD cache"):
        tried, loaded, refused, failed = (int(n.replace(",", "")) for n in rows[name][:4])
        assert tried == loaded + refused > 35
        assert failed == 0
