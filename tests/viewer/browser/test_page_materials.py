"""Known materials in known light: what glTF and VRM say of a surface is what is seen of it.

The lamp stands where the page's light says, so in flat colours every pixel can be derived: a toon
shows its colour where the cosine to the lamp is above its edge, and its shade below.
"""

from __future__ import annotations

import io
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from pictures import picture
from PIL import Image
from test_broken_files import choose
from test_skins import QUARTERS, colours
from visiting import FRAME, Visit, empty_page, settled, wait

from cards import BLUE, FLAT, GREEN, RED, WHITE, image_of
from elastomorph.cli.options import NamedRig
from elastomorph.cli.view import face_file
from elastomorph.viewer.file_scenes import FaceFile, read_scene
from gltf_builder import GltfBuilder

if TYPE_CHECKING:
    from playwright.sync_api import Page

CARD = {
    "POSITION": FLAT.astype("<f4"),
    "NORMAL": np.tile(np.float32([0, 0, 1]), (4, 1)),
    "TEXCOORD_0": np.float32([[0, 1], [1, 1], [1, 0], [0, 0]]),
}
BACKWARDS = {name: CARD[name] * np.float32([-1, 1, -1]) for name in ("POSITION", "NORMAL")}
NUMBERS = count()
TOON = "VRMC_materials_mtoon"
UNLIT = {"KHR_materials_unlit": {}}
TOWARDS = np.array([-0.50, 0.60, 0.62]) / np.linalg.norm([-0.50, 0.60, 0.62])
"""The lamp, as seen from the camera."""


class Cards(GltfBuilder):
    """Squares of 2 × 2 that face the camera, each with a material."""

    def __init__(self) -> None:
        super().__init__()
        self.add("scenes", {"nodes": []})

    def card(self, material: dict[str, Any], **columns: Any) -> None:
        """Another one; columns take the place of those of a card."""
        primitive = {
            "attributes": self.attributes(CARD | columns, interleaved=False),
            "indices": self.accessor(np.array([0, 1, 2, 0, 2, 3], "<u2")),
            "material": self.add("materials", material),
        }
        mesh = self.add("meshes", {"primitives": [primitive]})
        self.json["scenes"][0]["nodes"].append(self.add("nodes", {"mesh": mesh}))

    def image(self, content: bytes, kind: str | None = None, **reference: Any) -> dict[str, Any]:
        """A reference to a texture of an image; `kind` is the extension that names it."""
        image = self.add("images", {"bufferView": self.view(content), "mimeType": "image/png"})
        sampler = self.add("samplers", {"magFilter": 9728, "minFilter": 9728})
        names = {"source": image} if kind is None else {"extensions": {kind: {"source": image}}}
        return {"index": self.add("textures", {"sampler": sampler} | names)} | reference

    def pixels(self, pixels: Any, **reference: Any) -> dict[str, Any]:
        return self.image(image_of(pixels), **reference)


def seen(page: Page, cards: GltfBuilder, folder: Path) -> list[tuple[int, ...]]:
    """The colours in the quarters of what a file shows."""
    name = f"card{next(NUMBERS)}"
    choose(page, f"{name}.glb", cards.write(folder / "card.glb").read_bytes())
    wait(page, f"elastomorph.models().some(model => model.name === '{name}')")
    page.evaluate(
        "elastomorph.update({ arrangement: 'single', shown: ["
        f"elastomorph.models().findIndex(model => model.name === '{name}')] }})"
    )
    settled(page)  # the picture of the first file has no size before
    return colours(picture(page), QUARTERS)


def alike(found: list[tuple[int, ...]], expected: list[tuple[int, ...]]) -> bool:
    return bool(np.abs(np.array(found) - expected).max() <= 1)


@pytest.fixture
def page(visit: Visit) -> Page:
    return visit(empty_page(), size=FRAME)


