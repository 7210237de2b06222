"""The recorded motion of ICT-FaceKit's head is anatomical, and nothing of it follows a line."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

import record_motion
from record_motion import FRAMES, GLIDE, JAW_TURN, find_hinge, hinge_glide, jaw_angle, motion

pytestmark = pytest.mark.realdata

SKIN, GUMS = slice(0, 14062), slice(14062, 17039)
UPPER_TEETH, LOWER_TEETH = slice(17039, 19247), slice(19247, 21451)
EYEBALLS, AT_LIDS = slice(21451, 24591), slice(24591, 26719)
INCISOR, CHIN = 20281, 966
LIP_CORNER = (2.19, -3.46, 10.09)
D = 35.675  # cm, the largest distance between two vertices
EYE_CENTRE, EYE_RADIUS = np.array([3.116, 3.602, 7.982]), 1.577
SIDES = ((1.0, "Left"), (-1.0, "Right"))
TIMES = np.arange(11) / 10


def _positions(file: Path) -> np.ndarray:
    lines = file.read_text().splitlines()
    return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)


@pytest.fixture(scope="module")
def neutral(data_dir):
    return _positions(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")


@pytest.fixture(scope="module")
def triangles(data_dir):
    """Triangles of the skin."""
    file = data_dir / "ict-facekit" / "generic_neutral_mesh.obj"
    found = []
    for line in file.read_text().splitlines():
        if line.startswith("f "):
            corners = [int(word.split("/")[0]) - 1 for word in line.split()[1:]]
            found += [(corners[0], *corners[k : k + 2]) for k in range(1, len(corners) - 1)]
    return np.array([each for each in found if max(each) < SKIN.stop])


@pytest.fixture(scope="module")
def targets(data_dir, neutral):
    """Shapes by their ARKit names; the halves of browInnerUp are one."""
    found = {}
    for part in (
        *("mouthSmile", "mouthStretch", "mouthUpperUp", "noseSneer", "browInnerUp", "browOuterUp"),
        *("cheekSquint", "eyeSquint", "eyeBlink"),
    ):
        for _, side in SIDES:
            found[part + side] = _positions(data_dir / "ict-facekit" / f"{part}_{side[0]}.obj")
    halves = [found.pop(f"browInnerUp{side}") for _, side in SIDES]
    found["browInnerUp"] = halves[0] + halves[1] - neutral
    found["jawOpen"] = _positions(data_dir / "ict-facekit" / "jawOpen.obj")
    return found


@pytest.fixture(scope="module")
def frames(neutral, targets):
    return motion(neutral, targets)


def _rigid_motion(before, after):
    """Best rotation and translation from one set of points to another (Kabsch)."""
    a, b = before.mean(axis=0), after.mean(axis=0)
    u, _, vt = np.linalg.svd((before - a).T @ (after - b))
    turn = (u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt).T
    return turn, b - turn @ a


def test_eleven_finite_frames_from_the_neutral_bit_for_bit(frames, neutral):
    assert frames.shape == (FRAMES, *neutral.shape) == (11, 26719, 3)
    assert frames.dtype == np.float64
    assert np.isfinite(frames).all()
    assert frames[0].tobytes() == neutral.tobytes()


def test_it_is_the_same_on_every_call(frames, neutral, targets):
    backwards = dict(reversed(targets.items()))
    assert motion(neutral, backwards).tobytes() == frames.tobytes()


def test_the_hinge_is_that_of_jaw_open(neutral, targets):
    """25.3° about the axis along x through (0, −0.55, 1.82)."""
    centre, angle = find_hinge(neutral[LOWER_TEETH], targets["jawOpen"][LOWER_TEETH])
    np.testing.assert_allclose(centre, [-0.55, 1.82], atol=0.01)
    assert np.degrees(angle) == pytest.approx(25.3, abs=0.1)


@pytest.mark.parametrize("frame", range(1, 11))
def test_lower_teeth_and_gums_turn_rigidly_about_the_gliding_hinge(frame, frames, neutral, targets):
    before, after = neutral[LOWER_TEETH], frames[frame, LOWER_TEETH]
    turn, shift = _rigid_motion(before, after)
    np.testing.assert_allclose(before @ turn.T + shift, after, atol=1e-7)
    np.testing.assert_allclose(turn @ [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], atol=1e-7)
    angle = np.degrees(np.arctan2(turn[2, 1], turn[1, 1]))
    assert angle == pytest.approx(jaw_angle(frame / 10), abs=1e-6)
    hinge = np.append(0.0, find_hinge(before, targets["jawOpen"][LOWER_TEETH])[0])
    glide = turn @ hinge + shift - hinge
    np.testing.assert_allclose(glide[1:], hinge_glide(frame / 10), atol=1e-7)
    # gums and tongue are on one bone or on the other
    gone = np.linalg.norm(frames[frame, GUMS] - neutral[GUMS], axis=1)
    off = np.linalg.norm(neutral[GUMS] @ turn.T + shift - frames[frame, GUMS], axis=1)
    assert np.minimum(gone, off).max() < 1e-7
    assert (off < 1e-7).sum() == 1690


def test_the_jaw_opens_steadily_and_its_hinge_glides_forwards_and_down():
    angles = np.array([jaw_angle(t) for t in TIMES])
    assert angles[0] == 0.0
    assert angles[-1] == pytest.approx(JAW_TURN)
    assert 22.0 <= JAW_TURN <= 25.0
    assert (np.diff(angles) > 0.0).all()
    glides = np.array([hinge_glide(t) for t in TIMES])
    np.testing.assert_allclose(glides[[0, -1]], [[0.0, 0.0], GLIDE])
    assert (np.diff(glides, axis=0) * [-1.0, 1.0] > 0.0).all()
    assert np.linalg.norm(GLIDE) < 0.5


@pytest.mark.parametrize(("vertex", "tolerance"), [(INCISOR, 1e-3), (CHIN, 0.01)])
def test_a_vertex_of_the_jaw_leaves_its_chord_as_a_circular_arc_does(
    vertex, tolerance, neutral, targets
):
    """At angle α of θ an arc of radius r is r(cos(α − θ/2) − cos(θ/2)) away from its chord."""
    jaw = {"jawOpen": targets["jawOpen"]}
    hinge, angle = find_hinge(neutral[LOWER_TEETH], jaw["jawOpen"][LOWER_TEETH])
    (y, z), (to_y, to_z) = neutral[vertex, 1:] - hinge, jaw["jawOpen"][vertex, 1:] - hinge
    share = np.arctan2(y * to_z - z * to_y, y * to_y + z * to_z) / angle
    path = motion(neutral, jaw)[:, vertex, 1:] - share * np.array([hinge_glide(t) for t in TIMES])
    angles = np.radians([share * jaw_angle(t) for t in TIMES])
    radius = np.linalg.norm(path[0] - hinge)
    chord = (path[-1] - path[0]) / np.linalg.norm(path[-1] - path[0])
    offset = path - path[0]
    deviation = np.abs(offset[:, 0] * chord[1] - offset[:, 1] * chord[0])
    half = angles[-1] / 2
    expected = radius * (np.cos(angles - half) - np.cos(half))
    np.testing.assert_allclose(deviation, expected, atol=tolerance)
    assert deviation.max() > 0.15


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_lids_never_press_deeper_into_the_eyeball_than_at_both_ends(sign, frames, neutral):
    """By at most 0.001 cm, where straight lines between the same ends go 0.01 cm deeper."""
    away = np.linalg.norm(frames - EYE_CENTRE * [sign, 1.0, 1.0], axis=2)
    lids = np.flatnonzero(away[0] < EYE_RADIUS + 0.3)
    lids = lids[(lids < SKIN.stop) | (lids >= AT_LIDS.start)]
    assert len(lids) > 1000
    ends = np.minimum(away[0], away[-1])
    assert (ends - away)[:, lids].max() < 0.001
    middle = (frames[0] + frames[-1])[lids] / 2 - EYE_CENTRE * [sign, 1.0, 1.0]
    assert (ends[lids] - np.linalg.norm(middle, axis=1)).max() > 0.01


def test_skull_upper_teeth_and_eyeballs_stay(frames, neutral):
    for part in (UPPER_TEETH, EYEBALLS):
        for frame in frames:
            np.testing.assert_array_equal(frame[part], neutral[part])
    back = np.flatnonzero((neutral[SKIN, 1] > 3.0) & (neutral[SKIN, 2] < -2.0))
    assert len(back) > 300
    assert np.abs(frames[:, back] - neutral[back]).max() < 0.05


def test_vertices_at_one_place_stay_at_one_place(frames, neutral):
    """Such as roots of lashes at the edges of the lids."""
    _, place, count = np.unique(neutral, axis=0, return_inverse=True, return_counts=True)
    place = place.ravel()
    first = np.zeros(len(count), dtype=int)
    first[place[::-1]] = np.arange(len(place))[::-1]
    assert (count > 1).sum() > 100
    shared = np.flatnonzero(count[place] > 1)
    np.testing.assert_array_equal(frames[:, shared], frames[:, first[place[shared]]])


def test_parts_move_at_their_own_times(frames, neutral):
    """Brows lead, then the jaw and the corners of the mouth; the lower lids follow."""
    halfway = {}
    for name, point in (
        ("brow", (3.0, 6.0, 9.9)),
        ("chin", neutral[CHIN]),
        ("corner", (2.53, -3.52, 10.19)),
        ("lower lid", (3.4, 2.6, 9.6)),
    ):
        vertices = cKDTree(neutral[SKIN]).query(point, k=12)[1]
        gone = np.linalg.norm(frames[:, vertices] - neutral[vertices], axis=2)
        progress = gone.mean(axis=1) / gone[-1].mean()
        halfway[name] = float(np.interp(0.5, progress, TIMES))
    assert halfway["brow"] + 0.1 < halfway["chin"]
    assert halfway["brow"] + 0.1 < halfway["corner"]
    assert halfway["corner"] + 0.1 < halfway["lower lid"]


def test_it_is_as_symmetric_as_the_shapes(frames, neutral, targets):
    """The skin of mirrored poses differs by no more than mirrored shapes do, all together."""
    away, partner = cKDTree(neutral).query(neutral * [-1.0, 1.0, 1.0])
    paired = np.flatnonzero((away < 1e-6) & (partner[partner] == np.arange(len(neutral))))
    skin = (paired < SKIN.stop) & (partner[paired] < SKIN.stop)
    assert skin.sum() > 13000

    def skew(points):
        gap = points[paired] * [-1.0, 1.0, 1.0] - points[partner[paired]]
        return np.linalg.norm(gap, axis=1)

    allowed = skew(targets["jawOpen"]) + skew(targets["browInnerUp"])
    for name in {name.removesuffix("Left") for name in targets if name.endswith("Left")}:
        allowed += skew(targets[f"{name}Left"] + targets[f"{name}Right"] - neutral)
    for frame in frames:
        assert (skew(frame) - allowed)[skin].max() < 1e-9
        assert (skew(frame) - allowed).max() < 0.03  # other lashes touch the lids on each side


def _normals(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.zeros((SKIN.stop, 3))
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], np.cross(b - a, c - a))
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def test_lips_never_cross_deeper_than_at_both_ends(frames, neutral, targets, triangles):
    """By more than 0.01 cm. How deep: below the tangent plane of the other lip's nearest vertex."""
    x, y, z = np.abs(neutral[SKIN].T)
    near = (x < 2.6) & (y > 2.4) & (y < 4.4) & (z > 9.3)
    fallen = np.linalg.norm(targets["jawOpen"] - neutral, axis=1)[SKIN]
    lips = np.flatnonzero(near & (fallen < 1.2)), np.flatnonzero(near & (fallen > 2.2))
    assert min(map(len, lips)) > 400

    def depth(points):
        normals, deepest = _normals(points, triangles), 0.0
        for one, other in (lips, lips[::-1]):
            away, nearest = cKDTree(points[other]).query(points[one])
            gap = points[one] - points[other[nearest]]
            inside = -np.einsum("ij,ij->i", gap, normals[other[nearest]])
            deepest = max(deepest, float(inside[away < 0.4].max(initial=0.0)))
        return deepest

    allowed = max(depth(frames[0]), depth(frames[-1])) + 0.01
    assert max(depth(frame) for frame in frames) <= allowed


