"""Blendshapes and expressions do what their names say, on the topology of the head."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.model.mesh import require_same_topology
from elastomorph.rig.performance.naming import ARKIT
from elastomorph.samples import expressions, head, shapes
from elastomorph.samples.paper_expressions import EXPRESSIONS
from sculptor import groups, lips
from sculptor.anatomy import EYE_CENTRE, EYE_RADIUS
from sculptor.layout import MOUTH
from sculptor.weights import jaw_weights

MIRROR = np.array([-1.0, 1.0, 1.0])
SHAPES = shapes()
FACES = {**expressions(), **SHAPES}
ONE_PIECE = ["jawOpen", "jawLeft", "jawForward", "browInnerUp", "cheekPuff", "mouthLeft"]
PAIRED = ["eyeBlink", "mouthSmile", "mouthFrown", "mouthPress", "browDown", "browOuterUp"]


def _move(whole, face, indices):
    """Mean displacement of some vertices."""
    return (FACES[face].vertices - whole.mesh.vertices)[np.ravel(indices)].mean(axis=0)


@pytest.fixture(scope="module")
def corner(whole):
    """Left corner of the lips."""
    return whole.lay.mouth[lips.BORDER, lips.CORNER]


@pytest.fixture(scope="module")
def brow(whole):
    """(2, 10) the left eyebrow from its inner end."""
    return whole.lay.eye[1:3, :10]


def test_the_expected_names_are_there():
    assert list(expressions()) == ["sad", "angry", "confused", "grinning", "puff"]
    assert {*ONE_PIECE, *(f"{name}_{side}" for name in PAIRED for side in "LR")} <= set(SHAPES)


def test_every_shape_of_arkit_is_there():
    sides = {name.replace("Left", "_L").replace("Right", "_R") for name in ARKIT}
    whole = {
        "jaw_L": "jawLeft",
        "jaw_R": "jawRight",
        "mouth_L": "mouthLeft",
        "mouth_R": "mouthRight",
    }
    assert sorted(whole.get(name, name) for name in sides) == sorted(SHAPES)


def test_results_are_copies_of_the_catalogue():
    expressions().clear()
    shapes().clear()
    assert len(expressions()) == 5
    assert len(shapes()) == len(SHAPES)


@pytest.mark.parametrize("face", FACES)
def test_topology_is_shared_and_the_face_moves(face, neutral):
    require_same_topology(neutral, FACES[face])
    moved = np.linalg.norm(FACES[face].vertices - neutral.vertices, axis=1)
    assert 0.15 < moved.max() < 0.35 * neutral.diameter
    assert FACES[face].groups is neutral.groups


@pytest.mark.parametrize("face", ["sad", "angry", "grinning", "puff", "jawOpen", "cheekPuff"])
def test_symmetric_faces_are_symmetric(face, whole):
    points = FACES[face].vertices
    np.testing.assert_array_equal(points[whole.partner] * MIRROR, points)


@pytest.mark.parametrize("name", [n[:-2] for n in SHAPES if n.endswith("_L")])
def test_left_and_right_are_mirror_images(name, whole):
    left, right = SHAPES[f"{name}_L"].vertices, SHAPES[f"{name}_R"].vertices
    np.testing.assert_array_equal(left[whole.partner] * MIRROR, right)
    moved = np.abs(left - whole.mesh.vertices).max(axis=1)
    assert whole.mesh.vertices[moved.argmax(), 0] > 0.0


@pytest.mark.parametrize("face", FACES)
def test_no_lid_or_skin_enters_an_eyeball(face, whole):
    points = FACES[face].vertices
    for sign in (1.0, -1.0):
        offset = points[whole.part == "skin"] - EYE_CENTRE * [sign, 1.0, 1.0]
        assert np.linalg.norm(offset, axis=1).min() > EYE_RADIUS + 0.02


@pytest.mark.parametrize("face", FACES)
def test_eyeball_polygons_stay_behind_the_middle_of_lid_polygons(face, whole):
    """Lid polygons are flat: their middles must clear the sphere as well as their corners."""
    mesh = FACES[face]
    lid = mesh.groups.names.index(groups.LIDS)
    for number in np.flatnonzero(mesh.groups.of_face == lid):
        middle = mesh.vertices[mesh.faces[number]].mean(axis=0)
        centre = EYE_CENTRE * [np.sign(middle[0]), 1.0, 1.0]
        assert np.linalg.norm(middle - centre) > EYE_RADIUS - 0.03


def _closed(amount):
    """The jaw open as far, and the lips brought together."""
    neutral = head().vertices
    return neutral + amount * sum(SHAPES[k].vertices - neutral for k in ("jawOpen", "mouthClose"))


@pytest.mark.parametrize("face", [name for name in FACES if name != "mouthClose"])
def test_lips_do_not_cross(face, whole):
    assert _gaps(FACES[face].vertices, whole).min() > -0.01


@pytest.mark.parametrize("amount", [0.25, 0.5, 1.0])
def test_lips_that_the_jaw_has_parted_are_sealed_by_mouth_close(amount, whole):
    assert _gaps(_closed(amount), whole)[:, 1].min() > -0.01
    assert _gaps(_closed(amount), whole)[:, 1].max() < 0.05
    assert _gaps(SHAPES["jawOpen"].vertices, whole)[:, 1].max() > 2.5


@pytest.mark.parametrize(
    "names",
    [("mouthPress_L", "mouthPress_R"), ("mouthRollLower",), ("mouthRollUpper",),
     ("mouthRollLower", "mouthRollUpper")],
    ids="+".join,
)  # fmt: skip
def test_lips_that_press_or_roll_stay_closed(names, whole):
    neutral = head().vertices
    points = neutral + sum(SHAPES[name].vertices - neutral for name in names)
    assert _gaps(points, whole)[:, 1].max() < 0.03


def _gaps(points, whole):
    """(2, 2, 9) of the right and left half, the ring before the contact and the contact."""
    last = 2 * lips.STEPS
    found = []
    for rings in (whole.lay.mouth, whole.partner[whole.lay.mouth]):
        pair = rings[[lips.CONTACT - 1, lips.CONTACT]]
        upper = points[pair[:, : lips.STEPS], 1]
        found.append(upper - points[pair[:, last : last - lips.STEPS : -1], 1])
    return np.array(found)


def test_the_recipes_are_sums_of_shapes(neutral):
    """Where no lid turns, an expression is its shapes' displacements added up."""
    total = neutral.vertices.copy()
    for name, weight in EXPRESSIONS["puff"].items():
        for full in [name] if name in SHAPES else [f"{name}_L", f"{name}_R"]:
            total += weight * (SHAPES[full].vertices - neutral.vertices)
    np.testing.assert_allclose(FACES["puff"].vertices, total, atol=1e-7)