def one(material: dict[str, Any], cards: Cards | None = None, **columns: Any) -> Cards:
    made = cards or Cards()
    made.card(material, **columns)
    return made


def toon(**fields: Any) -> dict[str, Any]:
    """Red in light, blue in shade."""
    flat = {"shadeColorFactor": [0, 0, 1], "shadingToonyFactor": 1} | fields
    base = {"baseColorFactor": [1, 0, 0, 1]}
    return {"pbrMetallicRoughness": base, "extensions": {TOON: flat}}


@pytest.mark.parametrize("door", ["vrm", "gltf", "mesh", "settings"])
def test_a_character_looks_the_same_through_all_doors(
    page: Page, visit: Visit, tmp_path: Path, door: str
) -> None:
    """A card of VRM 0.x, which looks along -Z: both the page and the command turn it around.

    Its colours and normals are those of its vertices, which only the file itself has.
    """
    cards = Cards()
    cards.json["extensions"] = {"VRM": {"materialProperties": [{}]}}
    colours_of = np.float32([[0, 1, 0, 1], [0, 1, 0, 1], [1, 0, 0, 1], [1, 0, 0, 1]])
    lean = np.tile(np.float32([0.6, 0, -0.8]), (4, 1))
    cards.card({}, **BACKWARDS | {"NORMAL": lean, "COLOR_0": colours_of})
    move = cards.accessor(np.float32([[0, 0, 0], [0, 0, 0], [0, 0.2, 0], [0, 0.2, 0]]))
    cards.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": move}]
    dropped = seen(page, cards, tmp_path)
    served = visit(read_scene([through(door, cards, tmp_path)]), size=FRAME)
    assert colours(picture(served), QUARTERS) == dropped
    assert dropped[0][0] > dropped[0][1] + 40, "the upper half is red"
    assert dropped[2][1] > dropped[2][0] + 40, "the lower half is green"


def through(door: str, cards: Cards, folder: Path) -> FaceFile:
    """The first of some cards as the command line names it."""
    cards.json["nodes"][0]["name"] = "card"
    mesh = None
    if door == "mesh":  # another card, nearer to the camera, is not meant
        mesh = ["card"]
        cards.card({}, POSITION=BACKWARDS["POSITION"] - np.float32([0, 0, 0.5]))
    name = "card.gltf" if door == "gltf" else "card.glb"
    place = cards.write(folder / name)
    if door == "vrm":
        place = place.rename(folder / "card.vrm")
    if door == "settings":
        place = folder / "elastomorph.toml"
        words = f'[character]\nrig = "{name}"\n\n[groups]\nall = ["*"]\n'
        place.write_text(words, encoding="utf-8")
    return face_file(NamedRig.of(str(place), mesh=mesh), str(place), lambda _: None)


def test_colours_of_vertices_tint_the_base(page: Page, tmp_path: Path) -> None:
    """Linear, as floats or fractions; without images they alone dress a face."""
    base = {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1]}, "extensions": UNLIT}
    floats = np.tile(np.float32([0.0, 0.5, 1.0]), (4, 1))
    assert alike(seen(page, one(base, COLOR_0=floats), tmp_path), [(0, 188, 255)] * 4)
    fractions = np.tile(np.array([255, 0, 0, 255], "u1"), (4, 1))
    assert alike(seen(page, one(base, COLOR_0=fractions), tmp_path), [RED] * 4)


def test_a_toon_is_its_colour_or_its_shade(page: Page, tmp_path: Path) -> None:
    """A card that faces the camera has the cosine 0.62 to the lamp."""
    green = Cards()
    shade = green.pixels([[GREEN]])
    white = {"shadeColorFactor": [1, 1, 1], "shadeMultiplyTexture": shade}
    cases = [(toon(shadingShiftFactor=0.7), RED), (toon(shadingShiftFactor=-0.5), RED)]
    cases += [(toon(shadingShiftFactor=-0.7), BLUE)]
    coloured = np.tile(np.array([255, 255, 254, 255], "u1"), (4, 1))  # so that it is dressed
    for material, expected in cases:
        found = seen(page, one(material, COLOR_0=coloured), tmp_path)
        assert alike(found, [expected] * 4), (material, found)
    material = toon(shadingShiftFactor=-0.7, **white)
    assert alike(seen(page, one(material, green, COLOR_0=coloured), tmp_path), [GREEN] * 4)


