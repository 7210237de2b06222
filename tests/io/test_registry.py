"""A file's suffix decides who reads and writes it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from mesh_samples import assert_same_mesh, assert_same_surface, house, meshes

from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io import read, read_rig, write
from elastomorph.io.registry import MESH_FORMATS, Format, format_of, known_suffixes, writer_of
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig import Rig

SUFFIXES = known_suffixes(MESH_FORMATS)


@pytest.mark.parametrize("suffix", SUFFIXES)
@given(mesh=meshes())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_what_was_written_is_read_back(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, mesh: Mesh
) -> None:
    """PLY keeps positions and polygons; the other formats keep all."""
    path = tmp_path_factory.getbasetemp() / f"round-trip{suffix}"
    write(path, mesh)
    (assert_same_surface if suffix == ".ply" else assert_same_mesh)(read(path), mesh)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_mesh_knows_the_file_it_came_from(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"house{suffix}"
    write(path, house())
    assert read(path).name == read(str(path)).name == str(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_same_mesh_gives_the_same_bytes(tmp_path: Path, suffix: str) -> None:
    for name in "ab":
        write(tmp_path / f"{name}{suffix}", house())
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("old", [None, b"old"])
def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    suffix: str,
    error: BaseException,
    old: bytes | None,
) -> None:
    def fail(descriptor: int) -> None:
        raise error

    path = tmp_path / f"house{suffix}"
    if old is not None:
        path.write_bytes(old)
    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(FileError if isinstance(error, OSError) else type(error)):
        write(path, house())
    assert [p.read_bytes() for p in tmp_path.iterdir()] == ([] if old is None else [old])


def test_capitals_in_a_suffix_do_not_matter(tmp_path: Path) -> None:
    write(tmp_path / "HOUSE.OBJ", house())
    assert_same_mesh(read(tmp_path / "HOUSE.OBJ"), house())


@pytest.mark.parametrize("name", ["face.stl", "face", "face.obj.bak"])
def test_an_unknown_suffix_lists_the_known_ones(tmp_path: Path, name: str) -> None:
    there = tmp_path / "there" / name
    there.parent.mkdir()
    there.touch()
    for attempt in (lambda: read(there), lambda: write(tmp_path / name, house())):
        with pytest.raises(FormatError) as caught:
            attempt()
        assert all(suffix in str(caught.value) for suffix in SUFFIXES)
    assert list(tmp_path.iterdir()) == [there.parent]


def test_a_name_without_a_suffix_that_nothing_has_is_missing(tmp_path: Path) -> None:
    for attempt in (read, read_rig):
        with pytest.raises(FileError, match="no such file or folder"):
            attempt(tmp_path / "face")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_missing_file_or_folder_is_a_file_error(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(FileError, match="no such file"):
        read(tmp_path / f"missing{suffix}")
    with pytest.raises(FileError, match="does not exist"):
        write(tmp_path / "missing" / f"house{suffix}", house())
    folder = tmp_path / f"folder{suffix}"
    folder.mkdir()
    with pytest.raises(FileError, match="folder"):
        read(folder)
    with pytest.raises(FileError, match="folder"):
        write(folder, house())


def test_only_meshes_are_written(tmp_path: Path) -> None:
    motion = MeshSequence(house(), np.stack([house().vertices, house().vertices + 1]))
    wrong: Any
    for wrong, advice in ((motion, "write_sequence"), (np.zeros((3, 3)), "ndarray")):
        with pytest.raises(ParameterError, match=advice):
            write(tmp_path / "a.obj", wrong)
    assert list(tmp_path.iterdir()) == []


def test_one_line_in_a_table_adds_a_format_of_any_kind() -> None:
    written: list[tuple[object, ...]] = []
    counts: tuple[Format[int], ...] = (
        Format("tally", (".tally",), lambda: (lambda path: 5, lambda *told: written.append(told))),
    )
    assert format_of("a.tally", counts).read("a.tally") == 5
    writer_of("a.tally", counts)("a.tally", 7)
    assert written == [("a.tally", 7)]
    with pytest.raises(FormatError, match=r"expected one of \.tally"):
        format_of("a.obj", counts)


def test_readers_are_loaded_when_first_needed() -> None:
    program = (
        "import sys, elastomorph.io.registry as r; "
        "assert 'elastomorph.io.ply' not in sys.modules; "
        "assert 'elastomorph.io.obj' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.realdata
def test_a_production_mesh_survives_every_format(tmp_path: Path, data_dir: Path) -> None:
    mesh = read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")
    for suffix in SUFFIXES:
        write(tmp_path / f"face{suffix}", mesh)
        same = assert_same_surface if suffix == ".ply" else assert_same_mesh
        same(read(tmp_path / f"face{suffix}"), mesh)


@pytest.mark.parametrize("name", ["n" * 300, "n/" * 3000 + "a", "a\0b", "file.obj/a"])
@pytest.mark.parametrize("suffix", [".obj", ".ply", ".npz", ".glb", ".usda", ".fbx"])
def test_a_path_that_cannot_be_is_an_error_of_ours(tmp_path: Path, name: str, suffix: str) -> None:
    """Too long, with a NUL, or below a file: not even whether it is a folder may be asked."""
    (tmp_path / "file.obj").touch()
    for reads in (read, read_rig):
        if suffix not in (".obj", ".ply") or reads is read:
            with pytest.raises(FileError):
                reads(tmp_path / f"{name}{suffix}")


def test_a_folder_is_read_as_a_rig(tmp_path: Path) -> None:
    write(tmp_path / "neutral.obj", house())
    write(tmp_path / "smile.obj", house())
    assert read_rig(tmp_path, cache=None).names == ("smile",)


def test_a_format_that_is_only_read_is_not_written(tmp_path: Path) -> None:
    rig = Rig(house(), {})
    for suffix in (".gltf", ".fbx"):
        with pytest.raises(FormatError, match=r"only read; write one of \.glb, \.usd"):
            write(tmp_path / f"face{suffix}", rig)


@pytest.mark.parametrize(
    ("name", "known"),
    [("face.obj", "there are none"), ("face.ply", "there are encoding"), ("rig.glb", "normals, ")],
)
def test_an_option_that_the_format_has_not_is_refused(
    tmp_path: Path, name: str, known: str
) -> None:
    mesh = Mesh(np.eye(3), [[0, 1, 2]])
    thing = Rig(mesh, {}) if name.startswith("rig") else mesh
    with pytest.raises(ParameterError, match=rf"{name}: this format has no option .*{known}"):
        write(tmp_path / name, thing, tol=1)
    assert not list(tmp_path.iterdir())
