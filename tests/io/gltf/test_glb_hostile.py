"""glTF files made to harm: nested, crowded, contradicting what elastomorph left in them."""

from __future__ import annotations

import copy
import json
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import SHARED_VERTICES, SQUARE, HandMade, chunks_of, glb, seamed_mesh, square

from elastomorph.errors import ElastomorphWarning, FileError, FormatError
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.io.gltf.mesh_extras import packed
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig

TOO_MUCH = "would take more memory than"
POINT = {"attributes": {"POSITION": 0}}


@contextmanager
def soon() -> Iterator[None]:
    """In some seconds of processor time, where a search of all for each took minutes."""
    start = time.process_time()
    yield
    assert time.process_time() - start < 5


def nested(depth: int) -> bytes:
    return b"[" * depth + b"]" * depth


@pytest.mark.parametrize("place", ["POSITION", "TEXCOORD_0", "target", "uri", "mesh", "extras"])
def test_values_nested_as_deeply_as_json_can_be(tmp_path: Path, place: str) -> None:
    """What can just be read may be too deep to be looked at; wherever it stands, it is refused."""
    file = square()
    primitive = file.document["meshes"][0]["primitives"][0]
    holders = {
        "POSITION": (primitive["attributes"], "POSITION"),
        "TEXCOORD_0": (primitive["attributes"], "TEXCOORD_0"),
        "target": (primitive["targets"][0], "POSITION"),
        "uri": (file.document, "scene"),
        "mesh": (file.document["nodes"][0], "mesh"),
        "extras": (file.document["meshes"][0], "extras"),
    }
    file.document["buffers"] = [{"byteLength": len(file.blob)}]
    holder, key = holders[place]
    holder[key] = "DEEP"
    text = json.dumps(file.document).encode()
    path = tmp_path / "deep.glb"
    for depth in (10, 100, *range(880, 1000, 4), 100_000):
        deep = text.replace(b'"DEEP"', nested(depth))
        path.write_bytes(glb_of_text(deep, file.blob))
        if place == "extras" and depth < 800:
            assert len(read_glb(path).neutral.vertices) == 4
            continue
        if place == "extras" and depth < 1000:  # passed over, or too deep for this stack
            with suppress(FormatError):
                read_glb(path)
            continue
        with pytest.raises(FormatError) as caught:
            read_glb(path)
        assert str(path) in str(caught.value)
        assert len(str(caught.value)) < 400


def glb_of_text(text: bytes, blob: bytes) -> bytes:
    """A container of a document that is text already."""
    whole = glb({"HERE": 0}, blob)
    plain = json.dumps({"HERE": 0}).encode()
    plain += b" " * (-len(plain) % 4)
    text += b" " * (-len(text) % 4)
    parts = bytearray(whole.replace(plain, text))
    parts[8:12] = len(parts).to_bytes(4, "little")
    parts[12:16] = len(text).to_bytes(4, "little")
    return bytes(parts)


@pytest.mark.parametrize("half", ["\\ud800", "\\udfff", "x\\uDBFF!", "\\udc00\\ud800"])
def test_half_a_character_is_refused(tmp_path: Path, half: str) -> None:
    """No file and no terminal can hold such a name."""
    file = square()
    file.document["meshes"][0]["extras"] = {"targetNames": ["NAME"]}
    file.document["buffers"] = [{"byteLength": len(file.blob)}]
    text = json.dumps(file.document)
    path = tmp_path / "a.glb"
    path.write_bytes(glb_of_text(text.replace("NAME", half).encode(), file.blob))
    with pytest.raises(FormatError, match="half a character"):
        read_glb(path)
    path.write_bytes(glb_of_text(text.replace("NAME", "\\ud83d\\ude00").encode(), file.blob))
    assert read_glb(path).names == ("\U0001f600",)
    path.write_bytes(glb_of_text(text.replace("NAME", "\\\\ud800").encode(), file.blob))
    assert read_glb(path).names == ("\\ud800",)


def crowd(**parts: Any) -> HandMade:
    """A mesh of three vertices, and accessor 1 of zeros that takes nothing in the file."""
    file = HandMade()
    file.primitive(attributes={"POSITION": file.array(np.eye(3))})
    file.accessor(componentType=5126, count=3, type="VEC3")
    file.document.update(parts)
    return file


def with_targets(target: dict[str, int], count: int) -> HandMade:
    file = crowd()
    file.document["meshes"][0]["primitives"][0]["targets"] = [target] * count
    return file


