"""The C++ header: as Python computes, with nothing allocated in a frame, whatever it is given."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from kit import RUNTIMES, VECTORS, require_conforming, require_each_mesh_bent

from needs import program

pytestmark = pytest.mark.players

CPP = RUNTIMES / "cpp"
STRICT = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{CPP}"]
STRICT += ["-Wconversion", "-Wsign-conversion", "-Wshadow", "-Wold-style-cast"]
CHECKED = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def compiled(source: Path, out: Path, *flags: str) -> Path:
    command = [program("g++", "g++"), *STRICT, *flags, str(source), "-o", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=110)
    assert done.returncode == 0, done.stderr[-3000:]
    return out


@pytest.mark.parametrize("flags", [["-O2"], CHECKED], ids=["optimised", "checked"])
def test_it_passes_the_kit(tmp_path: Path, flags: list[str]) -> None:
    require_conforming([str(compiled(CPP / "conform.cpp", tmp_path / "conform", *flags))])


def test_each_mesh_of_a_face_in_materials_is_bent(tmp_path: Path) -> None:
    program = compiled(CPP / "conform.cpp", tmp_path / "conform", "-O2")
    require_each_mesh_bent([str(program)], tmp_path)


def test_damaged_extras_are_refused_and_frames_allocate_nothing(tmp_path: Path) -> None:
    """Under the sanitizers of addresses and of undefined behaviour."""
    hostile = compiled(Path(__file__).parent / "hostile.cpp", tmp_path / "hostile", *CHECKED)
    for name in ("folds", "names", "together"):
        extras = tmp_path / f"{name}.json"
        extras.write_text(json.dumps(VECTORS[name]["extras"]), encoding="utf-8")
        done = subprocess.run(
            [hostile, extras], capture_output=True, text=True, check=False, timeout=100
        )
        assert done.returncode == 0, done.stderr[-3000:]
        assert int(done.stdout) > 100  # another letter of a name, another digit: still extras


def test_it_needs_no_exceptions(tmp_path: Path) -> None:
    """As engines compile."""
    compiled(CPP / "conform.cpp", tmp_path / "conform.o", "-c", "-fno-exceptions", "-fno-rtti")
