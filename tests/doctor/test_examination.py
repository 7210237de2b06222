"""Each fault planted in a sound rig is found, by its name, and nothing else is."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planted_faults import (
    as_deltas,
    baked,
    names,
    shuffled,
    split_at,
    turn,
    turned_over,
    with_noise,
)

from elastomorph.doctor import (
    KINDS,
    BeamSettings,
    Examination,
    ExaminationSettings,
    as_document,
    as_text,
    examine,
)
from elastomorph.doctor.checks.order import with_reversed
from elastomorph.doctor.findings import Finding, finding
from elastomorph.errors import FormatError, ParameterError
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import Mesh
from elastomorph.physics import Material
from small_head import head, shapes

SMILE = "mouthSmile_L.obj"


def examined(
    face: Mesh, rig: dict[str, Mesh], settings: ExaminationSettings | None = None
) -> Examination:
    return examine(face, rig.items(), settings, file="neutral.obj")


def with_polygons(mesh: Mesh, faces: list[list[int]]) -> Mesh:
    return Mesh(mesh.vertices, faces)


def spiked(mesh: Mesh) -> Mesh:
    points = mesh.vertices.copy()
    points[2100] += [0.0, 0.0, 0.05 * mesh.diameter]
    return mesh.with_vertices(points)


def collapsed(mesh: Mesh) -> Mesh:
    points = mesh.vertices.copy()
    points[mesh.faces[1000]] = points[mesh.faces[1000]].mean(axis=0)
    return mesh.with_vertices(points)


TARGET_FAULTS: dict[str, Callable[[Mesh], Mesh]] = {
    "split-vertices": lambda mesh: split_at(mesh, 1234),
    "saved-as-deltas": lambda mesh: as_deltas(head(), mesh),
    "noise": lambda mesh: with_noise(mesh, 3e-4),
    "vertex-order": lambda mesh: shuffled(mesh)[0],
    "polygon-order": lambda m: with_polygons(m, [f.tolist() for f in m.faces][::-1]),
    "reversed-winding": turned_over,
    "triangulated": lambda m: with_polygons(m, m.faces.triangles().tolist()),
    "different-counts": lambda m: with_polygons(m, [f.tolist() for f in m.faces][:-1]),
    "different-units": lambda m: m.with_vertices(m.vertices / 2.54),
    "different-axes": lambda m: m.with_vertices(m.vertices[:, [0, 2, 1]] * [1, -1, 1]),
    "mirrored": lambda m: m.with_vertices(m.vertices * [-1, 1, 1]),
    "moves-the-head": lambda m: m.with_vertices(turn(m.vertices, 2.0) + [0, 0.4, 0]),
    "jumping-vertices": spiked,
    "zero-area": collapsed,
    "scrambled-vertices": lambda m: m.with_vertices(
        np.random.default_rng(0).permutation(m.vertices)
    ),
}


def test_a_sound_rig_has_no_findings(face: Mesh, rig: dict[str, Mesh]) -> None:
    found = examined(face, rig)
    assert found.findings == ()
    assert found.symmetric
    assert not found.repaired
    assert not found.beyond_repair
    assert "nothing found" in as_text(found)


@pytest.mark.parametrize("name", TARGET_FAULTS)
def test_a_fault_of_a_target_is_found_alone(face: Mesh, rig: dict[str, Mesh], name: str) -> None:
    """The grin with the fault has no other finding, and the others have none."""
    found = examined(face, {**rig, SMILE: TARGET_FAULTS[name](rig[SMILE])})
    assert names(found) == [(name, SMILE)]


@pytest.mark.parametrize(
    "name",
    [
        "vertex-order",
        "polygon-order",
        "triangulated",
        "reversed-winding",
        "split-vertices",
        "saved-as-deltas",
        "different-units",
        "different-axes",
        "mirrored",
    ],
)
def test_what_can_be_repaired_is_as_it_was(face: Mesh, rig: dict[str, Mesh], name: str) -> None:
    found = examined(face, {**rig, SMILE: TARGET_FAULTS[name](rig[SMILE])})
    mesh = found.repaired[SMILE].mesh
    assert mesh.faces == face.faces
    np.testing.assert_allclose(mesh.vertices, rig[SMILE].vertices, rtol=0, atol=1e-13 * 30)
    assert not found.beyond_repair


@pytest.mark.parametrize("unit", [25.4, 100.0])
def test_displacements_in_another_unit_are_left(
    face: Mesh, rig: dict[str, Mesh], unit: float
) -> None:
    """Added to the neutral as they are they would throw vertices far from the face."""
    deltas = as_deltas(face, rig[SMILE])
    rig[SMILE] = deltas.with_vertices(unit * deltas.vertices)
    found = examined(face, rig)
    assert names(found) == [("saved-as-deltas", SMILE)]
    assert "another unit" in found.findings[0].message
    assert found.beyond_repair == (SMILE,)


def test_all_at_once_is_undone(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Shuffled, Z up, in millimetres and with the head turned."""
    smile = rig[SMILE]
    moved = turn(smile.vertices, 3.0)
    there = (10.0 * moved)[:, [0, 2, 1]] * [1, -1, 1]
    rig[SMILE] = shuffled(smile.with_vertices(there))[0]
    found = examined(face, rig, ExaminationSettings(steady=True))
    kinds = {"vertex-order", "different-units", "different-axes", "moves-the-head"}
    assert names(found) == sorted((kind, SMILE) for kind in kinds)
    off = np.abs(found.repaired[SMILE].mesh.vertices - smile.vertices).max()
    assert off <= 1e-6 * face.diameter


