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
def sick(face: Mesh, rig: dict[str, Mesh]) -> Rig:
    """The head turns in one target, another does nothing."""
    smile = rig[f"{SMILE}.obj"]
    turned = smile.with_vertices(turn(smile.vertices, 2.0))
    return rig_of(face, {**rig, f"{SMILE}.obj": turned, "puff.obj": face})


EXPECTED = [("does-nothing", "puff"), ("moves-the-head", SMILE)]


def written(place: Path, kind: str, rig: Rig) -> Path:
    """The rig as a source of a kind."""
    if kind in ("folder", "settings", "settings-rig"):
        folder = place / "rig"
        folder.mkdir()
        if kind == "settings-rig":
            write(folder / "head.npz", rig)
            (folder / "hero.toml").write_text('[character]\nrig = "head.npz"\n')
            return folder / "hero.toml"
        write(folder / "neutral.obj", rig.neutral)
        for name, morph in rig.morphs.items():
            write(folder / f"{name}.obj", morph.target)
        if kind == "settings":
            (folder / "hero.toml").write_text('[character]\nneutral = "neutral.obj"\n')
            return folder / "hero.toml"
        return folder
    path = place / f"head{'.glb' if kind == '.vrm' else kind}"
    write(path, rig)
    return path.rename(path.with_suffix(".vrm")) if kind == ".vrm" else path


@pytest.mark.parametrize(
    "kind", ["folder", "settings", "settings-rig", ".npz", ".glb", ".vrm", ".usd", ".abc"]
)
def test_the_same_is_found_in_every_source(tmp_path: Path, sick: Rig, kind: str) -> None:
    if kind == ".abc":
        (tmp_path / "head.abc").write_bytes(b"Ogawa")
        with pytest.raises(FormatError, match=r"expected one of .*\.glb"):
            examine_files([tmp_path / "head.abc"])
        return
    if kind == ".usd":
        pytest.importorskip("pxr")
    source = written(tmp_path, kind, sick)
    found = examine_files([source])
    assert [(name, Path(file).stem) for name, file in names(found)] == EXPECTED
    assert found.facts is not None
    assert found.facts.counts.vertices == len(sick.neutral.vertices)


def test_the_built_in_head_is_sound(face: Mesh) -> None:
    found = examine_files(["built-in"])
    assert found.neutral == "built-in"
    assert "jawOpen" in found.targets
    assert not [one for one in found.findings if one.severity != "note"]


def test_a_rig_in_memory_is_examined(sick: Rig) -> None:
    found = examine_rig(sick, file="hero")
    assert names(found) == EXPECTED
    assert found.neutral == "hero"
    assert SMILE in as_text(found)
    assert as_document(found)["targets"] == list(sick.morphs)


def test_targets_of_a_rig_are_called_as_there(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Dots and all; sides are told by the whole name."""
    to = prepare(face, "linear")
    found = examine_rig(
        Rig(face, {"Face.brow.up": to(rig["browInnerUp.obj"]), "puff_L.v2": to(face)})
    )
    assert names(found) == [("does-nothing", "puff_L.v2")]


def test_a_repaired_rig_is_written_as_a_folder(
    tmp_path: Path, sick: Rig, rig: dict[str, Mesh]
) -> None:
    source = written(tmp_path, ".npz", sick)
    found = examine_files([source], ExaminationSettings(steady=True))
    done = repair(found, tmp_path / "fixed")
    assert [name for name, _ in done.repaired] == [SMILE]
    again = examine_files([tmp_path / "fixed"])
    assert [(name, Path(file).stem) for name, file in names(again)] == EXPECTED[:1]
    smile = read(tmp_path / "fixed" / f"{SMILE}.obj").vertices
    np.testing.assert_allclose(smile, rig[f"{SMILE}.obj"].vertices, atol=1e-5)
    assert read(tmp_path / "fixed" / "neutral.obj").faces == sick.neutral.faces


def test_a_rig_without_anything_to_repair_is_not_copied(tmp_path: Path, sick: Rig) -> None:
    found = examine_rig(sick, file="hero.glb")
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


def test_a_rig_is_named_alone(tmp_path: Path, face: Mesh, sick: Rig) -> None:
    write(tmp_path / "neutral.obj", face)
    for other in ("built-in", written(tmp_path, ".glb", sick)):
        with pytest.raises(ParameterError, match="name it alone"):
            examine_files([tmp_path / "neutral.obj", other])
    with pytest.raises(FileError):
        examine_files([tmp_path / "missing.glb"])
