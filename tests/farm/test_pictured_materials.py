"""Pictures show what materials, lamps, cameras and heads are said to be."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import elastomorph as em
from cards import BACK, GREEN, RED, WHITE, card, image_of, texture, unlit
from character_makers import make
from elastomorph.errors import MeshError, ParameterError
from elastomorph.farm.pictures.painter import Frame, Painter, lamp_colour, scene_of
from elastomorph.farm.reading.sheets import contact_sheet
from elastomorph.model.mesh import FaceLabels, Material, Mesh, Texture, UVMap
from needs import extra
from scenes import ball

extra("embreex", "farm")

SIZE = (40, 40)
STRAIGHT = {"camera.fill": 0.5, "camera.distance": 4.0}
"""A card of 2 × 2, whose D is its diagonal, is 14 pixels wide."""

SIDES = (np.s_[:48], np.s_[48:])
"""Of a picture of 96 pixels: the face's right is on the left."""


def painted(mesh: Mesh, **values: float) -> dict[str, NDArray[Any]]:
    """The arrays of one picture of a mesh; columns are named with _ for the dot."""
    columns = STRAIGHT | {name.replace("_", ".", 1): own for name, own in values.items()}
    drawn = Painter(em.Rig(mesh, {}), SIZE, {"corner": 0}).draw(mesh.vertices[None], columns)
    return {name: own[0] for name, own in drawn.items()}


def two_cards(front: Material, back: Material) -> Mesh:
    """A card of 2 × 2 and one behind it, by half a length."""
    one = card(front)
    vertices = np.concatenate([one.vertices, one.vertices - [0, 0, 0.5]])
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    uv = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] * 2)
    names = FaceLabels(("front", "tongue"), np.array([0, 0, 1, 1], dtype=np.int32))
    corners = np.array(faces, dtype=np.int32).reshape(-1)
    return Mesh(
        vertices, faces, UVMap(uv, corners), names, appearance={"front": front, "tongue": back}
    )


def see_through(alpha: int) -> Texture:
    """Green; its left half is opaque, the right has this opacity."""
    row = [(*GREEN, 255), (*GREEN, 255), (*GREEN, alpha), (*GREEN, alpha)]
    return Texture(image_of([row] * 4), "green", smooth=False)


def test_an_image_is_where_its_coordinates_say() -> None:
    """Rows from the top: red and green, blue and white."""
    drawn = painted(card(unlit(texture())))
    shown = drawn["colour"]
    assert [tuple(shown[y, x].tolist()) for y in (16, 23) for x in (16, 23)] == [
        RED,
        GREEN,
        (0, 0, 255),
        WHITE,
    ]
    assert (drawn["parts"] > 0).sum() == 14 * 14
    # z is forward, from a camera at 4 D.
    np.testing.assert_allclose(drawn["depth"][20, 20], 4 * np.sqrt(8), rtol=1e-6)
    np.testing.assert_array_equal(drawn["normals"][20, 20], [0, 0, -127])


def test_what_is_cut_out_shows_what_is_behind_in_colour_and_labels() -> None:
    cut = unlit(see_through(0), opacity="mask", cutoff=0.5)
    drawn = painted(two_cards(cut, unlit(colour=(1.0, 0.0, 0.0, 1.0))))
    assert drawn["colour"][20, [17, 22]].tolist() == [list(GREEN), list(RED)]
    near, far = drawn["depth"][20, [17, 22]]
    np.testing.assert_allclose(far - near, 0.5, rtol=1e-5)
    names = Painter(em.Rig(ball(), {}), SIZE).labels["parts"][2]["names"]
    assert [names[part] for part in drawn["parts"][20, [17, 22]]] == ["skin", "tongue"]