@pytest.mark.parametrize(
    "file",
    [
        crowd(nodes=[{"mesh": 0}] * 50_000, scenes=[{"nodes": list(range(50_000))}]),
        crowd(meshes=[{"primitives": [POINT] * 28_000}]),
        crowd(meshes=[{"primitives": [POINT]}] * 20_000, nodes=[], scenes=[]),
        with_targets({"POSITION": 1}, 50_000),
        with_targets({"POSITION": 0}, 50_000),
        with_targets({}, 300_000),
    ],
    ids=["nodes", "primitives", "meshes", "targets", "moving targets", "empty targets"],
)
def test_very_many_of_very_little_is_refused_soon(tmp_path: Path, file: HandMade) -> None:
    """Each takes a few bytes in the file, and a tenth of a millisecond and kilobytes to read."""
    path = file.write(tmp_path / "a.glb")
    with soon(), pytest.raises(FormatError, match=TOO_MUCH):
        read_glb(path)


def test_very_many_materials_are_told_apart_soon(tmp_path: Path) -> None:
    """A name is looked up, not searched for among all the others."""
    count = 6000
    file = crowd(
        meshes=[{"primitives": [{**POINT, "material": i} for i in range(count)]}],
        materials=[{"name": f"m{i}"} for i in range(count)],
    )
    with soon():
        rig = read_glb(file.write(tmp_path / "a.glb"))
    assert rig.neutral.materials is not None
    assert rig.neutral.materials.of_face.tolist() == list(range(count))


def one_view_a_buffer(uri: str, count: int) -> dict[str, Any]:
    view = {"componentType": 5126, "count": 3, "type": "VEC3"}
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36 + i, "uri": uri} for i in range(count)],
        "bufferViews": [{"buffer": i, "byteLength": 36} for i in range(count)],
        "accessors": [{"bufferView": i, **view} for i in range(count)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": i}} for i in range(count)]}],
    }


def test_a_file_beside_it_is_read_once_however_often_it_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "big.bin").write_bytes(bytes(500_000))
    path = tmp_path / "a.gltf"
    path.write_text(json.dumps(one_view_a_buffer("big.bin", 500)))
    opened: list[Path] = []
    from elastomorph.io.gltf import container

    real = container.read_bytes
    monkeypatch.setattr(container, "read_bytes", lambda p: opened.append(p) or real(p))
    with soon():
        rig = read_glb(path)
    assert len(rig.neutral.vertices) == 1500
    assert [p.name for p in opened] == ["a.gltf", "big.bin"]


@pytest.mark.parametrize("name", ["gone.bin", "folder.bin"])
def test_a_file_beside_it_that_cannot_be_read_is_an_error_of_both(
    tmp_path: Path, name: str
) -> None:
    (tmp_path / "folder.bin").mkdir()
    path = tmp_path / "a.gltf"
    path.write_text(json.dumps(one_view_a_buffer(name, 1)))
    with pytest.raises(FileError, match=rf"a\.gltf: it needs \"{name}\", but ") as caught:
        read_glb(path)
    assert caught.value.path == path


def test_a_link_to_itself_beside_it_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "loop.bin").symlink_to("loop.bin")
    path = tmp_path / "a.gltf"
    path.write_text(json.dumps(one_view_a_buffer("loop.bin", 1)))
    with pytest.raises(FileError, match=r"a\.gltf: .*(no file in its own folder|cannot be read)"):
        read_glb(path)


