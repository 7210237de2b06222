"""What single targets and pairs of them do wrong."""

from __future__ import annotations

import numpy as np
import pytest
from planted_faults import grid, only, turn

from elastomorph.doctor.checks.bends import BendCheck
from elastomorph.doctor.checks.head import align, examine_head
from elastomorph.doctor.checks.jumps import JumpCheck
from elastomorph.doctor.checks.material import BeamSettings, examine_material
from elastomorph.doctor.checks.same_shape import does_nothing, examine_doubles
from elastomorph.doctor.checks.symmetry import examine_names, examine_symmetry
from elastomorph.doctor.mirror import Mirror, find_mirror
from elastomorph.doctor.neighbours import Neighbours
from elastomorph.doctor.side_names import parse_sides, sided_pairs
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.physics import Load, Material, modal_response

HEAD = {"allowed": 5e-4, "steadier": 0.5}


@pytest.mark.parametrize("degrees", [0.0, 0.5, 3.0, 40.0])
@pytest.mark.parametrize("name", ["mouthSmile_L", "browInnerUp", "mouthLeft"])
def test_the_motion_of_the_head_is_found_and_taken_out(
    face: Mesh, rig: dict[str, Mesh], name: str, degrees: float
) -> None:
    """Not the motion of the face: it comes back within a millionth of D."""
    target = rig[f"{name}.obj"]
    moved = target.with_vertices(turn(target.vertices, degrees) + [0.3, -0.2, 0.5])
    found = examine_head(face, moved, "t", **HEAD)
    assert only(found.findings).name == "moves-the-head"
    off = np.abs(found.mesh.vertices - target.vertices).max()
    assert off <= 1e-6 * face.diameter


def test_expressions_do_not_move_the_head(face: Mesh, rig: dict[str, Mesh]) -> None:
    for mesh in rig.values():
        found = examine_head(face, mesh, "t", **HEAD)
        assert not found.findings
        assert found.mesh is mesh


def test_a_head_that_moves_in_every_part_differently_is_not_steadied(face: Mesh) -> None:
    """No rigid motion explains a head that grows."""
    grown = face.with_vertices(1.1 * face.vertices)
    assert not examine_head(face, grown, "t", **HEAD).findings


def test_alignment_to_chosen_vertices_is_exact(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Vertices that do not move with the smile tell the motion exactly."""
    target = rig["mouthSmile_R.obj"]
    still = np.flatnonzero((target.vertices == face.vertices).all(axis=1))
    moved = target.with_vertices(turn(target.vertices, 12.0, axis=0) - 4.0)
    back = align(face, moved, still)
    np.testing.assert_allclose(back.vertices, target.vertices, atol=1e-12 * face.diameter)


@pytest.mark.parametrize("spikes", [[700], [700, 2100, 4000]])
def test_jumping_vertices_are_found_and_no_others(
    face: Mesh, rig: dict[str, Mesh], spikes: list[int]
) -> None:
    check = JumpCheck(face, Neighbours(face), Thresholds())
    for mesh in rig.values():
        assert check.target(mesh, "t") == []
        points = mesh.vertices.copy()
        points[spikes] += 0.06 * face.diameter
        found = only(check.target(mesh.with_vertices(points), "t"))
        assert (found.name, found.vertices) == ("jumping-vertices", tuple(spikes))


def test_a_target_that_does_nothing(face: Mesh, rig: dict[str, Mesh]) -> None:
    assert only(does_nothing(face, face, "t", 1e-5)).message == "it is the neutral"
    rounded = face.with_vertices(np.round(face.vertices, 5))
    assert "rounding" in only(does_nothing(face, rounded, "t", 1e-5)).message
    for mesh in rig.values():
        assert does_nothing(face, mesh, "t", 1e-5) == []


def test_doubles_are_found_once_each(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Every later copy names the first, also where it was rounded."""
    smile = rig["mouthSmile_L.obj"]
    copies = {"again.obj": smile.with_vertices(np.round(smile.vertices, 5)), "more.obj": smile}
    assert examine_doubles(face, rig, 1e-5) == []
    found = examine_doubles(face, {**rig, **copies}, 1e-5)
    assert [one.file for one in found] == ["again.obj", "more.obj"]
    assert all("mouthSmile_L.obj" in one.message for one in found)


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
    found = examine_symmetry(face, targets, files, mirror, Thresholds())
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
    found = only(examine_symmetry(face, targets, {n: n for n in targets}, mirror, Thresholds()))
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
    assert only(examine_names(names)).file == "smile_L.obj"
    assert examine_names({"cheek_L": "c.obj", "jaw": "j.obj"}) == []


@pytest.mark.parametrize("degrees", [30.0, 60.0])
def test_a_turning_piece_is_off_the_chord_by_the_height_of_its_arc(degrees: float) -> None:
    """At radius r the chord is r(1 - cos θ/2) from the arc; halved, about a quarter is left."""
    mesh = grid(6, 6)
    target = mesh.with_vertices(turn(mesh.vertices, degrees))
    found = only(BendCheck(mesh, 1e-3).target(target, "t"))
    height = 6.0 * (1 - np.cos(np.radians(degrees) / 2)) / mesh.diameter
    left = 6.0 * (1 - np.cos(np.radians(degrees) / 4)) / mesh.diameter
    words = found.message.split()
    assert float(words[words.index("by") + 1]) == pytest.approx(100 * height, rel=0.01)
    assert float(words[words.index("leaves") + 1]) == pytest.approx(100 * left, rel=0.02)
    assert "in-between at t = 0.5" in found.message


def test_a_shift_needs_no_in_between(face: Mesh) -> None:
    shifted = face.with_vertices(face.vertices + [5.0, 0, 0])
    assert BendCheck(face, 1e-3).target(shifted, "t") == []


def test_a_material_is_at_resonance_where_its_law_is_singular() -> None:
    """R = 2 is singular at B = 2c; the grid has an open curve with B₁ = kπ⁴."""
    mesh = grid(5, 4)
    damping = np.pi**4 / 2
    law = modal_response(np.array([np.pi**4]), Load.power(2), Material(damping=damping))
    assert not np.isfinite(law).all() or np.abs(law).max() > 1e3
    found = only(examine_material(mesh, "n", BeamSettings(Material(damping=damping))))
    assert found.name == "resonant-material"
    assert "mode 1" in found.message
    assert examine_material(mesh, "n", BeamSettings(Material())) == []


def test_a_law_that_runs_backwards_is_a_warning() -> None:
    """At B = 4c the law of R = 2 is 2t² - t, which first runs back by 1/8."""
    beam = BeamSettings(Material(damping=np.pi**4 / 4))
    found = only(examine_material(grid(5, 4), "n", beam))
    assert (found.name, found.severity) == ("overshooting-material", "warning")
    assert "12.5%" in found.message
