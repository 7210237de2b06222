"""The conformance kit says what elastomorph does: its vectors, its schema, and what it refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from kit import DOUBLE, REFUSED, SCHEMA, VECTORS, glb_of, require_same, strict_schema, written_now

import elastomorph as em
import small_head
from elastomorph.errors import ParameterError
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.io.gltf.rig_extras import stored_rig
from elastomorph.io.untrusted import MemoryBudget
from foreign_files import chunks_of

LOOSE = jsonschema.Draft202012Validator(SCHEMA)


def flat(content: Any, place: str = "") -> dict[str, Any]:
    """Every number, text and empty list of JSON by its place."""
    inner = content.items() if isinstance(content, dict) else enumerate(content)
    found: dict[str, Any] = {}
    for key, value in inner:
        here = f"{place}/{key}"
        found |= flat(value, here) if isinstance(value, dict | list) and value else {here: value}
    return found


def test_the_vectors_are_what_python_computes_now(tmp_path: Path) -> None:
    now = flat(written_now(tmp_path))
    kept = flat({**VECTORS, "refused": REFUSED})
    assert list(now) == list(now | kept)
    assert len(now) == len(kept)
    for place, value in kept.items():
        if type(value) is float:
            assert now[place] == pytest.approx(value, rel=DOUBLE, abs=DOUBLE), place
        else:
            assert now[place] == value, place


@pytest.mark.parametrize("name", VECTORS)
def test_positions_are_sums_of_targets(name: str) -> None:
    vector = VECTORS[name]
    targets = np.array(vector["targets"])
    assert len(targets) == len(vector["extras"]["targetNames"])
    for pose in vector["poses"]:
        moved = np.tensordot(pose["weights"], targets, axes=1)
        require_same(np.array(vector["neutral"]) + moved, pose["positions"], 1e-11)


def test_the_kit_has_what_is_hard() -> None:
    """Degrees 0 to 7, a hundred pieces, sliders below 0, above 1 and exactly at breaks."""
    curves = [
        bend["curve"]
        for vector in VECTORS.values()
        for morph in vector["extras"].get("elastomorph", {}).get("morphs", [])
        for bend in morph["bends"]
    ]
    assert {len(curve["coefficients"][0]) - 1 for curve in curves} >= set(range(8))
    assert max(len(curve["coefficients"]) for curve in curves) > 90
    asked = {v for p in VECTORS["pieces"]["poses"] for v in p["sliders"].values()}
    assert min(asked) < 0
    assert max(asked) > 1
    assert len(asked & {t for curve in curves for t in curve["breaks"]}) > 20


class TestPython:
    """The fourth runtime: a file read with the extras of a vector."""

    @pytest.mark.parametrize("name", VECTORS)
    def test_it_passes_the_vectors(self, name: str, tmp_path: Path) -> None:
        vector = VECTORS[name]
        rig = read_glb(glb_of(vector, tmp_path / "v.glb"))
        for pose in vector["poses"]:
            known = {s: value for s, value in pose["sliders"].items() if s in rig.sliders.names}
            require_same(rig.pose(known), pose["positions"], 1e-11)

    @pytest.mark.parametrize("entry", REFUSED, ids=lambda entry: entry["why"])
    def test_it_refuses_what_is_to_be_refused(self, entry: dict[str, Any]) -> None:
        extras = entry["extras"]
        names, budget = extras["targetNames"], MemoryBudget("a.glb", 1 << 20)
        with pytest.raises(ParameterError):
            stored_rig(extras["elastomorph"], names, budget, names)


class TestSchema:
    """The schema accepts what is written, and refuses what has another form."""

    def test_it_is_a_schema(self) -> None:
        jsonschema.Draft202012Validator.check_schema(SCHEMA)

    @pytest.mark.parametrize("name", [n for n in VECTORS if n != "plain"])
    def test_the_vectors_fit(self, name: str) -> None:
        LOOSE.validate(VECTORS[name]["extras"]["elastomorph"])

    def test_what_has_another_form_does_not(self) -> None:
        """All that is refused for more than names and order."""
        fitting = [e["why"] for e in REFUSED if LOOSE.is_valid(e["extras"]["elastomorph"])]
        about_names = ("exist", "twice", "no morph", "itself", "has which", "one name", "of a bend")
        about_curves = ("do not rise", "more breaks", "of different length", "that is not 0")
        others = [why for why in fitting if not any(w in why for w in about_names + about_curves)]
        assert not others
        assert len(fitting) < len(REFUSED) / 2

    def test_files_fit_and_have_no_key_that_is_not_told(self, tmp_path: Path) -> None:
        """Also one with polygons, texture coordinates, correctives, groups and settings."""
        neutral = small_head.head()
        morphs = {
            name: em.interpolate(neutral, small_head.shapes()[name], "auto")
            for name in ("jawOpen", "mouthSmile_L", "mouthFunnel")
        }
        rig = em.Rig(
            neutral,
            morphs,
            correctives={"mouthFunnel": ["jawOpen", "mouthSmile_L"]},
            groups={"jaw": ["jawOpen"]},
        )
        write_glb(tmp_path / "head.glb", rig, settings={"seed": 1})
        strict = strict_schema()
        written = chunks_of(tmp_path / "head.glb")[0]["meshes"][0]["extras"]["elastomorph"]
        assert {"correctives", "groups", "surface", "settings"} < written.keys()
        strict.validate(written)
        assert not strict.is_valid(written | {"more": 1})
