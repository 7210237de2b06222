"""A repaired rig loads, is exact, and the files examined are never touched."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from planted_faults import shuffled, turn

from elastomorph.doctor import ExaminationSettings, as_document, as_text, examine_files, repair
from elastomorph.doctor.files import read_seeds, rig_paths
from elastomorph.errors import ElastomorphError, FileError, FormatError, ParameterError
from elastomorph.io import read, read_rig, write
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import Mesh


@pytest.fixture
def folder(tmp_path: Path, face: Mesh, rig: dict[str, Mesh]) -> Path:
    """A rig on disk: one target shuffled, one with the head turned, one of another mesh."""
    place = tmp_path / "rig"
    place.mkdir()
    write(place / "neutral.obj", face)
    write(place / "browInnerUp.obj", rig["browInnerUp.obj"])
    write(place / "blink.npz", shuffled(rig["eyeBlink_L.obj"])[0])
    smile = rig["mouthSmile_L.obj"]
    write(place / "smile.obj", smile.with_vertices(turn(smile.vertices, 5.0)))
    write(place / "wrong.obj", Mesh(face.vertices[:4], [[0, 1, 2]]))
    return place


def test_the_repaired_folder_is_a_rig(folder: Path, tmp_path: Path, rig: dict[str, Mesh]) -> None:
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    found = examine_files([folder], ExaminationSettings(steady=True))
    done = repair(found, tmp_path / "fixed")
    assert {Path(file).name for file, _ in done.repaired} == {"blink.npz", "smile.obj"}
    assert {Path(file).name for file in done.copied} == {"neutral.obj", "browInnerUp.obj"}
    assert [Path(file).name for file in done.left_out] == ["wrong.obj"]
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    again = read_rig(tmp_path / "fixed", cache=None)
    assert set(again.morphs) == {"blink", "browInnerUp", "smile"}
    np.testing.assert_array_equal(
        again.morphs["blink"].target.vertices, rig["eyeBlink_L.obj"].vertices
    )
    fixed = examine_files([tmp_path / "fixed"])
    assert fixed.findings == ()
    text = as_text(found, done)
    assert "2 files repaired and read back, 2 copied" in text
    assert "left out, as they could not be repaired: wrong.obj" in text
    assert as_document(found, done)["repair"]["copied"] == list(done.copied)


def test_a_repair_that_brings_something_new_is_not_written(
    folder: Path, tmp_path: Path, face: Mesh
) -> None:
    """As if the numbering found were wrong: two vertices that lie apart change places."""
    found = examine_files([folder])
    (file,) = found.repaired
    good = found.repaired[file]
    points = good.mesh.vertices.copy()
    points[[2100, 100]] = points[[100, 2100]]
    bad = replace(good, mesh=good.mesh.with_vertices(points))
    done = repair(replace(found, repaired={file: bad}), tmp_path / "fixed")
    assert not done.repaired
    ((name, why),) = done.refused
    assert name == file
    assert "vertices that jump" in why
    assert sorted(path.name for path in (tmp_path / "fixed").iterdir()) == [
        "browInnerUp.obj", "neutral.obj", "smile.obj"
    ]  # fmt: skip
    assert "blink.npz was not written: " in as_text(found, done)
    assert as_document(found, done)["repair"]["refused"] == [{"file": file, "why": why}]


def test_reversed_polygons_are_wound_again_and_nothing_else(
    folder: Path, tmp_path: Path, face: Mesh, rig: dict[str, Mesh]
) -> None:
    """One piece of a target: positions are as in the sound one, bit for bit."""
    smile = rig["mouthSmile_L.obj"]
    part = component_of(len(face.vertices), face.edges)
    for piece in range(part.max() + 1):
        faces = [f.tolist()[::-1] if part[f[0]] == piece else f.tolist() for f in smile.faces]
        write(folder / "smile.obj", Mesh(smile.vertices, faces))
        found = examine_files([folder / "neutral.obj", folder / "smile.obj"])
        (one,) = [f for f in found.findings if f.severity == "error"]
        assert one.name == "reversed-winding"
        assert one.vertices == tuple(np.flatnonzero(part == piece))
        done = repair(found, tmp_path / f"fixed{piece}")
        assert len(done.repaired) == 1
        again = read(tmp_path / f"fixed{piece}" / "smile.obj")
        assert again.faces == face.faces
        np.testing.assert_array_equal(again.vertices, smile.vertices)


def test_a_neutral_in_another_unit_is_brought_to_its_targets(
    tmp_path: Path, face: Mesh, rig: dict[str, Mesh]
) -> None:
    place = tmp_path / "rig"
    place.mkdir()
    write(place / "neutral.obj", face)
    for name, mesh in rig.items():
        write(place / name, mesh.with_vertices(100.0 * mesh.vertices))
    found = examine_files([place])
    assert [(one.name, Path(one.file).name) for one in found.findings] == [
        ("different-units", "neutral.obj")
    ]
    done = repair(found, tmp_path / "fixed")
    assert [Path(file).name for file, _ in done.repaired] == ["neutral.obj"]
    assert not examine_files([tmp_path / "fixed"]).findings
    factorless = replace(found, repaired={}, beyond_repair=(found.neutral,))
    with pytest.raises(ParameterError, match="no rig to write"):
        repair(factorless, tmp_path / "none")


def test_the_folder_examined_is_refused(folder: Path) -> None:
    with pytest.raises(ParameterError, match="name another"):
        repair(examine_files([folder]), folder)


def test_two_files_of_one_name_are_refused(folder: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    write(other / "neutral.obj", read(folder / "browInnerUp.obj"))
    found = examine_files([folder / "neutral.obj", other / "neutral.obj"])
    with pytest.raises(ParameterError, match=r"called neutral\.obj"):
        repair(found, tmp_path / "fixed")


def test_folders_are_made_one_deep(folder: Path, tmp_path: Path) -> None:
    """A mistyped path grows no folders."""
    with pytest.raises(FileError, match="cannot be made"):
        repair(examine_files([folder]), tmp_path / "no" / "such")


def test_what_is_named(folder: Path) -> None:
    assert rig_paths([folder])[0].name == "neutral.obj"
    assert rig_paths([folder / "smile.obj"]) == (folder / "smile.obj",)
    with pytest.raises(ParameterError, match="name it alone"):
        rig_paths([folder / "neutral.obj", folder])
    with pytest.raises(ParameterError, match="named twice"):
        rig_paths([folder / "smile.obj", folder / "smile.obj"])


def test_an_unreadable_neutral_is_a_finding(folder: Path) -> None:
    (folder / "neutral.obj").write_text("v 1 2 nan\n")
    found = examine_files([folder])
    assert [one.name for one in found.findings] == ["unreadable"]
    assert found.findings[0].line == 1
    assert found.facts is None
    assert "unreadable" in as_text(found)
    assert as_document(found)["facts"] is None


def test_seeds_in_text_and_file(tmp_path: Path) -> None:
    assert read_seeds("12=40, 13=41") == ((12, 40), (13, 41))
    file = tmp_path / "pairs.json"
    file.write_text("[[12, 40], [13, 41]]")
    assert read_seeds(str(file)) == ((12, 40), (13, 41))


@pytest.mark.parametrize("text", ["", "12", "12=", "a=b", "1=2,1=3", "1=2,3=2", "-1=2", "1=2=3"])
def test_bad_seeds_are_refused(text: str) -> None:
    with pytest.raises(ParameterError, match="--seeds"):
        read_seeds(text)


@pytest.mark.parametrize("content", ["", "{}", "[[1]]", "[[1, 2.5]]", "[[true, 1]]", "[" * 5000])
def test_bad_seed_files_are_refused(tmp_path: Path, content: str) -> None:
    file = tmp_path / "pairs.json"
    file.write_text(content)
    with pytest.raises(FormatError):
        read_seeds(str(file))
    with pytest.raises(ElastomorphError):
        read_seeds(str(tmp_path / "missing.json"))
