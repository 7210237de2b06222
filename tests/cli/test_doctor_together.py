"""``elastomorph doctor --together``: sliders that meet, for people and for machines."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

from elastomorph.io import write
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    """A sheet in which one vertex passes its neighbour where two sliders meet."""
    y, x = np.divmod(np.arange(121), 11)
    points = np.stack([x, y, 0 * x], axis=1).astype(float)
    faces = [[i, i + 1, i + 12, i + 11] for i in range(110) if i % 11 < 10]
    there = points.copy()
    there[60, 0] += 0.7
    neutral = Mesh(points, faces)
    named = {name: neutral.with_vertices(there) for name in ("jawOpen", "jawForward")}
    write(tmp_path / "rig.glb", Rig(neutral, named, method="linear"))
    return tmp_path / "rig.glb"


def test_sliders_that_meet_are_listed(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("doctor", rig, "--together")
    text = capsys.readouterr().out
    assert "sliders that meet, by the damage that is seen, the worst first" in text
    assert "jawOpen + jawForward  at 1, 1: 2 triangles fold" in text


def test_a_take_and_json(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    take = rig.with_name("take.csv")
    take.write_text(
        "Timecode,BlendShapeCount,JawOpen,JawForward\n"
        "00:00:00:00.000,2,1,1\n00:00:00:01.000,2,1,0\n"
    )
    run("doctor", rig, "--together", "--take", take, "--json")
    (meeting,) = json.loads(capsys.readouterr().out)["meetings"]
    assert meeting["sliders"] == ["jawOpen", "jawForward"]
    assert (meeting["frames"], meeting["per_frame"]) == (1, 1.0)


def test_the_worst_are_drawn(rig: Path) -> None:
    pytest.importorskip("vtkmodules")
    run("doctor", rig, "--together", "--sheet", rig.with_name("worst.png"))
    assert rig.with_name("worst.png").stat().st_size > 0


def test_without_it_nothing_is_ranked(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("doctor", rig, "--json")
    assert json.loads(capsys.readouterr().out)["meetings"] is None
    assert run("doctor", rig, "--take", rig) == 2
    assert "--take and --sheet are for --together: add it" in capsys.readouterr().err
