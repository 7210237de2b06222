"""What undoes a bend, and files that were bent before."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_characters import SmallFile, flap_character

import elastomorph as em
from elastomorph.bending import undo
from elastomorph.bending.undo import patched, reverse_patch
from elastomorph.io.gltf.container import open_gltf
from foreign_files import chunks_of, glb

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 3) | st.floats(-2, 2) | st.text(max_size=2),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=2), inner),
    max_leaves=12,
)


def exactly(value: Any) -> str:
    """JSON that tells 1 from 1.0 and True, and the order of members."""
    return json.dumps(value)


@given(VALUES, VALUES)
def test_the_patch_of_two_documents_makes_the_old_one_of_the_new(old: Any, new: Any) -> None:
    patch = reverse_patch(old, new)
    if patch is None:
        assert exactly(old) == exactly(new)
    else:
        stored = json.loads(json.dumps(patch))
        assert exactly(patched(new, stored)) == exactly(old)


@given(VALUES)
def test_the_same_document_needs_no_patch(value: Any) -> None:
    assert reverse_patch(value, copy.deepcopy(value)) is None


def test_what_was_appended_is_told_by_a_length_alone() -> None:
    old = {"accessors": [{"count": 3}] * 9, "extras": {"a": 1}}
    new = {"accessors": [{"count": 3}] * 12, "extras": {"a": 1, "b": [1] * 99}}
    assert reverse_patch(old, new) == {
        "in": {"accessors": {"cut": 9}, "extras": {"cut": ["b"]}}
    }  # fmt: skip


@st.composite
def small_files(draw: st.DrawFn) -> SmallFile:
    """Characters of all kinds that `flap_character` knows, placed anywhere."""
    quantized = draw(st.booleans())
    node: dict[str, Any] = {}
    if draw(st.booleans()):
        axis = np.array(draw(st.tuples(*[st.integers(-5, 5)] * 4)), dtype=float)
        length = np.linalg.norm(axis)
        node["rotation"] = (axis / length).tolist() if length else [0, 0, 0, 1]
        node["translation"] = draw(st.lists(st.integers(-9, 9), min_size=3, max_size=3))
    file = flap_character(
        quantized=quantized,
        normals=draw(st.booleans()),
        tangents=draw(st.booleans()),
        names=draw(st.sampled_from(["mesh", "primitive", "target", "nowhere"])),
        teeth=draw(st.booleans()),
        **node,
    )
    if draw(st.booleans()):
        file.json["nodes"][0]["weights"] = draw(
            st.lists(st.floats(0, 1, width=32), min_size=2, max_size=2)
        )
    if draw(st.booleans()):
        del file.json["extras"]
    file.json["nodes"][0]["extras"] = draw(VALUES)
    return file


@settings(max_examples=25, deadline=None)
@given(small_files(), st.booleans())
def test_unbending_gives_back_the_document_and_every_byte(
    tmp_path_factory: pytest.TempPathFactory, file: SmallFile, fold: bool
) -> None:
    folder = tmp_path_factory.mktemp("small")
    path = file.write(folder / "a.glb")
    before = path.read_bytes()
    em.bend(path, folder / "b.glb", fold=fold)
    em.unbend(folder / "b.glb", folder / "c.glb")
    original, found = open_gltf(path), open_gltf(folder / "c.glb")
    assert exactly(found.document) == exactly(original.document)
    assert found.buffer(0) == original.buffer(0)
    assert path.read_bytes() == before


def test_a_bent_file_is_bent_anew_from_its_original(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "b.glb")
    report = em.bend(tmp_path / "b.glb", tmp_path / "c.glb")
    assert report.was_bent
    assert (tmp_path / "c.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()
    for source in ("a", "b"):
        em.bend(tmp_path / f"{source}.glb", tmp_path / f"arc {source}.glb", method="arc")
    assert (tmp_path / "arc a.glb").read_bytes() == (tmp_path / "arc b.glb").read_bytes()
    before = (tmp_path / "b.glb").read_bytes()
    straight = em.bend(tmp_path / "b.glb", tmp_path / "b.glb", method="linear")
    assert (straight.output, straight.was_bent) == (None, True)
    assert (tmp_path / "b.glb").read_bytes() == before


EXTRAS: list[dict[str, Any]] = [
    {},
    {"elastomorph": {}},
    {"elastomorph": 7, "kept": 1},
    {"kept": {}, "elastomorph": None},
]


@pytest.mark.parametrize("extras", EXTRAS, ids=repr)
@pytest.mark.parametrize("name", ["a.glb", "embedded.gltf"])
def test_extras_of_the_document_come_back_whatever_they_were(
    tmp_path: Path, name: str, extras: dict[str, Any]
) -> None:
    """Empty ones too, and those of the key that the record has."""
    file = flap_character()
    file.json["extras"] = extras
    path = file.write(tmp_path / name)
    bent, again, back = (tmp_path / f"{own}{path.suffix}" for own in ("b", "c", "d"))
    em.bend(path, bent)
    em.bend(bent, again)
    assert open_gltf(again).document == open_gltf(bent).document
    em.unbend(bent, back)
    assert exactly(open_gltf(back).document) == exactly(open_gltf(path).document)


@pytest.mark.parametrize("extras", [None, {}, {"kept": 1}], ids=repr)
def test_records_of_earlier_versions_are_understood(tmp_path: Path, extras: Any) -> None:
    """Their digest and patch were of a document without extras where it had none."""
    file = flap_character()
    file.json.pop("extras")
    if extras is not None:
        file.json["extras"] = extras
    path = file.write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "b.glb")
    document, chunk = chunks_of(tmp_path / "b.glb")
    own = document["extras"].pop("elastomorph")
    if extras is None:
        del document["extras"]
        own["undo"]["cut"].remove("extras")
    own["made"] = undo._digest(document, chunk)
    document["extras"] = {**document.get("extras", {}), "elastomorph": own}
    (tmp_path / "b.glb").write_bytes(glb(document, chunk))
    em.unbend(tmp_path / "b.glb", tmp_path / "c.glb")
    found = open_gltf(tmp_path / "c.glb").document
    assert exactly(found) == exactly(open_gltf(path).document)


def test_a_bent_document_in_files_is_bent_anew_and_undone(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.gltf")
    em.bend(path, tmp_path / "b.gltf")
    em.bend(tmp_path / "b.gltf", tmp_path / "b.gltf", method="rotation")
    em.unbend(tmp_path / "b.gltf", tmp_path / "c.gltf")
    assert open_gltf(tmp_path / "c.gltf").document == open_gltf(path).document


@pytest.mark.parametrize("verb", [lambda f, o: em.bend(f, o), em.unbend])
def test_a_bent_file_that_was_changed_is_not_undone(tmp_path: Path, verb: Any) -> None:
    file = flap_character()
    path = file.write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "b.glb")
    content = (tmp_path / "b.glb").read_bytes()
    (tmp_path / "b.glb").write_bytes(content.replace(b'"still"', b'"STILL"'))
    with pytest.raises(em.FormatError, match=r"another program has changed it.*bend the original"):
        verb(tmp_path / "b.glb", tmp_path / "c.glb")
    (tmp_path / "b.glb").write_bytes(content[:-4] + b"abcd")
    with pytest.raises(em.FormatError, match="another program has changed it"):
        verb(tmp_path / "b.glb", tmp_path / "c.glb")
    assert not (tmp_path / "c.glb").exists()


def test_another_program_may_write_the_same_document_in_its_own_way(tmp_path: Path) -> None:
    """Members in another order, spaces, and whole numbers with a point."""
    path = flap_character().write(tmp_path / "embedded.gltf")
    em.bend(path, tmp_path / "b.gltf")
    document = json.loads((tmp_path / "b.gltf").read_text())
    document["nodes"][0]["mesh"] = 0
    document["asset"] = dict(reversed(document["asset"].items()))
    text = json.dumps(document, indent=4).replace('"count": 18', '"count": 18.0')
    (tmp_path / "b.gltf").write_text(text)
    em.unbend(tmp_path / "b.gltf", tmp_path / "c.gltf")
    assert open_gltf(tmp_path / "c.gltf").document == open_gltf(path).document


def test_chunks_that_no_one_knows_go_along(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.glb")
    content = bytearray(path.read_bytes()) + b"\x04\0\0\0ABCDwxyz"
    content[8:12] = len(content).to_bytes(4, "little")
    path.write_bytes(content)
    em.bend(path, tmp_path / "b.glb")
    em.unbend(tmp_path / "b.glb", tmp_path / "c.glb")
    for name in ("b.glb", "c.glb"):
        assert (tmp_path / name).read_bytes().endswith(b"\x04\0\0\0ABCDwxyz")
    open_gltf(tmp_path / "b.glb")


def test_the_binary_chunk_may_follow_one_that_no_one_knows(tmp_path: Path) -> None:
    """It is second by the standard, but readers skip what they do not know."""
    usual = flap_character().write(tmp_path / "usual.glb")
    content, unknown = usual.read_bytes(), b"\x04\0\0\0ABCDwxyz"
    binary = 20 + int.from_bytes(content[12:16], "little")
    swapped = bytearray(content[:binary] + unknown + content[binary:])
    swapped[8:12] = len(swapped).to_bytes(4, "little")
    (tmp_path / "a.glb").write_bytes(swapped)
    em.bend(tmp_path / "a.glb", tmp_path / "b.glb")
    em.bend(usual, tmp_path / "expected.glb")
    bent, expected = em.read_rig(tmp_path / "b.glb"), em.read_rig(tmp_path / "expected.glb")
    np.testing.assert_array_equal(bent.morphs["open"].at(0.5), expected.morphs["open"].at(0.5))
    em.unbend(tmp_path / "b.glb", tmp_path / "c.glb")
    original, again = open_gltf(tmp_path / "a.glb"), open_gltf(tmp_path / "c.glb")
    assert again.document == original.document
    assert (again.chunk, again.rest) == (original.chunk, unknown)


CURVELESS = "bend FILE --from BENT"


def without_curves(path: Path, out: Path, *, nodes: bool = False) -> Path:
    """A bent file as gltfpack leaves it, or three.js' exporter, which gives the curves to nodes."""
    document, blob = chunks_of(path)
    del document["extras"]
    for number, mesh in enumerate(document["meshes"]):
        stored = mesh.get("extras", {}).pop("elastomorph", None)
        if stored and nodes:
            document["nodes"][number]["extras"] = {"elastomorph": stored}
    out.write_bytes(glb(document, blob))
    return out


