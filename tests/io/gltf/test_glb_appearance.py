"""What glTF documents say of looks is read; what cannot be had is no reason to refuse a file."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import CORNERS, SQUARE, HandMade, square
from PIL import Image

from elastomorph.io.gltf import read_glb
from elastomorph.model.mesh import Finish, Material, Mesh

TEXTURE = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], dtype=float)


def png(pixels: Any = ((255, 0, 0),)) -> bytes:
    file = io.BytesIO()
    Image.fromarray(np.array([pixels], dtype=np.uint8)).save(file, "PNG")
    return file.getvalue()


def textured(material: dict[str, Any], image: dict[str, Any] | None = None) -> HandMade:
    """A square with texture coordinates, of a material with the first texture."""
    file = square()
    first = file.document["meshes"][0]["primitives"][0]
    first["attributes"]["TEXCOORD_0"] = file.array(TEXTURE)
    first["material"] = 0
    file.document["materials"] = [{"name": "skin", **material}]
    file.document["textures"] = [{"source": 0, "sampler": 0}]
    file.document["samplers"] = [{"wrapS": 33071, "wrapT": 33648}]
    file.document["images"] = [image or {"bufferView": file.view(png()), "mimeType": "image/png"}]
    return file


def read(file: HandMade, tmp_path: Path) -> Mesh:
    return read_glb(file.write(tmp_path / "a.glb")).neutral


def material_of(file: HandMade, tmp_path: Path) -> Material:
    mesh = read(file, tmp_path)
    assert mesh.appearance is not None
    return mesh.appearance["skin"]


SHOWN: dict[str, Any] = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}


def test_the_base_colour_comes_with_its_image_sampler_and_opacity(tmp_path: Path) -> None:
    looks = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 0.25, 1, 0.75]}
    file = textured(
        {
            "pbrMetallicRoughness": looks,
            "alphaMode": "MASK",
            "alphaCutoff": 0.3,
            "doubleSided": True,
            "extensions": {"KHR_materials_unlit": {}},
        }
    )
    found = material_of(file, tmp_path)
    assert found.colour == (0.5, 0.25, 1.0, 0.75)
    assert (found.opacity, found.cutoff) == ("mask", 0.3)
    assert found.double_sided
    assert found.unlit
    assert found.texture is not None
    assert found.texture.image == png()
    assert found.texture.wrap == ("clamp", "mirror")


def test_images_lie_in_the_file_in_data_uris_or_beside_it(tmp_path: Path) -> None:
    content = png([(1, 2, 3)])
    (tmp_path / "skin map.png").write_bytes(content)
    held = "data:image/png;base64," + base64.b64encode(content).decode()
    for uri in (held, "skin%20map.png"):
        found = material_of(textured(SHOWN, {"uri": uri}), tmp_path).texture
        assert found is not None
        assert found.image == content


@pytest.mark.parametrize(
    ("image", "problem"),
    [
        ({"uri": "missing.png"}, "missing.png"),
        ({"uri": "../secret.png"}, "own folder"),
        ({"uri": "https://example.org/a.png"}, "own folder"),
        ({"uri": "data:image/png;base64,!"}, "damaged"),
        ({"bufferView": 99}, "99"),
        ({"mimeType": "image/ktx2", "bufferView": 0}, "KTX2"),
        ({"uri": 5}, "names"),
    ],
)
def test_an_image_that_cannot_be_had_says_why(
    tmp_path: Path, image: dict[str, Any], problem: str
) -> None:
    found = material_of(textured(SHOWN, image), tmp_path).texture
    assert found is not None
    assert found.image == b""
    assert problem in found.problem


def test_a_texture_of_basis_universal_alone_has_no_image(tmp_path: Path) -> None:
    file = textured(SHOWN)
    file.document["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
    found = material_of(file, tmp_path).texture
    assert found is not None
    assert "PNG, JPEG or WebP" in found.problem


def test_webp_takes_the_place_of_its_substitute(tmp_path: Path) -> None:
    file = textured(SHOWN)
    webp = {"bufferView": file.view(b"RIFF"), "mimeType": "image/webp"}
    file.document["images"].append(webp)
    file.document["textures"][0]["extensions"] = {"EXT_texture_webp": {"source": 1}}
    found = material_of(file, tmp_path).texture
    assert found is not None
    assert found.image == b"RIFF"


def test_a_transform_and_another_set_of_coordinates_are_followed(tmp_path: Path) -> None:
    moved = {"offset": [0.5, 0.25], "rotation": 1.5, "scale": [2, 3], "texCoord": 1}
    shown = {"index": 0, "extensions": {"KHR_texture_transform": moved}}
    file = textured({"pbrMetallicRoughness": {"baseColorTexture": shown}})
    other = TEXTURE / 2
    attributes = file.document["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_1"] = file.array(other)
    mesh = read(file, tmp_path)
    assert mesh.uv is not None
    np.testing.assert_array_equal(mesh.uv.coordinates, other * [1, -1] + [0, 1])
    assert mesh.appearance is not None
    texture = mesh.appearance["skin"].texture
    assert texture is not None
    assert (texture.offset, texture.rotation, texture.scale) == ((0.5, 0.25), 1.5, (2.0, 3.0))


def test_materials_of_one_name_are_kept_apart(tmp_path: Path) -> None:
    """Two called alike and one without a name, on primitives that share their vertices."""
    file = square()
    first = file.document["meshes"][0]["primitives"][0]
    first["material"] = 0
    for number in (1, 2):
        file.primitive(**{**first, "material": number})
    colours = [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]]
    file.document["materials"] = [
        {"name": "skin", "pbrMetallicRoughness": {"baseColorFactor": colours[0]}},
        {"name": "skin", "pbrMetallicRoughness": {"baseColorFactor": colours[1]}},
        {"pbrMetallicRoughness": {"baseColorFactor": colours[2]}},
    ]
    mesh = read(file, tmp_path)
    assert mesh.materials is not None
    assert mesh.appearance is not None
    shown = [
        mesh.appearance[mesh.materials.names[label]].colour
        for label in mesh.materials.of_face.tolist()
    ]
    assert shown == [tuple(colours[i]) for i in (0, 0, 1, 1, 2, 2)]


def test_a_file_of_plain_greys_says_nothing_of_looks(tmp_path: Path) -> None:
    grey = {"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1]}}
    file = textured(grey)
    assert read(file, tmp_path).appearance is None
    file.document["materials"] = [{"name": "skin"}]
    assert read(file, tmp_path).appearance is None


def test_meshes_joined_keep_their_looks(tmp_path: Path) -> None:
    """One with an image, one that nothing is said of, and one without a material."""
    file = textured(SHOWN)
    file.document["materials"].append({"name": "hair"})
    for fields in ({"material": 1}, {}):
        file.document["nodes"].append({"mesh": len(file.document["meshes"])})
        file.document["meshes"].append({"primitives": []})
        at = {"POSITION": file.array(SQUARE + len(file.document["meshes"]))}
        indices = file.array(CORNERS, "<u2")
        number = len(file.document["meshes"]) - 1
        file.primitive(number, attributes=at, indices=indices, **fields)
    file.document["scenes"] = [{"nodes": [0, 1, 2]}]
    mesh = read(file, tmp_path)
    assert mesh.appearance is not None
    assert mesh.appearance["skin"].texture is not None
    assert mesh.appearance["hair"] == Material(finish=Finish(metal=1.0))
    assert mesh.materials is not None
    assert mesh.materials.of_face.tolist() == [0, 0, 1, 1, -1, -1]


def test_old_vrm_shaders_are_unlit_and_say_how_they_blend(tmp_path: Path) -> None:
    file = textured({})
    shader = {
        "shader": "VRM/MToon",
        "floatProperties": {"_BlendMode": 1, "_Cutoff": 0.25, "_CullMode": 0},
        "textureProperties": {"_MainTex": 0},
    }
    file.document["extensions"] = {"VRM": {"materialProperties": [shader]}}
    found = material_of(file, tmp_path)
    assert found.unlit
    assert found.double_sided
    assert (found.opacity, found.cutoff) == ("mask", 0.25)
    assert found.texture is not None


def test_new_vrm_toon_is_unlit(tmp_path: Path) -> None:
    toon = {**SHOWN, "extensions": {"VRMC_materials_mtoon": {"specVersion": "1.0"}}}
    assert material_of(textured(toon), tmp_path).unlit


def test_specular_and_glossiness_have_a_base_colour_too(tmp_path: Path) -> None:
    glossy = {"diffuseFactor": [1, 0.5, 0, 1], "diffuseTexture": {"index": 0}}
    file = textured({"extensions": {"KHR_materials_pbrSpecularGlossiness": glossy}})
    found = material_of(file, tmp_path)
    assert found.colour == (1.0, 0.5, 0.0, 1.0)
    assert found.texture is not None


@pytest.mark.parametrize(
    "material",
    [
        {"pbrMetallicRoughness": {"baseColorFactor": [1, 0, "x", 1], "baseColorTexture": 3}},
        {"pbrMetallicRoughness": {"baseColorFactor": [10**400, 0, 0, 1]}},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": "0", "texCoord": -1}}},
        {"pbrMetallicRoughness": [], "alphaMode": {}, "alphaCutoff": "half"},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 10**30}}},
        {"extensions": {"KHR_materials_pbrSpecularGlossiness": 7}},
    ],
)
def test_nonsense_in_materials_never_refuses_a_file(
    tmp_path: Path, material: dict[str, Any]
) -> None:
    file = textured(material)
    file.document["textures"][0]["sampler"] = {}
    file.document["extensions"] = {"VRM": {"materialProperties": [{"shader": []}]}}
    mesh = read(file, tmp_path)
    np.testing.assert_array_equal(mesh.vertices, SQUARE * [-1, 1, -1])


def test_toons_of_the_first_vrm_are_those_of_the_second(tmp_path: Path) -> None:
    """Colours as screens show them; an edge of the sharpness 1 where the cosine is -shift."""
    file = textured({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})
    settings = {"_ShadeShift": 0.25, "_ShadeToony": 1.0, "_BlendMode": 3}
    colours = {"_ShadeColor": [0.5, 0.0, 1.0, 1.0], "_EmissionColor": [1.0, 0.0, 0.5, 1.0]}
    shader = {
        "shader": "VRM/MToon",
        "floatProperties": settings,
        "vectorProperties": colours,
        "textureProperties": {"_MainTex": 0, "_ShadeTexture": 0},
        "renderQueue": 2503,
    }
    file.document["extensions"] = {"VRM": {"materialProperties": [shader]}}
    finish = material_of(file, tmp_path).finish
    assert finish is not None
    assert finish.toon is not None
    np.testing.assert_allclose(finish.toon.shade, [0.21404, 0, 1], atol=1e-5)
    np.testing.assert_allclose(finish.glow, [1, 0, 0.21404], atol=1e-5)
    assert (finish.toon.shift, finish.toon.toony) == (-0.25, 1.0)
    assert (finish.toon.covers, finish.toon.queue) == (True, 3)
    assert set(finish.layers) == {"shade"}


def test_images_by_other_coordinates_than_the_base_are_left_out(tmp_path: Path) -> None:
    """A mesh has one set of texture coordinates."""
    base = {"baseColorTexture": {"index": 0}}
    creases = {"index": 0, "texCoord": 1}
    file = textured({"pbrMetallicRoughness": base, "normalTexture": {"index": 0, "scale": 2.0}})
    file.document["materials"][0]["occlusionTexture"] = creases
    finish = material_of(file, tmp_path).finish
    assert finish is not None
    assert set(finish.layers) == {"bumps"}
    assert (finish.bump, finish.roughness, finish.metal, finish.toon) == (2.0, 1.0, 1.0, None)
