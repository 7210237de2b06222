"""A GLB file holds the looks of its mesh, each image once, and gives them back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from cards import card, image_of, texture, unlit
from elastomorph.io.gltf import read_glb
from elastomorph.io.gltf.writer import write_glb
from elastomorph.model.mesh import FaceLabels, Finish, Layer, Material, Mesh, Texture, Toon
from foreign_files import chunks_of


def rig_of(mesh: Mesh) -> em.Rig:
    up = mesh.with_vertices(mesh.vertices + [0, 0, 1])
    return em.Rig(mesh, {"up": up}, method="linear")


def back(mesh: Mesh, path: Path) -> Mesh:
    write_glb(path, rig_of(mesh))
    return read_glb(path).neutral


EVERY = [
    unlit(texture()),
    unlit(texture(wrap=("mirror", "clamp"))),
    Material((0.5, 0.25, 1.0, 0.5), texture(offset=(0.5, 0.25), scale=(2.0, 3.0), rotation=1.5)),
    Material(texture=texture(), opacity="mask", cutoff=0.25, double_sided=True),
    Material((1.0, 0.0, 0.0, 0.5), opacity="blend"),
]


@pytest.mark.parametrize("material", EVERY)
def test_looks_come_back(tmp_path: Path, material: Material) -> None:
    mesh = card(material)
    found = back(mesh, tmp_path / "card.glb")
    assert found.appearance is not None
    own = found.appearance["card"]
    for name in ("colour", "opacity", "cutoff", "double_sided", "unlit"):
        assert getattr(own, name) == getattr(material, name)
    assert (own.texture is None) == (material.texture is None)
    if own.texture is not None and material.texture is not None:
        for name in ("image", "wrap", "offset", "rotation", "scale", "smooth"):
            assert getattr(own.texture, name) == getattr(material.texture, name)
    assert found.uv is not None
    assert mesh.uv is not None
    np.testing.assert_allclose(
        found.uv.coordinates[found.uv.corners], mesh.uv.coordinates[mesh.uv.corners], atol=1e-7
    )


def test_finishes_come_back(tmp_path: Path) -> None:
    layers: dict[Layer, Texture] = {
        name: texture([[(number, 0, 0)]], scale=(2.0, 1.0))
        for number, name in enumerate(("bumps", "glow", "finish", "creases"))
    }
    for finish in (
        Finish(0.25, 0.5, (1.0, 2.0, 4.0), 0.5, 0.75, layers),
        Finish(layers={"shade": texture()}, toon=Toon((0.5, 0.25, 0.0), -0.5, 0.75, True, 3)),
    ):
        found = back(
            card(Material(texture=texture(scale=(3.0, 1.0)), finish=finish)), tmp_path / "a.glb"
        )
        assert found.appearance is not None
        own = found.appearance["card"].finish
        assert own is not None
        assert own.toon == finish.toon
        for name in ("roughness", "metal", "glow", "bump", "crease"):
            assert getattr(own, name) == getattr(finish, name)
        assert {n: (each.image, each.scale) for n, each in own.layers.items()} == {
            n: (each.image, each.scale) for n, each in finish.layers.items()
        }


def test_an_image_shown_twice_is_stored_once(tmp_path: Path) -> None:
    one = card(unlit(texture()))
    labels = FaceLabels(("left", "right"), np.array([0, 1], dtype=np.int32))
    looks = {"left": unlit(texture()), "right": Material(texture=texture(wrap=("clamp", "clamp")))}
    mesh = Mesh(one.vertices, one.faces, uv=one.uv, materials=labels, appearance=looks)
    write_glb(tmp_path / "card.glb", rig_of(mesh))
    document, blob = chunks_of(tmp_path / "card.glb")
    assert len(document["images"]) == 1
    assert len(document["textures"]) == 2
    assert blob.count(image_of()) == 1
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    start = view["byteOffset"]
    assert blob[start : start + view["byteLength"]] == image_of()
    assert document["buffers"][0]["byteLength"] == len(blob)
    assert document["extensionsUsed"] == ["KHR_materials_unlit"]
    assert "extensionsRequired" not in document


def test_webp_is_declared(tmp_path: Path) -> None:
    shown = Texture(image_of(kind="WEBP", lossless=True), "squares")
    write_glb(tmp_path / "card.glb", rig_of(card(unlit(shown))))
    document, _ = chunks_of(tmp_path / "card.glb")
    assert document["extensionsRequired"] == ["EXT_texture_webp"]
    assert "source" not in document["textures"][0]


@pytest.mark.parametrize("content", [b"", b"no image"])
def test_what_is_no_image_is_left_out(tmp_path: Path, content: bytes) -> None:
    material = Material((1.0, 0.5, 0.0, 1.0), Texture(content, "broken"))
    found = back(card(material), tmp_path / "card.glb")
    assert found.appearance is not None
    plain = Finish(roughness=0.7, metal=0.0)
    assert found.appearance["card"] == Material((1.0, 0.5, 0.0, 1.0), finish=plain)


def test_a_mesh_without_looks_has_the_materials_it_always_had(tmp_path: Path) -> None:
    bare = Mesh(card(None).vertices, card(None).faces)
    write_glb(tmp_path / "bare.glb", rig_of(bare))
    document, _ = chunks_of(tmp_path / "bare.glb")
    assert [m["name"] for m in document["materials"]] == ["unnamed"]
    assert not {"images", "textures", "samplers", "extensionsUsed"} & set(document)
    assert read_glb(tmp_path / "bare.glb").neutral.appearance is None


def test_a_file_says_whose_a_mesh_is_and_says_it_again(tmp_path: Path) -> None:
    plain = card(None)
    owned = Mesh(plain.vertices, plain.faces, copyright="© somebody, MIT licence")
    found = back(owned.with_vertices(2 * owned.vertices), tmp_path / "owned.glb")
    asset = chunks_of(tmp_path / "owned.glb")[0]["asset"]
    assert asset["copyright"] == found.copyright == "© somebody, MIT licence"
    assert back(plain, tmp_path / "plain.glb").copyright == ""
    assert "copyright" not in chunks_of(tmp_path / "plain.glb")[0]["asset"]