def test_toons_of_the_first_vrm_have_colours_as_screens_do(page: Page, tmp_path: Path) -> None:
    cards = Cards()
    red = {"baseColorTexture": cards.pixels([[RED]])}
    cards.card({"pbrMetallicRoughness": red}, **BACKWARDS)
    shade = {"vectorProperties": {"_ShadeColor": [0, 0.5, 1, 1]}}
    numbers = {"_ShadeShift": 0.9, "_ShadeToony": 1}
    named = {"shader": "VRM/MToon", "floatProperties": numbers, **shade}
    cards.json["extensions"] = {"VRM": {"materialProperties": [named]}}
    assert alike(seen(page, cards, tmp_path), [(0, 128, 255)] * 4)
    numbers["_ShadeShift"] = 0
    cards.json["extensions"] = {"VRM": {"materialProperties": [named]}}
    assert alike(seen(page, cards, tmp_path), [RED] * 4)


def test_bumps_lean_towards_the_lamp_or_away(page: Page, tmp_path: Path) -> None:
    """x of a normal map goes along u, y against v: up on the image is up on the card."""
    leaning = np.array([[(-0.7, 0.0), (0.7, 0.0)], [(0.0, 0.7), (0.0, -0.7)]])
    normals = np.dstack([leaning, np.sqrt(1 - (leaning**2).sum(-1))])
    cards = Cards()
    bumps = cards.pixels(np.rint(127.5 * (normals + 1)))
    material = toon(shadingShiftFactor=-0.5) | {"normalTexture": bumps}
    material["pbrMetallicRoughness"] = {"baseColorTexture": cards.pixels([[RED]])}
    lit = normals.reshape(-1, 3) @ TOWARDS > 0.5
    assert lit.tolist() == [True, False, True, False]
    found = seen(page, one(material, cards), tmp_path)
    assert alike(found, [RED if each else BLUE for each in lit])
    flat = Cards()
    again = toon(shadingShiftFactor=-0.5) | {
        "normalTexture": flat.pixels(np.rint(127.5 * (normals + 1)), scale=0)
    }
    again["pbrMetallicRoughness"] = {"baseColorTexture": flat.pixels([[RED]])}
    assert alike(seen(page, one(again, flat), tmp_path), [RED] * 4)


def test_the_file_s_normals_are_those_that_are_lit(page: Page, tmp_path: Path) -> None:
    """A card whose normals lean away from the lamp is in shade, flat as it is."""
    away = np.tile(np.float32([0.8, -0.4, 0.45]), (4, 1))
    cards = Cards()
    material = toon()
    material["pbrMetallicRoughness"] = {"baseColorTexture": cards.pixels([[RED]])}
    assert alike(seen(page, one(material, cards, NORMAL=away), tmp_path), [BLUE] * 4)


def test_light_of_its_own_is_added(page: Page, tmp_path: Path) -> None:
    cards = Cards()
    black = toon(shadeColorFactor=[0, 0, 0])
    black["pbrMetallicRoughness"] = {"baseColorTexture": cards.pixels([[(0, 0, 0)]])}
    black["emissiveFactor"] = [0.25, 1, 1]
    black["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": 2.0}
    black["emissiveTexture"] = cards.pixels([[WHITE, (255, 0, 0)]])
    assert alike(seen(page, one(black, cards), tmp_path), [(188, 255, 255), (188, 0, 0)] * 2)


