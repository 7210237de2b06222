"""What is no character, or a damaged one: one clear error, and nothing is written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_characters import SmallFile, flap_character

import elastomorph as em
from elastomorph.io.gltf.container import open_gltf
from small_head import head, shapes

Change = Callable[[SmallFile], object]


def first(file: SmallFile) -> Any:
    return file.json["meshes"][0]


def skinned(file: SmallFile, **skin: Any) -> None:
    file.json["nodes"].append({"scale": [0, 0, 0]})
    file.json["scenes"][0]["nodes"].append(len(file.json["nodes"]) - 1)
    file.json["skins"] = [{"joints": [len(file.json["nodes"]) - 1], **skin}]
    file.json["nodes"][0]["skin"] = 0


def clip(file: SmallFile, target: dict[str, Any], count: int = 4, **sampler: Any) -> None:
    times, values = file.array([0, 1.0]), file.array([0.0] * count)
    own = {"input": times, "output": values, **sampler}
    channel = {"sampler": 0, "target": target}
    file.json["animations"] = [{"channels": [channel], "samplers": [own]}]


def pointing(pointer: str) -> dict[str, Any]:
    return {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}


REFUSED: list[tuple[Change, str]] = [
    (lambda f: first(f)["primitives"][1]["targets"].pop(), r"have 1 to 2 morph targets; glTF asks"),
    (lambda f: first(f)["primitives"][1].update(targets=[{}, 7]), "morph target of mesh 0 is no o"),
    (lambda f: first(f)["primitives"].append(3), "a primitive of mesh 0 is no object"),
    (lambda f: first(f).update(extras=["a"]), "'extras' of mesh 0 are no object"),
    (lambda f: f.json.update(extras=7), "'extras' of the document are no object"),
    (lambda f: first(f).update(weights=[0.0]), "default weights of mesh 0 are not 2 numbers"),
    (lambda f: f.json["nodes"][0].update(weights=[0, "a"]), "default weights of mesh 0 are not 2"),
    (lambda f: f.json["nodes"][0].update(scale=[1, 0, 1]), r"mesh 0 is flattened .* scale of 0"),
    (lambda f: f.json["nodes"][0].update(children=[0]), "node 0 appears twice"),
    (skinned, "mesh 0 is flattened"),
    (lambda f: skinned(f, joints=[77]), "a joint of skin 0 is no node of the file"),
    (lambda f: skinned(f, inverseBindMatrices=99), "names number 99 of"),
    (lambda f: clip(f, {"node": 9, "path": "weights"}), "names number 9 of 3 nodes"),
    (lambda f: clip(f, {"node": 0, "path": "weights"}, count=3), "has 3 elements, expected 4"),
    (lambda f: clip(f, {"node": 0, "path": "weights"}, interpolation="BEZIER"), "cannot be bent"),
    (lambda f: clip(f, pointing("/nodes/9/weights")), "names number 9 of 3 nodes"),
    (lambda f: clip(f, pointing("/meshes/9/weights")), "names number 9 of 3 meshes"),
    (lambda f: clip(f, pointing("/nodes/0/weights/2"), count=2), "moves weight 2 of mesh 0, which"),
    (lambda f: f.json.update(meshes=[f.json["meshes"][2]] * 3), "none of its meshes has morph tar"),
    (lambda f: f.json.update(extensionsRequired=["EXT_unknown"]), "without the extension EXT_unk"),
]


@pytest.mark.parametrize(("change", "words"), REFUSED, ids=[words for _, words in REFUSED])
def test_a_damaged_character_is_one_clear_error(tmp_path: Path, change: Change, words: str) -> None:
    file = flap_character()
    change(file)
    path = file.write(tmp_path / "a.glb")
    before = path.read_bytes()
    with pytest.raises(em.ElastomorphError, match=words) as caught:
        em.bend(path, tmp_path / "b.glb")
    assert str(path) in str(caught.value)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_channel_of_a_node_without_a_mesh_is_refused(tmp_path: Path) -> None:
    file = flap_character()
    file.node(name="empty")
    clip(file, {"node": 3, "path": "weights"})
    with pytest.raises(em.FormatError, match="weights of node 3, which has no mesh"):
        em.bend(file.write(tmp_path / "a.glb"), tmp_path / "b.glb")


def test_a_file_whose_paths_are_bent_already_is_refused(tmp_path: Path) -> None:
    rig = em.Rig(head(), {"jawOpen": shapes()["jawOpen"]})
    em.write(tmp_path / "a.glb", rig)
    with pytest.raises(em.FormatError, match="bent already, and not by 'elastomorph bend'"):
        em.bend(tmp_path / "a.glb", tmp_path / "b.glb")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("built-in", "elastomorph export built-in --method linear -o head.glb"),
        ("folder", "'elastomorph export' makes one file"),
        ("a.fbx", "FBX is only read; export the character as .glb"),
        ("a.npz", "'elastomorph export' writes it as .glb"),
        ("a.obj", "unknown suffix '.obj'; a character is a file of .glb"),
        ("missing", "there is no such file"),
        ("missing.glb", "there is no such file"),
    ],
)
@pytest.mark.parametrize("verb", ["bend", "unbend"])
def test_what_is_no_character_is_told_what_to_do_instead(
    tmp_path: Path, name: str, words: str, verb: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    for file in ("a.fbx", "a.npz", "a.obj"):
        Path(file).write_bytes(b"")
    with pytest.raises(em.ElastomorphError, match=words):
        getattr(em, verb)(name, "b.glb")


@pytest.mark.parametrize(("name", "other"), [("a.glb", "b.gltf"), ("a.gltf", "b.glb")])
def test_a_character_keeps_its_format(tmp_path: Path, name: str, other: str) -> None:
    path = flap_character().write(tmp_path / name)
    with pytest.raises(em.FormatError, match=r"keeps its format, so name an output with the suffi"):
        em.bend(path, tmp_path / other)


@pytest.mark.parametrize("uri", ["../secret.png", "/secret.png", "link.png"])
def test_a_file_outside_of_the_folder_is_not_taken_along(tmp_path: Path, uri: str) -> None:
    file = flap_character()
    file.json["images"] = [{"uri": uri}]
    (tmp_path / "own").mkdir()
    file.write(tmp_path / "own" / "a.gltf")
    (tmp_path / "secret.png").write_bytes(b"secret")
    (tmp_path / "own" / "link.png").symlink_to(tmp_path / "secret.png")
    (tmp_path / "away").mkdir()
    with pytest.raises(em.FormatError, match="outside of its folder"):
        em.bend(tmp_path / "own" / "a.gltf", tmp_path / "away" / "b.gltf")
    assert not list((tmp_path / "away").iterdir())


def test_a_document_that_is_nested_too_deeply_is_refused(tmp_path: Path) -> None:
    deep: Any = 1
    for _ in range(700):
        deep = [deep]
    file = flap_character()
    file.json["extras"]["deep"] = deep
    path = file.write(tmp_path / "a.glb")
    with pytest.raises(em.FormatError, match="nested too deeply"):
        em.bend(path, tmp_path / "b.glb")


ODD: list[Any] = [None, True, -1, 0, 3, 99, 2**70, 1.5, 1e300, "", "x", [], {}, [[0]], {"a": 1}]


def places(value: Any, above: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The way to every value of a document."""
    inner: Any = []
    if isinstance(value, dict | list):
        inner = value.items() if isinstance(value, dict) else enumerate(value)
    return [above, *(way for key, own in inner for way in places(own, (*above, key)))]


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_a_document_with_anything_anywhere_is_bent_and_undone_or_refused(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    file = flap_character(normals=True, tangents=True, weights=[0.1, 0.2])
    clip(file, pointing("/nodes/0/weights/0"), count=2)
    file.json["skins"] = [{"joints": [0]}]
    *way, last = data.draw(st.sampled_from(places(file.json)[1:]))
    holder = file.json
    for key in way:
        holder = holder[key]
    holder[last] = data.draw(st.sampled_from(ODD))
    folder = tmp_path_factory.mktemp("odd")
    path = file.write(folder / "a.glb")
    said, output = "", None
    try:
        output = em.bend(path, folder / "b.glb").output
    except em.ElastomorphError as error:
        said = str(error)
    assert said.startswith(f"{path}: ") or not said
    if output is not None:
        em.unbend(output, folder / "c.glb")
        assert open_gltf(folder / "c.glb").document == open_gltf(path).document
    assert (folder / "b.glb").exists() == (output is not None)
