"""Names of materials and groups tell the parts of a head apart."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.draw.materials import (
    LOOKS,
    SPAN,
    eye_image,
    iris_coordinates,
    part_of_name,
    parts_of,
)
from elastomorph.model.mesh import FaceLabels, Mesh
from scenes import ball, joined


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("M_ScleraLeft", "sclera"),
        ("M_IrisRight", "iris"),
        ("pupil_L", "pupil"),
        ("M_Teeth", "teeth"),
        ("M_GumsTongue", "gum"),
        ("M_EyeLashes", "lash"),
        ("M_LacrimalFluid", "hidden"),
        ("M_EyeBlend", "hidden"),
        ("M_EyeOcclusion", "hidden"),
        ("Eye_occlusion.001", "hidden"),
        ("lower lip", "lips"),
        ("leftEye", "sclera"),
        ("eyebrows", "brow"),
        ("MouthSocket", "mouth"),
        ("nostrils", "nostril"),
        ("scalp", "hair"),
        ("Wolf3D_Outfit_Top", "clothes"),
        ("Wolf3D_Glasses", "clothes"),
        ("T-Shirt", "clothes"),
        ("M_Face", "skin"),
        # words that only contain the telling letters
        ("temporal", "skin"),
        ("clips", "skin"),
        ("flash", "skin"),
        ("eyelid", "skin"),
        ("mouth_corner", "skin"),
        ("", "skin"),
    ],
)
def test_a_name_means_what_a_rigger_means_by_it(name: str, part: str) -> None:
    assert part_of_name(name) == part
    assert part in LOOKS or part == "hidden"


def test_every_polygon_is_in_exactly_one_part() -> None:
    mesh = joined(skin=ball(), M_Teeth=ball(0.2), M_EyeBlend=ball(0.3), lips=ball(0.1))
    parts = parts_of(mesh)
    assert set(parts) == {"skin", "teeth", "hidden", "lips"}
    together = np.sort(np.concatenate(list(parts.values())))
    np.testing.assert_array_equal(together, np.arange(len(mesh.faces)))


def test_groups_speak_where_materials_say_nothing() -> None:
    mesh = ball()
    count = len(mesh.faces)
    groups = FaceLabels(("teeth",), np.where(np.arange(count) < 10, 0, -1).astype(np.int32))
    default = FaceLabels(("lambert1",), np.zeros(count, np.int32))
    labelled = Mesh(mesh.vertices, mesh.faces, materials=default, groups=groups)
    np.testing.assert_array_equal(parts_of(labelled)["teeth"], np.arange(10))


@pytest.mark.parametrize(("name", "attached"), [("lashes", "lash"), ("tears", "skin")])
def test_only_pieces_of_their_own_are_hidden(name: str, attached: str) -> None:
    """A row of lash polygons in the skin is skin painted dark; a card of lashes is left out."""
    mesh = ball()
    of_face = np.where(np.arange(len(mesh.faces)) < 10, 1, 0).astype(np.int32)
    grown = Mesh(mesh.vertices, mesh.faces, groups=FaceLabels(("skin", name), of_face))
    assert "hidden" not in parts_of(grown)
    assert np.isin(np.arange(10), parts_of(grown)[attached]).all()
    assert len(parts_of(joined(skin=ball(), **{name: ball(0.5)}))["hidden"]) == len(mesh.faces)


def test_a_mesh_without_names_is_all_skin(sphere: Mesh) -> None:
    assert list(parts_of(sphere)) == ["skin"]


NONE = np.zeros(0, dtype=np.int64)


def _all(mesh: Mesh) -> np.ndarray:
    return np.arange(len(mesh.faces))


def test_the_pole_of_each_eyeball_shows_the_middle_of_the_image() -> None:
    mesh = joined(left=ball(1.5, (3, 2, 9)), right=ball(1.5, (-3, 2, 9)))
    place = iris_coordinates(mesh, _all(mesh), NONE)
    corners = mesh.vertices[mesh.faces.indices]
    poles = corners[:, 2] == 10.5
    assert poles.sum() == 48
    np.testing.assert_allclose(place[poles], 0.5, atol=1e-12)
    np.testing.assert_array_equal(place[corners[:, 2] <= 9], 0)


def test_image_coordinates_are_the_front_view_in_eyeball_radii() -> None:
    mesh = ball(2.0, (5, 6, 7))
    place = iris_coordinates(mesh, _all(mesh), NONE)
    corners = (mesh.vertices[mesh.faces.indices] - [5, 6, 7]) / 2
    near = (corners[:, 2] > 0) & (np.abs(corners[:, :2]).max(axis=1) < SPAN)
    np.testing.assert_allclose(place[near], 0.5 + corners[near, :2] / (2 * SPAN), atol=1e-12)


def test_flat_shells_and_eyes_with_an_iris_in_front_stay_white() -> None:
    flat = ball()
    flat = flat.with_vertices(flat.vertices * [1, 0.3, 1])
    np.testing.assert_array_equal(iris_coordinates(flat, _all(flat), NONE), 0)
    mesh = joined(eye=ball(), iris=ball(0.3, (0, 0, 0.8)))
    count = len(ball().faces)
    numbers = np.arange(count)
    np.testing.assert_array_equal(iris_coordinates(mesh, numbers, numbers + count), 0)


def test_an_iris_behind_the_white_is_not_seen_and_so_painted() -> None:
    mesh = joined(eye=ball(), iris=ball(0.9))
    count = len(ball().faces)
    numbers = np.arange(count)
    assert iris_coordinates(mesh, numbers, numbers + count).any()


def test_the_image_is_dark_in_the_middle_and_white_at_its_edges() -> None:
    image = eye_image(64).astype(int)
    assert image[31:33, 31:33].max() < 20
    edge = np.concatenate([image[0], image[-1], image[:, 0], image[:, -1]])
    assert edge.min() > 220
    np.testing.assert_array_equal(edge, edge[:1].repeat(len(edge), axis=0))