def test_sad(whole, corner, brow):
    assert _move(whole, "sad", corner)[1] < -0.4
    assert _move(whole, "sad", brow[:, :3])[1] > 0.5
    assert abs(_move(whole, "sad", brow[:, 7:])[1]) < 0.3


def test_angry(whole, brow):
    inner = _move(whole, "angry", brow[:, :4])
    assert inner[1] < -0.3
    assert inner[0] < -0.1  # towards the nose
    assert _opening(whole, "angry") < 0.85 * _opening(whole, None)
    red = whole.lay.mouth[lips.BORDER, [0, -1]]
    lips_now, lips_then = (
        p[red[0], 1] - p[red[1], 1] for p in (FACES["angry"].vertices, whole.mesh.vertices)
    )
    assert lips_now < 0.9 * lips_then


def test_each_brow_shape_lifts_its_own_end(whole, brow):
    neutral = whole.mesh.vertices
    inner, outer = brow[:, :2], brow[:, -3:]
    for shape, more, less in (("browInnerUp", inner, outer), ("browOuterUp_L", outer, inner)):
        up = SHAPES[shape].vertices[:, 1] - neutral[:, 1]
        assert up[more].mean() > 2.0 * max(up[less].mean(), 0.0)


def test_confused(whole, brow):
    assert _move(whole, "confused", brow)[1] > 0.4
    assert _move(whole, "confused", whole.partner[brow])[1] < -0.15
    assert _move(whole, "confused", whole.lay.mouth[lips.CONTACT, [0, -1]])[0] > 0.3


def test_grinning(whole, corner):
    moved = _move(whole, "grinning", corner)
    assert moved[0] > 0.4
    assert moved[1] > 0.5
    assert _opening(whole, "grinning") < 0.85 * _opening(whole, None)
    last = 2 * lips.STEPS
    upper, lower = whole.lay.mouth[lips.CONTACT, [2, last - 2]]
    points = FACES["grinning"].vertices
    assert points[upper, 1] - points[lower, 1] > 0.15  # teeth show