def test_chosen_vertices_are_brought_back(face: Mesh, rig: dict[str, Mesh]) -> None:
    """In the target that moved the head, and in no other."""
    smile = rig[SMILE]
    same = [(mesh.vertices == face.vertices).all(axis=1) for mesh in rig.values()]
    rig[SMILE] = smile.with_vertices(turn(smile.vertices, 3.0))
    found = examined(face, rig, ExaminationSettings(still=np.flatnonzero(np.all(same, axis=0))))
    assert list(found.repaired) == [SMILE]
    np.testing.assert_allclose(found.repaired[SMILE].mesh.vertices, smile.vertices, atol=1e-9)


def test_without_being_told_to_the_head_is_left_where_it_is(
    face: Mesh, rig: dict[str, Mesh]
) -> None:
    rig[SMILE] = TARGET_FAULTS["moves-the-head"](rig[SMILE])
    assert not examined(face, rig).repaired


@pytest.mark.parametrize(
    ("kind", "forth"),
    [
        ("different-units", lambda points: 100.0 * points),
        ("different-axes", lambda points: points[:, [0, 2, 1]] * [1, -1, 1]),
    ],
)
def test_a_neutral_that_differs_from_all_its_targets_is_the_one_to_blame(
    face: Mesh, rig: dict[str, Mesh], kind: str, forth: Callable[..., np.ndarray]
) -> None:
    targets = {name: mesh.with_vertices(forth(mesh.vertices)) for name, mesh in rig.items()}
    found = examined(face, targets)
    assert names(found) == [(kind, "neutral.obj")]
    assert list(found.repaired) == ["neutral.obj"]
    np.testing.assert_allclose(
        found.repaired["neutral.obj"].mesh.vertices, forth(face.vertices), rtol=1e-14
    )
    # One that agrees with the neutral is then the odd one out.
    found = examined(face, {**targets, "zz.obj": rig[SMILE]})
    assert (kind, "neutral.obj") in names(found)
    assert (kind, "zz.obj") in names(found)


@pytest.mark.parametrize("piece", [0, 1, 3])
def test_a_neutral_wound_against_all_its_targets_is_the_one_to_turn(
    face: Mesh, rig: dict[str, Mesh], piece: int
) -> None:
    part = component_of(len(face.vertices), face.edges)
    over = with_reversed(face, part[face.faces.indices[face.faces.offsets[:-1]]] == piece)
    found = examined(over, rig)
    assert names(found) == [("reversed-winding", "neutral.obj")]
    assert found.findings[0].vertices == tuple(np.flatnonzero(part == piece))
    assert list(found.repaired) == ["neutral.obj"]
    assert found.repaired["neutral.obj"].mesh.faces == face.faces
    # A target that runs them as the neutral does is then the odd one out.
    odd = over.with_vertices(rig[SMILE].vertices)
    found = examined(over, {**rig, SMILE: odd})
    assert names(found) == [("reversed-winding", SMILE), ("reversed-winding", "neutral.obj")]
    assert found.repaired[SMILE].mesh.faces == face.faces


