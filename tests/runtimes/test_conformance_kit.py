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
from acceptance.runtime import bent_weights
from elastomorph.errors import ParameterError
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.io.gltf.rig_extras import stored_rig
from elastomorph.io.untrusted import MemoryBudget
from elastomorph.rig.laws import LAWS
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


@pytest.mark.parametrize("name", VECTORS)
def test_weights_are_those_of_the_page(name: str) -> None:
    """Computed from docs/extras.md alone: without a line of the package."""
    extras = VECTORS[name]["extras"]
    stored, names = extras.get("elastomorph"), extras["targetNames"]
    for pose in VECTORS[name]["poses"]:
        expected = bent_weights(stored, names, pose["sliders"])
        require_same(pose["weights"], expected, DOUBLE)


def test_the_kit_has_every_law() -> None:
    """Each alone at work, of drivers below 0, above 1, alike, and at the kink of a hinge."""
    described = VECTORS["laws"]["extras"]["elastomorph"]
    assert {own.get("law", "product") for own in described["correctives"]} == LAWS.keys()
    drivers = [own["drivers"] for own in described["correctives"]]
    assert {("a", "b"), ("c", "b", "a"), ("b",), ("a", "a")} < {tuple(own) for own in drivers}
    (hinge,) = (own for own in described["correctives"] if own["name"] == "hinge a b")
    asked = [pose["sliders"] for pose in VECTORS["laws"]["poses"] if "c" in pose["sliders"]]
    said = [hinge["gains"][0] * own["a"] + hinge["gains"][1] * own["b"] for own in asked]
    assert min(said) < 1 < max(said)
    assert 1.0 in said
    assert any(own["a"] == own["b"] != own["c"] for own in asked)
    assert min(own["a"] for own in asked) < 0
    assert max(own["a"] for own in asked) > 1


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
        about_drivers = ("gains for", "with a slider", "its own driver")
        about = about_names + about_curves + about_drivers
        others = [why for why in fitting if not any(words in why for words in about)]
        assert not others
        assert len(fitting) < len(REFUSED) / 2

    def test_files_fit_and_have_no_key_that_is_not_told(self, tmp_path: Path) -> None:
        """Also one with polygons, texture coordinates, laws, a pair bend, groups and settings."""
        neutral = small_head.head()
        morphs = {
            name: em.interpolate(neutral, small_head.shapes()[name], "auto")
            for name in ("jawOpen", "mouthSmile_L", "mouthFunnel")
        }
        bend = 0.1 * morphs["jawOpen"].delta[None]
        morphs["pair"] = em.Morph(neutral, neutral, bend, (em.BendCurve.power(2),))
        drivers = ("jawOpen", "mouthSmile_L")
        rig = em.Rig(
            neutral,
            morphs,
            correctives={
                "mouthFunnel": em.Corrective(drivers, "hinge", (1.0, 0.5)),
                "pair": em.Corrective(drivers, "softmin", (8.0,)),
            },
            groups={"jaw": ["jawOpen"]},
        )
        write_glb(tmp_path / "head.glb", rig, settings={"seed": 1})
        strict = strict_schema()
        written = chunks_of(tmp_path / "head.glb")[0]["meshes"][0]["extras"]["elastomorph"]
        assert {"correctives", "groups", "surface", "settings"} < written.keys()
        assert written["version"] == 3
        assert "target" not in written["morphs"][-1]
        strict.validate(written)
        assert not strict.is_valid(written | {"more": 1})
