"""Compressed files opened by the page itself: the same vertices as Python reads, in their order."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from faces import distances
from test_broken_files import choose
from visiting import COARSE, Visit, positions, update, wait

import elastomorph as em
from character_makers import make
from character_variants import PACKAGES, transformed
from elastomorph.io.gltf import read_glb
from elastomorph.viewer import rig_scene
from needs import node

if TYPE_CHECKING:
    from playwright.sync_api import Page

WAYS = ("meshopt", "draco", "quantize", "sparse")


@pytest.fixture(scope="module")
def characters(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A character with joints and a body, as glTF-Transform compresses it."""
    node(*PACKAGES)
    folder = tmp_path_factory.mktemp("compressed")
    plain = make("skinned", folder)
    return {way: transformed(plain, folder / f"{way}.glb", way) for way in WAYS}


@pytest.fixture
def page(visit: Visit) -> Page:
    """One with the policy that forbids scripts of others, as every page that is written has."""
    square = em.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    rig = em.Rig(square, {"up": square.with_vertices(square.vertices + [0, 0, 0.1])})
    return visit(rig_scene(rig, curves=em.CurveNetwork([], 4)), **COARSE)


@pytest.mark.parametrize("way", WAYS)
def test_a_compressed_file_is_what_python_reads(
    page: Page, characters: dict[str, Path], way: str
) -> None:
    rig = read_glb(characters[way])
    choose(page, "packed.glb", characters[way].read_bytes())
    wait(page, "elastomorph.models()[0].name === 'packed'")
    count = len(rig.neutral.vertices)
    assert page.evaluate("elastomorph.models()[0].vertices") == count
    assert distances(positions(page, 0, count), rig.neutral.vertices).max() < 1e-6
    for name in rig.morphs:
        assert page.get_by_role("slider", name=name, exact=True).count() == 1
        update(page, weights={name: 1.0}, t=1, clip=None, playing=False)
        found = positions(page, 0, count)
        assert distances(found, rig.pose({name: 1.0})).max() < 1e-6


def document_of(content: bytes) -> dict[str, Any]:
    (length,) = struct.unpack_from("<I", content, 12)
    found: dict[str, Any] = json.loads(content[20 : 20 + length])
    return found


def with_document(content: bytes, document: dict[str, Any]) -> bytes:
    (length,) = struct.unpack_from("<I", content, 12)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    whole = struct.pack("<I4s", len(text), b"JSON") + text + content[20 + length :]
    return struct.pack("<4sII", b"glTF", 2, 12 + len(whole)) + whole


def _streams(document: dict[str, Any]) -> list[dict[str, Any]]:
    """What says where the streams of a file are."""
    packed = [
        own["extensions"]["EXT_meshopt_compression"]
        for own in document["bufferViews"]
        if "extensions" in own
    ]
    draco = [
        document["bufferViews"][primitive["extensions"]["KHR_draco_mesh_compression"]["bufferView"]]
        for mesh in document["meshes"]
        for primitive in mesh["primitives"]
        if "extensions" in primitive
    ]
    return packed + draco


def _cut_off(document: dict[str, Any]) -> None:
    for stream in _streams(document):
        stream["byteLength"] //= 2


def _elsewhere(document: dict[str, Any]) -> None:
    for stream in _streams(document):
        stream["byteOffset"] = 10**9


def _endless(document: dict[str, Any]) -> None:
    """More memory than there is, said of a few bytes."""
    for stream in _streams(document):
        if "count" in stream:
            stream["count"] = 2**40
    for accessor in document["accessors"]:
        accessor["count"] = 2**40
    for view in document["bufferViews"]:
        if "extensions" in view:
            view["byteLength"] = 2**40 * view["extensions"]["EXT_meshopt_compression"]["byteStride"]


def _one_more(document: dict[str, Any]) -> None:
    for accessor in document["accessors"]:
        accessor["count"] += 1


@pytest.mark.parametrize("way", ["meshopt", "draco"])
def test_what_cannot_be_unpacked_is_one_sentence(
    page: Page, characters: dict[str, Path], way: str
) -> None:
    content = characters[way].read_bytes()
    cases: dict[Callable[[dict[str, Any]], None], str] = {
        _cut_off: "is damaged",
        _elsewhere: "reaches beyond its buffer",
        _endless: "MiB of memory",
        _one_more: "announces" if way == "draco" else "do not fit",
    }
    for damage, problem in cases.items():
        document = document_of(content)
        damage(document)
        choose(page, "packed.glb", with_document(content, document))
        message = page.get_by_role("alert").locator(".message")
        message.wait_for()
        words = message.inner_text()
        assert words.startswith("packed.glb: ")
        assert problem in words, words
        assert "xport it again" in words
        page.keyboard.press("Escape")
        message.wait_for(state="detached")
    assert page.evaluate("elastomorph.models()[0].vertices") == 4


@pytest.mark.parametrize("way", ["meshopt", "draco"])
def test_changed_streams_never_stop_the_page(
    page: Page, characters: dict[str, Path], way: str
) -> None:
    """Some changes only change numbers; all others are told."""
    content = bytearray(characters[way].read_bytes())
    document = document_of(bytes(content))
    (length,) = struct.unpack_from("<I", content, 12)
    rng = np.random.default_rng(3)
    for _ in range(6):
        changed = content.copy()
        for stream in _streams(document):
            start = 28 + length + stream.get("byteOffset", 0)
            for place in rng.integers(start, start + stream["byteLength"], 4):
                changed[place] = rng.integers(256)
        choose(page, "changed.glb", bytes(changed))
        wait(
            page, "document.querySelector('.message') || elastomorph.models()[0].name === 'changed'"
        )
        page.keyboard.press("Escape")
