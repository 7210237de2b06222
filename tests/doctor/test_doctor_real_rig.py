"""The ICT rig: what is truly there is found, each finding checked by hand, and nothing else."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from planted_faults import baked, shuffled, turned_over

from elastomorph.doctor import Examination, Thresholds, examine, examine_files, examine_rig
from elastomorph.doctor.checks.order import NeutralOrder, with_reversed
from elastomorph.doctor.checks.sides import find_mirror
from elastomorph.io import read, read_rig, write
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import Mesh

pytestmark = [pytest.mark.realdata, pytest.mark.slow]


@pytest.fixture(scope="module")
def folder(data_dir: Path) -> Path:
    return data_dir / "ict-facekit"


@pytest.fixture(scope="module")
def found(folder: Path) -> Examination:
    return examine_files([folder])


@pytest.fixture(scope="module")
def neutral(folder: Path) -> Mesh:
    return read(folder / "generic_neutral_mesh.obj")


@pytest.fixture(scope="module")
def order(neutral: Mesh) -> NeutralOrder:
    return NeutralOrder(neutral)


def moved(folder: Path, neutral: Mesh, name: str) -> np.ndarray:
    return read(folder / f"{name}.obj").vertices - neutral.vertices


def test_the_rig_has_these_findings_and_no_others(found: Examination) -> None:
    kinds = Counter(one.name for one in found.findings)
    assert kinds == {
        "zero-area": 2,
        "jumping-vertices": 2,
        "unwelded-vertices": 1,
        "asymmetric-pair": 6,
        "in-between-pays": 5,
    }
    assert found.count("error") == 0
    assert found.symmetric
    assert not found.repaired


def test_pupils_are_closed_to_a_line(found: Examination, folder: Path, neutral: Mesh) -> None:
    """PupilDilate draws nine rings of 20 iris vertices onto one: 160 quads lose their area."""
    for side in "LR":
        (one,) = [f for f in found.findings if f.file.endswith(f"PupilDilate_{side}.obj")]
        assert one.name == "zero-area"
        vertices = list(one.vertices)
        target = read(folder / f"PupilDilate_{side}.obj")
        assert len(vertices) == 180
        assert len(np.unique(neutral.vertices[vertices], axis=0)) == 180
        assert len(np.unique(target.vertices[vertices], axis=0)) == 20
        assert one.line is not None


def test_two_vertices_of_the_mouth_socket_were_left_behind(
    found: Examination, folder: Path, neutral: Mesh
) -> None:
    """In mouthLeft vertices 13292 and 13293 stay; all around them moves by 0.9 % of D."""
    left_behind = {"mouthLeft": (13292, 13293), "mouthRight": (12307, 12308)}
    jumps = {Path(f.file).stem: f.vertices for f in found.findings if f.name == "jumping-vertices"}
    assert jumps == left_behind
    for name, vertices in left_behind.items():
        motion = moved(folder, neutral, name)
        edges = neutral.edges
        around = np.unique(edges[np.isin(edges, vertices).any(axis=1)])
        others = np.setdiff1d(around, vertices)
        assert not motion[list(vertices)].any()
        assert (np.linalg.norm(motion[others], axis=1) > 0.009 * neutral.diameter).all()


def test_lashes_and_lids_touch_without_being_welded(found: Examination, neutral: Mesh) -> None:
    """468 vertices at 123 positions, on pieces of their own: lashes, tear fluid, the lid."""
    (one,) = [f for f in found.findings if f.name == "unwelded-vertices"]
    assert len(one.vertices) == 468
    assert len(np.unique(neutral.vertices[list(one.vertices)], axis=0)) == 123
    assert "different pieces touch" in one.message


def test_pairs_named_asymmetric_are(found: Examination, folder: Path, neutral: Mesh) -> None:
    """At the vertex named, left and right (x negated) differ by the amount named."""
    pairs = [f for f in found.findings if f.name == "asymmetric-pair"]
    stems = {Path(f.file).stem for f in pairs}
    assert stems == {f"{name}_L" for name in (
        "browInnerUp", "cheekPuff", "cheekRaiser", "eyeBlink", "eyeLookIn", "eyeLookOut"
    )}  # fmt: skip
    for one in pairs:
        stem = Path(one.file).stem[:-1]
        here, there = one.vertices
        np.testing.assert_allclose(
            neutral.vertices[here], neutral.vertices[there] * [-1, 1, 1], atol=1e-9
        )
        left, right = (moved(folder, neutral, f"{stem}{side}") for side in "LR")
        difference = np.linalg.norm(left[here] - right[there] * [-1, 1, 1])
        share = 100 * difference / neutral.diameter
        assert f"by up to {share:.2f} % of D" in one.message


def test_the_jaw_is_off_by_the_height_of_its_arc(
    found: Examination, folder: Path, neutral: Mesh
) -> None:
    """Teeth turn rigidly: by hand, the middle of the chord is r(1 - cos θ/2) off the arc."""
    from elastomorph.model.geometry import fit_rigid

    (jaw,) = [f for f in found.findings if f.file.endswith("jawOpen.obj")]
    target = read(folder / "jawOpen.obj")
    teeth = np.arange(17039, 21451)
    lower = teeth[np.linalg.norm(moved(folder, neutral, "jawOpen")[teeth], axis=1) > 0.5]
    gums = np.arange(14062, 17039)
    screw, _ = fit_rigid(neutral.vertices[lower], target.vertices[lower])
    assert np.degrees(screw.angle) == pytest.approx(25.3, abs=0.1)
    (vertex,) = jaw.vertices
    assert vertex in gums
    arm = neutral.vertices[vertex] - screw.centre
    radius = np.linalg.norm(arm - (arm @ screw.axis) * screw.axis)
    height = 100 * radius * (1 - np.cos(screw.angle / 2)) / neutral.diameter
    assert height == pytest.approx(0.67, abs=0.05)
    assert "0.67 % of D" in jaw.message


@pytest.mark.parametrize("name", ["eyeBlink_L", "jawOpen", "PupilDilate_R"])
def test_a_shuffled_copy_is_repaired_exactly(folder: Path, order: NeutralOrder, name: str) -> None:
    """Twelve lashes alike, eyeballs of 64 and 4 ways to turn, and lids that flip them over."""
    target = read(folder / f"{name}.obj")
    mixed, number = shuffled(target, seed=len(name))
    assert (number != np.arange(len(number))).any()
    found = order.examine(mixed, "mixed.obj")
    assert [f.name for f in found.findings] == ["vertex-order"]
    assert found.mesh is not None
    assert found.mesh.faces == order.neutral.faces
    np.testing.assert_array_equal(found.mesh.vertices, target.vertices)


def test_a_shuffled_copy_run_backwards_is_not_repaired(folder: Path, order: NeutralOrder) -> None:
    """The rig's polygons are symmetric, so they fit with left and right exchanged: refused."""
    mixed, _ = shuffled(turned_over(read(folder / "mouthSmile_L.obj")))
    found = order.examine(mixed, "mixed.obj")
    assert [f.name for f in found.findings] == ["reversed-winding"]
    assert found.mesh is None