@pytest.mark.parametrize(
    ("shape", "way", "degrees"), [("Up", 1, 24), ("Down", 1, -27), ("Out", 0, 32), ("In", 0, -32)]
)
def test_eyes_look_and_the_lids_follow(shape, way, degrees, whole):
    """The eyeball turns about its centre; the upper lid goes up and down with it."""
    eye, moved = whole.part == "eye_L", SHAPES[f"eyeLook{shape}_L"].vertices
    ahead = whole.mesh.vertices[eye][:, 2].argmax()
    offset = moved[eye][ahead] - EYE_CENTRE
    assert np.degrees(np.arcsin(offset[way] / EYE_RADIUS)) == pytest.approx(degrees, abs=1e-5)
    np.testing.assert_allclose(
        np.linalg.norm(moved[eye] - EYE_CENTRE, axis=1), EYE_RADIUS, atol=1e-7
    )
    lid = _move(whole, f"eyeLook{shape}_L", whole.lay.eye[7, 3:7])[way]
    assert np.sign(degrees) * lid > 0.1
    np.testing.assert_array_equal(
        moved[whole.part == "eye_R"], whole.mesh.vertices[whole.part == "eye_R"]
    )


@pytest.mark.parametrize("name", ["eyeBlink_L", "eyeLookDown_L", "eyeLookUp_L", "eyeSquint_L"])
def test_lids_go_around_the_eyeball_by_auto(name, whole):
    """At 11 times no vertex of the skin is in it, as on a straight line some are in a blink."""
    ends = whole.mesh, SHAPES[name]
    skin = np.flatnonzero((whole.part == "skin") & (whole.mesh.vertices[:, 0] > 0.0))

    def nearest(method):
        path = em.interpolate(*ends, method)
        around = [path.at(t)[skin] - EYE_CENTRE for t in np.linspace(0.0, 1.0, 11)]
        return np.linalg.norm(around, axis=2).min()

    assert nearest("auto") > EYE_RADIUS
    assert name != "eyeBlink_L" or nearest("linear") < EYE_RADIUS - 0.02


def test_puff(whole):
    """Cheeks swell: the skin gains volume, most of it beside the mouth."""
    assert _volume(whole, "puff") > _volume(whole, None) + 20.0
    moved = FACES["puff"].vertices - whole.mesh.vertices
    swollen = whole.mesh.vertices[moved[:, 0].argmax()]
    assert swollen[0] > 3.0
    assert -8.0 < swollen[1] < -4.5


def test_a_blink_closes_one_eye(whole):
    assert _opening(whole, "eyeBlink_L") < 0.02
    assert _opening(whole, "eyeBlink_R") == pytest.approx(_opening(whole, None))
    assert _opening(whole, "eyeWide_L") > 1.15 * _opening(whole, None)


def test_the_open_jaw_carries_lower_teeth_rigidly(whole, neutral):
    moved = SHAPES["jawOpen"].vertices
    rigid = np.flatnonzero(jaw_weights() == 1.0)
    rigid = rigid[np.isin(whole.part[rigid], ("lower_teeth", "tongue"))]
    before = neutral.vertices[rigid] - neutral.vertices[rigid[0]]
    after = moved[rigid] - moved[rigid[0]]
    np.testing.assert_allclose(after @ after.T, before @ before.T, atol=1e-6)
    chin = whole.lay.grid[MOUTH.bottom + 3, 0]
    assert moved[chin, 1] < neutral.vertices[chin, 1] - 2.0
    still = np.isin(whole.part, ("upper_teeth", "eye_L", "eye_R"))
    np.testing.assert_array_equal(moved[still], neutral.vertices[still])


def _opening(whole, face):
    """Height of the left eye's opening in the middle."""
    points = whole.mesh.vertices if face is None else FACES[face].vertices
    edge = whole.lay.eye[7]
    return float(np.linalg.norm(points[edge[4]] - points[edge[18]]))


def _volume(whole, face):
    mesh = whole.mesh if face is None else FACES[face]
    a, b, c = mesh.vertices[mesh.faces.triangles()].swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
