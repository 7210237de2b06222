"""Markers of C3D files: as they were recorded, and refused in one sentence where they cannot be."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from elastomorph.errors import ElastomorphWarning, FileError, FormatError
from elastomorph.io import read_markers
from elastomorph.io.sequences import holds_markers, read_recording
from needs import extra

ezc3d = extra("ezc3d", "mocap")

FRAMES, MARKERS = 7, 5
NAMES = ["chin", "lip", "brow", "chin", ""]


@pytest.fixture(scope="module")
def positions() -> np.ndarray:
    """(T, M, 3) as 32-bit files keep them, one marker missing in two frames."""
    taken = np.random.default_rng(0).normal(scale=100, size=(FRAMES, MARKERS, 3))
    taken[2:4, 1] = np.nan
    return taken.astype(np.float32).astype(float)


@pytest.fixture(scope="module")
def content(positions: np.ndarray, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    file = tmp_path_factory.mktemp("c3d") / "take.c3d"
    written(file, positions, NAMES)
    return file.read_bytes()


def written(file: Path, positions: np.ndarray, names: list[str], rate: float = 120) -> None:
    taken = ezc3d.c3d()
    point = taken["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"] = [rate], ["mm"]
    point["LABELS"]["value"] = names
    ones = np.ones((1, positions.shape[1], len(positions)))
    taken["data"]["points"] = np.concatenate([positions.transpose(2, 1, 0), ones])
    taken.write(str(file))


def test_markers_are_those_recorded(tmp_path: Path, content: bytes, positions: np.ndarray) -> None:
    (tmp_path / "take.C3D").write_bytes(content)
    assert holds_markers(tmp_path / "take.C3D")
    taken = read_markers(tmp_path / "take.C3D")
    np.testing.assert_array_equal(taken.frames, positions)
    assert taken.names == (*NAMES[:4], "4")
    np.testing.assert_allclose(taken.times, np.arange(FRAMES) / 120)
    assert taken.unit == "mm"


def test_more_names_than_one_list_holds(tmp_path: Path) -> None:
    names = [f"m{number}" for number in range(300)]
    written(tmp_path / "many.c3d", np.zeros((2, 300, 3)), names)
    assert read_markers(tmp_path / "many.c3d").names == tuple(names)


def test_names_in_latin_1_and_no_rate(tmp_path: Path, content: bytes) -> None:
    changed = content.replace(b"chin", b"ch\xeen").replace(struct.pack("<f", 120), bytes(4))
    (tmp_path / "take.c3d").write_bytes(changed)
    taken = read_markers(tmp_path / "take.c3d")
    assert taken.names[0] == "chîn"
    assert taken.times is None


def test_a_file_cut_off_says_so(tmp_path: Path, content: bytes, positions: np.ndarray) -> None:
    (tmp_path / "take.c3d").write_bytes(content[: len(content) - 600])
    with pytest.warns(ElastomorphWarning, match=r"take\.c3d: \d frames .* has 7; it may be cut"):
        taken = read_markers(tmp_path / "take.c3d")
    np.testing.assert_array_equal(taken.frames, positions[: len(taken)])


def test_a_take_to_learn_from_keeps_its_times(tmp_path: Path) -> None:
    written(tmp_path / "take.c3d", np.random.default_rng(1).normal(size=(5, 4, 3)), list("abcd"))
    take = read_recording(tmp_path / "take.c3d")
    assert take.names == tuple("abcd")
    np.testing.assert_allclose(take.motion.times, np.linspace(0, 1, 5))


def test_files_that_are_none_are_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "take.c3d"
    with pytest.raises(FileError, match=r"take\.c3d: "):
        read_markers(file)
    for wrong in (b"", b"text", content[:511], content[:700], b"\0" * 2000):
        file.write_bytes(wrong)
        with pytest.raises(FormatError, match=r"take\.c3d: .*(read as C3D|broke|no positions)"):
            read_markers(file)


@pytest.mark.filterwarnings("ignore::elastomorph.errors.ElastomorphWarning")
def test_a_file_that_says_it_is_huge_takes_no_more_than_it_is(
    tmp_path: Path, content: bytes
) -> None:
    """Numbers of the header and the number of markers at their greatest, one after another."""
    file = tmp_path / "take.c3d"
    used = content.index(b"USED") + len(b"USED") + 2 + 2  # past the offset, type and dimensions
    for place in (2, 4, 8, 10, 12, 16, 18, used, used + 1):
        changed = bytearray(content)
        changed[place : place + 2] = b"\xff\xff"
        file.write_bytes(changed)
        frames = np.empty(0)
        with suppress(FormatError):
            frames = read_markers(file).frames
        assert frames.nbytes < 100 * len(content)
