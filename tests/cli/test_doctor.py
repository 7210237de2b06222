"""``elastomorph doctor`` as a rigger and as a script call it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

from elastomorph.io import read, write
from elastomorph.model.mesh import Mesh
from elastomorph.paths import prepare
from elastomorph.rig import Rig
from small_head import head, shapes


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    """A sound rig in a folder."""
    place = tmp_path / "rig"
    place.mkdir()
    write(place / "neutral.obj", head())
    for name in ("mouthSmile_L", "mouthSmile_R"):
        write(place / f"{name}.obj", shapes()[name])
    return place


def reordered(file: Path) -> None:
    """Number the vertices of a file backwards."""
    mesh = read(file)
    last = len(mesh.vertices) - 1
    write(file, Mesh(mesh.vertices[::-1], [(last - face).tolist() for face in mesh.faces]))


def test_a_sound_rig_exits_with_0(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("doctor", rig, "--fail-on", "warning") == 0
    assert "nothing found" in capsys.readouterr().out


def test_files_can_be_named_one_by_one(rig: Path) -> None:
    assert run("doctor", rig / "neutral.obj", rig / "mouthSmile_L.obj") == 0
    assert run("doctor", rig / "neutral.obj") == 0


def test_rigs_are_examined_like_files(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The built-in head, a rig file, and settings; nothing of a sound rig is written."""
    to = prepare(head(), "linear")
    smile = shapes()["mouthSmile_L"]
    write(tmp_path / "head.glb", Rig(head(), {"smile": to(smile), "nothing": to(head())}))
    assert run("doctor", "built-in") == 0
    assert "built-in and " in capsys.readouterr().out
    assert run("doctor", tmp_path / "head.glb", "--fail-on", "warning") == 1
    assert "[does-nothing]\n  nothing  it is the neutral" in capsys.readouterr().out
    assert run("doctor", tmp_path / "head.glb", "--repair", tmp_path / "fixed") == 2
    assert "nothing to repair" in capsys.readouterr().err
    assert not (tmp_path / "fixed").exists()
    (rig / "elastomorph.toml").write_text('[character]\nname = "hero"\n')
    assert run("doctor", rig / "elastomorph.toml", "--fail-on", "warning") == 0
    assert run("doctor", rig / "neutral.obj", tmp_path / "head.glb") == 2


