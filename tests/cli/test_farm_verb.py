"""``elastomorph farm``: made, gone on with, verified, estimated, interrupted."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import printed_by
from calls import status_of as run

import elastomorph as em
from needs import extra

extra("zarr", "farm")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a rig of two sliders."""
    monkeypatch.chdir(tmp_path)
    mesh = em.Mesh(np.eye(3), [[0, 1, 2]])
    moved = em.interpolate(mesh, mesh.with_vertices(mesh.vertices * 1.5), "linear")
    em.write(tmp_path / "rig.npz", em.Rig(mesh, {"jawOpen": moved, "smile": moved}))
    points = em.Mesh(np.eye(3), [])
    moved = em.interpolate(points, points.with_vertices(points.vertices * 1.5), "linear")
    em.write(tmp_path / "points.npz", em.Rig(points, {"jawOpen": moved}))
    return tmp_path


def test_a_data_set_is_made_verified_and_estimated(here: Path) -> None:
    words = ["farm", "rig.npz", "--faces", "70", "--unit", "32", "--vertices", "int16"]
    found = json.loads(printed_by(*words, "-o", "faces.zarr", "--json"))
    assert found == {
        "faces": 70,
        "vertices": 3,
        "stored": ["weights", "vertices"],
        "written": "faces.zarr",
    }
    said = printed_by("farm", "--verify", "--sample", "2", "-o", "faces.zarr")
    assert "all checksums of 3 finished units are right" in said
    assert "in 2 of them were made again and are as stored, bit for bit" in said
    estimated = json.loads(printed_by(*words, "--dry-run", "--json"))
    assert estimated["faces"] == estimated["tried"] == 70
    files = [file for file in (here / "faces.zarr").rglob("*") if file.is_file()]
    assert estimated["bytes"] == pytest.approx(sum(f.stat().st_size for f in files), rel=0.1)
    assert estimated["objects"] == len(files)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["farm", "rig.npz", "--faces", "9"], "name where the data set is"),
        (["farm", "--faces", "9", "-o", "f"], "name the rig whose faces are made"),
        (["farm", "rig.npz", "-o", "f"], "say how many faces"),
        (["farm", "rig.npz", "--faces", "0", "-o", "f"], "one face or more"),
        (["farm", "points.npz", "--faces", "9", "-o", "f", "--normals"], "have no normals"),
        (["farm", "rig.npz", "-o", "f", "--verify"], "--verify makes nothing, so the name of a"),
        (["farm", "-o", "f", "--verify", "--unit", "64"], "so --unit has no meaning beside it"),
        (["farm", "-o", "f", "--verify", "--sheet", "s.png"], "so --sheet has no meaning"),
        (["farm", "-o", "f", "--sheet", "s.png", "--dry-run"], "for --dry-run, name a rig too"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--sample", "9"], "add --verify"),
        (["farm", "rig.npz", "--faces", "9", "--dry-run", "--prices", "1,2"], "is gone: --dry-run"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--dashboard=:1"], "gone: start Dask your"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--scheduler", "q.toml"], "dask-jobqueue"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--tolerance", "1e-3"], "name their type"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--render", "5"], "16 to 4096 pixels"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--codec", "zip"], "compressed by lz4"),
        (["farm", "--verify", "-o", "f"], "there is no data set"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--sheet", "s.bmp"], "as .png"),
        (["farm", "rig.npz", "--faces", "9" * 18, "-o", "f"], "67,108,864 units: ask for fewer"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--recipe", "no.toml"], "no such file"),
        (["farm", "rig.npz", "--faces", "9", "-o", "f", "--landmarks", "rig.npz"], "not JSON"),
    ],
)
def test_what_cannot_be_meant_is_one_sentence(
    here: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*words) == 1
    printed = capsys.readouterr().err
    assert printed.startswith("error: ")
    assert said in printed
    assert printed.count("\n") == 1
    assert not (here / "f").exists()


def test_an_interrupt_is_one_sentence_that_says_how_far_it_is(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("elastomorph.farm.making.executors.make_unit", interrupted)
        assert run("farm", "rig.npz", "--faces", "9", "-o", "f") == 130
    assert capsys.readouterr().err == "interrupted after 0 of 9 faces; the same command goes on\n"
    assert run("farm", "rig.npz", "--faces", "9", "-o", "f") == 0
