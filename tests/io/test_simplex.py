"""What drives shapes by the definition of Simplex."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.errors import ElastomorphWarning, FileError, FormatError

NAMES = ["jawOpen", "smile", "frown", "jawOpen_smile", "jawOpen_frown", "half"]


def definition(*combos: dict[str, Any]) -> dict[str, Any]:
    """A jaw, a mouth that smiles at 1 and frowns at -1, and combos of both."""
    progressions = [
        [[0, 0.0], [1, 1.0]],
        [[3, -1.0], [0, 0.0], [6, 0.5], [2, 1.0]],
        [[0, 0.0], [4, 1.0]],
        [[0, 0.0], [5, 1.0]],
    ]
    return {
        "encodingVersion": 3,
        "systemName": "Face",
        "shapes": [{"name": name} for name in ("Rest", *NAMES)],
        "progressions": [{"name": "", "pairs": own} for own in progressions],
        "sliders": [{"name": "jaw", "prog": 0}, {"name": "mouth", "prog": 1}],
        "combos": [{"name": f"combo{i}", **own} for i, own in enumerate(combos)],
    }


def combo(prog: int, jaw: float, mouth: float, **more: Any) -> dict[str, Any]:
    return {"prog": prog, "pairs": [[0, jaw], [1, mouth]], **more}


def read(folder: Path, content: Any, names: list[str] = NAMES) -> dict[str, em.Corrective]:
    file = folder / "face.json"
    file.write_text(json.dumps(content))
    return em.read_correctives(file, names)


def test_ends_of_sliders_are_targets(tmp_path: Path) -> None:
    """The negative end of a slider is a target of its own."""
    found = read(
        tmp_path,
        definition(combo(2, 1.0, 1.0, solveType="mulAvgAll"), combo(3, 1.0, -1.0, solveType=None)),
    )
    assert found == {
        "jawOpen_smile": em.Corrective(("jawOpen", "smile"), "mulAvgAll"),
        "jawOpen_frown": em.Corrective(("jawOpen", "frown"), "min"),
    }


@pytest.mark.parametrize("law", ["min", "allMul", "extMul", "mulAvgExt", "mulAvgAll", "None"])
def test_laws_go_by_their_names(tmp_path: Path, law: str) -> None:
    (found,) = read(tmp_path, definition(combo(2, 1.0, 1.0, solveType=law))).values()
    assert found.law == ("min" if law == "None" else law)


@pytest.mark.parametrize(
    ("own", "names", "why"),
    [
        (combo(2, 1.0, 0.5), NAMES, "between the ends"),
        (combo(2, 1.0, 0.0), NAMES, "between the ends"),
        (combo(2, 1.0, 1.0, enabled=False), NAMES, "switched off"),
        (combo(2, 1.0, 1.0), ["jawOpen", "smile"], "no target 'jawOpen_smile'"),
        (combo(2, 1.0, 1.0), ["jawOpen", "jawOpen_smile"], "no target 'smile'"),
    ],
)
def test_combos_that_no_law_can_drive_are_left_out_and_said(
    tmp_path: Path, own: dict[str, Any], names: list[str], why: str
) -> None:
    with pytest.warns(ElastomorphWarning, match=rf"face\.json: .*combo0 \({why}"):
        assert read(tmp_path, definition(own), names) == {}


def test_what_is_no_definition_is_refused(tmp_path: Path) -> None:
    older = {**definition(), "encodingVersion": 1}
    with pytest.raises(FormatError, match=r"face\.json: expected version 2 or 3, found 1"):
        read(tmp_path, older)
    with pytest.raises(FormatError, match="expected a definition by Simplex"):
        read(tmp_path, [1, 2])
    with pytest.raises(FormatError, match="expected a definition by Simplex"):
        read(tmp_path, definition(combo(9, 1.0, 1.0)))
    (tmp_path / "face.json").write_text('{"encodingVersion": 3, "sha')
    with pytest.raises(FormatError, match="expected a definition by Simplex"):
        em.read_correctives(tmp_path / "face.json", NAMES)
    with pytest.raises(FileError, match=r"none\.json"):
        em.read_correctives(tmp_path / "none.json", NAMES)


VALUES = st.none() | st.booleans() | st.integers(-9, 9) | st.floats() | st.text(max_size=3)
JSON = st.recursive(
    VALUES, lambda own: st.lists(own, max_size=3) | st.dictionaries(st.text(max_size=3), own)
)


@given(
    key=st.sampled_from(["shapes", "progressions", "sliders", "combos", "encodingVersion"]),
    value=JSON,
)
@pytest.mark.filterwarnings("ignore::elastomorph.errors.ElastomorphWarning")
def test_any_damage_is_one_error_of_ours(
    tmp_path_factory: pytest.TempPathFactory, key: str, value: Any
) -> None:
    damaged = {**definition(combo(2, 1.0, 1.0)), key: value}
    with suppress(FormatError):
        read(tmp_path_factory.getbasetemp(), damaged)


@given(place=st.sampled_from(["name", "prog", "pairs", "solveType", "enabled"]), value=JSON)
@pytest.mark.filterwarnings("ignore::elastomorph.errors.ElastomorphWarning")
def test_any_damage_of_a_combo_is_one_error_of_ours(
    tmp_path_factory: pytest.TempPathFactory, place: str, value: Any
) -> None:
    damaged = definition({**combo(2, 1.0, 1.0), place: value})
    with suppress(FormatError):
        read(tmp_path_factory.getbasetemp(), damaged)