@pytest.mark.parametrize("kind", ["files", "rig", "folder"])
def test_settings_say_what_is_examined(
    rig: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Named, or in the folder: a character of mesh files, or of a rig file."""
    names = {"mouthSmile_L": shapes()["mouthSmile_L"], "nothing": head()}
    if kind == "rig":
        to = prepare(head(), "linear")
        write(rig / "head.npz", Rig(head(), {name: to(mesh) for name, mesh in names.items()}))
        (rig / "hero.toml").write_text('[character]\nrig = "head.npz"\n')
    else:
        for name, mesh in names.items():
            write(rig / f"{name}.ply", mesh)
        chosen = '[character]\nneutral = "neutral.obj"\ntargets = ["*.ply"]\n'
        (rig / ("hero.toml" if kind == "files" else "elastomorph.toml")).write_text(chosen)
    assert run("doctor", rig if kind == "folder" else rig / "hero.toml", "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert [Path(target).stem for target in document["targets"]] == list(names)
    found = {(each["name"], Path(each["file"]).stem) for each in document["findings"]}
    assert ("does-nothing", "nothing") in found


def test_findings_at_the_severity_asked_for_exit_with_1(rig: Path) -> None:
    write(rig / "nothing.obj", head())
    assert run("doctor", rig) == 0
    assert run("doctor", rig, "--fail-on", "warning") == 1
    reordered(rig / "mouthSmile_L.obj")
    assert run("doctor", rig) == 1


def test_a_repaired_folder_is_sound(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    reordered(rig / "mouthSmile_L.obj")
    assert run("doctor", rig, "--repair", tmp_path / "fixed") == 1
    text = capsys.readouterr().out
    assert "[vertex-order]" in text
    assert "1 file repaired and read back, 2 copied" in text
    assert run("doctor", tmp_path / "fixed", "--fail-on", "warning") == 0
    np.testing.assert_array_equal(
        read(tmp_path / "fixed" / "mouthSmile_L.obj").vertices, shapes()["mouthSmile_L"].vertices
    )


def test_json_is_one_document(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    reordered(rig / "mouthSmile_R.obj")
    assert run("doctor", rig, "--json", "--repair", tmp_path / "fixed") == 1
    document = json.loads(capsys.readouterr().out)
    assert document["counts"] == {"error": 1, "warning": 0, "note": 0}
    (found,) = document["findings"]
    assert (found["name"], Path(found["file"]).name) == ("vertex-order", "mouthSmile_R.obj")
    assert document["facts"]["vertices"] == len(head().vertices)
    assert len(document["repair"]["repaired"]) == 1


def test_motion_of_the_head_is_taken_out(rig: Path, tmp_path: Path) -> None:
    smile = shapes()["mouthSmile_L"]
    write(rig / "mouthSmile_L.obj", smile.with_vertices(smile.vertices + [0.0, 1.0, 0.0]))
    still = np.flatnonzero((smile.vertices == head().vertices).all(axis=1))
    (tmp_path / "skull.json").write_text(json.dumps(still.tolist()))
    for place, vertices in (("a", "auto"), ("b", tmp_path / "skull.json")):
        assert run("doctor", rig, "--align", vertices, "--repair", tmp_path / place) == 0
        back = read(tmp_path / place / "mouthSmile_L.obj").vertices
        np.testing.assert_allclose(back, smile.vertices, atol=1e-5)


def test_pairs_seeds_and_names_of_sides_are_understood(rig: Path) -> None:
    last = len(head().vertices) - 1
    reordered(rig / "mouthSmile_L.obj")
    assert run("doctor", rig, "--seeds", f"0={last},5={last - 5}", "--pairs", "_L=_R") == 1
    assert run("doctor", rig, "--seeds", "0=12") == 1


def test_a_material_at_resonance_is_an_error(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("doctor", rig, "--damping", 8 * np.pi**4, "--order", 2) == 1
    assert "[resonant-material]" in capsys.readouterr().out


def test_the_threshold_of_in_betweens_can_be_chosen(
    rig: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(rig / "jawOpen.obj", shapes()["jawOpen"])
    assert run("doctor", rig) == 0
    assert "[in-between-pays]" in capsys.readouterr().out
    assert run("doctor", rig, "--bend", 5) == 0
    assert "[in-between-pays]" not in capsys.readouterr().out


def test_an_unreadable_file_exits_with_2(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """And the other files are examined."""
    (rig / "mouthSmile_R.obj").write_text("v 0 0 nan\nf 1 1 1\n")
    reordered(rig / "mouthSmile_L.obj")
    assert run("doctor", rig) == 2
    text = capsys.readouterr().out
    assert "[unreadable]" in text
    assert "line 1" in text
    assert "[vertex-order]" in text


@pytest.mark.parametrize(
    "words",
    [
        ["--fail-on", "note"],
        ["--align", "auto"],
        ["--seeds", "1"],
        ["--seeds", "999999=0"],
        ["--pairs", "_L"],
        ["--damping", "-1"],
        ["--damping", "1", "--closure", "tight"],
        ["--nonsense"],
    ],
)
def test_options_that_cannot_be_understood_exit_with_2(
    rig: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("doctor", rig, *words) == 2
    assert "rror" in capsys.readouterr().err


def test_a_folder_without_a_neutral_exits_with_2(tmp_path: Path) -> None:
    assert run("doctor", tmp_path) == 2
    assert run("doctor", tmp_path / "missing.obj") == 2