def test_metal_has_no_light_but_its_own_colour(page: Page, tmp_path: Path) -> None:
    """Left half metal, right half not: there the lamp's white is on the red, and creases darken."""
    cards = Cards()
    finish = cards.pixels([[(0, 128, 255), (0, 128, 0)]])
    creases = cards.pixels([[WHITE], [(64, 64, 64)]])
    shading = {"baseColorTexture": cards.pixels([[RED]]), "metallicRoughnessTexture": finish}
    material = {"pbrMetallicRoughness": shading, "occlusionTexture": creases}
    found = np.array(seen(page, one(material, cards), tmp_path))
    metal, other = found[[0, 2]], found[[1, 3]]
    assert (metal[:, 1:] == 0).all()
    assert (other[:, 1:] > 0).all()
    for upper, lower in (metal, other):
        assert 0.2 < lower[0] / upper[0] < 0.9


def test_images_take_the_coordinates_they_ask_for(page: Page, tmp_path: Path) -> None:
    """The base by the second set, turned by a half; the shade by the first."""
    cards = Cards()
    pixels = [[RED, GREEN], [BLUE, WHITE]]
    material = toon(shadingShiftFactor=0.9)
    material["pbrMetallicRoughness"] = {"baseColorTexture": cards.pixels(pixels, texCoord=1)}
    flat = material["extensions"][TOON]
    flat |= {"shadeColorFactor": [1, 1, 1], "shadeMultiplyTexture": cards.pixels(pixels)}
    turned = 1 - CARD["TEXCOORD_0"]
    assert alike(
        seen(page, one(material, cards, TEXCOORD_1=turned), tmp_path), [WHITE, BLUE, GREEN, RED]
    )
    flat["shadingShiftFactor"] = -0.9
    cards.json["materials"][0] = material
    assert alike(seen(page, cards, tmp_path), [RED, GREEN, BLUE, WHITE])


def test_of_two_clear_cards_the_nearer_is_drawn_last(page: Page, tmp_path: Path) -> None:
    found = []
    for names in (("near", "far"), ("far", "near")):
        cards = Cards()
        for name in names:
            colour = RED if name == "near" else BLUE
            base = {"baseColorTexture": cards.pixels([[(*colour, 128)]])}
            material = {"pbrMetallicRoughness": base, "alphaMode": "BLEND", "extensions": UNLIT}
            cards.card(
                material, POSITION=CARD["POSITION"] + np.float32([0, 0, 0.1 * (name == "near")])
            )
        found.append(seen(page, cards, tmp_path))
    assert found[0] == found[1]
    for red, _, blue in found[0]:
        assert red > blue > 100


def test_what_is_solid_of_a_clear_part_hides_what_is_behind(page: Page, tmp_path: Path) -> None:
    """Two cards of one part, the nearer first, as hair is: without depth the farther won."""
    cards = Cards()
    both = {
        "POSITION": np.concatenate([FLAT + [0, 0, 0.1], FLAT]).astype("<f4"),
        "NORMAL": np.tile(CARD["NORMAL"], (2, 1)),
        "TEXCOORD_0": np.concatenate(
            [CARD["TEXCOORD_0"] * [0.5, 1], CARD["TEXCOORD_0"] * [0.5, 1] + [0.5, 0]]
        ).astype("<f4"),
    }
    base = {"baseColorTexture": cards.pixels([[(*RED, 255), (*BLUE, 255)]])}
    cards.card({"pbrMetallicRoughness": base, "alphaMode": "BLEND", "extensions": UNLIT}, **both)
    corners = cards.accessor(np.array([0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7], "<u2"))
    cards.json["meshes"][0]["primitives"][0]["indices"] = corners
    assert alike(seen(page, cards, tmp_path), [RED] * 4)


