"""A surface shows the image its file gives it: where, how bright, and what shines through."""

from __future__ import annotations

import struct
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cards import (
    BACK,
    BLUE,
    BOTH,
    FLAT,
    GREEN,
    PAPER,
    RED,
    UV,
    WHITE,
    card,
    image_of,
    texture,
    unlit,
)
from elastomorph.draw.camera import Camera
from elastomorph.draw.materials import (
    MOST_PIXELS,
    encoded,
    linear,
    pixels_of,
    places_in,
    welded_corners,
)
from elastomorph.draw.stage import Stage
from elastomorph.errors import ElastomorphWarning
from elastomorph.model.mesh import FaceLabels, Finish, Material, Mesh, Texture, UVMap
from scenes import ball, seen_at

SIZE = (120, 120)


def seen(mesh: Mesh, points: list[tuple[float, float]], **how: Any) -> list[tuple[int, ...]]:
    """The colours in the picture at points of the plane."""
    camera = Camera.framing(FLAT, size=SIZE)
    with Stage(mesh, camera, size=SIZE) as stage:
        image = stage.picture(**how)
    places = seen_at(camera, np.array([[x, y, 0.0] for x, y in points]), SIZE)
    return [tuple(image[int(row), int(column)].tolist()) for column, row in places]


QUARTERS = [(-0.5, 0.5), (0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)]
"""Upper left and right, lower left and right."""


def test_pixels_appear_where_texture_coordinates_put_them() -> None:
    assert seen(card(unlit(texture())), QUARTERS) == [RED, GREEN, BLUE, WHITE]


@pytest.mark.parametrize(("kind", "settings"), [("PNG", {}), ("WEBP", {"lossless": True})])
def test_lossless_formats_show_their_very_colours(kind: str, settings: dict[str, Any]) -> None:
    shown = Texture(image_of(kind=kind, **settings), "squares", smooth=False)
    assert seen(card(unlit(shown)), QUARTERS) == [RED, GREEN, BLUE, WHITE]


def test_jpeg_is_shown() -> None:
    grey = np.full((8, 8, 3), 90)
    shown = Texture(image_of(grey, "JPEG", quality=95), "grey")
    ((red, green, blue),) = seen(card(unlit(shown)), [(0.0, 0.0)])
    assert max(abs(red - 90), abs(green - 90), abs(blue - 90)) <= 1


def test_an_image_goes_on_beside_itself_as_its_sampler_says() -> None:
    """The square shows three images across and down; the left upper corner of each is red."""
    points = [(-0.85, 0.85), (-0.15, 0.85), (-0.5, 0.85), (0.15, 0.85)]
    wide = UV * 3 - [0, 2]  # from the upper left corner of the image
    repeated = seen(card(unlit(texture()), uv=wide), points)
    assert repeated == [RED, RED, GREEN, GREEN]
    mirrored = seen(card(unlit(texture(wrap=("mirror", "mirror"))), uv=wide), points)
    assert mirrored == [RED, GREEN, GREEN, RED]
    clamped = seen(card(unlit(texture(wrap=("clamp", "clamp"))), uv=wide), points)
    assert clamped == [RED, GREEN, GREEN, GREEN]


def test_an_image_may_wrap_one_way_across_and_another_down() -> None:
    wide = UV * [3, 1]
    points = [(-0.85, 0.5), (-0.5, 0.5), (-0.15, 0.5), (0.15, 0.5)]
    mixed = card(unlit(texture(wrap=("mirror", "clamp"))), uv=wide)
    assert seen(mixed, points) == [RED, GREEN, GREEN, RED]
    tall = UV * [1, 3] - [0, 2]
    points = [(-0.5, 0.85), (-0.5, 0.5), (-0.5, 0.15), (-0.5, -0.15)]
    mixed = card(unlit(texture(wrap=("clamp", "mirror"))), uv=tall)
    assert seen(mixed, points) == [RED, BLUE, BLUE, RED]
    mixed = card(unlit(texture(wrap=("clamp", "repeat"))), uv=tall)
    assert seen(mixed, points) == [RED, BLUE, RED, BLUE]


def test_a_transform_moves_turns_and_scales_the_coordinates() -> None:
    """Half an image to the right; a quarter turn counter-clockwise; a quarter of the image."""
    moved = card(unlit(texture(offset=(0.5, 0.0))))
    assert seen(moved, QUARTERS) == [GREEN, RED, WHITE, BLUE]
    turned = card(unlit(texture(rotation=np.pi / 2)))
    assert seen(turned, QUARTERS) == [BLUE, RED, WHITE, GREEN]
    scaled = card(unlit(texture(scale=(0.5, 0.5))))
    assert seen(scaled, QUARTERS) == [RED, RED, RED, RED]


