"""A file cut off or changed anywhere gives a mesh or an error of ours, never anything else."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mesh_samples import house

from elastomorph.errors import FormatError
from elastomorph.io.npz import read_npz, read_npz_sequence, write_npz, write_npz_sequence
from elastomorph.io.obj import read_obj, write_obj
from elastomorph.io.ply import read_ply, write_ply
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence


def write_motion(path: Path, mesh: Mesh) -> None:
    write_npz_sequence(path, MeshSequence(mesh, [mesh.vertices, mesh.vertices * 2]))


Codec = tuple[Callable[[Path], Any], Callable[[Path, Mesh], None]]

CODECS: dict[str, Codec] = {
    "obj": (read_obj, write_obj),
    "ply ascii": (read_ply, partial(write_ply, encoding="ascii")),
    "ply little": (read_ply, write_ply),
    "ply big": (read_ply, partial(write_ply, encoding="binary_big_endian")),
    "npz": (read_npz, write_npz),
    "npz motion": (read_npz_sequence, write_motion),
}
MADE_OF_WHOLE_BYTES = ["ply little", "ply big", "npz", "npz motion"]


def whole_file(folder: Path, codec: str) -> tuple[Path, bytes]:
    path = folder / f"{codec}.file"
    CODECS[codec][1](path, house())
    return path, path.read_bytes()


def refused(codec: str, path: Path) -> bool:
    """Whether the file is refused; anything but a FormatError that names it is a failure."""
    try:
        CODECS[codec][0](path)
    except FormatError as error:
        if str(path) not in str(error):
            raise
        return True
    return False


# What is left of a damaged text may be odd rather than wrong.
@pytest.mark.filterwarnings("ignore::elastomorph.ElastomorphWarning")
@pytest.mark.parametrize("codec", CODECS)
def test_a_file_cut_off_at_any_byte(tmp_path: Path, codec: str) -> None:
    """Binary files are refused wherever they are cut; text may be cut to a shorter whole text."""
    path, whole = whole_file(tmp_path, codec)
    assert not refused(codec, path)
    cut = []
    for length in reversed(range(len(whole))):
        os.truncate(path, length)
        cut.append(refused(codec, path))
    assert all(cut) if codec in MADE_OF_WHOLE_BYTES else cut[-1] and sum(cut) > len(cut) // 8


@pytest.mark.parametrize("codec", CODECS)
def test_a_file_with_any_one_byte_turned_around(tmp_path: Path, codec: str) -> None:
    path, whole = whole_file(tmp_path, codec)
    for place in range(0, len(whole), 1 + len(whole) // 800):
        changed = bytearray(whole)
        changed[place] ^= 0xFF
        path.write_bytes(changed)
        refused(codec, path)


@pytest.mark.filterwarnings("ignore::elastomorph.ElastomorphWarning")
@pytest.mark.parametrize("codec", CODECS)
@given(edits=st.data())
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_a_file_with_random_bytes_changed(
    tmp_path_factory: pytest.TempPathFactory, codec: str, edits: st.DataObject
) -> None:
    path, whole = whole_file(tmp_path_factory.getbasetemp(), codec)
    changed = bytearray(whole)
    for _ in range(edits.draw(st.integers(1, 6))):
        place = edits.draw(st.integers(0, len(changed)))
        new = edits.draw(st.binary(max_size=4) | st.sampled_from([b"9", b"-", b" ", b"\n", b"e"]))
        changed[place : place + edits.draw(st.integers(0, 4))] = new
    path.write_bytes(changed)
    refused(codec, path)


@pytest.mark.parametrize("codec", CODECS)
@given(content=st.binary(max_size=200))
@settings(max_examples=60, deadline=None)
def test_random_bytes_behind_the_beginning_of_a_file(
    tmp_path_factory: pytest.TempPathFactory, codec: str, content: bytes
) -> None:
    path, whole = whole_file(tmp_path_factory.getbasetemp(), codec)
    path.write_bytes(whole[: len(content)] + content)
    refused(codec, path)