def test_a_shuffled_target_in_millimetres_and_z_up(folder: Path, neutral: Mesh) -> None:
    target = read(folder / "mouthFrown_L.obj")
    there = (10 * target.vertices)[:, [0, 2, 1]] * [1, -1, 1]
    mixed, _ = shuffled(target.with_vertices(there), seed=5)
    found = examine(neutral, [("frown.obj", mixed)], file="neutral.obj")
    kinds = [f.name for f in found.findings if f.file == "frown.obj"]
    assert kinds == ["vertex-order", "different-units", "different-axes"]
    mesh = found.repaired["frown.obj"].mesh
    np.testing.assert_allclose(mesh.vertices, target.vertices, rtol=1e-14, atol=1e-12)


def test_one_reversed_piece_of_a_target_is_wound_again(folder: Path, order: NeutralOrder) -> None:
    """Each of the eight largest pieces; numbers and positions are never touched."""
    target = read(folder / "mouthSmile_L.obj")
    part = component_of(len(target.vertices), target.edges)
    for piece in np.argsort(-np.bincount(part))[:8].tolist():
        inside = part[target.faces.indices[target.faces.offsets[:-1]]] == piece
        over = with_reversed(target, inside)
        found = order.examine(over, "over.obj")
        (one,) = found.findings
        assert one.name == "reversed-winding"
        assert one.vertices == tuple(np.flatnonzero(part == piece))
        assert found.mesh is not None
        assert found.mesh.faces == order.neutral.faces
        np.testing.assert_array_equal(found.mesh.vertices, target.vertices)
        mixed = order.examine(shuffled(over, piece)[0], "mixed.obj")
        if mixed.mesh is None:
            assert [f.name for f in mixed.findings] == ["different-polygons"]
        else:
            np.testing.assert_array_equal(mixed.mesh.vertices, target.vertices)


