"""A file cut off or changed anywhere is read or refused by an error of ours, soon and in bounds."""

from __future__ import annotations

import copy
import json
import os
import random
import tracemalloc
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from glb_samples import HandMade, chunks_of, glb, seamed_mesh, triangle_rig

from effort import worked
from elastomorph.errors import ElastomorphWarning, FormatError
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.io.untrusted import allowed_memory
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A small file with everything in it."""
    mesh = seamed_mesh()
    up = mesh.with_vertices(mesh.vertices * [1, 1, 3] + [0, 0, 1])
    morph = Morph(mesh, up, mesh.vertices[None] / 3, (BendCurve.power(2),))
    rig = Rig(
        mesh,
        {"a": morph, "b": morph, "c": morph},
        correctives={"c": ["a", "b"]},
        groups={"both": ["a", "b"]},
    )
    path = tmp_path_factory.mktemp("whole") / "whole.glb"
    write_glb(path, rig)
    return path.read_bytes()


@pytest.fixture(autouse=True)
def _seldom_warned() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ElastomorphWarning)
        yield


def refused(path: Path) -> bool:
    """Whether the file is refused; any other error, or two seconds, are a failure."""
    before = worked()
    try:
        read_glb(path)
    except FormatError as error:
        if str(path) not in str(error):
            raise
        return True
    finally:
        assert worked() - before < 2
    return False


def test_a_file_cut_off_at_any_byte_is_refused(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "cut.glb"
    path.write_bytes(whole)
    assert not refused(path)
    for length in reversed(range(len(whole))):
        os.truncate(path, length)
        assert refused(path), length


def test_a_file_with_any_byte_turned_around(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "turned.glb"
    for place in range(0, len(whole), 1 + len(whole) // 1500):
        changed = bytearray(whole)
        changed[place] ^= 0xFF
        path.write_bytes(changed)
        refused(path)


STRANGE: list[Any] = [
    *(None, True, False, 0, 1, 2, -1, 3, 5, 7, 255, 65535, 2**31, 2**63, 10**30, 1.5, -0.0, 1e308),
    *("", "x", "a", "2.0", "AAAA", [], {}, [0], [[]], {"x": 1}, [0, 1], [1e308, -1e308, 3]),
]


def places_in(value: Any) -> list[tuple[Any, Any]]:
    """Every container in a document, and every key or index of it."""
    found: list[tuple[Any, Any]] = []
    if isinstance(value, dict | list):
        keys = value.keys() if isinstance(value, dict) else range(len(value))
        for key in keys:
            found.append((value, key))
            found += places_in(value[key])
    return found


def test_a_document_with_any_value_replaced_or_left_out(tmp_path: Path, whole: bytes) -> None:
    """Each value in turn, by two strange ones and by none; the binary part stays."""
    path = tmp_path / "strange.glb"
    path.write_bytes(whole)
    document, blob = chunks_of(path)
    choice = random.Random(0)
    for holder, key in places_in(document):
        before = copy.copy(holder)
        for strange in choice.sample(STRANGE, 2):
            holder[key] = strange
            path.write_bytes(glb(document, blob))
            refused(path)
        del holder[key]
        path.write_bytes(glb(document, blob))
        refused(path)
        holder.clear()
        (holder.update if isinstance(holder, dict) else holder.extend)(before)
    path.write_bytes(glb(document, blob))
    assert not refused(path)


def many_vertices() -> HandMade:
    file = HandMade()
    file.primitive(attributes={"POSITION": file.array([[0.0, 0, 0]] * 60_000)})
    return file


def too_many_targets() -> HandMade:
    """Targets of zeros cost the file nothing, and the memory a vertex each."""
    file = many_vertices()
    empty = file.accessor(componentType=5126, count=60_000, type="VEC3")
    file.document["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": empty}] * 3000
    return file


def targets_of_nothing() -> HandMade:
    file = many_vertices()
    file.document["meshes"][0]["primitives"][0]["targets"] = [{}] * 50_000
    return file


def targets_of_nothing_shown_often() -> HandMade:
    file = too_many_nodes()
    file.document["accessors"][0]["count"] = 3
    file.document["meshes"][0]["primitives"][0]["targets"] = [{}] * 10_000
    return file


def targets_of_one_name() -> HandMade:
    file = targets_of_nothing()
    file.document["meshes"][0]["extras"] = {"targetNames": ["smile"] * 50_000}
    return file


def too_many_nodes() -> HandMade:
    """A mesh that is shown ten thousand times."""
    file = many_vertices()
    file.document["nodes"] = [{"mesh": 0} for _ in range(10_000)]
    file.document["scenes"][0]["nodes"] = list(range(10_000))
    return file


def one_byte_for_all() -> HandMade:
    """Primitives whose accessors all lie on the same bytes."""
    file = many_vertices()
    view = file.document["accessors"][0]
    for shift in range(10_000):
        number = file.accessor(**{**view, "count": 30_000, "byteOffset": 4 * shift})
        file.primitive(attributes={"POSITION": number})
    return file


@pytest.mark.parametrize(
    "made",
    [
        too_many_targets,
        targets_of_nothing,
        targets_of_one_name,
        targets_of_nothing_shown_often,
        too_many_nodes,
        one_byte_for_all,
    ],
)
def test_a_small_file_cannot_fill_the_memory(tmp_path: Path, made: Any) -> None:
    path = made().write(tmp_path / "a.glb")
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="made to harm"):
            read_glb(path)
        assert tracemalloc.get_traced_memory()[1] < allowed_memory(path.stat().st_size)
    finally:
        tracemalloc.stop()


def test_an_absurd_count_is_refused_before_anything_is_allocated(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", triangle_rig())
    document, blob = chunks_of(tmp_path / "a.glb")
    for number in range(len(document["accessors"])):
        changed = json.loads(json.dumps(document))
        changed["accessors"][number]["count"] = 10**11
        path = tmp_path / "absurd.glb"
        path.write_bytes(glb(changed, blob))
        tracemalloc.start()
        try:
            refused(path)
            assert tracemalloc.get_traced_memory()[1] < 2 << 20
        finally:
            tracemalloc.stop()
