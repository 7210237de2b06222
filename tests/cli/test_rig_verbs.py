"""The verbs that work on rigs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from needs import extra
from small_head import expressions, head, shapes

HEAD = "HEAD"  # stands for the file of the fixture below


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of the small head with paths to the five expressions and a shape."""
    file = tmp_path_factory.mktemp("head") / "head.npz"
    targets = {**expressions(), "browDown_L": shapes()["browDown_L"]}
    em.write(file, em.Rig(head(), targets))
    return file


def test_blend_makes_all_combinations(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three levels of five expressions are 242 faces; each is rig.blend of its weights."""
    out = tmp_path / "faces.npz"
    assert run("blend", rig, "--levels", 3, "-t", 0.5, "-o", out, "--json") == 0
    assert json.loads(capsys.readouterr().out)["faces"] == 242
    five = em.read_rig(rig).only(list(expressions()))
    with np.load(out) as archive:
        row = archive["weights"][100]
        face = archive["vertices"][100]
    zeta = dict(zip(five.names, (row / row.sum()).tolist(), strict=True))
    np.testing.assert_allclose(face, five.blend(zeta, 0.5), atol=1e-5)


def test_blend_makes_one_face(rig: Path, tmp_path: Path) -> None:
    out = tmp_path / "face.obj"
    assert run("blend", rig, "-w", "grinning=0.5", "-w", "browDown_L=1", "-o", out) == 0
    neutral = head().vertices
    moved = np.linalg.norm(em.read(out).vertices - neutral, axis=1)
    assert moved.max() > 0.1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["blend", HEAD, "-w", "grinning"], "name=number"),
        (["blend", HEAD, "-w", "grining=1", "-o", "x.obj"], "did you mean 'grinning'"),
        (["blend", HEAD, "-w", "sad=1"], "say where"),
        (["blend", HEAD, "--expressions", "sad,happy", "-o", "x.npy"], "happy"),
        (["blend", HEAD, "--levels", "3", "-o", "x.txt"], "x.txt"),
        (["export", HEAD, "-o", "x.stl"], "x.stl"),
        (["export", HEAD, "-o", "x.fbx"], "only read"),
        (["export", "nowhere.glb", "-o", "x.glb"], "nowhere.glb"),
    ],
)
def test_mistakes(
    arguments: list[str],
    message: str,
    rig: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*(rig if word == HEAD else word for word in arguments)) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert message in said
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_bench_prints_its_table(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("bench", rig, "--levels", 2, "--repeats", 1) == 0
    assert run("bench", rig, "--repeats", 10**9) == 2  # Told before any work
    said = capsys.readouterr().out
    assert "31 faces" in said
    assert "memory copy" in said


def test_what_a_writer_says_is_json(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also of USD, whose writer says where it wrote."""
    extra("pxr.Usd", "usd")
    out = tmp_path / "head.usda"
    assert run("export", rig, "-o", out, "--only", "sad", "--json") == 0
    assert json.loads(capsys.readouterr().out)["written"] == str(out)
