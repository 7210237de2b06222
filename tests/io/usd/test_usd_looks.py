"""Base colours, images and opacity of UsdPreviewSurface come with a rig."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from cards import PIXELS, image_of
from elastomorph.bending.usd import bend_usd
from elastomorph.io.usd import read_usd
from elastomorph.model.appearance import Material
from elastomorph.model.mesh import Mesh

pytest.importorskip("pxr")

STAGE = """#usda 1.0
(
    defaultPrim = "Root"
    upAxis = "Y"
)
def SkelRoot "Root" {{
    def Mesh "Card" (prepend apiSchemas = ["MaterialBindingAPI", "SkelBindingAPI"]) {{
        point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
        int[] faceVertexCounts = [3, 3]
        int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")
        rel material:binding = </Root/Skin>
        token[] skel:blendShapes = ["up"]
        rel skel:blendShapeTargets = </Root/Card/up>
        def BlendShape "up" {{
            vector3f[] offsets = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
        }}
    }}
    def Material "Skin" {{
        token outputs:surface.connect = </Root/Skin/Surface.outputs:surface>
        def Shader "Surface" {{
            uniform token info:id = "UsdPreviewSurface"
            {inputs}
            token outputs:surface
        }}
        def Shader "Image" {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @{file}@
            token inputs:wrapS = "clamp"
            token inputs:wrapT = "mirror"
            {st}
            float3 outputs:rgb
            float outputs:a
        }}
        def Shader "Place" {{
            uniform token info:id = "UsdTransform2d"
            float2 inputs:scale = (0.5, 0.5)
            float2 inputs:translation = (0, 0.5)
            float2 outputs:result
        }}
    }}
}}
"""
SHOWN = "color3f inputs:diffuseColor.connect = </Root/Skin/Image.outputs:rgb>"
PLACED = "float2 inputs:st.connect = </Root/Skin/Place.outputs:result>"


def read(folder: Path, inputs: str, file: str = "skin.png", st: str = "") -> Mesh:
    path = folder / "card.usda"
    path.write_text(STAGE.format(inputs=inputs, file=file, st=st))
    return read_usd(path).neutral


def look(folder: Path, inputs: str, **more: str) -> Material:
    mesh = read(folder, inputs, **more)
    assert mesh.appearance is not None
    return mesh.appearance["Skin"]


def test_an_image_beside_the_stage_is_its_base_colour(tmp_path: Path) -> None:
    (tmp_path / "skin.png").write_bytes(image_of(PIXELS))
    found = look(tmp_path, SHOWN)
    assert found.opacity == "opaque"
    assert found.texture is not None
    assert found.texture.image == image_of(PIXELS)
    assert found.texture.wrap == ("clamp", "mirror")


def test_a_transform_of_coordinates_is_followed(tmp_path: Path) -> None:
    """The upper left quarter of the image: half its size, moved up by half."""
    from elastomorph.draw.textures import places_in

    (tmp_path / "skin.png").write_bytes(image_of(PIXELS))
    texture = look(tmp_path, SHOWN, st=PLACED).texture
    assert texture is not None
    corners = np.array([[0.0, 0.0], [1.0, 1.0]])
    np.testing.assert_allclose(places_in(texture, corners), [[0, 0.5], [0.5, 1]], atol=1e-12)


def test_an_image_in_a_package_is_found(tmp_path: Path) -> None:
    package = tmp_path / "card.usdz"
    with zipfile.ZipFile(package, "w", zipfile.ZIP_STORED) as archive:
        for name, content in (
            ("card.usda", STAGE.format(inputs=SHOWN, file="skin.png", st="").encode()),
            ("skin.png", image_of(PIXELS)),
        ):
            info = zipfile.ZipInfo(name)
            offset = archive.fp.tell() + 30 + len(name) + 4  # type: ignore[union-attr]
            info.extra = b"\x00\x00" + (-offset % 64).to_bytes(2, "little") + bytes(-offset % 64)
            archive.writestr(info, content)
    mesh = read_usd(package).neutral
    assert mesh.appearance is not None
    texture = mesh.appearance["Skin"].texture
    assert texture is not None
    assert texture.image == image_of(PIXELS)


def test_an_image_elsewhere_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "secret.png").write_bytes(image_of(PIXELS))
    inside = tmp_path / "inside"
    inside.mkdir()
    for file in ("../secret.png", str(tmp_path / "secret.png"), "missing.png"):
        texture = look(inside, SHOWN, file=file).texture
        assert texture is not None
        assert texture.image == b""
        assert "no file below the folder" in texture.problem


def test_colours_and_opacity_without_an_image(tmp_path: Path) -> None:
    red = "color3f inputs:diffuseColor = (1, 0.5, 0)"
    found = look(tmp_path, red)
    assert found.colour == (1.0, 0.5, 0.0, 1.0)
    assert found.texture is None
    clear = look(tmp_path, f"{red}\n            float inputs:opacity = 0.25")
    assert (clear.opacity, clear.colour[3]) == ("blend", 0.25)
    alpha = "float inputs:opacity.connect = </Root/Skin/Image.outputs:a>"
    threshold = "float inputs:opacityThreshold = 0.5"
    masked = look(tmp_path, f"{SHOWN}\n            {alpha}\n            {threshold}")
    assert (masked.opacity, masked.cutoff) == ("mask", 0.5)


def test_a_grey_material_says_nothing_of_looks(tmp_path: Path) -> None:
    assert read(tmp_path, "color3f inputs:diffuseColor = (0.5, 0.5, 0.5)").appearance is None
    assert read(tmp_path, "").appearance is None


@pytest.mark.parametrize("packed", [False, True])
def test_a_layer_of_bends_shows_the_images_of_its_original(tmp_path: Path, packed: bool) -> None:
    from pxr import UsdUtils

    image = image_of(PIXELS)
    (tmp_path / "skin.png").write_bytes(image)
    original = tmp_path / "card.usda"
    original.write_text(STAGE.format(inputs=SHOWN, file="skin.png", st=""))
    if packed:
        original = tmp_path / "card.usdz"
        assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "card.usda"), str(original))
    (tmp_path / "bent").mkdir()
    for folder in (tmp_path, tmp_path / "bent"):
        bend_usd(original, folder / "bent.usdc", method="ease:2")
        appearance = read_usd(folder / "bent.usdc").neutral.appearance
        assert appearance is not None
        texture = appearance["Skin"].texture
        assert texture is not None
        assert texture.image == image


def test_the_coordinates_are_those_that_the_material_names(tmp_path: Path) -> None:
    (tmp_path / "skin.png").write_bytes(image_of(PIXELS))
    reader = """float2 inputs:st.connect = </Root/Skin/Image/Reader.outputs:result>
            def Shader "Reader" {
                uniform token info:id = "UsdPrimvarReader_float2"
                string inputs:varname = "second"
                float2 outputs:result
            }
            """
    text = STAGE.format(inputs=SHOWN, file="skin.png", st=reader)
    second = "        texCoord2f[] primvars:second = [(0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5)] "
    text = text.replace(
        "        rel material", f'{second}(interpolation = "vertex")\n        rel material'
    )
    (tmp_path / "card.usda").write_text(text)
    uv = read_usd(tmp_path / "card.usda").neutral.uv
    assert uv is not None
    assert uv.coordinates.max() == 0.5


def test_a_large_image_beside_a_small_stage_is_no_harm(tmp_path: Path) -> None:
    """It counts as a part of the character when memory is allowed for."""
    (tmp_path / "skin.png").write_bytes(image_of(PIXELS) + bytes(60_000_000))
    texture = look(tmp_path, SHOWN).texture
    assert texture is not None
    assert len(texture.image) > 60_000_000