def test_of_mirror_images_the_one_that_shows_its_back_is_to_blame(
    face: Mesh, rig: dict[str, Mesh]
) -> None:
    over = face.with_vertices(face.vertices * [-1, 1, 1])
    found = examined(over, rig)
    assert names(found) == [("mirrored", "neutral.obj")]
    np.testing.assert_array_equal(found.repaired["neutral.obj"].mesh.vertices, face.vertices)
    targets = {name: m.with_vertices(m.vertices * [-1, 1, 1]) for name, m in rig.items()}
    found = examined(face, targets)
    assert names(found) == [("mirrored", name) for name in sorted(rig)]


def test_where_all_targets_are_noisy_none_is_to_blame(face: Mesh, rig: dict[str, Mesh]) -> None:
    """That is how the face was captured; one that is much noisier still stands out."""
    noisy = {n: with_noise(mesh, 2e-4, seed) for seed, (n, mesh) in enumerate(rig.items())}
    assert "noise" not in {f.name for f in examined(face, noisy).findings}
    noisy[SMILE] = with_noise(rig[SMILE], 1e-3)
    found = [f.file for f in examined(face, noisy).findings if f.name == "noise"]
    assert found == [SMILE]


@pytest.mark.parametrize(("weight", "severity"), [(1.0, "warning"), (0.4, "note")])
def test_a_target_baked_into_another_is_named(
    face: Mesh, rig: dict[str, Mesh], weight: float, severity: str
) -> None:
    jaw = shapes()["jawOpen"]
    rig |= {"jawOpen.obj": jaw, SMILE: baked(face, rig[SMILE], jaw, weight)}
    (one,) = [f for f in examined(face, rig).findings if f.name == "baked-in-target"]
    assert (one.file, one.severity) == (SMILE, severity)
    assert "contains jawOpen" in one.message
    assert ("40 %" in one.message) == (weight < 1.0)


def test_combinations_of_targets_are_not_called_baked(face: Mesh, rig: dict[str, Mesh]) -> None:
    """The left and the right of one expression, or three others and nothing of their own."""
    both = baked(face, rig[SMILE], rig["mouthSmile_R.obj"])
    sad = baked(face, baked(face, rig["browInnerUp.obj"], rig["mouthLeft.obj"]), both, 0.5)
    found = examined(face, {**rig, "smile.obj": both, "sad.obj": sad})
    assert "baked-in-target" not in {f.name for f in found.findings}


def test_what_shows_its_back_in_all_files_is_turned(face: Mesh, rig: dict[str, Mesh]) -> None:
    """The whole head, or one closed piece of it; positions stay bit for bit."""
    part = component_of(len(face.vertices), face.edges)
    eyeball = int(part[face.faces[-1][0]])
    for wrong in (part >= 0, part == eyeball):
        faces = [f.tolist()[::-1] if wrong[f[0]] else f.tolist() for f in face.faces]
        targets = {name: Mesh(mesh.vertices, faces) for name, mesh in rig.items()}
        found = examined(Mesh(face.vertices, faces), targets)
        assert names(found) == [("inside-out", "neutral.obj")]
        assert found.findings[0].vertices == tuple(np.flatnonzero(wrong))
        assert set(found.repaired) == {"neutral.obj", *rig}
        again = {name: found.repaired[name].mesh for name in rig}
        assert not examined(found.repaired["neutral.obj"].mesh, again).findings
        for name, mesh in again.items():
            np.testing.assert_array_equal(mesh.vertices, rig[name].vertices)


