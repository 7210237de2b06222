"""The built-in head: ICT-FaceKit's in all its shapes, by ARKit's names, with its paths."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.errors import FormatError
from elastomorph.model.geometry import moved_extent
from elastomorph.rig.naming import ARKIT, shape_of
from elastomorph.rig.performance import slider_weights
from elastomorph.samples import (
    built_in_head,
    built_in_rig,
    expressions,
    head,
    landmarks,
    recorded_motion,
    shapes,
)
from elastomorph.samples.paper_expressions import EXPRESSIONS

LOWER_TEETH = slice(19247, 21451)
RELAXED = [12307, 12308, 13292, 13293]  # jump in the lining of the mouth, to the left and right
HALVES = ("browInnerUp", "cheekPuff")  # of which ICT-FaceKit has a left and a right file


@pytest.fixture(scope="module")
def folder(data_dir: Path) -> Path:
    return data_dir / "ict-facekit"


# Up to the left eyeball all vertices are ICT-FaceKit's, then those that are seen: the right sclera.
SKIN_TO_EYE = 22221
EYES = {"Left": slice(21451, 22221), "Right": slice(22221, 22991)}
THEIRS = np.r_[0:SKIN_TO_EYE, 23021:23791]


def test_the_neutral_is_that_of_ict_facekit(folder: Path) -> None:
    """Vertices within 3e-6 of D, polygons and texture coordinates in their order."""
    theirs, ours = em.read(folder / "generic_neutral_mesh.obj"), head()
    away = np.linalg.norm(ours.vertices[: len(THEIRS)] - theirs.vertices[THEIRS], axis=1)
    assert away.max() < 3e-6 * theirs.diameter
    further = cKDTree(theirs.vertices).query(ours.vertices[len(THEIRS) :])[0]
    assert further.max() < 3e-6 * theirs.diameter
    polygons = [
        [face.tolist() for face in mesh.faces if face.max() < SKIN_TO_EYE]
        for mesh in (theirs, ours)
    ]
    assert polygons[0] == polygons[1]
    corners = sum(map(len, polygons[0]))
    assert ours.uv is not None
    assert theirs.uv is not None
    np.testing.assert_allclose(
        ours.uv.coordinates[ours.uv.corners[:corners]],
        theirs.uv.coordinates[theirs.uv.corners[:corners], :2],
        atol=5e-5,
    )


def test_each_shape_is_the_sum_of_its_files(folder: Path) -> None:
    """Displacements within 2e-5 of D, those of two halves added up."""
    neutral = em.read(folder / "generic_neutral_mesh.obj")
    moves: dict[str, Any] = {}
    for file in sorted(folder.glob("*.obj")):
        if (shape := shape_of(file.stem)) is not None:
            name = next((own for own in HALVES if own in shape), shape)
            moves[name] = moves.get(name, 0.0) + em.read(file).vertices - neutral.vertices
    assert {*moves} == {*ARKIT} - {"tongueOut"}
    for name, move in moves.items():
        ours = (shapes()[name].vertices - head().vertices)[: len(THEIRS)]
        away = np.linalg.norm(ours - move[THEIRS], axis=1)
        if name in ("mouthLeft", "mouthRight"):
            away[RELAXED] = 0.0
        if name.startswith("eyeLook"):
            away[EYES["Left" if name.endswith("Left") else "Right"]] = 0.0
        assert away.max() < 2e-5 * neutral.diameter, name


def test_landmarks_are_those_of_ict_facekit(folder: Path) -> None:
    listed = (folder / "vertex_indices.json").read_text().partition('"idx_to_landmark_verts": [')[2]
    assert landmarks() == tuple(int(word) for word in listed.partition("]")[0].split(","))


def test_shapes_are_the_52_of_arkit_in_its_order() -> None:
    assert tuple(shapes()) == ARKIT
    assert all(mesh.faces is head().faces for mesh in shapes().values())
    assert all((mesh.vertices != head().vertices).any() for mesh in shapes().values())


def test_left_is_plus_x() -> None:
    """Shapes of one side move hardly anything on the other."""
    x = head().vertices[:, 0]
    for name, mesh in shapes().items():
        if name.endswith(("Left", "Right")) and not name.startswith(("jaw", "mouthLeft", "mouthR")):
            away = np.linalg.norm(mesh.vertices - head().vertices, axis=1)
            sign = 1.0 if name.endswith("Left") else -1.0
            assert away[sign * x > 0].sum() > 4.0 * away[sign * x < 0].sum(), name


@pytest.mark.parametrize(
    ("way", "degrees"), [("Up", 24.0), ("Down", 27.0), ("In", 32.0), ("Out", 32.0)]
)
@pytest.mark.parametrize("side", ["Left", "Right"])
def test_eyeballs_turn_about_their_centres(way: str, degrees: float, side: str) -> None:
    """By the stated angle, from forwards to where the name says, and one eye alone."""
    before, after = head().vertices, shapes()[f"eyeLook{way}{side}"].vertices
    eye, other = EYES[side], EYES["Right" if side == "Left" else "Left"]
    middle = before[eye].mean(axis=0), after[eye].mean(axis=0)
    turn, _ = Rotation.align_vectors(after[eye] - middle[1], before[eye] - middle[0])
    assert np.degrees(turn.magnitude()) == pytest.approx(degrees, abs=0.05)
    lengths = (np.linalg.norm(np.diff(mesh[eye], axis=0), axis=1) for mesh in (before, after))
    np.testing.assert_allclose(*lengths, atol=2e-3)  # steps of 5e-4 cm
    x, y, z = turn.apply([0.0, 0.0, 1.0])
    outwards = x if side == "Left" else -x
    towards = {"Up": y, "Down": -y, "Out": outwards, "In": -outwards}[way]
    assert towards == pytest.approx(np.sin(np.radians(degrees)), abs=1e-3)
    assert z > 0.8
    np.testing.assert_array_equal(before[other], after[other])


def test_the_tongue_comes_out_between_the_teeth() -> None:
    """It ends in front of the lower lip and below it, the jaw open for it, the skull still."""
    moved, rest = shapes()["tongueOut"].vertices, head()
    assert rest.materials is not None
    tongue = rest.materials.of_face == rest.materials.names.index("tongue")
    vertices = np.unique(rest.faces.indices[np.repeat(tongue, rest.faces.sizes)])
    tip = vertices[moved[vertices, 2].argmax()]
    lower_lip = moved[landmarks()[57]]
    assert moved[tip, 2] > lower_lip[2]
    assert moved[tip, 1] < lower_lip[1]
    assert abs(moved[tip, 0]) < 0.5
    jaw = shapes()["jawOpen"].vertices
    still = (jaw == rest.vertices).all(axis=1)
    still[vertices] = False
    np.testing.assert_array_equal(moved[still], rest.vertices[still])
    teeth = moved[LOWER_TEETH] - rest.vertices[LOWER_TEETH]
    opened = jaw[LOWER_TEETH] - rest.vertices[LOWER_TEETH]
    assert 0.3 < (teeth * opened).sum() / (opened**2).sum() < 0.6


def test_expressions_are_sums_of_shapes_on_both_sides() -> None:
    start = head().vertices
    assert list(expressions()) == list(EXPRESSIONS)
    for name, recipe in EXPRESSIONS.items():
        expected = start.copy()
        for word, weight in recipe.items():
            for shape in {word, f"{word}Left", f"{word}Right"} & {*shapes()}:
                expected += weight * (shapes()[shape].vertices - start)
        np.testing.assert_allclose(expressions()[name].vertices, expected, atol=1e-9)


@pytest.mark.parametrize("name", ["jawOpen", "eyeBlinkLeft", "cheekPuff", "browDownRight"])
def test_its_paths_are_those_of_auto(name: str) -> None:
    """They are kept as they were made, in whole steps: within what each of them states."""
    rig = built_in_rig()
    targets = [morph.target for morph in rig.morphs.values()]
    extent = moved_extent(head().vertices, (mesh.vertices for mesh in targets))
    made = em.prepare(head(), "auto", extent=extent, targets=targets)(shapes()[name])
    kept = rig.morphs[name]
    assert len(kept.bends) == len(made.bends)
    assert kept.method == made.method
    assert kept.target is shapes()[name]
    assert kept.choice is not None
    assert made.choice is not None
    assert kept.choice.straight == made.choice.straight
    assert kept.choice.distance == pytest.approx(made.choice.distance, rel=1e-6)
    assert kept.bake_error < made.bake_error + 1e-4
    for t in (0.25, 0.5, 0.75):
        away = np.linalg.norm(kept.at(t) - made.at(t), axis=1).max()
        assert away <= (kept.bake_error - made.bake_error) * head().diameter + 1e-9


def test_the_rig_has_shapes_and_expressions() -> None:
    rig = em.read_rig("built-in")
    assert rig.names == (*ARKIT, *EXPRESSIONS)
    assert rig.neutral is head()
    assert sum(len(morph.bends) > 0 for morph in rig.morphs.values()) > 10
    straight = em.read_rig("built-in", method="linear")
    assert not any(len(morph.bends) for morph in straight.morphs.values())


def test_the_motion_begins_with_the_neutral_bit_for_bit() -> None:
    motion = recorded_motion()
    assert len(motion) == 11
    np.testing.assert_allclose(motion.times, np.arange(11) / 10)
    assert motion.frames[0].tobytes() == head().vertices.tobytes()
    assert motion.mesh.faces is head().faces


def test_the_lower_teeth_of_the_motion_move_rigidly() -> None:
    """Distances between them stay, but for rounding to steps of 5e-4 cm."""
    frames = recorded_motion().frames[:, LOWER_TEETH]
    some = np.random.default_rng(0).integers(frames.shape[1], size=(2, 200))
    lengths = np.linalg.norm(frames[:, some[0]] - frames[:, some[1]], axis=2)
    np.testing.assert_allclose(lengths, np.broadcast_to(lengths[0], lengths.shape), atol=2e-3)
    assert np.linalg.norm(frames[-1] - frames[0], axis=1).max() > 2.0


@pytest.mark.parametrize("spelling", ["browInnerUp", "browInnerUp_{}", "BrowInnerUp{}"])
def test_takes_drive_whole_shapes_and_halves(spelling: str, tmp_path: Path) -> None:
    """`browInnerUp` of ARKit, or both halves of it as ICT-FaceKit has them."""
    sides = ("L", "R") if "_" in spelling else ("Left", "Right")
    names = list(dict.fromkeys(spelling.format(side) for side in sides))
    file = tmp_path / "take.csv"
    file.write_text(
        "\n".join([",".join(["time", *names]), "0" + ",0" * len(names)])
        + "\n1"
        + ",0.5" * len(names)
        + "\n"
    )
    rig = built_in_rig()
    weights = slider_weights(rig, em.read_performance(file))
    assert weights[1, rig.names.index("browInnerUp")] == pytest.approx(0.5)
    assert np.count_nonzero(weights) == 1


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("eyeBlink_L", "eyeBlinkLeft"),
        ("mouthSmile_R", "mouthSmileRight"),
        ("cheekPuff_L", "cheekPuff"),
    ],
)
def test_other_spellings_are_told_the_right_one(wrong: str, right: str) -> None:
    with pytest.raises(em.ParameterError, match=f"'{right}'"):
        built_in_rig().pose({wrong: 1.0})


def test_whose_it_is_stands_in_what_is_written(tmp_path: Path) -> None:
    em.write(tmp_path / "head.glb", built_in_rig())
    again = em.read_rig(tmp_path / "head.glb").neutral
    assert "USC Institute for Creative Technologies" in again.copyright
    assert "MIT" in again.copyright
    assert again.appearance is not None
    assert {*again.appearance} == {*(head().appearance or ())}
    licence = Path(built_in_head.__file__).parent / "ict-facekit" / "LICENSE"
    assert "USC Institute for Creative Technologies" in licence.read_text()


@pytest.mark.parametrize("damage", ["cut", "other", "missing"])
def test_damaged_files_say_so(damage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The file is named, and installing the package again is what helps."""
    source = Path(built_in_head.__file__).parent / "shapes.npz"
    file = tmp_path / "shapes.npz"
    if damage == "cut":
        file.write_bytes(source.read_bytes()[:-1000])
    elif damage == "other":
        with np.load(source) as arrays:
            np.savez(file, **{**arrays, "version": 99})
    monkeypatch.setattr(built_in_head, "files", lambda _: tmp_path)
    with pytest.raises(FormatError, match="install elastomorph again") as found:
        built_in_head._stored.__wrapped__("shapes")
    assert "shapes.npz" in str(found.value)
