"""The face of a walkthrough: what it is made of, and what it costs to get."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.cli.demo import _tell
from elastomorph.curves import CurveNetwork
from elastomorph.errors import FormatError
from elastomorph.evaluation.target_paths import TargetPath, TargetPaths
from elastomorph.io import write
from elastomorph.io.rig_folder import read_rig
from elastomorph.model.morph import Choice
from elastomorph.paths.auto import Auto
from elastomorph.report.subject import rig_subject
from elastomorph.report.walkthrough import BeamTiming, Walkthrough
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


def test_the_jaw_is_what_opens_it_unless_that_is_empty() -> None:
    """Avatars have shapes of all names of ARKit, some of which move nothing."""
    mesh = ball()
    wide = mesh.with_vertices(mesh.vertices * [1.2, 1, 1])
    hidden = mesh.vertices.copy()
    hidden[:2] *= 0.1  # far, but few
    for name, jaw in (("JawOpen", wide), ("jawOpen", mesh)):
        targets = {"hide": mesh.with_vertices(hidden), name: jaw, "joy": wide}
        rig = em.Rig(mesh, targets, method="linear")
        assert rig_subject("rig.glb", rig).jaw == ("joy" if jaw is mesh else name)
    with pytest.raises(FormatError, match=r"rig\.glb: there are no targets in it"):
        rig_subject("rig.glb", em.Rig(mesh, {}))


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


def test_what_is_told_at_the_console_keeps_the_brackets_of_names(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """They are no markup."""
    mesh, name = ball(), "brow[red]Up"
    rig = em.Rig(mesh, {name: mesh.with_vertices(mesh.vertices * [1, 1.2, 1])}, method="linear")
    path = TargetPath(name, Choice(0.01, 5e-4), 2, 8, 0.0, 0)
    beam, paths = BeamTiming(name, 0.0), TargetPaths(1.0, (path,))
    nothing = CurveNetwork((), len(mesh.vertices))
    found = Walkthrough(rig_subject("rig.glb", rig), nothing, paths, [], {}, None, [], beam, [])
    _tell(found, 1.0, Path("out"))
    said = capsys.readouterr().out
    assert "on 0 curves, 1 target\n" in said
    assert "in-between would pay for brow[red]Up." in said
    assert "Of 1 target, the quadratic beam" in said