@pytest.mark.parametrize("stem", ["jaw{}", "mouth{}", "mouthSmile_{}", "browDown_{}"])
@pytest.mark.parametrize("z_up", [False, True])
def test_left_and_right_are_told_by_the_face_where_no_third_file_helps(
    face: Mesh, stem: str, z_up: bool
) -> None:
    """By the side that moves, or the way it moves: the character's left is at x > 0."""
    words = ("L", "R") if stem.endswith("_{}") else ("Left", "Right")
    both = [shapes()[stem.format(word)] for word in words]
    if z_up:
        face, *both = (
            m.with_vertices(m.vertices[:, [0, 2, 1]] * [1, -1, 1]) for m in (face, *both)
        )
    files = [f"{stem.format(word)}.obj" for word in words]
    right = examined(face, dict(zip(files, both, strict=True)))
    assert "swapped-sides" not in {f.name for f in right.findings}
    swapped = examined(face, dict(zip(files, both[::-1], strict=True)))
    assert ("swapped-sides", files[0]) in names(swapped)


def test_an_expression_that_enlarges_the_face_is_no_other_unit(
    face: Mesh, rig: dict[str, Mesh]
) -> None:
    drop = np.exp(-np.maximum(face.vertices[:, 1] - face.vertices[:, 1].min(), 0) / 5.0)
    dropped = face.vertices - 0.6 * face.diameter * drop[:, None] * [0, 1, 0]
    found = examined(face, {**rig, "jawOpen.obj": face.with_vertices(dropped)})
    assert not [one for one in found.findings if one.severity == "error"]


def test_faults_across_targets(face: Mesh, rig: dict[str, Mesh]) -> None:
    faulty = {**rig, "puff.obj": face, "z_browInnerUp.obj": rig["browInnerUp.obj"]}
    assert names(examined(face, faulty)) == [
        ("does-nothing", "puff.obj"),
        ("duplicate-targets", "z_browInnerUp.obj"),
    ]
    del rig["eyeBlink_R.obj"]
    assert names(examined(face, rig)) == [("missing-pair", "eyeBlink_L.obj")]


