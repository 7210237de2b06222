"""The C# file: as Python computes, whatever it is given."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from kit import RUNTIMES, VECTORS, require_conforming, require_each_mesh_bent

from needs import program

pytestmark = pytest.mark.players

CSHARP = RUNTIMES / "csharp"


@pytest.fixture(scope="module")
def mono() -> str:
    return program("mono", "mono-runtime")


def compiled(source: Path, out: Path) -> Path:
    """An assembly of the file and a program; C# 7.3 is what Unity and Godot have at least."""
    command = [program("mcs", "mono-mcs"), "-langversion:7", "-warn:4", "-warnaserror"]
    command += [f"-out:{out}", str(CSHARP / "Elastomorph.cs"), str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=100)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return out


def test_it_passes_the_kit(mono: str, tmp_path: Path) -> None:
    require_conforming([mono, str(compiled(CSHARP / "Conform.cs", tmp_path / "Conform.exe"))])


def test_each_mesh_of_a_face_in_materials_is_bent(mono: str, tmp_path: Path) -> None:
    program = compiled(CSHARP / "Conform.cs", tmp_path / "Conform.exe")
    require_each_mesh_bent([mono, str(program)], tmp_path)


@pytest.mark.parametrize("name", ["correctives", "together"])
def test_damaged_extras_are_refused(mono: str, name: str, tmp_path: Path) -> None:
    extras = tmp_path / "extras.json"
    extras.write_text(json.dumps(VECTORS[name]["extras"]), encoding="utf-8")
    hostile = compiled(Path(__file__).parent / "Hostile.cs", tmp_path / "Hostile.exe")
    done = subprocess.run(
        [mono, str(hostile), str(extras)], capture_output=True, text=True, check=False, timeout=100
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert int(done.stdout) > 100  # another letter of a name, another digit: still extras