@pytest.mark.parametrize("kind", ["WEBP", "AVIF"])
def test_images_of_other_kinds(page: Page, tmp_path: Path, kind: str) -> None:
    file = io.BytesIO()
    try:
        Image.new("RGB", (8, 8), (200, 100, 50)).save(file, kind, quality=100)
    except (KeyError, OSError):
        pytest.skip(f"needs a Pillow that writes {kind}")
    cards = Cards()
    texture = cards.image(file.getvalue(), f"EXT_texture_{kind.lower()}")
    cards.card({"pbrMetallicRoughness": {"baseColorTexture": texture}, "extensions": UNLIT})
    found = np.array(seen(page, cards, tmp_path))
    assert np.abs(found - [200, 100, 50]).max() <= 6


def test_images_that_cannot_be_shown_are_named(page: Page, tmp_path: Path) -> None:
    """Too large by what they say of themselves, so that they are never unpacked; or of a kind."""
    large = bytearray(image_of([[WHITE]]))
    large[16:24] = (20_000).to_bytes(4, "big") * 2
    basis = b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(80)
    cases = {
        bytes(large): "image 0 is larger than 8,192",
        basis: "image 0 is KTX 2",
        b"no image at all": "image 0 is damaged",
    }
    for content, words in cases.items():
        cards = Cards()
        kind = "KHR_texture_basisu" if content == basis else None
        base = {"baseColorTexture": cards.image(content, kind), "baseColorFactor": [0, 1, 0, 1]}
        cards.card({"pbrMetallicRoughness": base, "extensions": UNLIT})
        found = seen(page, cards, tmp_path)
        message = page.get_by_role("alert").locator(".message").last
        assert words in message.inner_text()
        assert alike(found, [GREEN] * 4)
        page.keyboard.press("Escape")


def test_what_is_not_shown_is_said_in_a_sentence(page: Page, tmp_path: Path) -> None:
    coat = {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5}}
    none = {"KHR_materials_clearcoat": {"clearcoatFactor": 0}}
    lined = toon(outlineWidthMode="worldCoordinates", outlineWidthFactor=0.1)
    rim = toon(parametricRimColorFactor=[0, 0.2, 0])
    cards = one({"extensions": none})
    for material in ({"extensions": coat}, lined, rim):
        cards.card(material)
    seen(page, cards, tmp_path)
    words = page.get_by_role("alert").locator(".message").inner_text()
    assert "clear coat, outlines and rim light of its materials are not shown." in words


def test_specular_and_glossiness_have_a_base_too(page: Page, tmp_path: Path) -> None:
    cards = Cards()
    glossy = {"diffuseTexture": cards.pixels([[GREEN]]), "glossinessFactor": 0.2}
    one({"extensions": {"KHR_materials_pbrSpecularGlossiness": glossy}}, cards)
    found = seen(page, cards, tmp_path)
    assert all(green > 2 * max(red, blue) for red, green, blue in found)


def test_the_pointer_reaches_what_is_seen(page: Page, tmp_path: Path) -> None:
    """Through the clear half of an image, and through a back that is not drawn."""
    cards = Cards()
    half = cards.pixels([[(255, 0, 0, 0), (255, 0, 0, 255)]])
    base = {"baseColorTexture": half}
    cards.card({"pbrMetallicRoughness": base, "alphaMode": "MASK", "extensions": UNLIT})
    below = CARD["POSITION"] - np.float32([0, 0, 0.1])
    cards.card({"extensions": UNLIT}, POSITION=below)
    cards.card({"extensions": UNLIT}, POSITION=BACKWARDS["POSITION"] + np.float32([0, 0, 0.1]))
    seen(page, cards, tmp_path)
    box = page.locator(".picture").bounding_box()
    assert box
    for side, vertices in ((-0.2, range(4, 8)), (0.2, range(4))):
        middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.mouse.move(middle[0] + side * box["height"], middle[1])
        ends = "|".join(map(str, vertices))
        wait(page, f"/vertex ({ends})$/.test(document.querySelector('.status').textContent)")
