"""A character goes in and comes out whole, with its paths bent."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io.gltf.container import open_gltf


@pytest.fixture(scope="module")
def head(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A few targets of the built-in head, straight, in a file of our own."""
    file = tmp_path_factory.mktemp("head") / "head.glb"
    rig = em.read_rig("built-in", method="linear").only(["jawOpen", "eyeBlink_L", "mouthPucker"])
    em.write(file, rig)
    return file


@pytest.fixture(scope="module")
def bent(head: Path) -> Path:
    file = head.with_name("bent.glb")
    em.bend(head, file)
    return file


def test_paths_of_a_bent_file_are_those_of_auto(head: Path, bent: Path) -> None:
    expected = em.read_rig(head, method="auto")
    found = em.read_rig(bent)
    assert found.names == expected.names
    scale = expected.neutral.diameter
    for name in expected.names:
        for t in (0.25, 0.5, 0.9):
            away = found.pose({name: t}) - expected.pose({name: t})
            assert np.abs(away).max() < 3e-4 * scale, name
    assert len(found.morphs["jawOpen"].bends)


def test_unbending_gives_back_the_document_and_its_bytes(head: Path, bent: Path) -> None:
    back = bent.with_name("back.glb")
    em.unbend(bent, back)
    original, found = open_gltf(head), open_gltf(back)
    assert found.document == original.document
    assert found.buffer(0) == original.buffer(0)
    with pytest.raises(em.FormatError, match="nothing to undo"):
        em.unbend(back, bent.with_name("twice.glb"))


def test_all_that_was_there_comes_first(head: Path, bent: Path) -> None:
    original, found = open_gltf(head), open_gltf(bent)
    bytes_before = bytes(original.buffer(0))
    assert bytes(found.buffer(0))[: len(bytes_before)] == bytes_before
    for kind in ("accessors", "bufferViews"):
        before = original.document[kind]
        assert found.document[kind][: len(before)] == before
        assert len(found.document[kind]) > len(before)
