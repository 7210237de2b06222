"""Which meshes of a file are read: all that is shown, or what is named."""

from __future__ import annotations

import json

import pytest

from elastomorph.errors import ParameterError
from elastomorph.io.choices import (
    ListedMesh,
    choice_from_json,
    choice_to_json,
    chosen_meshes,
    wanted_names,
)
from elastomorph.model.morph import Choice

HEAD = ListedMesh(("/a/head", "head"), 5)
HAIR = ListedMesh(("/a/hair", "hair"), 0)
OLD = ListedMesh(("/old/head", "head"), 3, shown=False)
GUIDE = ListedMesh(("/guide",), 0, shown=False)


@pytest.mark.parametrize(
    ("meshes", "wanted", "expected"),
    [
        ([HEAD, HAIR, OLD, GUIDE], [], [0, 1]),
        ([HAIR, OLD, GUIDE], [], [0, 1]),
        ([HEAD, HAIR, OLD], ["head"], [0, 2]),
        ([HEAD, HAIR, OLD], ["/old/head"], [2]),
        ([HEAD, HAIR, OLD], ["hair", "/a/head"], [0, 1]),
        ([HEAD, GUIDE], ["/guide"], [1]),
    ],
)
def test_what_is_read(meshes: list[ListedMesh], wanted: list[str], expected: list[int]) -> None:
    """Hidden ones only where they are named, or where nothing else moves."""
    assert chosen_meshes(meshes, wanted) == expected


def test_what_is_not_there_is_listed() -> None:
    with pytest.raises(ParameterError, match=r"called 'nose'; there are '/a/head' \(5 shapes\)"):
        chosen_meshes([HEAD, HAIR], ["head", "nose"])
    with pytest.raises(ParameterError, match=r"no mesh has blend shapes; .*'/a/hair' \(no shapes"):
        chosen_meshes([HAIR], [])
    assert chosen_meshes([HAIR], [], need_shapes=False) == [0]


def test_names_are_one_or_several() -> None:
    assert wanted_names(None) == ()
    assert wanted_names("head") == ("head",)
    assert wanted_names(["head", "hair"]) == ("head", "hair")
    with pytest.raises(ParameterError, match="at least one"):
        wanted_names([])


def test_a_choice_is_the_same_from_a_file() -> None:
    """With what it counts; files without counts are read, and negative ones are damaged."""
    for choice in (Choice(0.1, 5e-4), Choice(0.0, 5e-4, False, 3, 4, 5, 6, 7e-4)):
        assert choice_from_json(json.loads(json.dumps(choice_to_json(choice)))) == choice
    stored = choice_to_json(Choice(0.1, 5e-4, shrunk=2))
    assert stored is not None
    assert "hidden" not in stored
    for wrong in (
        {**stored, "shrunk": -1},
        {**stored, "hidden": "many"},
        {**stored, "deeper": -1e-4},
        ["distance"],
    ):
        with pytest.raises(ParameterError):
            choice_from_json(wrong)


def test_a_choice_tells_what_was_eased_and_what_is_left() -> None:
    assert Choice(0.01, 5e-4, deeper=4e-5, crossing=3).text == Choice(0.01, 5e-4).text
    told = Choice(0.01, 5e-4, eased=1063, crossing=4, deeper=7.8e-4)
    for words in ("1,063 vertices bend less", "0.078 % of D deeper, 4 vertices cross"):
        assert words in told.passing
    assert told.text.endswith(f"; {told.passing}")
    assert "cross" not in Choice(0.01, 5e-4, deeper=7e-4).text
