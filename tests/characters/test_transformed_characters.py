"""Bent characters keep their bends through every command of glTF-Transform that keeps targets.

Needs Node.js and the packages of ``web``.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import elastomorph as em
from character_makers import make
from character_variants import PACKAGES
from needs import node
from transformed import COMMANDS, outcome

pytestmark = [pytest.mark.slow, pytest.mark.players]  # a program starts for each command

# Commands that round positions: to 14 bits of a body 1.7 m high, of which D is a tenth.
ROUNDING = {"quantize", "meshopt", "optimize"}


@pytest.fixture(scope="module")
def bent(tmp_path_factory: pytest.TempPathFactory) -> Path:
    node(*PACKAGES)
    folder = tmp_path_factory.mktemp("transformed")
    out = folder / "bent.glb"
    em.bend(make("skinned", folder), out)
    return out


@pytest.mark.parametrize("command", [own for own in COMMANDS if own not in ROUNDING])
def test_nothing_is_gone(bent: Path, command: str, tmp_path: Path) -> None:
    found = outcome(bent, command, tmp_path)
    assert found.targets == (7, 7)
    assert found.bends[0] == found.bends[1] >= 7
    assert found.off <= 1e-12
    assert found.said == ()


@pytest.fixture(scope="module")
def exact(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Stored within so little that some bends are smaller than what is rounded away."""
    node(*PACKAGES)
    folder = tmp_path_factory.mktemp("exact")
    out = folder / "bent.glb"
    em.bend(make("skinned", folder), out, tolerance=1e-5)
    return out


@pytest.mark.parametrize("command", sorted(ROUNDING))
def test_bends_smaller_than_the_rounding_are_named(
    exact: Path, command: str, tmp_path: Path
) -> None:
    found = outcome(exact, command, tmp_path)
    assert found.targets == (7, 7)
    assert found.bends[0] == found.bends[1]
    assert found.off <= 1e-3
    (said,) = found.said
    assert re.search(r": 1 of 13 bends, such as '\w+\.bend2', move nothing: rounded away", said)


@pytest.mark.parametrize("command", ["copy", "prune", "draco"])
def test_bends_of_quantized_characters_are_not_emptied(command: str, tmp_path: Path) -> None:
    """Sparse arrays of fractions would be: glTF-Transform writes zeros in their place."""
    node(*PACKAGES)
    bent = tmp_path / "bent.glb"
    em.bend(make("quantized", tmp_path), bent)
    found = outcome(bent, command, tmp_path)
    assert found.bends[0] == found.bends[1] >= 7
    assert found.off <= 1e-12
    assert found.said == ()
