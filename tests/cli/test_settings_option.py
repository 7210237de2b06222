"""Verbs take settings, the command line overrides them, outputs say what they were made with."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from elastomorph.io.performance import write_performance_csv
from elastomorph.io.registry import settings_used
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig.performance import Performance
from needs import extra
from small_meshes import grid

SIDE = 5
SETTINGS = """\
[character]
name = "Ada"
unit = "mm"
neutral = "rest.ply"
targets = "shapes/*.ply"
[method]
default = "beam:3"
material = { damping = 0.5 }
[methods]
jawOpen = "rotation"
[timing]
default = "cosine"
[export.glb]
normals = "none"
"""


def sheet() -> em.Mesh:
    return grid(SIDE, SIDE, lambda x, y: 0.1 * x * y)


def turned(angle: float) -> em.Mesh:
    x, y, z = sheet().vertices.T
    high, wide = y * np.sin(angle) + z, y * np.cos(angle) - z * np.sin(angle)
    return sheet().with_vertices(np.stack([x, wide, high], axis=1))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A character with settings, and the folder as the working folder."""
    face = tmp_path / "face"
    (face / "shapes").mkdir(parents=True)
    em.write(face / "rest.ply", sheet())
    em.write(face / "shapes" / "jawOpen.ply", turned(1.0))
    em.write(face / "shapes" / "smile.ply", sheet().with_vertices(sheet().vertices ** 1.2))
    (face / "elastomorph.toml").write_text(SETTINGS)
    monkeypatch.chdir(tmp_path)
    return face


def methods_of(path: Path | str) -> dict[str, str]:
    return {name: morph.method for name, morph in em.read_rig(path).morphs.items()}


def used(path: Path | str) -> dict[str, Any]:
    found = settings_used(path)
    assert found is not None
    return found


BOTH = {"jawOpen": "rotation", "smile": "beam R=3 m=1 c=0.5 k=1"}


@pytest.mark.parametrize(
    "words", [["face"], ["face", "--settings", "face/elastomorph.toml"], ["face/elastomorph.toml"]]
)
def test_a_folder_a_file_or_an_option_says_the_same(folder: Path, words: list[str]) -> None:
    assert run("export", *words, "-o", "out.glb") == 0
    assert methods_of("out.glb") == BOTH
    tables = used("out.glb")
    assert tables["character"]["name"] == "Ada"
    assert tables["made_with"] == {
        "elastomorph": tables["made_with"]["elastomorph"],
        "settings": "elastomorph.toml",
    }
    assert str(folder) not in json.dumps(tables)


def test_options_override_and_outputs_say_so(folder: Path) -> None:
    words = ["--method", "ease:2", "--timing", "linear", "--normals", "delta", "--only", "smile"]
    assert run("export", "face", *words, "-o", "out.glb") == 0
    assert methods_of("out.glb") == {"smile": "ease R=2"}
    tables = used("out.glb")
    assert tables["method"]["default"] == "ease:2"
    assert tables["timing"] == {"default": "linear"}
    assert tables["export"]["glb"] == {"normals": "delta"}
    assert tables["made_with"]["command_line"] == ["method", "normals", "timing", "only"]
    assert clips_of("out.glb") == ["smile"]  # a timing is one of clips


def clips_of(path: str) -> list[str]:
    from elastomorph.io.gltf.container import open_gltf

    return [clip["name"] for clip in open_gltf(path).items("animations")]


def test_clips_are_written_where_they_are_asked_for(folder: Path) -> None:
    assert run("export", "face", "--only", "smile", "-o", "plain.glb") == 0
    assert run("export", "face", "--only", "smile", "--clips", "-o", "moving.glb") == 0
    assert (clips_of("plain.glb"), clips_of("moving.glb")) == ([], ["smile"])


def test_what_settings_say_of_a_format_reaches_it(folder: Path) -> None:
    """The keys of one format do not disturb another."""
    assert run("export", "face", "-o", "small.glb") == 0
    assert run("export", "face", "--normals", "delta", "-o", "large.glb") == 0
    assert Path("small.glb").stat().st_size < Path("large.glb").stat().st_size
    assert run("export", "face", "-o", "out.npz") == 0
    assert used("out.npz") == used("small.glb")
    usd = extra("pxr.Usd", "usd")
    assert run("export", "face", "--tolerance", "1e-5", "-o", "out.usda") == 0
    assert used("out.usda")["export"]["usd"] == {"tolerance": 1e-5}
    stage = usd.Stage.Open("out.usda")
    assert stage.GetMetadata("metersPerUnit") == 0.001