@pytest.mark.parametrize("expression", ["eyeBlink", "eyeLookDown", "eyeWide"])
def test_the_lids_alone_do_not_say_which_way_a_face_looks(
    folder: Path, neutral: Mesh, expression: str
) -> None:
    """What they move looks up; taken for the front, left and right would be told the wrong way."""
    files = [f"{expression}_{side}.obj" for side in "LR"]
    found = examine(neutral, [(file, read(folder / file)) for file in files], file="neutral.obj")
    assert "swapped-sides" not in {one.name for one in found.findings}


def test_a_smile_with_the_jaw_baked_in_is_named(folder: Path, neutral: Mesh) -> None:
    jaw, smile = (read(folder / f"{name}.obj") for name in ("jawOpen", "mouthSmile_L"))
    names = ("jawOpen", "mouthFunnel", "mouthPucker", "mouthSmile_R")
    clean = {f"{name}.obj": read(folder / f"{name}.obj") for name in names}
    found = examine(
        neutral, {**clean, "mouthSmile_L.obj": baked(neutral, smile, jaw)}.items(), file="n"
    )
    named = [(f.file, f.message) for f in found.findings if f.name == "baked-in-target"]
    assert named == [("mouthSmile_L.obj", "contains jawOpen: used together, it counts twice")]


def test_a_face_whose_jaw_enlarges_it_is_one_rig(data_dir: Path, tmp_path: Path) -> None:
    """FaceCap, from FBX and from OBJ: no errors, and nothing to repair."""
    rig = read_rig(data_dir / "facecap" / "FaceCapHeadGeneric.fbx")
    write(tmp_path / "neutral.obj", rig.neutral)
    for name, target in rig.targets.items():
        write(tmp_path / f"{name}.obj", target)
    for found in (examine_rig(rig, file="FaceCap"), examine_files([tmp_path])):
        assert found.count("error") == 0
        assert not found.repaired
        assert not found.beyond_repair
        warned = {(f.name, Path(f.file).stem) for f in found.findings if f.severity == "warning"}
        assert warned == {("does-nothing", "tongueOut"), ("asymmetric-pair", "jawLeft")}
    jaw = rig.morphs["jawOpen"].target.vertices
    spread = [
        np.median(np.linalg.norm(points - np.median(points, axis=0), axis=1))
        for points in (rig.neutral.vertices, jaw)
    ]
    assert spread[1] / spread[0] > Thresholds().scale


def test_vertices_are_paired_with_their_mirror_image_or_with_none(data_dir: Path) -> None:
    """Teeth of FaceCap are alike: none is paired with one of the other end of the jaw."""
    face = read_rig(data_dir / "facecap" / "FaceCapHeadGeneric.fbx").neutral
    mirror = find_mirror(face)
    assert mirror is not None
    known = np.flatnonzero(mirror.partner >= 0)
    there = face.vertices[mirror.partner[known]] * [-1, 1, 1]
    off = np.linalg.norm(there - face.vertices[known], axis=1)
    assert off.max() < 0.05 * face.diameter
    assert len(known) > 0.95 * len(face.vertices)
