"""The plane of symmetry, and what pairs of left and right targets do wrong."""

from __future__ import annotations

import numpy as np
import pytest
from planted_faults import grid, only, turn

from elastomorph.doctor.checks.sides import (
    Mirror,
    asymmetric_pairs,
    find_mirror,
    missing_sides,
    parse_sides,
    sided_pairs,
    swapped_sides,
)
from elastomorph.doctor.neutral import Neutral
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh


@pytest.fixture(scope="module")
def mirror(face: Mesh) -> Mirror:
    found = find_mirror(face)
    assert found is not None
    return found


def test_the_plane_of_the_head_is_x_zero(face: Mesh, mirror: Mirror) -> None:
    """And the mirror image of each vertex is a vertex, each other's."""
    np.testing.assert_allclose(np.abs(mirror.normal), [1, 0, 0], atol=1e-12)
    assert mirror.distance == pytest.approx(0.0, abs=1e-9)
    here = np.arange(len(mirror.partner))
    np.testing.assert_array_equal(mirror.partner[mirror.partner], here)
    image = face.vertices[mirror.partner] * [-1, 1, 1]
    np.testing.assert_allclose(image, face.vertices, atol=1e-9)


def test_the_plane_of_a_crooked_face_is_found_by_its_polygons(face: Mesh, mirror: Mirror) -> None:
    """A nose to the left and a head held askew change no vertex's mirror image."""
    points = face.vertices.copy()
    points[:, 0] += 0.4 * np.exp(-0.05 * ((points - points[600]) ** 2).sum(axis=1))
    askew = face.with_vertices(turn(points, 4.0) + [3.0, 0, 0])
    found = find_mirror(askew)
    assert found is not None
    np.testing.assert_array_equal(found.partner, mirror.partner)


def test_a_mesh_without_symmetry_has_no_mirror() -> None:
    mesh = grid(4, 3, seed=1)
    assert find_mirror(Mesh(mesh.vertices, [*mesh.faces[:11], [13, 14, 19]])) is None


def compared(face: Mesh, targets: dict[str, Mesh], mirror: Mirror) -> list[tuple[str, str, str]]:
    files = {name: f"{name}.obj" for name in targets}
    pairs = sided_pairs(targets)[0]
    found = asymmetric_pairs(Neutral(face), targets, files, mirror, pairs)
    found += swapped_sides(Neutral(face), targets, files, mirror, pairs)
    return [(one.name, one.severity, one.file) for one in found]


def test_mirrored_pairs_are_right(face: Mesh, rig: dict[str, Mesh], mirror: Mirror) -> None:
    assert compared(face, {name[:-4]: mesh for name, mesh in rig.items()}, mirror) == []


@pytest.mark.parametrize(("share", "severity"), [(0.8, "note"), (0.3, "warning")])
def test_a_weaker_side_is_reported_with_its_amount(
    face: Mesh, rig: dict[str, Mesh], mirror: Mirror, share: float, severity: str
) -> None:
    """A right smile of 80 % differs by 20 % of the motion."""
    left, right = rig["mouthSmile_L.obj"], rig["mouthSmile_R.obj"]
    weak = right.with_vertices(face.vertices + share * (right.vertices - face.vertices))
    targets = {"smileLeft": left, "smileRight": weak}
    files, pairs = {name: name for name in targets}, [("smileLeft", "smileRight")]
    found = only(asymmetric_pairs(Neutral(face), targets, files, mirror, pairs))
    assert (found.name, found.severity) == ("asymmetric-pair", severity)
    assert f"({100 * (1 - share):.0f} % of its motion)" in found.message


def test_swapped_sides_are_told_from_the_others(
    face: Mesh, rig: dict[str, Mesh], mirror: Mirror
) -> None:
    targets = {name[:-4]: mesh for name, mesh in rig.items()}
    for name in ("eyeBlink", "mouthSmile"):
        targets |= {f"{name}2{side}": targets[f"{name}{side}"] for side in ("_L", "_R")}
    swapped = {**targets, "eyeBlink_L": targets["eyeBlink_R"], "eyeBlink_R": targets["eyeBlink_L"]}
    assert compared(face, targets, mirror) == []
    assert compared(face, swapped, mirror) == [("swapped-sides", "warning", "eyeBlink_L.obj")]


def test_names_of_sides() -> None:
    names = ["eyeBlink_L", "eyeBlink_R", "jawLeft", "jawRight", "jawOpen", "L_brow", "R_brow"]
    pairs, alone = sided_pairs([*names, "cheekPuff_R", "cleft"])
    assert pairs == [("eyeBlink_L", "eyeBlink_R"), ("jawLeft", "jawRight"), ("L_brow", "R_brow")]
    assert alone == ["cheekPuff_R"]
    own = parse_sides("_lft=_rgt, port_=star_")
    assert sided_pairs(["a_lft", "a_rgt", "port_b", "star_b"], own) == (
        [("a_lft", "a_rgt"), ("port_b", "star_b")],
        [],
    )
    for text in ("", "_L", "_L=_L", "a=b=c"):
        with pytest.raises(ParameterError, match="expected left=right"):
            parse_sides(text)


def test_a_missing_side_is_reported_where_others_have_two() -> None:
    names = {name: f"{name}.obj" for name in ("blink_L", "blink_R", "smile_L")}
    assert only(missing_sides(names)).file == "smile_L.obj"
    assert missing_sides({"cheek_L": "c.obj", "jaw": "j.obj"}) == []
