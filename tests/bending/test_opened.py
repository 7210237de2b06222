"""A character that is read once is handed on whole, through whichever door it came."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_characters import SmallFile, flap_character

import elastomorph as em
from cards import image_of
from elastomorph.bending.opened import OpenedCharacter
from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.rig import Rig

TIMES = (0.3, 0.7)


def dressed(file: SmallFile) -> SmallFile:
    """With a colour at each vertex of its first mesh, and an image."""
    for primitive in file.json["meshes"][0]["primitives"]:
        count = file.json["accessors"][primitive["attributes"]["POSITION"]]["count"]
        shades = np.linspace(0, 1, 3 * count).reshape(count, 3)
        primitive["attributes"]["COLOR_0"] = file.array(shades)
    file.json["images"] = [{"uri": "skin.png"}, {"uri": "nowhere.png"}, {"uri": "skin.png"}]
    return file


def given_back(content: bytes, folder: Path) -> tuple[GltfFile, Path]:
    place = folder / "given back.glb"
    place.write_bytes(content)
    return open_gltf(place), place


def attribute(file: GltfFile, mesh: int, primitive: int, name: str) -> Any:
    entry = file.document["meshes"][mesh]["primitives"][primitive]["attributes"]
    return read_floats(file, entry[name], 3, "a test")


@pytest.mark.parametrize("name", ["a.gltf", "embedded.gltf", "a.glb"])
def test_all_that_belongs_to_it_is_inside(tmp_path: Path, name: str) -> None:
    """Colours, normals and images of a .gltf and of the files beside it, each image once."""
    (tmp_path / "skin.png").write_bytes(image_of())
    path = dressed(flap_character(normals=True)).write(tmp_path / name)
    source, rig = open_gltf(path), em.read_rig(path, method="rotation")
    found, place = given_back(OpenedCharacter.of(open_gltf(path)).glb(rig), tmp_path)
    assert found.is_glb
    entries = [*found.items("buffers"), *found.items("images")]
    assert not any("uri" in entry for entry in entries)
    for kind in ("NORMAL", "COLOR_0"):
        for primitive in (0, 1):
            expected = attribute(source, 0, primitive, kind)
            np.testing.assert_array_equal(attribute(found, 0, primitive, kind), expected)
    one, missing, other = found.items("images")
    assert one == other
    assert missing == {}
    assert bytes(found.view(one["bufferView"], "a test")[0]) == image_of()
    assert one["mimeType"] == "image/png"
    again = em.read_rig(place)
    for t in TIMES:
        apart = again["open"].at(t) - rig["open"].at(t)
        assert np.linalg.norm(apart, axis=1).max() < 3e-5


def test_of_one_mesh_the_others_are_not_shown(tmp_path: Path) -> None:
    """Its own colours and normals stay, and clips of it alone."""
    file = dressed(flap_character(normals=True))
    times = file.array([[0.0], [1.0]], min=[0], max=[1])
    nodes = file.json["nodes"]
    clips = []
    for number, node in enumerate(nodes):
        targets = file.json["meshes"][node["mesh"]]["primitives"][0].get("targets", [])
        if targets:
            keys = file.array(np.eye(2)[:, : len(targets)].reshape(-1, 1))
            channel = {"sampler": 0, "target": {"node": number, "path": "weights"}}
            sampler = {"input": times, "output": keys}
            clips.append({"channels": [channel], "samplers": [sampler]})
    file.json["animations"] = clips
    assert len(clips) > 1
    path = file.write(tmp_path / "a.glb")
    rig = em.read_rig(path, mesh="flap", method="rotation")
    found, place = given_back(OpenedCharacter.of(open_gltf(path), ("flap",)).glb(rig), tmp_path)
    shown = [node for node in found.items("nodes") if "mesh" in node]
    assert [node["name"] for node in shown] == ["flap"]
    assert len(found.items("animations")) == 1
    colours = attribute(open_gltf(path), 0, 1, "COLOR_0")
    np.testing.assert_array_equal(attribute(found, 0, 1, "COLOR_0"), colours)
    again = em.read_rig(place)
    assert len(again.neutral.vertices) == len(rig.neutral.vertices)
    for t in TIMES:
        np.testing.assert_allclose(again["open"].at(t), rig["open"].at(t), atol=3e-5)


@pytest.mark.parametrize("method", ["rotation", "linear"])
def test_groups_and_correctives_of_settings_are_in_it(tmp_path: Path, method: str) -> None:
    path = flap_character().write(tmp_path / "a.glb")
    read = em.read_rig(path, method=method)
    sliders: dict[str, Any] = {"correctives": {"slide": ["open", "slide"]}}
    sliders["groups"] = {"both": ["open", "slide"]}
    rig = Rig(read.neutral, read.morphs, **sliders)
    _, place = given_back(OpenedCharacter.of(open_gltf(path)).glb(rig), tmp_path)
    again = em.read_rig(place, mesh="flap")
    assert again.sliders.correctives == rig.sliders.correctives
    assert again.sliders.groups == rig.sliders.groups


def test_a_bent_file_gets_other_paths_from_its_original(tmp_path: Path) -> None:
    path = flap_character(normals=True).write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "bent.glb")
    opened = OpenedCharacter.of(open_gltf(tmp_path / "bent.glb"))
    assert len(opened.rig["open"].bends)
    found, _ = given_back(opened.glb(em.read_rig(path, method="linear")), tmp_path)
    assert found.document["meshes"] == open_gltf(path).document["meshes"]


def test_what_is_missing_is_said_as_by_any_reader(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.gltf")
    (tmp_path / "some bytes.bin").unlink()
    with pytest.raises(em.ElastomorphError) as plain:
        em.read_rig(path)
    with pytest.raises(em.ElastomorphError) as opened:
        OpenedCharacter.of(open_gltf(path))
    assert str(opened.value) == str(plain.value)


def test_views_that_name_no_buffer_are_refused(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.gltf")
    document = json.loads(path.read_text(encoding="utf-8"))
    document["bufferViews"].append({"buffer": 7, "byteLength": 4})
    path.write_text(json.dumps(document), encoding="utf-8")
    opened = OpenedCharacter.of(open_gltf(path))  # nobody uses that view
    with pytest.raises(em.FormatError, match="buffer"):
        opened.glb(opened.rig)
