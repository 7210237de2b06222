"""Expressions of VRM 1.0 that override others: told where a file is inspected and bent."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import elastomorph as em
from character_makers import make
from elastomorph.cli import main
from elastomorph.errors import FormatError
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.io.gltf.vrm import overrides_note, overrides_of
from foreign_files import chunks_of, glb


def character(folder: Path, preset: dict[str, Any], custom: dict[str, Any] | None = None) -> Path:
    """Write a character of VRM 1.0 whose expressions say these things of others."""
    path = make("vrm1", folder)
    document, blob = chunks_of(path)
    expressions = document["extensions"]["VRMC_vrm"]["expressions"]
    for name, own in preset.items():
        expressions["preset"].setdefault(name, {}).update(own)
    expressions["custom"] |= custom or {}
    path.write_bytes(glb(document, blob))
    return path


def test_all_groups_and_expressions_are_told(tmp_path: Path) -> None:
    path = character(
        tmp_path,
        {"happy": {"overrideBlink": "blend", "overrideMouth": "block", "overrideLookAt": "none"}},
        {"shout": {"overrideLookAt": "block"}},
    )
    found = overrides_of(open_gltf(path))
    assert found == {"happy": {"blink": "blend", "mouth": "block"}, "shout": {"look": "block"}}
    assert "happy (blink: blend, mouth: block), shout (look: block);" in overrides_note(found)


def test_a_member_does_not_override_its_own_group(tmp_path: Path) -> None:
    path = character(
        tmp_path,
        {
            "blinkLeft": {"overrideBlink": "blend", "overrideMouth": "blend"},
            "aa": {"overrideMouth": "block"},
        },
    )
    assert overrides_of(open_gltf(path)) == {"blinkLeft": {"mouth": "blend"}}


@pytest.mark.parametrize("name", ["vrm0", "vrm1", "plain"])
def test_where_nothing_is_overridden_nothing_is_said(name: str, tmp_path: Path) -> None:
    path = make(name, tmp_path)
    assert overrides_of(open_gltf(path)) == {}
    assert em.bend(path, None).notes == ()


ANY = st.recursive(
    st.none() | st.integers(0, 9) | st.sampled_from(["blend", "block", ""]),
    lambda own: (
        st.lists(own, max_size=2)
        | st.dictionaries(st.sampled_from(["preset", "custom", "happy", "overrideBlink"]), own)
    ),
)


@given(expressions=ANY)
def test_what_is_not_as_vrm_says_is_not_there(expressions: Any) -> None:
    document = {"extensions": {"VRMC_vrm": {"expressions": expressions}}}
    found = overrides_of(GltfFile("a.vrm", document, None, 0, b""))
    assert all(own == {"blink": how} for own in found.values() for how in own.values())


def run(*words: object) -> None:
    with pytest.raises(SystemExit) as stopped:
        main([str(word) for word in words])
    assert not stopped.value.code


def test_inspect_and_bend_tell_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = character(tmp_path, {"happy": {"overrideBlink": "blend"}})
    told = "happy (blink: blend); players do so before they set morph targets"
    run("inspect", path)
    assert told in capsys.readouterr().out
    run("inspect", path, "--json")
    assert json.loads(capsys.readouterr().out)["overrides"] == {"happy": {"blink": "blend"}}
    run("bend", path, "-o", tmp_path / "bent.vrm")
    assert told in capsys.readouterr().out
    before, after = chunks_of(path)[0], chunks_of(tmp_path / "bent.vrm")[0]
    assert after["extensions"]["VRMC_vrm"] == before["extensions"]["VRMC_vrm"]
    assert told in em.bend(tmp_path / "bent.vrm", None).notes[0]


def test_they_are_no_correctives(tmp_path: Path) -> None:
    """Those follow targets, whose weights players set when overrides are done."""
    path = character(tmp_path, {"happy": {"overrideBlink": "blend"}})
    with pytest.raises(FormatError, match=r"vrm1\.vrm: players apply the overrides"):
        em.read_correctives(path, em.read_rig(path, method="linear").names)
