"""The tab key: what it offers, that it is quick about it, and that it never complains."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_files import write_all
from typer.testing import CliRunner

from effort import worked
from elastomorph import samples
from elastomorph.cli import app
from elastomorph.paths import Method

SLIDERS = {"jawOpen", "smile"}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("files")
    write_all(folder)
    (folder / "broken.glb").write_bytes(b"glTF\x02\x00")
    (folder / "broken.toml").write_text("[")
    return folder


def offered(files: Path, monkeypatch: pytest.MonkeyPatch, *words: str) -> set[str]:
    """What bash is told for a line that ends in the last word."""
    monkeypatch.chdir(files)
    line = ["elastomorph", *words]
    result = CliRunner().invoke(
        app,
        [],
        prog_name="elastomorph",
        env={
            "_ELASTOMORPH_COMPLETE": "complete_bash",
            "COMP_WORDS": " ".join(line),
            "COMP_CWORD": str(len(line) - 1),
        },
    )
    assert not result.stderr
    return set(result.stdout.split())


@pytest.mark.parametrize("verb", ["export", "animate", "view", "blend", "bench", "interpolate"])
def test_methods(files: Path, monkeypatch: pytest.MonkeyPatch, verb: str) -> None:
    assert {kind.name for kind in Method.known} <= offered(
        files, monkeypatch, verb, "face", "--method", ""
    )
    assert offered(files, monkeypatch, verb, "face", "--method", "be") == {
        "beam",
        "beam:2",
        "beam:3",
    }


def test_views(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert offered(files, monkeypatch, "render", "face", "--view", "th") == {"three-quarter"}


def test_what_a_capture_stops_after_and_how_its_cameras_stand(
    files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert offered(files, monkeypatch, "capture", "photos", "--to", "") == {
        "cameras",
        "neutral",
        "poses",
    }
    assert offered(files, monkeypatch, "capture", "photos", "--rig", "f") == {"fixed"}


@pytest.mark.parametrize(
    "rig",
    ["face", "character", "character/elastomorph.toml", "ours.glb", "foreign.vrm", "ours.npz"],
)
def test_sliders_of_the_rig(files: Path, monkeypatch: pytest.MonkeyPatch, rig: str) -> None:
    assert offered(files, monkeypatch, "export", rig, "--only", "") == SLIDERS
    assert offered(files, monkeypatch, "export", rig, "--only", "smile,") == {"smile,jawOpen"}
    assert offered(files, monkeypatch, "render", rig, "--pose", "") == {"jawOpen=", "smile="}
    smiles = {f"smile={weight}" for weight in ("0.25", "0.5", "0.75", "1")}
    assert offered(files, monkeypatch, "blend", rig, "-w", "s") == smiles
    assert offered(files, monkeypatch, "blend", rig, "-w", "smile=0.7") == {"smile=0.75"}
    assert offered(files, monkeypatch, "blend", rig, "--expressions", "j") == {"jawOpen"}


def test_poses_of_a_file(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (files / "p.json").write_text('{"Smile": {}, "Sad": {}, "Open": {}}')
    (files / "p.csv").write_text("pose,x\nSmile,1\n")
    found = offered(files, monkeypatch, "render", "face", "--pose", "p.json#S")
    assert found == {"p.json#Smile", "p.json#Sad"}
    assert offered(files, monkeypatch, "render", "face", "-p", "p.csv#") == {"p.csv#Smile"}
    assert not offered(files, monkeypatch, "render", "face", "-p", "nowhere.csv#")
    assert offered(files, monkeypatch, "render", "face", "-p", "p.") == {"p.json", "p.csv"}
    both = {"p.csv", "p.csv#Smile"}
    assert offered(files, monkeypatch, "render", "face", "-p", "p.c") == both


def test_sliders_of_the_built_in_head_come_at_once(
    files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    offered(files, monkeypatch, "blend", "--expressions", "")  # imports
    before = worked()
    names = offered(files, monkeypatch, "blend", "--expressions", "")
    assert worked() - before < 0.5
    assert "jawOpen" in names
    assert names == {*samples.shapes(), *samples.expressions()}


@pytest.mark.parametrize("rig", ["nowhere.glb", "nowhere", "broken.glb", "broken.toml", "take.csv"])
def test_what_cannot_be_read_has_no_sliders(
    files: Path, monkeypatch: pytest.MonkeyPatch, rig: str
) -> None:
    assert not offered(files, monkeypatch, "export", rig, "--only", "")
