"""The verbs that work on rigs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from elastomorph.samples import expressions, head
from needs import extra


def test_blend_makes_all_combinations(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Three levels of five expressions are 242 faces; each is rig.blend of its weights."""
    out = tmp_path / "faces.npz"
    assert run("blend", "--levels", 3, "-t", 0.5, "-o", out, "--json") == 0
    assert json.loads(capsys.readouterr().out)["faces"] == 242
    rig = em.read_rig("built-in").only(list(expressions()))
    with np.load(out) as archive:
        row = archive["weights"][100]
        face = archive["vertices"][100]
    zeta = dict(zip(rig.names, (row / row.sum()).tolist(), strict=True))
    np.testing.assert_allclose(face, rig.blend(zeta, 0.5), atol=1e-5)


def test_blend_makes_one_face(tmp_path: Path) -> None:
    out = tmp_path / "face.obj"
    assert run("blend", "-w", "grinning=0.5", "-w", "browDown_L=1", "-o", out) == 0
    neutral = head().vertices
    moved = np.linalg.norm(em.read(out).vertices - neutral, axis=1)
    assert moved.max() > 0.1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["blend", "-w", "grinning"], "name=number"),
        (["blend", "-w", "grining=1", "-o", "x.obj"], "did you mean 'grinning'"),
        (["blend", "-w", "sad=1"], "say where"),
        (["blend", "--expressions", "sad,happy", "-o", "x.npy"], "happy"),
        (["blend", "--levels", "3", "-o", "x.txt"], "x.txt"),
        (["export", "built-in", "-o", "x.stl"], "x.stl"),
        (["export", "built-in", "-o", "x.fbx"], "only read"),
        (["export", "nowhere.glb", "-o", "x.glb"], "nowhere.glb"),
    ],
)
def test_mistakes(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*arguments) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert message in said
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_bench_prints_its_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("bench", "--levels", 2, "--repeats", 1) == 0
    assert run("bench", "--repeats", 10**9) == 2  # Told before any work
    said = capsys.readouterr().out
    assert "31 faces" in said
    assert "memory copy" in said


def test_what_a_writer_says_is_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also of USD, whose writer says where it wrote."""
    extra("pxr.Usd", "usd")
    out = tmp_path / "head.usda"
    assert run("export", "built-in", "-o", out, "--only", "jawOpen", "--json") == 0
    assert json.loads(capsys.readouterr().out)["written"] == str(out)
