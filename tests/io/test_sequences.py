"""Recorded motion is read in the order and at the times of its frames, and written whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_samples import assert_same_mesh, house, same_bits

import elastomorph.io.obj
from elastomorph.errors import FileError, FormatError, ParameterError, TopologyError
from elastomorph.io import read, read_sequence, write, write_sequence
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence


def frame(number: int) -> Mesh:
    return house().with_vertices(house().vertices + number)


def motion(times: list[float]) -> MeshSequence:
    return MeshSequence(house(), [frame(i).vertices for i in range(len(times))], times)


def write_frames(folder: Path, numbers: list[int], suffix: str = ".obj") -> None:
    for number in numbers:
        write(folder / f"scan.{number:04d}{suffix}", frame(number))


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".npz"])
@pytest.mark.parametrize("pattern", ["scan.####", "scan.*", ""])
def test_times_follow_the_frame_numbers(tmp_path: Path, suffix: str, pattern: str) -> None:
    write_frames(tmp_path, [9, 10, 13, 11], suffix)
    sequence = read_sequence(str(tmp_path / (pattern + suffix if pattern else "")))
    assert sequence.times.tolist() == [0, 0.25, 0.5, 1]
    assert sequence.names == tuple(f"scan.{n:04d}{suffix}" for n in (9, 10, 11, 13))
    assert sequence.missing == (f"scan.0012{suffix}",)
    expected = np.stack([frame(n).vertices for n in (9, 10, 11, 13)])
    assert same_bits(sequence.frames, expected)
    assert sequence.mesh.faces == house().faces


def test_labels_and_source_are_those_of_the_first_frame(tmp_path: Path) -> None:
    write_frames(tmp_path, [1, 2])
    sequence = read_sequence(tmp_path)
    assert_same_mesh(sequence.mesh, frame(1))
    assert sequence.mesh.name == str(tmp_path / "scan.0001.obj")


def test_a_frame_with_other_polygons_is_named_with_its_line(tmp_path: Path) -> None:
    write_frames(tmp_path, [1, 2, 3])
    path = tmp_path / "scan.0002.obj"
    path.write_text(path.read_text().replace("f 4/4 3/3 5", "f 3/3 4/4 5"))
    with pytest.raises(TopologyError, match=r"scan\.0002\.obj and .*scan\.0001\.obj .*\(line 15\)"):
        read_sequence(tmp_path)


def test_a_frame_with_other_vertices_is_named(tmp_path: Path) -> None:
    write_frames(tmp_path, [1, 2])
    write(tmp_path / "scan.0003.obj", Mesh([[0, 0, 0]]))
    with pytest.raises(TopologyError, match=r"scan\.0003\.obj has 1 vertices"):
        read_sequence(tmp_path)


def test_a_damaged_frame_is_named(tmp_path: Path) -> None:
    write_frames(tmp_path, [1, 2])
    (tmp_path / "scan.0002.obj").write_text("v 0 0\n")
    with pytest.raises(FormatError, match=r"scan\.0002\.obj, line 1"):
        read_sequence(tmp_path)


def test_frames_of_an_unknown_format_are_refused(tmp_path: Path) -> None:
    for number in (1, 2):
        (tmp_path / f"scan.{number}.stl").touch()
    with pytest.raises(FormatError, match=r"unknown suffix '\.stl'"):
        read_sequence(tmp_path / "scan.#.stl")


def test_a_missing_archive_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"no files called 'motion\.npz'"):
        read_sequence(tmp_path / "motion.npz")


def test_an_archive_keeps_times_names_and_gaps(tmp_path: Path) -> None:
    before = MeshSequence(house(), motion([0, 0.3, 1]).frames, [0, 0.3, 1], ["a", "b", "d"], ["c"])
    write_sequence(tmp_path / "motion.npz", before)
    after = read_sequence(tmp_path / "motion.npz")
    assert_same_mesh(after.mesh, before.mesh)
    assert same_bits(after.frames, before.frames)
    assert same_bits(after.times, before.times)
    assert (after.names, after.missing) == (before.names, before.missing)


@given(numbers=st.sets(st.integers(1, 60), min_size=2, max_size=8))
@settings(max_examples=25, deadline=None)
def test_numbered_files_give_frames_and_times_back(
    tmp_path_factory: pytest.TempPathFactory, numbers: set[int]
) -> None:
    before = motion([float(number) for number in sorted(numbers)])
    pattern = tmp_path_factory.mktemp("motion") / "scan.##.obj"
    write_sequence(pattern, before)
    after = read_sequence(pattern)
    assert same_bits(after.frames, before.frames)
    np.testing.assert_allclose(after.times, before.times, rtol=0, atol=1e-15)
    assert_same_mesh(after.mesh, before.mesh)


def test_files_are_numbered_from_one_with_the_digits_of_the_pattern(tmp_path: Path) -> None:
    write_sequence(tmp_path / "scan.###.ply", motion([0, 1, 3]))
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "scan.001.ply",
        "scan.002.ply",
        "scan.004.ply",
    ]
    assert same_bits(read(tmp_path / "scan.004.ply").vertices, frame(2).vertices)


def test_times_on_no_even_grid_need_an_archive(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"\.npz"):
        write_sequence(tmp_path / "scan.##.obj", motion([0, 1, np.pi, 2 + np.sqrt(2), 6]))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("old", [False, True])
def test_a_frame_that_fails_leaves_all_old_frames_and_no_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, old: bool
) -> None:
    if old:
        write_sequence(tmp_path / "scan.##.obj", motion([0, 1, 2, 3]))
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    written = 0
    write_obj = elastomorph.io.obj.write_obj

    def fail_at_the_third(path: str | Path, mesh: Mesh) -> None:
        nonlocal written
        written += 1
        if written == 3:
            raise error
        write_obj(path, mesh)

    monkeypatch.setattr(elastomorph.io.obj, "write_obj", fail_at_the_third)
    changed = MeshSequence(house(), motion([0, 1, 2, 3]).frames * 2)
    with pytest.raises(FileError if isinstance(error, OSError) else type(error)):
        write_sequence(tmp_path / "scan.##.obj", changed)
    assert written == 3
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_frames_of_another_motion_are_not_mixed_with_this_one(tmp_path: Path) -> None:
    write_sequence(tmp_path / "scan.##.obj", motion([0, 1, 2, 3]))
    write_sequence(tmp_path / "scan.##.obj", motion([0, 1, 2, 3]))
    with pytest.raises(FileError, match=r"scan\.03\.obj is already there .*\(2 such files\)"):
        write_sequence(tmp_path / "scan.##.obj", motion([0, 1]))
    with pytest.raises(FileError, match="already there"):
        write_sequence(tmp_path / "scan.#.obj", motion([0, 1, 2, 3]))
    assert len(read_sequence(tmp_path)) == 4


def test_a_complaint_of_a_format_names_the_frame(tmp_path: Path) -> None:
    bad = house()
    assert bad.groups is not None
    labels = type(bad.groups)(("two\nlines",), bad.groups.of_face)
    sequence = MeshSequence(
        Mesh(bad.vertices, bad.faces, groups=labels), [bad.vertices, bad.vertices]
    )
    with pytest.raises(FormatError, match=r"scan\.1\.obj: the name 'two\\nlines'"):
        write_sequence(tmp_path / "scan.#.obj", sequence)
    assert list(tmp_path.iterdir()) == []


def test_places_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    wrong: Any = house()
    with pytest.raises(ParameterError, match="expected a MeshSequence, found Mesh"):
        write_sequence(tmp_path / "a.npz", wrong)
    for pattern, words in (
        ("missing/scan.##.obj", "does not exist"),
        ("missing/motion.npz", "does not exist"),
        ("scan.obj", "one run of #"),
        ("scan.##.stl", "unknown suffix"),
    ):
        with pytest.raises(FileError, match=words):
            write_sequence(tmp_path / pattern, motion([0, 1]))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.realdata
def test_recorded_markers_survive_an_archive(tmp_path: Path, data_dir: Path) -> None:
    """A real capture: points without polygons."""
    with np.load(data_dir / "animface" / "eyebrows.npz", allow_pickle=False) as archive:
        frames = archive["stab"]
    frames = frames[np.isfinite(frames).all(axis=(1, 2))]
    before = MeshSequence(Mesh(frames[0]), frames)
    write_sequence(tmp_path / "eyebrows.npz", before)
    assert same_bits(read_sequence(tmp_path / "eyebrows.npz").frames, before.frames)


def test_frames_that_are_small_as_files_and_large_together_are_refused(tmp_path: Path) -> None:
    """Each file may take what it does, but not all of them at once."""
    zeros = np.zeros((300_000, 3), "i1")
    for number in range(12):
        np.savez_compressed(tmp_path / f"scan.{number}.npz", vertices=zeros)
    with pytest.raises(FormatError, match=r"scan\.#\.npz: it would take more memory than"):
        read_sequence(tmp_path / "scan.#.npz")


def test_a_frame_that_is_a_link_to_itself_is_an_error_of_that_frame(tmp_path: Path) -> None:
    write_frames(tmp_path, [1, 2])
    (tmp_path / "scan.0003.obj").symlink_to(tmp_path / "scan.0003.obj")
    with pytest.raises(FileError, match=r"scan\.0003\.obj"):
        read_sequence(tmp_path / "scan.####.obj")


@pytest.mark.parametrize("name", ["n" * 300, "n/" * 3000, "a\0b"])
@pytest.mark.parametrize("suffix", [".npz", ".#.obj", ".*.obj", ""])
def test_a_path_that_cannot_be_is_an_error_of_ours(tmp_path: Path, name: str, suffix: str) -> None:
    with pytest.raises(FileError):
        read_sequence(tmp_path / f"{name}{suffix}")