def test_hardly_a_vertex_of_the_skin_is_turned_over(frames, neutral, triangles):
    """Fewer than 10 of 14,062, all of them where lids and lips fold at their corners."""
    corners = [[sign * x, y, z] for sign, _ in SIDES for x, y, z in ((4.5, 3.42, 8.6), LIP_CORNER)]
    before = _normals(frames[0], triangles)
    for frame in frames:
        turned = np.einsum("ij,ij->i", before, _normals(frame, triangles))
        over = np.flatnonzero(turned < 0.0)
        assert len(over) < 10
        assert (cKDTree(corners).query(neutral[over])[0] < 0.2).all()


def test_no_straight_line_reproduces_it(frames):
    """Even with the best common timing of all, straight paths are off by over 1 % of D."""
    start, way = frames[0], frames[-1] - frames[0]
    worst = 0.0
    for frame in frames[1:-1]:
        best = np.sum((frame - start) * way) / np.sum(way**2)
        worst = max(worst, float(np.linalg.norm(frame - start - best * way, axis=1).max()))
    assert worst > 0.01 * D


def test_it_shares_nothing_with_the_methods_that_it_judges() -> None:
    """The motion is made with NumPy alone."""
    tree = ast.parse(Path(record_motion.__file__).read_text(encoding="utf-8"))
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    modules |= {name.name for n in ast.walk(tree) if isinstance(n, ast.Import) for name in n.names}
    assert modules == {"__future__", "collections.abc", "numpy", "numpy.typing"}
