"""The face of a walkthrough: what it is made of, and what it costs to get."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io import write
from elastomorph.io.rig_folder import read_rig
from elastomorph.paths.auto import Auto
from elastomorph.report.subject import rig_subject
from scenes import ball


def test_a_rig_is_read_without_looking_for_its_paths(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The walkthrough looks for them itself: twice would be half of its time."""
    mesh = ball()
    moved = mesh.with_vertices(mesh.vertices * [1.0, 1.2, 1.0])
    write(tmp_path / "neutral.obj", mesh)
    write(tmp_path / "jawOpen.obj", moved)

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("no path is wanted here")

    monkeypatch.setattr(Auto, "prepare", refused)
    subject = rig_subject(tmp_path, read_rig(tmp_path, method="linear"))
    assert subject.jaw == "jawOpen"
    assert list(subject.targets) == ["jawOpen"]
    np.testing.assert_allclose(subject.targets["jawOpen"].vertices, moved.vertices, atol=1e-6)


@pytest.mark.parametrize(
    ("place", "command"),
    [
        ("my rig", "elastomorph export 'my rig' -o bent.glb"),
        ("rig.fbx", "elastomorph export rig.fbx -o bent.glb"),
        ("a/face.VRM", "elastomorph bend a/face.VRM -o face.bent.vrm"),
        ("face.usda", "elastomorph bend face.usda -o face.bent.usda"),
    ],
)
def test_the_command_keeps_what_a_file_holds_beside_the_face(place: str, command: str) -> None:
    mesh = ball()
    rig = em.Rig(mesh, {"grow": mesh.with_vertices(mesh.vertices * 1.1)}, method="linear")
    assert rig_subject(place, rig).command == command
