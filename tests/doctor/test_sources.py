"""A rig is examined from every kind of source that holds one, with the same findings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from planted_faults import names, turn

from elastomorph.doctor import (
    ExaminationSettings,
    as_document,
    as_text,
    examine_files,
    examine_rig,
    repair,
)
from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io import read, write
from elastomorph.model.mesh import Mesh
from elastomorph.paths import prepare
from elastomorph.rig import Rig

SMILE = "mouthSmile_L"


def rig_of(face: Mesh, targets: dict[str, Mesh]) -> Rig:
    to = prepare(face, "linear")
    return Rig(face, {Path(file).stem: to(mesh) for file, mesh in targets.items()})


@pytest.fixture
def faulty(face: Mesh, rig: dict[str, Mesh]) -> Rig:
    """The head turns in one target, another does nothing."""
    smile = rig[f"{SMILE}.obj"]
    turned = smile.with_vertices(turn(smile.vertices, 2.0))
    return rig_of(face, {**rig, f"{SMILE}.obj": turned, "puff.obj": face})


EXPECTED = [("does-nothing", "puff"), ("moves-the-head", SMILE)]


def written(place: Path, kind: str, rig: Rig) -> Path:
    """The rig as a source of a kind."""
    if kind in ("folder", "settings", "settings-folder", "settings-rig"):
        folder = place / "rig"
        folder.mkdir()
        if kind == "settings-rig":
            write(folder / "head.npz", rig)
            (folder / "hero.toml").write_text('[character]\nrig = "head.npz"\n')
            return folder / "hero.toml"
        write(folder / "neutral.obj", rig.neutral)
        for name, morph in rig.morphs.items():
            write(folder / f"{name}.obj", morph.target)
        if kind == "folder":
            return folder
        chosen = folder / ("hero.toml" if kind == "settings" else "elastomorph.toml")
        chosen.write_text('[character]\nneutral = "neutral.obj"\n')
        return chosen if kind == "settings" else folder
    path = place / f"head{'.glb' if kind == '.vrm' else kind}"
    write(path, rig)
    return path.rename(path.with_suffix(".vrm")) if kind == ".vrm" else path


@pytest.mark.parametrize(
    "kind",
    ["folder", "settings", "settings-folder", "settings-rig", ".npz", ".glb", ".vrm", ".usd"],
)
def test_the_same_is_found_in_every_source(tmp_path: Path, faulty: Rig, kind: str) -> None:
    if kind == ".usd":
        pytest.importorskip("pxr")
    source = written(tmp_path, kind, faulty)
    found = examine_files([source])
    assert [(name, Path(file).stem) for name, file in names(found)] == EXPECTED
    assert found.facts is not None
    assert found.facts.counts.vertices == len(faulty.neutral.vertices)


def test_what_is_no_rig_is_refused(tmp_path: Path) -> None:
    (tmp_path / "head.abc").write_bytes(b"Ogawa")
    with pytest.raises(FormatError, match=r"expected one of .*\.glb"):
        examine_files([tmp_path / "head.abc"])
    (tmp_path / "hero.toml").write_text("[character]\nneutral = 3\n")
    with pytest.raises(FormatError, match=r"line 2: 'character\.neutral'"):
        examine_files([tmp_path / "hero.toml"])


def test_the_built_in_head_is_sound(face: Mesh) -> None:
    found = examine_files(["built-in"])
    assert found.neutral == "built-in"
    assert "jawOpen" in found.targets
    assert not [one for one in found.findings if one.severity != "note"]


def test_a_rig_in_memory_is_examined(faulty: Rig) -> None:
    found = examine_rig(faulty, file="hero")
    assert names(found) == EXPECTED
    assert found.neutral == "hero"
    assert SMILE in as_text(found)
    assert as_document(found)["targets"] == list(faulty.morphs)


def test_targets_of_a_rig_are_called_as_there(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Dots and all; sides are told by the whole name."""
    to = prepare(face, "linear")
    found = examine_rig(
        Rig(face, {"Face.brow.up": to(rig["browInnerUp.obj"]), "puff_L.v2": to(face)})
    )
    assert names(found) == [("does-nothing", "puff_L.v2")]


def test_a_repaired_rig_is_written_as_a_folder(
    tmp_path: Path, faulty: Rig, rig: dict[str, Mesh]
) -> None:
    source = written(tmp_path, ".npz", faulty)
    found = examine_files([source], ExaminationSettings(steady=True))
    done = repair(found, tmp_path / "fixed")
    assert [name for name, _ in done.repaired] == [SMILE]
    again = examine_files([tmp_path / "fixed"])
    assert [(name, Path(file).stem) for name, file in names(again)] == EXPECTED[:1]
    smile = read(tmp_path / "fixed" / f"{SMILE}.obj").vertices
    np.testing.assert_allclose(smile, rig[f"{SMILE}.obj"].vertices, atol=1e-5)
    assert read(tmp_path / "fixed" / "neutral.obj").faces == faulty.neutral.faces


def test_a_rig_without_anything_to_repair_is_not_copied(tmp_path: Path, faulty: Rig) -> None:
    found = examine_rig(faulty, file="hero.glb")
    with pytest.raises(ParameterError, match=r"nothing to repair in hero\.glb"):
        repair(found, tmp_path / "fixed")
    assert not (tmp_path / "fixed").exists()


def test_targets_that_cannot_be_files_are_refused(
    tmp_path: Path, face: Mesh, rig: dict[str, Mesh]
) -> None:
    to = prepare(face, "linear")
    smile = rig[f"{SMILE}.obj"]
    turned = to(smile.with_vertices(turn(smile.vertices, 2.0)))
    found = examine_rig(Rig(face, {"../smile": turned}), ExaminationSettings(steady=True))
    with pytest.raises(ParameterError, match="cannot be the name of a file"):
        repair(found, tmp_path / "fixed")


def test_a_rig_is_named_alone(tmp_path: Path, face: Mesh, faulty: Rig) -> None:
    write(tmp_path / "neutral.obj", face)
    settings = written(tmp_path, "settings", faulty)
    for other in ("built-in", settings):
        with pytest.raises(ParameterError, match="name it alone"):
            examine_files([tmp_path / "neutral.obj", other])
    rig = written(tmp_path, ".glb", faulty)
    for files in ([tmp_path / "neutral.obj", rig], [rig, tmp_path / "neutral.obj"]):
        (finding,) = examine_files(files).findings
        assert (finding.name, finding.file) == ("unreadable", str(rig))
        assert "this is a rig, targets: " in finding.message
    with pytest.raises(FileError):
        examine_files([tmp_path / "missing.glb"])
