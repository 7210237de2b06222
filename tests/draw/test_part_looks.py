"""Names of materials and groups tell the parts of a head apart."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.draw.materials import LOOKS, part_of_name, parts_of
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