@pytest.fixture(scope="module", params=["a mesh a material", "shared vertices"])
def own(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[dict[str, Any], bytes]:
    """The parts of a file that elastomorph wrote, now or before."""
    if request.param == "shared vertices":
        return chunks_of(SHARED_VERTICES)
    mesh = seamed_mesh()
    up = mesh.with_vertices(mesh.vertices + [0, 0, 1])
    morph = Morph(mesh, up, np.zeros((0, *mesh.vertices.shape)), ())
    path = tmp_path_factory.mktemp("own") / "own.glb"
    write_glb(path, Rig(mesh, {"a": morph, "b": morph}, groups={"g": ["a", "b"]}))
    return chunks_of(path)


def changed(own: tuple[dict[str, Any], bytes], path: Path, *keys: Any, value: Any) -> Path:
    """The file with one thing replaced that elastomorph left in it."""
    document = copy.deepcopy(own[0])
    holder = document["meshes"][0]["extras"]["elastomorph"]
    if "whole" in holder and keys[0] in ("surface", "groups"):
        holder = holder["whole"]
    for key in keys[:-1]:
        holder = holder[key]
    holder[keys[-1]] = value
    path.write_bytes(glb(document, own[1]))
    return path


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (("surface", "sizes"), packed([2**31 - 1, 2**31 - 1, 2**31 - 1])),
        (("surface", "sizes"), packed([2**31 - 1, 4, 3])),
        (("surface", "sizes"), packed([4, 4, 4])),
        (("surface", "parts"), [2**70, 0, 1]),
        (("surface", "parts"), [0, 0, 0]),
        (("surface", "uv", "coordinates"), [[[[]]]]),
        (("surface", "uv", "coordinates"), ["A"] * 200_000),
        (("morphs", 0, "limit_law", "coefficients"), [[0.0] * 200_000]),
        (("morphs", 0, "limit_law", "coefficients"), []),
        (("morphs", 0, "limit_law", "coefficients"), {}),
        (("morphs", 0, "limit_law", "breaks"), [0, 10**400]),
        (("groups",), [{"name": "g", "members": ["x" * 900_000]}]),
    ],
)
def test_what_no_longer_fits_the_mesh_is_passed_over_with_a_warning(
    tmp_path: Path, own: tuple[dict[str, Any], bytes], keys: tuple[Any, ...], value: Any
) -> None:
    """Polygons of two thousand million corners are refused before there is room made for them."""
    path = changed(own, tmp_path / "a.glb", *keys, value=value)
    with soon(), pytest.warns(ElastomorphWarning, match="no longer fits it") as warned:
        rig = read_glb(path)
    assert tuple(name for name in rig.names if name != "a.bend1") == ("a", "b")
    assert len(rig.neutral.vertices) >= 7
    assert all(len(str(one.message)) < 1000 + len(str(path)) for one in warned)


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (("part", "vertices"), packed([0, 1, 2**31 - 1, 3])),
        (("part", "vertices"), packed([0, 1, 4, 2])),
        (("part", "vertices"), packed([1] * 2**16)),
        (("part", "number"), "1"),
        (("part", "number"), 1),
        (("whole", "vertices"), 2**60),
        (("whole", "vertices"), -1),
        (("whole", "parts"), 2),
        (("whole", "targets"), [[]]),
        (("whole", "targets"), {}),
        (("whole", "groups"), 7),
        (("whole",), []),
    ],
)
def test_meshes_that_do_not_make_one_face_are_read_one_by_one(
    tmp_path: Path, keys: tuple[Any, ...], value: Any
) -> None:
    mesh = seamed_mesh()
    up = mesh.with_vertices(mesh.vertices + [0, 0, 1])
    rig = Rig(mesh, {"a": Morph(mesh, up, np.zeros((0, *mesh.vertices.shape)), ())})
    write_glb(tmp_path / "a.glb", rig)
    path = changed(chunks_of(tmp_path / "a.glb"), tmp_path / "b.glb", *keys, value=value)
    with soon(), warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        found = read_glb(path)
    assert found.names == ("a",)
    np.testing.assert_allclose(found.morphs["a"].delta, [[0, 0, 1]] * len(found.neutral.vertices))


def test_polygons_of_many_parts_are_restored_as_of_few(
    tmp_path: Path, own: tuple[dict[str, Any], bytes]
) -> None:
    path = tmp_path / "a.glb"
    path.write_bytes(glb(*own))
    mesh = seamed_mesh()
    found = read_glb(path).neutral
    assert found.faces == mesh.faces
    assert found.materials is not None
    assert mesh.materials is not None
    np.testing.assert_array_equal(found.materials.of_face, mesh.materials.of_face)


def test_groups_that_would_be_looked_up_without_end_are_refused(
    tmp_path: Path, own: tuple[dict[str, Any], bytes]
) -> None:
    """Every member of every group is looked up among the names of all morphs."""
    document = copy.deepcopy(own[0])
    mesh = document["meshes"][0]
    names = [f"m{i}" for i in range(3000)]
    place = mesh["primitives"][0]["targets"][0]["POSITION"]
    for primitive in mesh["primitives"]:
        primitive["targets"] = [{"POSITION": place}] * len(names)
    mesh["extras"] = {
        "targetNames": names,
        "elastomorph": {
            "version": 1,
            "morphs": [],
            "groups": [{"name": "g", "members": [names[-1]] * 100_000}],
        },
    }
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document, own[1]))
    with soon(), pytest.raises(FormatError, match=TOO_MUCH):
        read_glb(path)


