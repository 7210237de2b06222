"""Base colours, images and opacity of UsdPreviewSurface come with a rig."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from cards import PIXELS, card, image_of, texture
from elastomorph.bending.usd import bend_usd
from elastomorph.errors import FileError
from elastomorph.io.usd import read_usd, write_usd
from elastomorph.model.mesh import Finish, Layer, Material, Mesh, Texture
from elastomorph.rig import Rig

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
    from elastomorph.draw.materials import places_in

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


def rig_of(mesh: Mesh) -> Rig:
    up = mesh.with_vertices(mesh.vertices + [0, 0, 1])
    return Rig(mesh, {"up": up}, method="linear")


WRITTEN = [
    Material((0.5, 0.25, 1.0, 1.0), finish=Finish(0.25, 1.0)),
    Material(texture=texture(wrap=("mirror", "clamp")), finish=Finish(0.5)),
    Material((0.5, 0.25, 1.0, 0.5), texture(), "blend", finish=Finish(0.125)),
    Material(texture=texture(), opacity="mask", cutoff=0.25, finish=Finish(1.0)),
    Material((1.0, 0.5, 0.0, 0.5), opacity="blend", finish=Finish(1.0)),
]


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usdz"])
@pytest.mark.parametrize("material", WRITTEN)
def test_looks_that_are_written_come_back(tmp_path: Path, material: Material, suffix: str) -> None:
    path = tmp_path / f"card{suffix}"
    write_usd(path, rig_of(card(material)))
    found = read_usd(path).neutral.appearance
    assert found is not None
    own = found["card"]
    assert own.colour == material.colour
    assert own.opacity == material.opacity
    assert own.cutoff == (0.25 if material.opacity == "mask" else 0.0)
    assert own.finish is not None
    assert material.finish is not None
    assert (own.finish.roughness, own.finish.metal) == (
        material.finish.roughness,
        material.finish.metal,
    )
    if material.texture is None:
        assert own.texture is None
        return
    assert own.texture is not None
    assert own.texture.image == material.texture.image
    assert own.texture.wrap == material.texture.wrap
    image = "card_squares.png"
    beside = {path.name} if suffix == ".usdz" else {path.name, image}
    assert {each.name for each in tmp_path.iterdir()} == beside


def test_a_transform_of_coordinates_is_written(tmp_path: Path) -> None:
    from elastomorph.draw.materials import places_in

    moved = texture(offset=(0.5, 0.25), scale=(2.0, 3.0), rotation=1.5)
    write_usd(tmp_path / "card.usda", rig_of(card(Material(texture=moved))))
    found = read_usd(tmp_path / "card.usda").neutral.appearance
    assert found is not None
    own = found["card"].texture
    assert own is not None
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.25, 0.5]])
    np.testing.assert_allclose(places_in(own, corners), places_in(moved, corners), atol=1e-6)


def test_pxr_finds_each_image_by_the_surface_bound_to_a_part(tmp_path: Path) -> None:
    """As renderers of other people look for it: binding, surface, texture, primvar, file."""
    from pxr import Usd, UsdGeom, UsdShade

    layers: dict[Layer, Texture] = {
        name: texture([[(number, 0, 0)]])
        for number, name in enumerate(("bumps", "glow", "finish", "creases"))
    }
    look = Material(texture=texture(), finish=Finish(0.5, 0.25, (0.5, 0.5, 0.5), layers=layers))
    write_usd(tmp_path / "card.usdc", rig_of(card(look)))
    stage = Usd.Stage.Open(str(tmp_path / "card.usdc"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Face/Mesh"))
    (subset,) = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
    material, _ = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()
    surface, _, _ = material.ComputeSurfaceSource()
    assert surface.GetIdAttr().Get() == "UsdPreviewSurface"
    images = {None: look.texture, **layers}
    for key, channel, layer in (
        ("diffuseColor", "rgb", None),
        ("emissiveColor", "rgb", "glow"),
        ("roughness", "g", "finish"),
        ("metallic", "b", "finish"),
        ("occlusion", "r", "creases"),
        ("normal", "rgb", "bumps"),
    ):
        (source,), _ = surface.GetInput(key).GetConnectedSources()
        assert source.sourceName == channel
        shown = UsdShade.Shader(source.source.GetPrim())
        assert shown.GetIdAttr().Get() == "UsdUVTexture"
        file = Path(shown.GetInput("file").Get().resolvedPath)
        assert file.parent == tmp_path
        expected = images[layer]
        assert expected is not None
        assert file.read_bytes() == expected.image
        (place,), _ = shown.GetInput("st").GetConnectedSources()
        name = UsdShade.Shader(place.source.GetPrim()).GetInput("varname").Get()
        assert UsdGeom.PrimvarsAPI(mesh).GetPrimvar(name).HasValue()


def test_an_image_that_usd_does_not_know_is_left_out(tmp_path: Path) -> None:
    webp = Texture(image_of(kind="WEBP"), "skin")
    mesh = card(Material((1.0, 0.5, 0.0, 1.0), webp, finish=Finish(1.0)))
    with pytest.warns(UserWarning, match="'skin' is left out .USD shows PNG and JPEG images alone"):
        write_usd(tmp_path / "card.usda", rig_of(mesh))
    assert [each.name for each in tmp_path.iterdir()] == ["card.usda"]
    found = read_usd(tmp_path / "card.usda").neutral.appearance
    assert found is not None
    assert found["card"].colour == (1.0, 0.5, 0.0, 1.0)


def test_where_an_image_cannot_be_written_nothing_is(tmp_path: Path) -> None:
    (tmp_path / "card_squares1.png").mkdir()
    two = Finish(layers={"glow": texture([[(9, 9, 9)]])})
    with pytest.raises(FileError, match=r"card_squares1\.png: this is a folder"):
        write_usd(tmp_path / "card.usda", rig_of(card(Material(texture=texture(), finish=two))))
    assert [each.name for each in tmp_path.iterdir()] == ["card_squares1.png"]


def test_a_stage_says_whose_a_mesh_is(tmp_path: Path) -> None:
    from pxr import Sdf

    mesh = card(None)
    owned = Mesh(mesh.vertices, mesh.faces, copyright="© somebody")
    for each, said in ((mesh, ""), (owned, "© somebody")):
        write_usd(tmp_path / "card.usda", rig_of(each))
        layer = Sdf.Layer.OpenAsAnonymous(str(tmp_path / "card.usda"))
        assert layer.comment == said
