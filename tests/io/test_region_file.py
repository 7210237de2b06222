"""Regions from files and from ranges."""

from __future__ import annotations

from pathlib import Path

import pytest

from elastomorph.errors import ElastomorphError, FormatError, ParameterError
from elastomorph.io.vertex_lists import read_region


def test_ranges_and_files_say_the_same(tmp_path: Path) -> None:
    plain, named = tmp_path / "a.json", tmp_path / "b.json"
    plain.write_text("[3, 4, 5, 9]")
    named.write_text('{"vertices": [3, 4, 5, 9]}')
    for region in ("3-5,9", plain, str(named)):
        assert read_region(region).tolist() == [3, 4, 5, 9]


@pytest.mark.parametrize("text", ["", "a", "3-", "5-3", "-2", "1,,2", "0-99999999999", "1.5"])
def test_ranges_that_are_none(text: str) -> None:
    with pytest.raises(ParameterError, match="range"):
        read_region(text)


@pytest.mark.parametrize("text", ["", "{}", "[1.5]", "[true]", "[-1]", "[" * 100_000, "7"])
def test_files_that_hold_no_region(text: str, tmp_path: Path) -> None:
    file = tmp_path / "region.json"
    file.write_text(text)
    with pytest.raises(FormatError, match=r"region\.json"):
        read_region(file)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(ElastomorphError, match=r"no\.json"):
        read_region(tmp_path / "no.json")