@pytest.mark.parametrize("name", ["X" * 5000, "KHR_draco" + "x" * 5000])
def test_an_extension_with_an_endless_name(tmp_path: Path, name: str) -> None:
    file = square()
    file.document["extensionsRequired"] = [name]
    with pytest.raises(FormatError) as caught:
        read_glb(file.write(tmp_path / "a.glb"))
    assert len(str(caught.value)) < 400


def test_a_link_to_the_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    whole = square().write(tmp_path / "elsewhere" / "a.glb")
    (tmp_path / "link.glb").symlink_to(whole)
    np.testing.assert_array_equal(read_glb(tmp_path / "link.glb").neutral.vertices, SQUARE)


def document_of(file: HandMade) -> dict[str, Any]:
    file.document["buffers"] = [{"byteLength": len(file.blob)}]
    return file.document


def sparse(file: HandMade, **fields: Any) -> dict[str, Any]:
    """The sparse part of a new target of the square: one place and its value."""
    accessor = file.document["accessors"][file.array(np.zeros((4, 3)))]
    places, values = file.view(b"\2\0"), file.view(np.ones((1, 3), "<f4").tobytes())
    accessor["sparse"] = {
        "count": 1,
        "indices": {"bufferView": places, "componentType": 5123},
        "values": {"bufferView": values},
        **fields,
    }
    target = {"POSITION": len(file.document["accessors"]) - 1}
    file.document["meshes"][0]["primitives"][0]["targets"].append(target)
    return accessor


def a_sparse_count_beyond_the_vertices(file: HandMade) -> None:
    sparse(file, count=5)


def sparse_places_of_floats(file: HandMade) -> None:
    accessor = sparse(file)
    accessor["sparse"]["indices"]["componentType"] = 5126


def normalised_floats(file: HandMade) -> None:
    file.document["accessors"][0]["normalized"] = True


def a_uri_that_is_a_number(file: HandMade) -> None:
    file.document["buffers"] = [{"byteLength": len(file.blob), "uri": 5}]


def a_uri_that_cannot_be_a_path(file: HandMade) -> None:
    file.document["buffers"] = [{"byteLength": len(file.blob), "uri": "a" * 5000}]


def an_index_of_endless_digits(file: HandMade) -> None:
    file.document["nodes"][0]["mesh"] = 10**300


def an_extension_without_a_name(file: HandMade) -> None:
    file.document["extensionsRequired"] = [5]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (a_sparse_count_beyond_the_vertices, "has 4 elements, and 5 sparse ones of them"),
        (sparse_places_of_floats, "places that are no whole numbers"),
        (normalised_floats, "holds normalised floats, which do not exist"),
        (a_uri_that_is_a_number, "the URI of buffer 0 is no text"),
        (a_uri_that_cannot_be_a_path, "no file in its own folder|File name too long"),
        (an_index_of_endless_digits, "names number a number too large to show of 1 meshes"),
        (an_extension_without_a_name, "a required extension has no name"),
    ],
)
def test_what_contradicts_itself_is_refused(tmp_path: Path, change: Any, words: str) -> None:
    file = square()
    path = tmp_path / "a.glb"
    document_of(file)
    change(file)
    file.document["buffers"][0]["byteLength"] = len(file.blob)
    path.write_bytes(glb(file.document, file.blob))
    with pytest.raises(FileError, match=words) as caught:
        read_glb(path)
    assert caught.value.path == path


def test_a_sparse_target_is_read(tmp_path: Path) -> None:
    file = square()
    sparse(file)
    rig = read_glb(file.write(tmp_path / "a.glb"))
    assert rig.morphs["target_1"].delta.tolist() == [[0] * 3, [0] * 3, [1] * 3, [0] * 3]


def test_texture_coordinates_that_another_program_has_dropped(
    tmp_path: Path, own: tuple[dict[str, Any], bytes]
) -> None:
    document = copy.deepcopy(own[0])
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            del primitive["attributes"]["TEXCOORD_0"]
    path = tmp_path / "a.glb"
    path.write_bytes(glb(document, own[1]))
    with pytest.warns(ElastomorphWarning, match="no texture coordinates in the file"):
        assert read_glb(path).neutral.uv is None