def test_a_transform_scales_then_turns_then_moves() -> None:
    shown = texture(offset=(0.1, 0.2), rotation=np.pi / 2, scale=(2.0, 3.0))
    # (u, v) = (0.3, 0.6) from the bottom is (0.3, 0.4) from the top: scaled (0.6, 1.2), turned
    # to (1.2, -0.6), moved to (1.3, -0.4), which is 1.4 from the bottom.
    np.testing.assert_allclose(places_in(shown, np.array([[0.3, 0.6]])), [[1.3, 1.4]])


def test_a_colour_tints_its_image_as_light_does() -> None:
    """Half the light of white is 188 of 255 in sRGB, and it is that of the colour alone too."""
    half = (0.5, 0.5, 0.5, 1.0)
    grey = (188, 188, 188)
    assert seen(card(unlit(texture(), colour=half)), QUARTERS[3:]) == [grey]
    assert seen(card(unlit(colour=half)), QUARTERS[:1]) == [grey]


def test_light_and_what_shows_it_are_inverse() -> None:
    levels = np.arange(256) / 255
    np.testing.assert_allclose(encoded(linear(levels)), levels, atol=1e-6)


def test_a_lit_surface_is_shaded_and_an_unlit_one_is_not() -> None:
    grey = np.full((2, 2, 3), 100)
    bare = unlit(texture(grey))
    lit = replace(bare, unlit=False)
    ((first, _, _),) = seen(card(lit), [(0.0, 0.0)])
    turned = FLAT @ np.array([[0.6, 0, -0.8], [0, 1, 0], [0.8, 0, 0.6]])  # towards the right
    ((second, _, _),) = seen(card(lit), [(0.0, 0.0)], vertices=turned)
    assert abs(first - second) > 10
    assert seen(card(bare), [(0.0, 0.0)], vertices=turned) == [(100, 100, 100)]


def test_a_mask_shows_what_reaches_its_cutoff() -> None:
    pixels = [[(*RED, 255), (*GREEN, 120)], [(*BLUE, 0), (*WHITE, 140)]]
    masked = unlit(texture(pixels), opacity="mask", cutoff=0.5)
    assert seen(card(masked), QUARTERS) == [RED, PAPER, PAPER, WHITE]
    for opacity, shown in ((0.4, PAPER), (0.6, RED)):  # without an image
        bare = Material((1.0, 0.0, 0.0, opacity), opacity="mask", unlit=True)
        assert seen(card(bare), QUARTERS) == [shown] * 4
    low = replace(masked, cutoff=0.4)
    assert seen(card(low), QUARTERS) == [RED, GREEN, PAPER, WHITE]


def test_an_opaque_surface_takes_no_notice_of_opacity() -> None:
    pixels = [[(*RED, 0), (*GREEN, 120)], [(*BLUE, 0), (*WHITE, 140)]]
    assert seen(card(unlit(texture(pixels))), QUARTERS) == [RED, GREEN, BLUE, WHITE]


def test_what_is_behind_shines_through_what_blends() -> None:
    """A half clear card before a blue one, whichever the file names first."""
    clear = unlit(texture([[(255, 0, 0, 128)]]), opacity="blend")
    solid = unlit(colour=(0.0, 0.0, 1.0, 1.0))
    for names in (("clear", "solid"), ("solid", "clear")):
        first, second = (FLAT + [0, 0, 0.1 * (name == "clear")] for name in names)
        mesh = Mesh(
            np.concatenate([first, second]),
            BOTH,
            uv=UVMap(np.concatenate([UV, UV]), np.array(BOTH).reshape(-1)),
            materials=FaceLabels(names, np.array([0, 0, 1, 1])),
            appearance={"clear": clear, "solid": solid},
        )
        ((red, green, blue),) = seen(mesh, [(0.0, 0.0)])
        assert abs(red - 128) <= 2
        assert green == 0
        assert abs(blue - 127) <= 2


def test_polygons_that_blend_are_drawn_from_behind() -> None:
    """Two half clear cards of one material: the nearer one counts most, in either order."""
    image = texture([[(255, 0, 0, 128), (0, 0, 255, 128)]])
    left, right = np.full((4, 2), [0.25, 0.5]), np.full((4, 2), [0.75, 0.5])
    for uv in (np.concatenate([left, right]), np.concatenate([right, left])):
        mesh = Mesh(
            np.concatenate([FLAT + [0, 0, 0.1], FLAT]),
            BOTH,
            uv=UVMap(uv, np.array(BOTH).reshape(-1)),
            materials=FaceLabels(("card",), np.zeros(4, dtype=np.int32)),
            appearance={"card": unlit(image, opacity="blend")},
        )
        ((red, _, blue),) = seen(mesh, [(0.0, 0.0)])
        near, far = (red, blue) if uv[0, 0] < 0.5 else (blue, red)
        assert near > far + 40