def test_faults_of_the_neutral_are_said_once(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Not again for every target that has them too."""
    faces = [f.tolist() for f in face.faces]
    faces[1000] = faces[1000][::-1]
    points = np.concatenate([face.vertices, [[0.0, 0.0, 0.0]]])
    neutral = Mesh(points, faces)
    targets = {
        name: neutral.with_vertices(np.concatenate([mesh.vertices, points[-1:]]))
        for name, mesh in rig.items()
    }
    found = examined(neutral, targets)
    assert names(found) == [
        ("inconsistent-winding", "neutral.obj"),
        ("isolated-vertices", "neutral.obj"),
    ]


def test_a_material_is_tried_only_when_given(face: Mesh) -> None:
    beam = BeamSettings(Material(damping=8 * np.pi**4))
    found = examine(face, [], ExaminationSettings(beam=beam), file="neutral.obj")
    assert names(found) == [("resonant-material", "neutral.obj")]


def test_an_unreadable_target_does_not_hide_the_others(face: Mesh, rig: dict[str, Mesh]) -> None:
    error = FormatError("bad.obj", "nan is no coordinate", line=7)
    rig["eyeBlink_L.obj"] = face
    found = examine(face, [*rig.items(), ("bad.obj", error)], file="neutral.obj")
    assert ("unreadable", "bad.obj") in names(found)
    assert ("does-nothing", "eyeBlink_L.obj") in names(found)
    assert found.unreadable
    assert found.beyond_repair == ("bad.obj",)
    worst = found.findings[0]
    assert (worst.name, worst.line, worst.message) == ("unreadable", 7, "nan is no coordinate")


def test_targets_without_names_are_told_by_their_number(face: Mesh, rig: dict[str, Mesh]) -> None:
    """None takes the place of another."""
    meshes = [("", rig[SMILE]), ("", face), ("mesh", spiked(rig["browInnerUp.obj"]))]
    found = examine(face, meshes)
    assert found.targets == ("target 0", "target 1", "mesh (2)")
    assert names(found) == [("does-nothing", "target 1"), ("jumping-vertices", "mesh (2)")]


def test_vertices_the_neutral_does_not_have_are_refused(face: Mesh) -> None:
    with pytest.raises(ParameterError, match="has no vertex 99,999"):
        examine(face, [], ExaminationSettings(seeds=((99_999, 0),)))
    with pytest.raises(ParameterError, match="three vertices"):
        examine(face, [], ExaminationSettings(still=np.array([1, 2])))


def test_text_says_each_kind_once_gravest_first(face: Mesh, rig: dict[str, Mesh]) -> None:
    """A line a file, and one remedy for all of them."""
    copies = {f"copy{i:02}.obj": rig[SMILE] for i in range(20)}
    larger = TARGET_FAULTS["different-units"](rig[SMILE])
    text = as_text(examined(face, {**rig, **copies, "unit.obj": larger}))
    assert text.index("ERROR") < text.index("WARNING")
    assert text.count(KINDS["duplicate-targets"].remedy) == 1
    assert "and 9 more" in text
    assert len(text.splitlines()) < 30
    assert max(map(len, text.splitlines())) < 200


def test_the_document_has_every_field(face: Mesh, rig: dict[str, Mesh]) -> None:
    rig[SMILE] = spiked(rig[SMILE])
    document = as_document(examined(face, rig))
    assert set(document) == {
        "neutral", "targets", "facts", "symmetric", "counts", "findings", "meetings", "repair"
    }  # fmt: skip
    assert document["counts"] == {"error": 0, "warning": 1, "note": 0}
    (entry,) = document["findings"]
    assert entry == {
        "name": "jumping-vertices",
        "severity": "warning",
        "file": SMILE,
        "line": None,
        "vertices": [2100],
        "message": entry["message"],
        "remedy": KINDS["jumping-vertices"].remedy,
        "link": "docs/findings.md#jumping-vertices",
    }


def test_findings_are_of_known_kinds() -> None:
    with pytest.raises(ParameterError, match="unknown kind"):
        finding("no-such-kind", "a.obj", "")
    assert isinstance(finding("vertex-order", "a.obj", ""), Finding)


@given(seed=st.integers(0, 10_000), shape=st.sampled_from(["solid", "flat", "line", "point"]))
@settings(max_examples=120, deadline=None)
def test_any_meshes_are_examined(seed: int, shape: str) -> None:
    """Polygons that cross, repeat and collapse give findings, never an exception or a warning."""
    random = np.random.default_rng(seed)
    count, number = int(random.integers(1, 10)), int(random.integers(0, 7))

    def polygons() -> list[list[int]]:
        sizes = random.integers(3, 6, size=number)
        return [random.integers(0, count, size=size).tolist() for size in sizes]

    span = {"solid": [1, 1, 1], "flat": [1, 1, 0], "line": [1, 0, 0], "point": [0, 0, 0]}[shape]
    points = random.normal(size=(count, 3)) * span
    neutral = Mesh(points, polygons())
    targets = {}
    for name in ("a_L.obj", "a_R.obj", "b.obj"):
        noise = random.normal(size=(count, 3)) * random.choice([0.0, 0.1, 1e3, 1e-9])
        faces = neutral.faces if random.random() < 0.7 else polygons()
        targets[name] = Mesh(points * random.choice([1, -1, 10, 0]) + noise, faces)
    found = examined(
        neutral, targets, ExaminationSettings(steady=True, beam=BeamSettings(Material()))
    )
    assert as_text(found)
    assert json.dumps(as_document(found), allow_nan=False)


@pytest.mark.parametrize("noise", [0.0, 1e-4, 5e-4])
def test_clean_scans_of_a_head_give_no_warnings(noise: float) -> None:
    """Ten that differ smoothly by 0.1 % of D from what was sculpted, with noise or without."""
    face, random, targets = head(), np.random.default_rng(1), {}
    sculpted = [name for name in shapes() if not name.endswith(("_R", "Right"))][:10]
    for number, name in enumerate(sculpted):
        points = shapes()[name].vertices.copy()
        for centre in face.vertices[random.integers(len(points), size=12)]:
            weights = np.exp(-((points - centre) ** 2).sum(axis=1) / (0.3 * face.diameter) ** 2)
            points += 1e-3 * face.diameter * weights[:, None] * random.normal(size=3)
        targets[f"scan_{number:02}.obj"] = with_noise(face.with_vertices(points), noise, number)
    found = examined(face, targets)
    assert [one for one in found.findings if one.severity != "note"] == []