@pytest.mark.parametrize(("alpha", "front"), [(64, False), (191, True)])
def test_what_blends_is_mixed_in_colour_and_whole_in_labels(alpha: int, front: bool) -> None:
    veil = unlit(see_through(alpha), opacity="blend")
    drawn = painted(two_cards(veil, unlit(colour=(1.0, 0.0, 0.0, 1.0))))
    red, green, blue = drawn["colour"][20, 22].tolist()
    share = alpha / 255
    mixed = [1.055 * light ** (1 / 2.4) - 0.055 for light in (1 - share, share)]
    np.testing.assert_allclose([red, green, blue], [255 * mixed[0], 255 * mixed[1], 0], atol=1)
    assert drawn["colour"][20, 17].tolist() == list(GREEN)
    behind = drawn["depth"][20, 22] - drawn["depth"][20, 17]
    np.testing.assert_allclose(behind, 0.0 if front else 0.5, atol=1e-4)


def test_a_blend_that_lets_nothing_through_is_solid_and_casts_shadows() -> None:
    """Exporters say of whole characters that they blend."""
    whole = Texture(image_of([[(*GREEN, 255)] * 2] * 2), "green")
    blended, solid = (
        painted(two_cards(Material(texture=whole, opacity=kind), Material()))["colour"]
        for kind in ("blend", "opaque")
    )
    np.testing.assert_array_equal(blended, solid)


def test_the_back_of_what_has_only_a_front_is_not_there() -> None:
    red = unlit(colour=(1.0, 0.0, 0.0, 1.0))
    assert not painted(card(red, BACK))["parts"].any()
    both = unlit(colour=(1.0, 0.0, 0.0, 1.0), double_sided=True)
    drawn = painted(card(both, BACK))
    assert drawn["colour"][20, 20].tolist() == list(RED)
    np.testing.assert_array_equal(drawn["normals"][20, 20], [0, 0, -127])


def test_a_fine_image_seen_from_far_is_averaged() -> None:
    """Black and white squares, many to a pixel, are grey; in light, not in codes."""
    board = np.indices((256, 256)).sum(axis=0) % 2 * 255
    fine = Texture(image_of(np.repeat(board[..., None], 3, axis=2)), "board")
    shown = painted(card(unlit(fine)))["colour"][16:24, 16:24]
    assert np.abs(shown.astype(int) - 188).max() <= 2


def test_the_lamp_lights_the_side_it_is_on_in_its_colour() -> None:
    left = painted(ball(), light_azimuth=90, light_elevation=0, light_ambient=0.0)["colour"]
    # The face's left is on the right of a picture from the front.
    assert left[20, 24].sum() > 300
    assert not left[20, 15].any()
    dark = painted(ball(), light_strength=0, light_ambient=0)["colour"]
    assert not dark[20, 20].any()
    warm, cold = (
        painted(ball(), light_temperature=kelvin)["colour"][20, 20].astype(int)
        for kelvin in (3000, 12000)
    )
    assert warm[0] - warm[2] > cold[0] - cold[2] + 20


def test_what_is_before_the_lamp_casts_a_shadow() -> None:
    """A card above a floor, the lamp straight above both: below it the floor is dark."""
    floor = np.array([[-2.0, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]])
    vertices = np.concatenate([floor, floor * 0.4 + [0, 1.5, 0]])
    mesh = Mesh(vertices, [[0, 1, 2, 3], [4, 5, 6, 7]])
    above = {"camera_elevation": 40, "camera_fill": 1.0, "light_ambient": 0.0}
    lit = painted(mesh, light_elevation=90, **above)["colour"].sum(axis=-1)
    assert 20 < (lit < 10).sum() < 200
    aside = painted(mesh, light_elevation=30, **above)["colour"].sum(axis=-1)
    assert aside[lit < 10].max() > 100


def test_colours_of_lamps_are_equally_bright_and_white_by_day() -> None:
    np.testing.assert_allclose(lamp_colour(6504.0), 1.0)
    for kelvin in (1700, 2222, 2223, 4000, 4001, 25000):
        colour = lamp_colour(kelvin)
        assert (colour > 0).all()
        np.testing.assert_allclose(colour @ [0.2126, 0.7152, 0.0722], 1.0)
    np.testing.assert_allclose(lamp_colour(4000), lamp_colour(4000.1), rtol=1e-2)


