"""Frames are found by pattern, wildcard or folder, and put in the order of their numbers."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph.errors import FileError, FormatError
from elastomorph.io.numbering import find_frames, frame_pattern

SUFFIXES = (".obj", ".ply")


def folder_with(folder: Path, names: Iterable[str]) -> Path:
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).touch()
    return folder


def found(pattern: Path) -> tuple[list[str], list[int], list[str]]:
    frames = find_frames(pattern, SUFFIXES)
    return [file.name for file in frames.files], list(frames.numbers), list(frames.missing)


@pytest.mark.parametrize("pattern", ["scan.####.obj", "scan.#.obj", "scan.*.obj", "scan*", "."])
def test_frames_are_in_numeric_order_whatever_their_width(tmp_path: Path, pattern: str) -> None:
    names = ["scan.10.obj", "scan.9.obj", "scan.0008.obj", "scan.11.obj"]
    folder_with(tmp_path, names)
    assert found(tmp_path / pattern) == (
        ["scan.0008.obj", "scan.9.obj", "scan.10.obj", "scan.11.obj"],
        [8, 9, 10, 11],
        [],
    )


def test_a_pattern_finds_only_names_that_fit_it_exactly(tmp_path: Path) -> None:
    fits = ["scan.1.obj", "scan.2.obj"]
    others = [
        "scan.1.obj.bak",
        "scan.1.ply",
        "my scan.3.obj",
        "scan.x.obj",
        "scan..obj",
        "scan_4.obj",
    ]
    folder_with(tmp_path, fits + others + ["scanx5.obj", "scan.6.OBJ", ".scan.7.obj"])
    (tmp_path / "scan.8.obj").mkdir()
    assert found(tmp_path / "scan.##.obj")[0] == fits


def test_signs_of_regular_expressions_in_a_pattern_stand_for_themselves(tmp_path: Path) -> None:
    folder_with(tmp_path, ["a+(b).1.obj", "a+(b).2.obj", "aab.3.obj"])
    assert found(tmp_path / "a+(b).#.obj")[1] == [1, 2]


def test_gaps_in_the_numbers_are_named(tmp_path: Path) -> None:
    folder_with(tmp_path, [f"scan.{n:04d}.obj" for n in (7, 8, 11, 12)])
    assert found(tmp_path / "scan.####.obj")[2] == ["scan.0009.obj", "scan.0010.obj"]


def test_equal_steps_leave_nothing_out(tmp_path: Path) -> None:
    folder_with(tmp_path, [f"scan.{n}.obj" for n in (10, 20, 30, 50)])
    assert found(tmp_path / "scan.##.obj")[1:] == ([10, 20, 30, 50], ["scan.40.obj"])


@given(st.sets(st.integers(0, 300), min_size=2, max_size=20))
@settings(max_examples=40, deadline=None)
def test_frames_and_gaps_together_are_an_even_count(
    tmp_path_factory: pytest.TempPathFactory, numbers: set[int]
) -> None:
    folder = folder_with(tmp_path_factory.mktemp("frames"), [f"f{n:03d}.obj" for n in numbers])
    files, order, missing = found(folder)
    assert order == sorted(numbers)
    together = sorted(int(name[1:4]) for name in files + missing)
    steps = {b - a for a, b in pairwise(together)}
    assert len(steps) == 1
    assert not set(missing) & set(files)


def test_the_number_that_differs_is_the_frame_number(tmp_path: Path) -> None:
    """Not the last run of digits, where that is the same in every name."""
    folder_with(tmp_path, ["take2_frame1_v3.obj", "take2_frame2_v3.obj", "take2_frame4_v3.obj"])
    _, numbers, missing = found(tmp_path / "take*.obj")
    assert numbers == [1, 2, 4]
    assert missing == ["take2_frame3_v3.obj"]


def test_names_that_differ_in_their_words_go_by_their_last_number(tmp_path: Path) -> None:
    folder_with(tmp_path, ["1_neutral_00.obj", "1_half_05.obj", "1_smile_10.obj"])
    assert found(tmp_path)[:2] == (
        ["1_neutral_00.obj", "1_half_05.obj", "1_smile_10.obj"],
        [0, 5, 10],
    )


def test_a_folder_is_all_its_mesh_files_but_not_the_rest(tmp_path: Path) -> None:
    folder_with(tmp_path, ["a1.obj", "a2.OBJ", "notes.txt", "a.mtl", ".a3.obj", "preview1.png"])
    assert found(tmp_path)[0] == ["a1.obj", "a2.OBJ"]


def test_a_folder_of_mixed_formats_is_refused(tmp_path: Path) -> None:
    folder_with(tmp_path, ["a1.obj", "a2.obj", "a1.ply"])
    with pytest.raises(FormatError, match=r"several formats \(\.obj, \.ply\).*\*\.obj"):
        find_frames(tmp_path, SUFFIXES)


@pytest.mark.parametrize("pattern", ["*.obj", "."])
def test_files_without_a_number_are_refused(tmp_path: Path, pattern: str) -> None:
    folder_with(tmp_path, ["neutral.obj", "scan1.obj", "scan2.obj", "smile.obj"])
    with pytest.raises(FileError, match=r"neutral\.obj has no frame number.* 1 more"):
        find_frames(tmp_path / pattern, SUFFIXES)


@pytest.mark.parametrize("pattern", ["scan.##.obj", "*.obj", "."])
def test_two_files_with_one_number_are_refused(tmp_path: Path, pattern: str) -> None:
    folder_with(tmp_path, ["scan.1.obj", "scan.01.obj", "scan.2.obj"])
    with pytest.raises(FileError, match=r"scan\.01\.obj and scan\.1\.obj both have .* number 1"):
        find_frames(tmp_path / pattern, SUFFIXES)


def test_a_number_far_from_the_rest_is_refused_instead_of_naming_a_million_gaps(
    tmp_path: Path,
) -> None:
    folder_with(tmp_path, ["scan.1.obj", "scan.2.obj", "scan.20240131.obj"])
    with pytest.raises(FileError, match="from 1 to 20240131, but there are only 3 files"):
        find_frames(tmp_path / "scan.#.obj", SUFFIXES)


@pytest.mark.parametrize("pattern", ["scan.####.obj", "scan*.obj"])
def test_no_match_says_what_was_looked_for_and_what_is_there(tmp_path: Path, pattern: str) -> None:
    folder_with(tmp_path, [f"head_{n}.obj" for n in range(7)])
    with pytest.raises(FileError) as caught:
        find_frames(tmp_path / pattern, SUFFIXES)
    message = str(caught.value)
    assert f"no files called '{pattern}' in {tmp_path}" in message
    assert "7 files: head_0.obj, head_1.obj, head_2.obj, head_3.obj, head_4.obj, …" in message


def test_an_empty_or_missing_folder_is_said_to_be(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"no mesh files in .*, which holds no files"):
        find_frames(tmp_path, SUFFIXES)
    for pattern in ("missing/scan.##.obj", "missing/scan*.obj", "missing/scan.obj"):
        with pytest.raises(FileError, match=r"missing.*does not exist"):
            find_frames(tmp_path / pattern, SUFFIXES)


def test_one_frame_is_no_motion(tmp_path: Path) -> None:
    folder_with(tmp_path, ["scan.1.obj"])
    with pytest.raises(FileError, match=r"at least 2 frames, found only scan\.1\.obj"):
        find_frames(tmp_path / "scan.##.obj", SUFFIXES)
    with pytest.raises(FileError, match="this is one file"):
        find_frames(tmp_path / "scan.1.obj", SUFFIXES)


@pytest.mark.parametrize("name", ["scan.obj", "scan.##.##.obj", "a#b#.obj"])
def test_a_pattern_has_one_run_of_signs(name: str) -> None:
    with pytest.raises(FileError, match="one run of #"):
        frame_pattern(name)


def test_a_pattern_names_files_with_as_many_digits_as_it_has_signs() -> None:
    pattern = frame_pattern("takes/scan.###.obj")
    assert pattern.file(7) == Path("takes/scan.007.obj")
    assert pattern.file(12345) == Path("takes/scan.12345.obj")
