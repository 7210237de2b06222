"""``elastomorph register``: what it writes, and what it refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from elastomorph.capturing.scans import registration
from elastomorph.capturing.scans.registered_files import keep_pose, write_figures
from elastomorph.capturing.work.registered import Registered
from elastomorph.io.npz.confidence import read_confidence, write_confidence
from elastomorph.samples import head


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two scans; what registers them is left out, for it has tests of its own."""
    monkeypatch.chdir(tmp_path)
    for name in ("neutral", "smile"):
        em.write(f"{name}.ply", head())

    def found(scans: list[Path], template: str, **options: Any) -> dict[str, Registered]:
        assert template == "built-in"
        asked.append({"scans": [str(scan) for scan in scans], **options})
        figures = {"surface_mean": 0.01, "shown": 0.8, "flagged": 0.5, "correspondence": "by hand"}
        mesh = head()
        poses = {
            scan.stem: Registered.of(mesh, mesh.vertices, np.ones(len(mesh.vertices)), figures)
            for scan in scans
        }
        for name, pose in poses.items():
            keep_pose(options["output"], name, pose)
            options["done"](name, pose)
        write_figures(options["output"], poses)
        return poses

    asked.clear()
    monkeypatch.setattr(registration, "register_all", found)
    return tmp_path


asked: list[dict[str, object]] = []


def test_it_writes_a_mesh_of_each_scan(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("register", "neutral.ply", "smile.ply", "--template", "built-in", "-o", "poses")
    assert run(*words, "--neutral", "smile", "--no-texture", "--landmarks", "marks.json") == 0
    said, log = capsys.readouterr()
    assert "written to poses/" in said
    assert "by hand" in said
    assert "neutral: " in log.splitlines()[0]
    assert log.splitlines()[0].endswith("1 of 2")
    assert log.splitlines()[1].endswith("2 of 2")
    names = {"neutral.obj", "smile.obj", "confidence.npz", "register.json", "report.html"}
    assert {path.name for path in Path("poses").iterdir()} == names
    page = Path("poses/report.html").read_text(encoding="utf-8")
    assert "elastomorph register neutral.ply smile.ply --template built-in" in page
    (options,) = asked
    assert options["scans"] == ["neutral.ply", "smile.ply"]
    assert (options["neutral"], options["texture"]) == ("smile", False)
    assert options["landmarks"] == Path("marks.json")


def test_a_second_run_into_the_folder_keeps_what_the_first_left(folder: Path) -> None:
    for scan in ("neutral.ply", "smile.ply", "smile.ply"):
        assert run("register", scan, "--template", "built-in", "-o", "poses") == 0
    assert set(read_confidence("poses/confidence.npz")) == {"neutral", "smile"}
    measured = json.loads(Path("poses/register.json").read_text())["poses"]
    assert list(measured) == ["neutral", "smile"]
    Path("poses/neutral.obj").unlink()
    assert run("register", "smile.ply", "--template", "built-in", "-o", "poses") == 0
    assert set(read_confidence("poses/confidence.npz")) == {"smile"}


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda: write_confidence("poses/confidence.npz", {"smile": [1.0]}), "1 vertices for"),
        (lambda: Path("poses/confidence.npz").write_bytes(b"PK"), "confidence.npz"),
        (lambda: Path("poses/register.json").write_text("[]"), "register.json"),
    ],
)
def test_a_folder_of_another_template_or_damaged_is_refused_before_any_work(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    damage: Callable[[], object],
    said: str,
) -> None:
    words = ("register", "smile.ply", "--template", "built-in", "-o", "poses")
    assert run(*words) == 0
    damage()
    asked.clear()
    before = {path: path.read_bytes() for path in Path("poses").iterdir()}
    assert run(*words) == 1
    assert said in capsys.readouterr().err
    assert not asked
    assert {path: path.read_bytes() for path in Path("poses").iterdir()} == before


def test_machines_are_told_what_was_measured(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("register", "smile.ply", "--template", "built-in", "-o", "poses", "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert said["poses"]["smile"]["correspondence"] == "by hand"
    assert said["written"] == [
        str(Path("poses") / name)
        for name in ("smile.obj", "confidence.npz", "register.json", "report.html")
    ]


def test_an_output_never_takes_the_place_of_a_scan(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor is anything beside it left behind."""
    em.write("smile.obj", head())
    before = Path("smile.obj").read_bytes()
    whole = registration.register_all

    def reading(scans: list[Path], template: str, **options: object) -> dict[str, Registered]:
        for scan in scans:
            em.read(scan)
        return whole(scans, template, **options)

    monkeypatch.setattr(registration, "register_all", reading)
    assert run("register", "smile.obj", "--template", "built-in", "-o", ".") == 1
    assert "smile.obj" in capsys.readouterr().err
    assert Path("smile.obj").read_bytes() == before
    assert not Path("register.json").exists()
    assert not Path("confidence.npz").exists()


def test_where_poses_cannot_be_written_is_told_before_any_work(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*args: object, **options: object) -> dict[str, Registered]:
        raise AssertionError("scans were registered for nothing")

    monkeypatch.setattr(registration, "register_all", never)
    em.write("smile.obj", head())
    words = ("register", "smile.obj", "--template", "built-in", "-o")
    for output, said in (
        (".", "the pose would be written over the input smile.obj"),
        ("neutral.ply/poses", "neutral.ply is a file; name a folder"),
    ):
        assert run(*words, output) == 1
        assert said in capsys.readouterr().err


def test_a_pose_is_written_over_its_scan_where_that_is_asked_for(folder: Path) -> None:
    em.write("smile.obj", head())
    words = ("register", "smile.obj", "--template", "built-in", "-o", ".", "--overwrite")
    assert run(*words) == 0
    assert Path("register.json").exists()
