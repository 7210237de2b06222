"""What `init` finds in a folder, and the settings file that it writes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from characters import shapes, sheet
from elastomorph.character import read_settings, rig_from_settings
from elastomorph.character.template import (
    arkit_names,
    correctives,
    missing_arkit,
    settings_text,
    slider_groups,
    survey,
    turning,
    write_settings,
)
from elastomorph.errors import FileError
from elastomorph.io.performance import write_performance_csv
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig.performance import Performance
from small_meshes import meeting


def switched_on(text: str) -> str:
    """The file with every suggestion in it used."""
    return re.sub(r"^#(?! )", "", text, flags=re.MULTILINE)


def motion() -> MeshSequence:
    frames = sheet().vertices + np.linspace(0, 1, 4)[:, None, None]
    return MeshSequence(sheet(), frames)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """All that a folder of a character may hold."""
    place = tmp_path / "Ada Lovelace"
    place.mkdir()
    em.write(place / "Ada_neutral.obj", sheet())
    targets = shapes()
    for name in ("jawOpen", "mouthFunnel", "mouthClose", "eyeBlink_L", "eyeBlink_R"):
        em.write(place / f"{name}.obj", targets["jawOpen"])
    em.write(place / "jawOpen_30.obj", targets["smile"])
    em.write(place / "jawOpen_mouthFunnel.obj", targets["brow"])
    em.write(place / "dimple [left].ply", targets["brow"])
    em.write_sequence(place / "scan.####.obj", motion())
    em.write_sequence(place / "motion.npz", motion())
    em.write(
        place / "old.npz", em.Rig(sheet(), {"smile": em.interpolate(sheet(), targets["smile"])})
    )
    (place / "curves.json").write_text(json.dumps([[0, 7, 14], [1, 8, 15]]))
    (place / "mouth.json").write_text(json.dumps(list(range(20))))
    (place / "other.json").write_text('{"colour": "red"}')
    (place / "far.json").write_text("[900]")
    take = Performance(("jawOpen",), np.arange(3) / 30, np.eye(3)[:, :1], 30.0)
    write_performance_csv(place / "take.csv", take)
    (place / "shots.csv").write_text("name,length\nfirst,3\n")
    return place


TARGETS = (
    "dimple [left]",
    "eyeBlink_L",
    "eyeBlink_R",
    "jawOpen",
    "jawOpen_30",
    "jawOpen_mouthFunnel",
    "mouthClose",
    "mouthFunnel",
)


def test_files_are_told_apart_by_name_and_content(folder: Path) -> None:
    found = survey(folder)
    assert found.neutral == folder / "Ada_neutral.obj"
    assert found.shapes == tuple(found.targets) == TARGETS
    assert found.vertices == len(sheet().vertices)
    assert found.sequences == {"motion.npz": 4, "scan.####.obj": 4}
    assert found.inbetweens == {"jawOpen": {0.3: folder / "jawOpen_30.obj"}}
    assert [file.name for file in found.curves] == ["curves.json"]
    assert [file.name for file in found.regions] == ["mouth.json"]
    assert [file.name for file in found.takes] == ["take.csv"]
    assert [file.name for file in found.other_rigs] == ["old.npz"]
    assert found.rig is None


def test_the_file_reads_back_and_means_what_was_found(folder: Path) -> None:
    path, _ = write_settings(folder)
    settings = read_settings(folder)
    assert settings.path == path
    assert settings.character.name == "Ada Lovelace"
    assert settings.character.curves == "curves.json"
    rig = rig_from_settings(settings, cache=None)
    assert tuple(rig.morphs) == TARGETS
    assert {morph.choice is not None for morph in rig.morphs.values()} == {True}
    assert not rig.sliders.correctives


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
def test_every_suggestion_is_valid(folder: Path) -> None:
    """One by one, and all of them together."""
    text = settings_text(survey(folder))
    (folder / "elastomorph.toml").write_text(switched_on(text))
    settings = read_settings(folder)
    assert settings.choice_for("eyeBlink_L").name == "rotation"
    assert settings.character.unit == "cm"
    rig = rig_from_settings(settings, cache=None)
    assert rig.morphs["jawOpen"].method.startswith("through 0.3")
    assert "jawOpen_30" not in rig.morphs
    assert rig.sliders.correctives == {
        "jawOpen_mouthFunnel": em.Corrective(("jawOpen", "mouthFunnel"))
    }
    assert rig.sliders.groups["eye"] == ("eyeBlink_L", "eyeBlink_R")
    lines = text.split("\n")
    for number, line in enumerate(lines):
        if re.match(r"#(?! )", line) and not line.startswith(("#[", "#vertices", "#falloff")):
            table = next(own for own in reversed(lines[:number]) if re.match(r"#?\[", own))
            if not table.startswith("#"):
                one = [*lines[:number], line[1:], *lines[number + 1 :]]
                (folder / "elastomorph.toml").write_text("\n".join(one))
                read_settings(folder)


def test_prose_says_what_was_found(folder: Path) -> None:
    prose = " ".join(
        line[2:] for line in settings_text(survey(folder)).split("\n") if line[:2] == "# "
    )
    for words in (
        "8 targets of 49 vertices",
        "5 have names of ARKit's 52 shapes",
        "scan.####.obj, 4 frames",
        "motion.npz, 4 frames",
        "A performance: take.csv",
        "Another rig, not used: old.npz",
        "tongueOut",
    ):
        assert words in prose


def test_a_pattern_is_written_where_it_says_the_same(tmp_path: Path) -> None:
    em.write(tmp_path / "neutral.obj", sheet())
    for name, mesh in shapes().items():
        em.write(tmp_path / f"{name}.obj", mesh)
    write_settings(tmp_path)
    assert read_settings(tmp_path).character.targets == ("*.obj",)
    em.write(tmp_path / "more.ply", sheet())
    write_settings(tmp_path, force=True)
    assert read_settings(tmp_path).character.targets == ("*.obj", "*.ply")


def test_targets_may_lie_in_folders_of_their_own(tmp_path: Path) -> None:
    em.write(tmp_path / "neutral.obj", sheet())
    for folder, (name, mesh) in zip(("a", "b", "b"), shapes().items(), strict=True):
        (tmp_path / folder).mkdir(exist_ok=True)
        em.write(tmp_path / folder / f"{name}.obj", mesh)
    write_settings(tmp_path)
    assert read_settings(tmp_path).character.targets == ("a/*.obj", "b/*.obj")
    assert rig_from_settings(read_settings(tmp_path), cache=None).names == (
        "brow",
        "jawOpen",
        "smile",
    )


def test_a_rig_file_alone_is_the_character(tmp_path: Path) -> None:
    """Its own paths stay, for the default method is only suggested."""
    path = em.interpolate(sheet(), shapes()["smile"], "ease:3")
    em.write(tmp_path / "head.npz", em.Rig(sheet(), {"smile": path}))
    write_settings(tmp_path)
    settings = read_settings(tmp_path)
    assert settings.character.rig == "head.npz"
    assert rig_from_settings(settings, cache=None).morphs["smile"].method == "ease R=3"
    (tmp_path / "elastomorph.toml").write_text(
        switched_on((tmp_path / "elastomorph.toml").read_text())
    )
    rig = rig_from_settings(read_settings(tmp_path), cache=None)
    assert rig.morphs["smile"].choice is not None


def test_settings_that_are_there_are_kept(tmp_path: Path) -> None:
    em.write(tmp_path / "neutral.obj", sheet())
    em.write(tmp_path / "smile.obj", shapes()["smile"])
    (tmp_path / "elastomorph.toml").write_text("# mine")
    with pytest.raises(FileError, match=r"elastomorph\.toml: there are settings already; --force"):
        write_settings(tmp_path)
    assert (tmp_path / "elastomorph.toml").read_text() == "# mine"
    write_settings(tmp_path, force=True)
    assert read_settings(tmp_path).character.neutral == "neutral.obj"


def test_folders_that_hold_no_character(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="neither a mesh nor a rig"):
        write_settings(tmp_path)
    with pytest.raises(FileError, match="no such folder"):
        write_settings(tmp_path / "none")
    em.write(tmp_path / "smile.obj", sheet())
    with pytest.raises(FileError, match="this is a file"):
        write_settings(tmp_path / "smile.obj")
    with pytest.raises(FileError, match="expected one mesh file with 'neutral'"):
        write_settings(tmp_path)
    with pytest.raises(FileError, match="no targets"):
        write_settings(tmp_path, neutral="smile.obj")
    with pytest.raises(FileError, match="no such file to be the neutral"):
        write_settings(tmp_path, neutral="rest.obj")
    em.write(tmp_path / "frown.obj", sheet())
    write_settings(tmp_path, neutral="smile.obj")
    assert rig_from_settings(read_settings(tmp_path), cache=None).names == ("frown",)


def test_a_damaged_rig_or_archive_is_no_harm(tmp_path: Path) -> None:
    em.write(tmp_path / "neutral.obj", sheet())
    em.write(tmp_path / "smile.obj", shapes()["smile"])
    for name in ("damaged.npz", "damaged.glb", "damaged.json", "damaged.csv"):
        (tmp_path / name).write_bytes(b"\x00\xff{")
    assert survey(tmp_path).shapes == ("smile",)


NAMES = ["jawOpen", "mouthClose", "mouthSmile_L", "mouthSmile_R", "Blink_Left", "browInnerUp_L"]


def test_names_of_arkit_are_recognised() -> None:
    assert arkit_names([*NAMES, "nose"]) == {
        "jawOpen": "jawOpen",
        "mouthClose": "mouthClose",
        "mouthSmile_L": "mouthSmileLeft",
        "mouthSmile_R": "mouthSmileRight",
    }
    assert len(missing_arkit(NAMES)) == 48
    halves = ["browInnerUp_L", "browInnerUp_R", "cheekPuff_L"]
    assert set(missing_arkit([])) - set(missing_arkit(halves)) == {"browInnerUp"}


def test_jaws_and_lids_turn() -> None:
    names = ["jawOpen", "jawLeft", "eyeBlink_L", "EyeLookUpRight", "mouthOpen", "jaw_drop", "smile"]
    assert turning(names) == ["jawOpen", "eyeBlink_L", "EyeLookUpRight", "mouthOpen", "jaw_drop"]


def test_names_of_names_are_correctives() -> None:
    """The longest name counts, and one that corrects a corrective is left to people."""
    names = ["jawOpen", "mouthSmile_L", "mouthSmile", "jawOpen_mouthSmile_L", "jawOpen_no"]
    assert correctives(names) == {"jawOpen_mouthSmile_L": ["jawOpen", "mouthSmile_L"]}
    nested = ["a", "b", "c", "a_b", "a_b_c", "a_a"]
    assert correctives(nested) == {"a_b": ["a", "b"]}
    assert correctives(["jawOpen", "mouthClose", "eyeBlink_L"]) == {}
    assert correctives(["eyeBlink", "L", "eyeBlink_L"]) == {"eyeBlink_L": ["eyeBlink", "L"]}


def test_pair_bends_of_a_rig_file_are_no_targets(tmp_path: Path) -> None:
    """They are called as combination shapes are, and nobody has made them."""
    em.write(tmp_path / "head.npz", em.Rig(sheet(), meeting(sheet())))
    assert "jawOpen_mouthClose" in em.read_rig(tmp_path / "head.npz")
    assert survey(tmp_path).shapes == ("jawOpen", "mouthClose")


def test_groups_are_patterns_where_they_say_the_same() -> None:
    assert slider_groups(["eyeBlink_L", "eyeBlink_R", "brow"]) == {"eye": ["eye*"]}
    mixed = ["eyeBlink_L", "EyeWideLeft", "jawOpen"]
    assert slider_groups(mixed) == {"eye": ["eyeBlink_L", "EyeWideLeft"]}
