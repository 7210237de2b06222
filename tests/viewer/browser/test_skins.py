"""The page shows surfaces as their files say, and the head of a whole figure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pictures import Pixels, picture
from visiting import FRAME, Visit, update

import elastomorph as em
from cards import (
    BACK,
    BLUE,
    BOTH,
    FLAT,
    GREEN,
    RED,
    UV,
    WHITE,
    card,
    character,
    image_of,
    texture,
    unlit,
)
from elastomorph.model.mesh import FaceLabels, Finish, Material, Mesh, Texture, Toon, UVMap
from elastomorph.viewer import Scene, rig_scene

QUARTERS = [(-0.2, 0.2), (0.2, 0.2), (-0.2, -0.2), (0.2, -0.2)]
"""Upper left and right, lower left and right, in halves of the card."""


def scene(mesh: Mesh) -> Scene:
    moved = mesh.with_vertices(mesh.vertices * [1, 1.05, 1])
    rig = em.Rig(mesh, {"taller": moved}, method="linear")
    return rig_scene(rig, curves=em.CurveNetwork([], len(mesh.vertices)))


def colours(pixels: Pixels, points: list[tuple[float, float]]) -> list[tuple[int, ...]]:
    """Those at places in the middle of the picture, over half its height, y upwards."""
    height, width = pixels.shape[:2]
    return [
        tuple(pixels[round(height * (0.5 - y)), round(width / 2 + height * x)].tolist())
        for x, y in points
    ]


def shown(visit: Visit, mesh: Mesh) -> list[tuple[int, ...]]:
    return colours(picture(visit(scene(mesh), size=FRAME)), QUARTERS)


def test_pixels_of_an_image_are_where_they_belong(visit: Visit) -> None:
    assert shown(visit, card(unlit(texture()))) == [RED, GREEN, BLUE, WHITE]
    turned = unlit(texture(rotation=np.pi / 2))
    assert shown(visit, card(turned)) == [BLUE, RED, WHITE, GREEN]
    moved = unlit(texture(offset=(0.5, 0.0)))
    assert shown(visit, card(moved)) == [GREEN, RED, WHITE, BLUE]


def test_an_image_goes_on_as_its_sampler_says(visit: Visit) -> None:
    """From the lower left quarter of the card on it is another image."""
    wide = UV * 2 - [0, 1]
    points = [(-0.3, 0.1), (-0.1, 0.1), (0.1, 0.1), (0.3, 0.1)]
    found = []
    for wrap in ("repeat", "mirror", "clamp"):
        mesh = card(unlit(texture(wrap=(wrap, wrap))), uv=wide)
        found.append(colours(picture(visit(scene(mesh), size=FRAME)), points))
    assert found == [
        [BLUE, WHITE, BLUE, WHITE],
        [BLUE, WHITE, WHITE, BLUE],
        [BLUE, WHITE, WHITE, WHITE],
    ]


def test_a_colour_tints_its_image_as_light_does(visit: Visit) -> None:
    half = unlit(texture(), colour=(0.5, 0.5, 0.5, 1.0))
    grey = shown(visit, card(half))[3]
    assert max(abs(part - 188) for part in grey) <= 1


def test_a_finish_comes_through_python(visit: Visit) -> None:
    """A toon in shade, as the cosine of a card to the lamp is 0.62; a light of its own is added."""
    finish = Finish(glow=(0.0, 0.5, 0.0), toon=Toon((0.0, 0.0, 1.0), shift=-0.7, toony=1.0))
    toon = Material(texture=texture([[RED]]), unlit=True, finish=finish)
    assert shown(visit, card(toon)) == [(0, 188, 255)] * 4


def test_masks_and_sides_let_the_wall_be_seen(visit: Visit) -> None:
    pixels = [[(*RED, 255), (*GREEN, 100)], [(*BLUE, 140), (*WHITE, 0)]]
    masked = shown(visit, card(unlit(texture(pixels), opacity="mask")))
    assert masked[0] == RED
    assert masked[2] == BLUE
    behind = shown(visit, card(unlit(texture()), BACK))
    for colour in (masked[1], masked[3], *behind):
        assert min(colour) > 200
        assert max(colour) - min(colour) < 12
    both = replace(unlit(texture()), double_sided=True)
    assert shown(visit, card(both, BACK)) == [RED, GREEN, BLUE, WHITE]


def test_what_is_behind_shines_through_what_blends(visit: Visit) -> None:
    for names in (("clear", "solid"), ("solid", "clear")):
        first, second = (FLAT + [0, 0, 0.1 * (name == "clear")] for name in names)
        mesh = Mesh(
            np.concatenate([first, second]),
            BOTH,
            uv=UVMap(np.concatenate([UV, UV]), np.array(BOTH, dtype=np.int32).reshape(-1)),
            materials=FaceLabels(names, np.array([0, 0, 1, 1], dtype=np.int32)),
            appearance={
                "clear": unlit(texture([[(255, 0, 0, 128)]]), opacity="blend"),
                "solid": unlit(texture([[BLUE]])),
            },
        )
        for red, green, blue in shown(visit, mesh):
            assert abs(red - 128) <= 2
            assert green == 0
            assert abs(blue - 127) <= 2


def test_a_damaged_image_leaves_the_colour(visit: Visit) -> None:
    broken = Texture(image_of()[:40], "broken")
    page = visit(scene(card(Material((0.0, 1.0, 0.0, 1.0), broken, unlit=True))), size=FRAME)
    assert colours(picture(page), QUARTERS) == [GREEN] * 4
    words = page.get_by_role("alert").locator(".message").inner_text()
    assert "image 0 is damaged" in words
    assert "only colours are shown there" in words


def test_heat_takes_the_place_of_the_image(visit: Visit) -> None:
    mesh = card(unlit(texture()))
    moved = mesh.with_vertices(mesh.vertices * [1, 1.05, 1])
    scenes = {
        "linear": em.Rig(mesh, {"taller": moved}, method="linear"),
        "other": em.Rig(mesh, {"taller": moved}, method="linear"),
    }
    both = em.viewer.comparison_scene(scenes, curves=em.CurveNetwork([], 4))
    page = visit(both, size=FRAME)
    update(page, arrangement="single", shown=[0])
    assert colours(picture(page), QUARTERS) == [RED, GREEN, BLUE, WHITE]
    update(page, heat=True, against=1)
    heat = colours(picture(page), QUARTERS)
    assert len(set(heat)) <= 2  # the colour of no distance, but for the last bit
    assert not {RED, GREEN, BLUE} & set(heat)


def test_the_camera_frames_the_head_of_a_figure(visit: Visit) -> None:
    """The head is a sixth of the figure's height, and most of the picture's."""
    bare = character().neutral
    labels = FaceLabels(("skin",), np.zeros(len(bare.faces), dtype=np.int32))
    uv = UVMap(np.zeros((1, 2)), np.zeros(len(bare.faces.indices), dtype=np.int32))
    skin = unlit(texture([[RED]]))
    mesh = Mesh(bare.vertices, bare.faces, uv=uv, materials=labels, appearance={"skin": skin})
    target = mesh.with_vertices(character().morphs["open"].target.vertices)
    rig = em.Rig(mesh, {"open": target}, method="linear")
    page = visit(rig_scene(rig, curves=em.CurveNetwork([], len(mesh.vertices))), size=FRAME)
    red = (picture(page) == RED).all(axis=-1)
    widest = red.sum(axis=1).max() / len(red)
    assert 0.4 < widest < 1