def test_what_is_bent_is_not_bent_again(tmp_path: Path) -> None:
    """With the curves in the nodes they are read from there; without, it is said what has them."""
    path = flap_character().write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "bent.glb")
    moved = without_curves(tmp_path / "bent.glb", tmp_path / "moved.glb", nodes=True)
    expected, found = em.read_rig(tmp_path / "bent.glb"), em.read_rig(moved)
    np.testing.assert_array_equal(found.pose({"open": 0.5}), expected.pose({"open": 0.5}))
    with pytest.raises(em.FormatError, match="bent already"):
        em.bend(moved, tmp_path / "b.glb")
    gone = without_curves(tmp_path / "bent.glb", tmp_path / "gone.glb")
    with pytest.raises(em.FormatError, match=CURVELESS):
        em.bend(gone, tmp_path / "b.glb")
    assert not (tmp_path / "b.glb").exists()


@pytest.mark.parametrize("bends_left", [True, False])
def test_curves_that_no_longer_fit_do_not_let_bends_be_bent(
    tmp_path: Path, bends_left: bool
) -> None:
    """A program that gives targets names of its own, and keeps extras; or takes the bends out."""
    path = flap_character().write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "bent.glb")
    document, blob = chunks_of(tmp_path / "bent.glb")
    del document["extras"]
    for mesh in document["meshes"]:
        if "extras" in mesh:
            count = len(mesh["primitives"][0]["targets"]) if bends_left else 1
            mesh["extras"]["targetNames"] = [f"shape {number}" for number in range(count)]
            mesh["weights"] = [0] * count
            for primitive in mesh["primitives"]:
                del primitive["targets"][count:]
    (tmp_path / "renamed.glb").write_bytes(glb(document, blob))
    if bends_left:
        with pytest.raises(em.FormatError, match=CURVELESS):
            em.bend(tmp_path / "renamed.glb", tmp_path / "b.glb")
        em.bend(tmp_path / "renamed.glb", tmp_path / "b.glb", source=tmp_path / "bent.glb")
    else:
        with pytest.warns(em.ElastomorphWarning, match="no longer fits"):
            em.bend(tmp_path / "renamed.glb", tmp_path / "b.glb")
    assert (tmp_path / "b.glb").exists()


def test_curves_of_a_node_that_no_longer_hold_give_way(tmp_path: Path) -> None:
    """three.js reads the extras of a node over those of its mesh."""
    file = flap_character()
    straight = {"version": 1, "morphs": [{"name": "open", "target": "open", "method": "linear"}]}
    file.json["nodes"][0]["extras"] = {"elastomorph": straight, "kept": 1}
    path = file.write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "b.glb")
    assert open_gltf(tmp_path / "b.glb").document["nodes"][0]["extras"] == {"kept": 1}
    em.unbend(tmp_path / "b.glb", tmp_path / "c.glb")
    assert open_gltf(tmp_path / "c.glb").document == open_gltf(path).document
