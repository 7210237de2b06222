"""The command that tries hostile files tells right from wrong, and finds nothing wrong."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastomorph.errors import FormatError, MeshError
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"

linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is measured as on Linux")


@pytest.fixture(autouse=True)
def _benchmarks_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def told_of(read: Callable[[Path], Any], folder: Path, wanted: str = "either") -> dict[str, Any]:
    """What comes of a file of five bytes with a reader."""
    formats = importlib.import_module("hostile.formats")
    trial = importlib.import_module("hostile.trial")
    case = importlib.import_module("hostile.case").Case("five", "a.x", {"a.x": b"12345"}, wanted)
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
    trial = importlib.import_module("hostile.trial")
    assert told_of(take_long, tmp_path)["outcome"] == "loaded"
    monkeypatch.setattr(trial, "MOST_SECONDS", 0.1)
    assert "took 0.3 s" in told_of(take_long, tmp_path)["problem"]


def test_a_file_that_must_load_or_must_not(tmp_path: Path) -> None:
    assert "must load" in told_of(refuse, tmp_path, "loaded")["problem"]
    assert "must be refused" in told_of(triangle, tmp_path, "refused")["problem"]


def test_the_same_seed_makes_the_same_inputs() -> None:
    trial = importlib.import_module("hostile.trial")
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