def test_heads_and_cameras_turn_as_their_columns_say() -> None:
    """To the face's left is to the right of a picture from the front."""
    frame = Frame(np.array([1.0, 2.0, 3.0]), 2.0, (100, 80))
    nose, top = np.array([[1.0, 2, 4]]), np.array([[1.0, 3, 3]])

    def at(point: NDArray[Any], **values: float) -> NDArray[Any]:
        columns = {name.replace("_", ".", 1): own for name, own in values.items()}
        scene = scene_of(frame, columns)
        return scene.pixels(scene.seen(point))[0]

    middle = np.array([39.5, 49.5])
    np.testing.assert_allclose(at(nose), middle)
    assert at(nose, head_yaw=20)[0] > 40
    assert at(nose, head_pitch=20)[1] < 49
    assert at(top, head_roll=20)[0] > 40
    assert at(nose, head_x=0.1)[0] > 40
    assert at(nose, camera_azimuth=20)[0] < 39
    assert at(nose, camera_elevation=20)[1] > 50
    assert at(top, camera_roll=20)[0] > 40
    np.testing.assert_allclose(at(nose, camera_x=0.1, camera_y=-0.2), middle + [10, -20])
    # A length of D takes so much of the height, from any distance.
    for distance in (2.0, 50.0):
        high, low = (
            at(np.array([[1.0, 2 + y, 3]]), camera_fill=0.6, camera_distance=distance)[1]
            for y in (-1, 1)
        )
        np.testing.assert_allclose(high - low, 60)


def test_a_camera_inside_the_head_still_draws() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drawn = painted(ball(), camera_distance=1.0, head_z=1.0)
    assert (drawn["depth"] >= 0).all()


def test_wrong_pictures_are_refused() -> None:
    rig = em.Rig(ball(), {})
    with pytest.raises(ParameterError, match="1 to 4096 pixels"):
        Painter(rig, (0, 40))
    with pytest.raises(ParameterError, match="found colours"):
        Painter(rig, SIZE, arrays=("colours",))
    with pytest.raises(ParameterError, match="landmark chin is vertex 9999"):
        Painter(rig, SIZE, {"chin": 9999})
    with pytest.raises(MeshError, match="no polygons"):
        Painter(em.Rig(Mesh(np.eye(3)), {}), SIZE)
    with pytest.raises(ParameterError, match="needs pictures"):
        contact_sheet({}, [1])


def test_a_contact_sheet_shows_all_arrays_and_the_landmarks(tmp_path: Path) -> None:
    painter = Painter(em.Rig(ball(), {}), SIZE, {"front": 264, "back": 265})
    drawn = painter.draw(np.repeat(ball().vertices[None], 3, axis=0), STRAIGHT)
    marks = drawn["landmarks"][0]
    assert sorted(marks[:, 2]) == [0, 1]
    sheet = contact_sheet(drawn, [5, 17, 1000], tmp_path / "sheet.png", title="three")
    assert (tmp_path / "sheet.png").stat().st_size > 1000
    assert (sheet == [60, 230, 90]).all(axis=-1).sum() > 20
    smaller = contact_sheet({"colour": drawn["colour"]}, [5, 17, 1000])
    assert smaller.shape[1] < sheet.shape[1] / 2


def test_a_character_with_images_closes_its_eyes_in_all_arrays(tmp_path: Path) -> None:
    """Skin of the colour of its image; the lid covers the eye in colour, depth and parts alike."""
    rig = em.read_rig(make("plain", tmp_path))
    closed = rig.batch(np.eye(len(rig.names))[[rig.names.index("eyeBlinkLeft")]])
    painter = Painter(rig, (96, 96))
    straight = {"camera.fill": 0.9, "light.azimuth": 0.0, "light.elevation": 0.0}
    drawn = painter.draw(np.concatenate([rig.neutral.vertices[None], closed]), straight)
    pupil = painter.labels["parts"][2]["names"].index("pupil")
    eyes = [(drawn["parts"][face] == pupil)[:, side].sum() for face in (0, 1) for side in SIDES]
    assert min(eyes[0], eyes[1], eyes[2]) > 5
    assert eyes[3] == 0
    covered = (drawn["parts"][0] == pupil) & (drawn["parts"][1] != pupil)
    assert (drawn["depth"][1][covered] < drawn["depth"][0][covered]).all()
    red, green, blue = drawn["colour"][1][covered].mean(axis=0)
    assert red > green + 15 > blue + 25