def test_settings_for_another_rig(folder: Path) -> None:
    """A rig file and a folder without settings, with those of the character."""
    em.write(
        "jaw.npz", em.Rig(sheet(), {"jawOpen": em.interpolate(sheet(), turned(0.5), "linear")})
    )
    assert run("export", "jaw.npz", "--settings", "face", "-o", "out.npz") == 0
    assert methods_of("out.npz") == {"jawOpen": "rotation"}
    assert used("out.npz")["character"]["rig"] == "jaw.npz"
    assert used("out.npz")["made_with"]["command_line"] == ["rig"]


def test_without_settings_nothing_is_kept(folder: Path) -> None:
    """A folder without settings is read as it always was."""
    (folder / "elastomorph.toml").unlink()
    (folder / "rest.ply").rename(folder / "shapes" / "neutral.ply")
    assert run("export", "face/shapes", "-o", "out.npz") == 0
    assert settings_used("out.npz") is None
    assert all(morph.choice for morph in em.read_rig("out.npz").morphs.values())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["export", "face", "-o", "out.npz", "--normals", "none"], "--normals is for .glb"),
        (["export", "face", "-o", "out.usda", "--timing", "cosine"], "--timing is for .glb"),
        (["export", "face", "-o", "out.glb", "--settings", "no.toml"], "no.toml"),
        (["export", "face", "-o", "out.glb", "--settings", "."], "has no elastomorph.toml"),
        (["export", "built-in", "-o", "out.glb", "--settings", "face"], "has no settings"),
        (
            ["export", "face/elastomorph.toml", "-o", "out.glb", "--settings", "face"],
            "settings of its own",
        ),
    ],
)
@pytest.mark.usefixtures("folder")
def test_mistakes(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert run(*words) == 1
    assert message in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["face"]


def test_a_mistake_in_the_settings_is_one_sentence(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "elastomorph.toml").write_text("[method]\ndefalt = 'arc'\n")
    assert run("export", "face", "-o", "out.glb") == 1
    said = capsys.readouterr().err
    assert "elastomorph.toml, line 2: unknown key 'defalt' in [method]" in said
    assert "did you mean 'default'?" in said


def test_one_face_and_many_of_a_character(folder: Path) -> None:
    """`blend` takes the rig from the option alone."""
    assert run("blend", "--settings", "face", "-w", "jawOpen=1", "-t", 0.5, "-o", "face.npz") == 0
    expected = em.interpolate(sheet(), em.read("face/shapes/jawOpen.ply"), "rotation").at(0.5)
    np.testing.assert_allclose(em.read("face.npz").vertices, expected, atol=1e-13)
    assert run("blend", "face", "--levels", 2, "-t", 0.5, "-o", "faces.npy") == 0
    assert np.load("faces.npy").shape == (3, SIDE * SIDE, 3)
    assert run("bench", "--settings", "face", "--levels", 2, "--repeats", 1, "--json") == 0


def test_a_performance_on_a_character(folder: Path) -> None:
    take = Performance(("jawOpen",), np.arange(4) / 30, np.eye(4)[:, :1], 30.0)
    write_performance_csv("take.csv", take)
    assert run("animate", "face", "take.csv", "-o", "take.glb") == 0
    assert methods_of("take.glb") == BOTH
    assert used("take.glb")["character"]["name"] == "Ada"
    assert run("animate", "face", "take.csv", "--method", "linear", "-o", "take.npz") == 0
    with np.load("take.npz") as archive:
        assert archive["frames"].shape == (4, SIDE * SIDE, 3)


def test_the_path_to_one_target(folder: Path) -> None:
    """`interpolate` knows a target by the name of its file; options override here too."""
    words = ["interpolate", "face/rest.ply", "face/shapes/jawOpen.ply"]
    assert run(*words, "--settings", "face", "-t", 0.3, "-o", "way.npz") == 0
    jaw = em.read("face/shapes/jawOpen.ply")
    at = em.timing.cosine.at(0.3)
    expected = em.interpolate(sheet(), jaw, "rotation").at(at)
    np.testing.assert_allclose(em.read("way.npz").vertices, expected, atol=1e-12)
    options = ["--method", "beam:3", "--damping", 0.25, "--timing", "linear"]
    assert run(*words, "--settings", "face", *options, "-t", 0.3, "-o", "way.npz") == 0
    beam = em.interpolate(sheet(), jaw, "beam:3", material=em.Material(damping=0.25))
    np.testing.assert_allclose(em.read("way.npz").vertices, beam.at(0.3), atol=1e-12)
    assert run(*words, "--settings", "face", "--region", "0-9", "-t", 0.3, "-o", "part.npz") == 0
    part = em.interpolate(sheet(), jaw, "rotation", region=range(10))
    np.testing.assert_allclose(em.read("part.npz").vertices, part.at(at), atol=1e-12)


def test_an_evaluation_says_what_it_was_made_with(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = [turned(angle).vertices for angle in (0.0, 0.3, 0.7, 1.0)]
    em.write_sequence("scan.npz", MeshSequence(sheet(), np.array(frames)))
    (folder / "curves.json").write_text(json.dumps([list(range(SIDE))]))
    (folder / "elastomorph.toml").write_text(
        SETTINGS.replace('name = "Ada"', 'name = "Ada"\ncurves = "curves.json"')
    )
    words = ["evaluate", "scan.npz", "--method", "beam:3", "--no-pictures"]
    assert run(*words, "--settings", "face", "-o", "made", "--json") == 0
    page = json.loads(capsys.readouterr().out)
    assert page["settings"]["character"]["name"] == "Ada"
    assert used("made/evaluation.json") == page["settings"]
    assert [method["label"] for method in page["methods"]] == ["beam R=3 m=1 c=0.5 k=1"]
    assert page["curves"][0]["vertices"] == SIDE
    assert run(*words, "-o", "plain", "--json") == 0
    plain = json.loads(capsys.readouterr().out)
    assert "settings" not in plain
    assert set(page) - set(plain) == {"settings"}
    assert run(*words, "--settings", "face", "--damping", 2, "--json") == 0
    page = json.loads(capsys.readouterr().out)
    assert page["settings"]["made_with"]["command_line"] == ["damping"]
    assert [method["label"] for method in page["methods"]] == ["beam R=3 m=1 c=2 k=1"]


def test_inspect_tells_how_a_file_was_made(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("out.glb", "out.npz"):
        assert run("export", "face", "-o", name) == 0
        capsys.readouterr()
        assert run("inspect", name) == 0
        said = capsys.readouterr().out
        assert "character.name  Ada" in said
        assert "methods.jawOpen.method  rotation" in said
        assert "jawOpen  (rotation)" in said
        assert run("inspect", name, "--json") == 0
        page = json.loads(capsys.readouterr().out)
        assert page["settings"] == used(name)
        assert page["vertices"] == SIDE * SIDE
        assert page["targets"]["smile"]["method"] == BOTH["smile"]
    em.write("plain.npz", em.read_rig("out.npz"))
    assert run("inspect", "plain.npz", "--json") == 0
    assert "settings" not in json.loads(capsys.readouterr().out)
    assert run("inspect", "face/rest.ply", "--json") == 0
    assert json.loads(capsys.readouterr().out)["targets"] == {}


def test_curves_of_settings(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Verbs that only need curves take those of the character."""
    drawn = [list(range(SIDE)), [SIDE + 1, SIDE]]
    (folder / "curves.json").write_text(json.dumps(drawn))
    (folder / "elastomorph.toml").write_text('[character]\ncurves = "curves.json"')
    assert run("curves", "face/rest.ply", "--settings", "face", "-o", "all.json") == 0
    written = [curve["vertices"] for curve in json.loads(Path("all.json").read_text())["curves"]]
    for curve in drawn:
        assert curve in written
    frames = np.stack([turned(angle).vertices for angle in (0.0, 0.3, 0.7, 1.0)])
    em.write_sequence("scan.npz", MeshSequence(sheet(), frames))
    assert run("inbetweens", "suggest", "scan.npz", "-n", 1, "--settings", "face", "--json") == 0


@pytest.mark.usefixtures("folder")
def test_pictures_and_pages_of_a_character() -> None:
    extra("vtkmodules", "demo")
    assert run("render", "face", "-p", "jawOpen=1", "--size", "64x64", "-o", "a.png") == 0
    assert (
        run("render", "face/elastomorph.toml", "-p", "smile=1", "--size", "64x64", "-o", "b.png")
        == 0
    )
    assert run("view", "face", "-o", "face.html") == 0


def test_a_character_is_examined_as_its_files(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`doctor` takes settings for the neutral and the targets they name."""
    assert run("doctor", "face/elastomorph.toml", "--json", "--fail-on", "error") in (0, 1)
    page = capsys.readouterr().out
    for name in ("rest", "jawOpen", "smile"):
        assert name in page
