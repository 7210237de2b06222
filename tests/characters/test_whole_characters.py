"""Characters come out of `bend` whole, with their paths bent: everything that is promised of it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from acceptance.judging import Verdict, judge
from character_makers import RECIPES, make
from character_variants import PACKAGES, VARIANTS, variant
from needs import MODULES, node

# Targets had extras that glTF gives them no place for: each added one is found fault with too.
NOT_VALIDATED = ("old-names",)
HAS_VALIDATOR = shutil.which("node") is not None and (MODULES / "gltf-validator").is_dir()


def judged(path: Path, folder: Path, *, validator: bool) -> Verdict:
    found = judge(path, folder, validator=validator)
    assert not found.problems, "\n".join(found.problems[:10])
    assert found.bent >= 6
    assert found.targets[1] > found.targets[0]
    assert found.straight > 1e-2  # what would be lost on straight lines
    assert found.between < 2e-4
    return found


@pytest.mark.parametrize("name", RECIPES)
def test_a_character_is_whole_and_bent(name: str, tmp_path: Path) -> None:
    validator = HAS_VALIDATOR and name not in NOT_VALIDATED
    path = make(name, tmp_path)
    (tmp_path / "out").mkdir()
    found = judged(path, tmp_path / "out", validator=validator)
    assert found.ends <= 1e-12  # bends weigh nothing there; sums of more terms round otherwise
    assert bool(found.clips) == bool(RECIPES[name].clips)


def test_the_validator_is_asked(tmp_path: Path) -> None:
    """Where it is installed, it is not left out."""
    node("gltf-validator")
    assert HAS_VALIDATOR


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_what_gltf_transform_made_of_it_is_whole_and_bent(name: str, tmp_path: Path) -> None:
    node(*PACKAGES)
    if name in ("meshopt", "optimized"):
        pytest.importorskip("meshopt", reason="needs the package meshopt")
    if name == "draco":
        pytest.importorskip("DracoPy", reason="needs the package DracoPy")
    (tmp_path / "out").mkdir()
    path = variant(make("skinned", tmp_path), name, tmp_path)
    judged(path, tmp_path / "out", validator=True)