def test_one_sided_surfaces_are_not_seen_from_behind() -> None:
    one = unlit(texture())
    assert seen(card(one, BACK), QUARTERS[:1]) == [PAPER]
    assert seen(card(replace(one, double_sided=True), BACK), QUARTERS[:1]) == [RED]


def test_colours_take_the_place_of_the_image_but_not_of_its_opacity() -> None:
    pixels = [[(*RED, 255), (*GREEN, 0)]]
    masked = card(unlit(texture(pixels), opacity="mask"))
    colours = np.full((4, 3), [0.0, 0.2, 1.0])
    shown = seen(masked, [(-0.5, 0.0), (0.5, 0.0)], colours=colours, lit=False)
    assert shown == [(0, 52, 255), PAPER]  # what paints a heat map is 2 % brighter


def test_what_nothing_is_said_of_is_white() -> None:
    mesh = card(None)
    assert seen(mesh, [(0.0, 0.0)], lit=False) == [WHITE]


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "empty"),
        (b"not an image at all", "no PNG, JPEG or WebP"),
        (image_of()[:50], "damaged"),
        (image_of(kind="BMP"), "no PNG, JPEG or WebP"),
    ],
)
def test_a_damaged_image_leaves_the_colour_and_one_warning(content: bytes, problem: str) -> None:
    broken = Texture(content, "squares")
    material = unlit(broken, colour=(0.0, 1.0, 0.0, 1.0))
    with pytest.warns(ElastomorphWarning, match=problem) as met:
        shown = seen(card(material), QUARTERS[:1])
    assert shown == [GREEN]
    assert len(met) == 1


def bomb(side: int) -> bytes:
    """A PNG that announces a square image and holds nothing."""
    head = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(b"")), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content))
        + kind
        + content
        + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks
    )


@pytest.mark.parametrize("side", [int(MOST_PIXELS**0.5) + 1, 14_000, 60_000])
def test_an_image_that_announces_too_many_pixels_is_not_decoded(side: int) -> None:
    pixels, problem = pixels_of(Material(texture=Texture(bomb(side), "bomb")))
    assert pixels is None
    assert "pixels" in problem


def test_a_large_image_is_made_smaller() -> None:
    wide = Texture(image_of(np.full((4, 4096, 3), 7)), "wide")
    pixels, _ = pixels_of(Material(texture=wide))
    assert pixels is not None
    assert pixels.shape == (2, 2048, 4)
    assert (pixels == [7, 7, 7, 255]).all()


def test_seams_are_shaded_as_if_they_were_none() -> None:
    """Two halves of a roof whose vertices are cut apart are lit like those that share them."""
    roof = np.array([[-1.0, -1, 0], [0, -1, 0.2], [0, 1, 0.2], [-1, 1, 0], [1, -1, 0], [1, 1, 0]])
    shared = Mesh(roof, [[0, 1, 2, 3], [1, 4, 5, 2]], appearance={})
    cut = Mesh(np.concatenate([roof, roof[[1, 2]]]), [[0, 1, 2, 3], [6, 4, 5, 7]], appearance={})
    assert welded_corners(cut).tolist()[:2] != welded_corners(cut).tolist()[4:6]
    camera = Camera.framing(roof, size=SIZE)
    with Stage(shared, camera, size=SIZE) as one, Stage(cut, camera, size=SIZE) as other:
        np.testing.assert_array_equal(one.picture(), other.picture())


def test_a_crowd_of_corners_at_one_place_is_no_seam() -> None:
    count = 500
    mesh = Mesh(np.zeros((3 * count, 3)), np.arange(3 * count).reshape(-1, 3), appearance={})
    assert len(np.unique(welded_corners(mesh))) == 3 * count


def test_what_is_smooth_has_highlights_where_its_image_is_black() -> None:
    """A black ball, wet and dry: light falls on it from the upper left of the camera."""
    mesh = ball()
    uv = UVMap(np.zeros((1, 2)), np.zeros(len(mesh.faces.indices), dtype=np.int32))
    labels = FaceLabels(("ball",), np.zeros(len(mesh.faces), dtype=np.int32))

    def brightest(roughness: float, **how: Any) -> int:
        black = Material(texture=texture([[(0, 0, 0)]]), finish=Finish(roughness))
        own = Mesh(mesh.vertices, mesh.faces, uv, labels, appearance={"ball": black})
        with Stage(own, size=(120, 120), supersampling=1) as stage:
            picture = stage.picture(background=(0.0, 0.0, 0.0), **how)
        return int(picture.max())

    assert brightest(0.05) > 150
    assert brightest(0.9) < 30
    assert brightest(0.05, lit=False) == 0
