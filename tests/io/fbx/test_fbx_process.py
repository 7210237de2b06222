"""Whatever becomes of the FBX worker, the program that started it gets a rig or one clear error."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from effort import worked
from elastomorph.errors import FormatError
from elastomorph.io import read_rig
from elastomorph.io.fbx import read_fbx
from elastomorph.rig import Rig
from fbx_samples import as_binary, as_text, quad, scene
from needs import installed

installed("ufbx", "fbx")

SLOWEST = 20.0


@pytest.fixture
def face(tmp_path: Path) -> Path:
    path = tmp_path / "face.fbx"
    path.write_bytes(as_binary(scene(quad())))
    return path


def outcome(path: Path) -> Rig | FormatError:
    """The rig or the refusal; anything else, or long work, is a failure."""
    before = worked()
    try:
        found: Rig | FormatError = read_fbx(path)
    except FormatError as error:
        if str(path) not in str(error):
            raise
        found = error
    assert worked() - before < SLOWEST
    return found


@pytest.mark.parametrize(
    "content", [b"", b"text", b"; FBX 7.4.0 project file\n", b"Kaydara FBX Binary  \x00\x1a\x00"]
)
def test_what_is_no_fbx_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.fbx"
    path.write_bytes(content)
    found = outcome(path)
    assert isinstance(found, FormatError)
    assert "export it again" in str(found)


@pytest.mark.parametrize("encoding", [as_text, as_binary])
def test_a_file_cut_off_anywhere(tmp_path: Path, encoding: object) -> None:
    """A sample of lengths: text may be cut to a shorter whole text, binary may not."""
    whole = (as_text if encoding is as_text else as_binary)(scene(quad()))
    path = tmp_path / "a.fbx"
    for length in np.linspace(1, len(whole) - 200, 12).astype(int).tolist():
        path.write_bytes(whole[:length])
        found = outcome(path)
        assert encoding is as_text or isinstance(found, FormatError)


@pytest.mark.parametrize("encoding", [as_text, as_binary])
def test_a_file_with_bytes_changed_anywhere(tmp_path: Path, encoding: object) -> None:
    whole = (as_text if encoding is as_text else as_binary)(scene(quad()))
    random = np.random.default_rng(11)
    path = tmp_path / "a.fbx"
    for _ in range(14):
        changed = bytearray(whole)
        for place in random.integers(30, len(whole), size=random.integers(1, 4)).tolist():
            changed[place] = int(random.integers(256))
        path.write_bytes(changed)
        outcome(path)


def test_points_and_shapes_that_contradict_each_other(tmp_path: Path) -> None:
    """Indices beyond the points, numbers that are not finite: refused, or as the reader mends."""
    whole = as_text(scene(quad()))
    path = tmp_path / "a.fbx"
    for old, new in [
        (b"a: 0,1,2,-4", b"a: 0,1,2,-400"),
        (b"a: 2\n", b"a: 99\n"),
        (b"a: 2\n", b"a: -5\n"),
        (b"0.25,0.5", b"1e999,0.5"),
        (b"0.0,0.0,0.5", b"nan,0.0,0.5"),
        (b'"Lcl Scaling", "", "A", 1.0', b'"Lcl Scaling", "", "A", 1e400'),
    ]:
        assert whole.count(old) == 1
        path.write_bytes(whole.replace(old, new))
        found = outcome(path)
        if isinstance(found, Rig):
            assert np.isfinite(found.pose({"lift": 1.0})).all()


def test_shapes_beyond_all_lengths_are_refused_by_every_door(tmp_path: Path) -> None:
    """Paths are made of what was read, so that nothing there may overflow either."""
    path = tmp_path / "far.fbx"
    path.write_bytes(as_text(scene(quad())).replace(b"0.25,0.5", b"1e308,1e308"))
    for door in (read_fbx, read_rig):
        with pytest.raises(FormatError, match=r"far\.fbx: vertex \d has .* at most 1e\+75"):
            door(path)


def test_the_worker_leaves_no_core_and_no_output_of_its_own(
    face: Path, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    here = Path.cwd()
    os.chdir(tmp_path)
    try:
        read_fbx(face)
    finally:
        os.chdir(here)
    assert capfd.readouterr() == ("", "")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["face.fbx"]


def test_one_mesh_of_very_many_nodes_is_refused(tmp_path: Path) -> None:
    """Each node of it costs a few bytes in the file, and arrays of its own when it is read."""
    whole = as_text(scene(quad()))
    mesh = whole.split(b"Geometry: ", 1)[1].split(b",", 1)[0].decode()
    nodes, links = "", ""
    for number in range(9000, 12_000):
        nodes += f'\tModel: {number}, "Model::n{number}", "Mesh" {{\n\t}}\n'
        links += f'\tC: "OO", {number}, 0\n\tC: "OO", {mesh}, {number}\n'
    text = whole.decode()
    text = text.replace("Objects:  {\n", f"Objects:  {{\n{nodes}")
    text = text.replace("Connections:  {\n", f"Connections:  {{\n{links}")
    path = tmp_path / "many.fbx"
    path.write_text(text)
    found = outcome(path)
    assert isinstance(found, FormatError)
    assert "more memory" in str(found) or "too much time" in str(found)


def test_transforms_beyond_all_numbers_are_refused(tmp_path: Path) -> None:
    whole, scale = as_text(scene(quad())), b'"Lcl Scaling", "", "A", '
    path = tmp_path / "far.fbx"
    for number in (b"1e308", b"1e400", b"nan"):
        path.write_bytes(whole.replace(scale + b"1.0", scale + number))
        found = outcome(path)
        if isinstance(found, Rig):
            assert np.isfinite(found.neutral.vertices).all()
