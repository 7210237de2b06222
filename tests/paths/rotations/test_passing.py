"""Bends are eased where a surface would pass deeper through itself than straight, only there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.geometry import moved_extent
from elastomorph.model.morph import Choice
from elastomorph.paths.rotations import Neighbourhoods
from elastomorph.paths.rotations.passing import ALLOWED, Sheets, passing, without_passing
from small_head import head, shapes

Points = NDArray[np.float64]
Triangles = NDArray[np.int64]

GAP, FLAP, WIDE = 0.5, 20, 16
CURVE = BendCurve.polynomial([0.0, 4.0, -4.0])  # 1 at t = 1/2
D = 100.0


def hairpin(gap: float = GAP) -> em.Mesh:
    """One sheet folded so that its two flaps, unit squares, face each other across a gap."""
    along = np.arange(FLAP + 1.0)
    x = np.concatenate([along, along[::-1]])
    z = np.repeat([0.0, gap], FLAP + 1)
    y = np.arange(WIDE + 1.0)
    rows, columns = len(x) - 1, WIDE
    points = np.stack(np.broadcast_arrays(x[:, None], y, z[:, None]), axis=-1).reshape(-1, 3)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    quads = np.stack([corner, corner + columns + 1, corner + columns + 2, corner + 1], axis=1)
    return em.Mesh(points, quads)


def dent(mesh: em.Mesh) -> NDArray[np.float64]:
    """(V,) 1 in the middle of the upper flap, 0 at its borders and on the lower flap."""
    x, y, _ = mesh.vertices.T
    upper = np.arange(len(x)) >= len(x) // 2
    across = np.clip(np.minimum(x - 2, FLAP - 4 - x) / 4, 0, 1)
    across *= np.clip(np.minimum(y, WIDE - y) / 4, 0, 1)
    return np.where(upper, across, 0.0)


def pushed(mesh: em.Mesh, by: float, end: float = 0.0) -> em.Morph:
    """The upper flap dented downwards by a bend, and by the target."""
    down = dent(mesh)[:, None] * [0.0, 0.0, -1.0]
    target = mesh.with_vertices(mesh.vertices + end * down)
    return em.Morph(mesh, target, by * down[None], (CURVE,))


def sheets(mesh: em.Mesh) -> Sheets:
    return Sheets.of(mesh, around(mesh))


def around(mesh: em.Mesh) -> Neighbourhoods:
    return Neighbourhoods.of(len(mesh.vertices), mesh.edges)


def test_the_depth_is_that_of_the_hand() -> None:
    """A flap pushed by gap + d at t = 1/2 is d behind the other, which is flat."""
    mesh = hairpin()
    deeper, crossing, deep = passing(pushed(mesh, GAP + 0.3), sheets(mesh), D)
    assert deeper == pytest.approx(0.3 / D, rel=1e-9)
    through = (GAP + 0.3) * dent(mesh) > GAP * (1 + 1e-9)
    # Those of the lower flap below the dent are behind it too.
    assert through.sum() < crossing <= 2 * through.sum()
    assert deep[(GAP + 0.3) * dent(mesh) - GAP > ALLOWED * D].all()
    assert passing(pushed(mesh, 0.9 * GAP), sheets(mesh), D)[:2] == (0.0, 0)


def test_depth_of_the_target_is_that_of_the_shapes() -> None:
    """Depth at t is e·t - g(1 - t) + 4t(1 - t)·p with a target e behind: e of it does not count."""
    mesh, target, by = hairpin(), 0.4, 0.9
    time = np.arange(1, 6) / 6
    depth = target * time - GAP * (1 - time) + 4 * time * (1 - time) * by
    deeper, _, _ = passing(pushed(mesh, by, GAP + target), sheets(mesh), D)
    assert deeper == pytest.approx((depth.max() - target) / D, rel=1e-9)
    assert passing(pushed(mesh, 0.2, GAP + target), sheets(mesh), D)[0] == 0


def test_depth_of_the_neutral_is_that_of_the_shapes() -> None:
    """The same backwards: a neutral e behind, found in the target, which is in front."""
    mesh, depth, by = hairpin(), 0.4, 0.9
    back = pushed(mesh, by, GAP + depth)
    turned = em.Morph(back.target, back.neutral, back.bends, back.bend_curves)
    expected = passing(back, sheets(mesh), D)
    assert expected[0] > ALLOWED
    found = passing(turned, sheets(turned.neutral), D)
    assert found[0] == pytest.approx(expected[0], rel=1e-9)
    assert found[1] == expected[1]
    np.testing.assert_array_equal(found[2], expected[2])


def test_what_faces_in_one_shape_only_is_found() -> None:
    """Flaps eight edges apart that the target, or the neutral, brings together."""
    mesh = hairpin(8.0)
    closing = pushed(mesh, 0.0, 7.6)
    bends = pushed(mesh, 6.0).bends
    for start, end in ((mesh, closing.target), (closing.target, mesh)):
        morph = em.Morph(start, end, bends, (CURVE,))
        assert passing(morph, sheets(start), D)[0] > ALLOWED


def test_more_than_is_allowed_is_deep_and_no_less() -> None:
    """Which vertices are too deep is decided at .1 % of D, on both flaps."""
    mesh = hairpin()
    half = len(mesh.vertices) // 2
    for by, deep in ((0.98 * ALLOWED * D, False), (1.02 * ALLOWED * D, True)):
        found = passing(pushed(mesh, GAP + by), sheets(mesh), D)
        assert found[0] == pytest.approx(by / D, rel=1e-9)
        assert found[2][:half].any() == found[2][half:].any() == deep


def test_what_is_farther_than_some_edges_does_not_face() -> None:
    """Eight edges: the flaps have nothing to do with each other, whatever bends do."""
    mesh = hairpin(8.0)
    assert passing(pushed(mesh, 8.3), sheets(mesh), D)[:2] == (0.0, 0)


def test_what_is_carried_along_does_not_pass() -> None:
    """Both flaps bend far, together."""
    mesh = hairpin()
    bends = np.full((1, *mesh.vertices.shape), 3.0)
    morph = em.Morph(mesh, mesh, bends, (CURVE,))
    assert passing(morph, sheets(mesh), D)[:2] == (0.0, 0)
    assert without_passing(morph, around(mesh), sheets(mesh), (), D) is morph


def test_the_two_sides_of_a_cheek_do_not_face_each_other() -> None:
    """Turned over, each flap is behind the other from the first."""
    mesh = hairpin()
    other = em.Mesh(mesh.vertices, [polygon[::-1] for polygon in mesh.faces])
    assert passing(pushed(other, GAP + 0.3), sheets(other), D)[:2] == (0.0, 0)


def test_easing_leaves_less_than_is_allowed_and_keeps_what_is_far() -> None:
    mesh = hairpin()
    morph = replace(pushed(mesh, GAP + 0.68), choice=Choice(0.01, 5e-4))
    eased = without_passing(morph, around(mesh), sheets(mesh), (), D)
    assert passing(morph, sheets(mesh), D)[0] > ALLOWED
    assert passing(eased, sheets(mesh), D)[0] <= ALLOWED
    assert eased.choice is not None
    changed = (eased.bends != morph.bends).any(axis=(0, 2))
    assert eased.choice.eased == changed.sum() > 0
    assert 0 < eased.choice.deeper <= ALLOWED
    assert eased.choice.crossing > 0
    # All of what was too deep and three rings more are halved alike.
    deep = around(mesh).within(passing(morph, sheets(mesh), D)[2], 3) & (morph.bends[0, :, 2] != 0)
    assert (eased.bends[0, deep, 2] <= -0.0).all()
    assert (np.abs(eased.bends[0, deep, 2]) <= 0.5 * np.abs(morph.bends[0, deep, 2])).all()
    assert without_passing(eased, around(mesh), sheets(mesh), (), D).bends is eased.bends
    share = eased.bends[0, changed, 2] / morph.bends[0, changed, 2]
    assert (share >= 0).all()
    assert (share < 1).all()


@given(st.integers(0, 10**6), st.floats(-3, 3))
@settings(max_examples=15, deadline=None)
def test_the_measure_is_free_of_place_size_and_numbers(seed: int, exponent: float) -> None:
    """Rotated, scaled and renumbered, a morph passes as deep, at the same vertices."""
    rng = np.random.default_rng(seed)
    mesh = hairpin()
    # Nothing is equally far from two places.
    mesh = mesh.with_vertices(
        mesh.vertices + rng.uniform(-0.2, 0.2, (len(mesh.vertices), 3)) * [1, 1, 0]
    )
    waves = np.sin(mesh.vertices @ rng.normal(size=3) * 0.3)
    down = dent(mesh) * (GAP + 0.6 + 0.1 * waves)
    bends = down[:, None] * [0.0, 0.0, -1.0]
    morph = em.Morph(mesh, mesh, bends[None], (CURVE,))
    deeper, crossing, deep = passing(morph, sheets(mesh), D)
    assert deeper > ALLOWED
    size, turn = 10.0**exponent, Rotation.random(random_state=seed).as_matrix().T
    order = rng.permutation(len(mesh.vertices))
    number = np.argsort(order)
    faces = [number[polygon] for polygon in mesh.faces]
    again = em.Mesh(
        size * mesh.vertices[order] @ turn + 3 * size,
        [faces[i] for i in rng.permutation(len(faces))],
    )
    other = em.Morph(again, again, size * bends[None, order] @ turn, (CURVE,))
    found = passing(other, sheets(again), size * D)
    assert found[0] == pytest.approx(deeper, rel=1e-6)
    assert found[1] == crossing
    # A closest point on an edge is of either triangle there.
    assert (found[2] != deep[order]).mean() < 0.01


def test_what_hangs_on_a_surface_is_no_part_of_it() -> None:
    """Lashes: a strip that grows from a line within the lower flap, up through the upper one."""
    mesh = hairpin()
    count = len(mesh.vertices)
    root = 10 * (WIDE + 1) + np.arange(3, WIDE - 2)
    tips = count + np.arange(len(root))
    points = np.concatenate([mesh.vertices, mesh.vertices[root] + [0.0, 0.0, 0.4 * GAP]])
    strip = np.stack([root[:-1], root[1:], tips[1:], tips[:-1]], axis=1)
    both = em.Mesh(points, [*mesh.faces, *strip])
    parts = sheets(both)
    assert (parts.numbers[count:] == -1).all()
    assert (parts.numbers[:count] == parts.numbers[0]).all()
    bends = np.zeros((1, *points.shape))
    bends[0, count:, 2] = 2.0
    morph = em.Morph(both, both, bends, (CURVE,))
    assert passing(morph, parts, D)[:2] == (0.0, 0)
    assert without_passing(morph, around(both), parts, (), D) is morph


def test_nothing_is_eased_where_nothing_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Paths of the small head are the same to the bit without the measure."""
    face, targets = head(), shapes()
    bent = {name: morph for name, morph in prepared(face, targets).items() if len(morph.bends)}
    assert len(bent) > 5
    monkeypatch.setattr("elastomorph.paths.rotation.without_passing", lambda morph, *_: morph)
    without = prepared(face, {name: targets[name] for name in bent})
    for name, morph in bent.items():
        assert morph.choice is not None
        assert morph.choice.eased == 0
        np.testing.assert_array_equal(morph.bends, without[name].bends)


def prepared(neutral: em.Mesh, targets: dict[str, em.Mesh]) -> dict[str, em.Morph]:
    to = em.prepare(neutral, "auto", targets=list(targets.values()))
    return {name: to(target) for name, target in targets.items()}


def test_no_surface_and_no_bends_pass_nothing() -> None:
    mesh = hairpin()
    straight = em.interpolate(mesh, pushed(mesh, 0.0, 2 * GAP).target, "linear")
    assert passing(straight, sheets(mesh), D)[:2] == (0.0, 0)
    markers = em.Mesh(mesh.vertices)
    morph = em.Morph(markers, markers, pushed(mesh, 2.0).bends, (CURVE,))
    assert passing(morph, sheets(markers), D)[:2] == (0.0, 0)


def behind(points: Points, triangles: Triangles, asked: Points) -> Points:
    """(N,) how far points are behind a surface by VTK; NaN where its border is closest."""
    from scipy.spatial import cKDTree
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

    surface, corners, cells = vtkPolyData(), vtkPoints(), vtkCellArray()
    corners.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=1))
    offsets = np.arange(0, triangles.size + 1, 3)
    cells.SetData(*(numpy_to_vtkIdTypeArray(a, deep=1) for a in (offsets, triangles.ravel())))
    surface.SetPoints(corners)
    surface.SetPolys(cells)
    distance = vtkImplicitPolyDataDistance()
    distance.SetInput(surface)
    depth, closest = np.empty(len(asked)), np.empty((len(asked), 3))
    for place, point in enumerate(asked):
        depth[place] = -distance.EvaluateFunctionAndGetClosestPoint(point, closest[place])
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    sides, uses = np.unique(sides, axis=0, return_counts=True)
    border = points[np.unique(sides[uses == 1])]
    edge = np.linalg.norm(points[sides[:, 0]] - points[sides[:, 1]], axis=1).mean()
    depth[cKDTree(border).query(closest)[0] < 0.3 * edge] = np.nan
    return depth


class Halves:
    """Two parts of the skin of ICT FaceKit: those that a target moves far, and the others."""

    def __init__(self, neutral: em.Mesh, mover: em.Mesh, near: float) -> None:
        moved = np.linalg.norm(mover.vertices - neutral.vertices, axis=1)
        triangles = neutral.faces.triangles().astype(np.int64)
        triangles = triangles[(triangles < 9409).all(axis=1)]  # M_Face
        far = moved > 0.5 * moved[:9409].max()
        points = neutral.vertices
        one, other = (np.unique(triangles[s[triangles].all(axis=1)]) for s in (far, ~far))
        gap = [np.linalg.norm(points[one, None] - points[other], axis=2)]
        self.asked = one[gap[0].min(axis=1) < near], other[gap[0].min(axis=0) < near]
        middle = points[np.concatenate(self.asked)].mean(axis=0)
        close = np.linalg.norm(points - middle, axis=1) < 6 * near
        self.parts = [triangles[(s & close)[triangles].all(axis=1)] for s in (~far, far)]

    def depth(self, points: Points) -> Points:
        """Of each part behind the other."""
        return np.concatenate(
            [
                behind(points, part, points[own])
                for part, own in zip(self.parts, self.asked, strict=True)
            ]
        )

    def excess(self, morph: em.Morph) -> float:
        """The largest depth beyond that of neutral, target and straight line."""
        start, end = morph.neutral.vertices, morph.target.vertices
        ends = [self.depth(start), self.depth(end)]
        most = 0.0
        for t in np.arange(1, 6) / 6:
            straight = self.depth((1 - t) * start + t * end)
            before = np.maximum.reduce([*ends, straight, np.zeros(len(straight))])
            more = self.depth(morph.at(t)) - before
            more[np.minimum(*ends) > 0] = np.nan
            most = max(most, float(np.nanmax(more)))
        return most


@pytest.fixture(scope="module")
def ict(data_dir: Path) -> tuple[em.Mesh, dict[str, em.Mesh]]:
    folder = data_dir / "ict-facekit"
    names = ("jawOpen", "mouthClose", "mouthFunnel", "eyeBlink_L", "eyeBlink_R")
    return (
        em.read(folder / "generic_neutral_mesh.obj"),
        {name: em.read(folder / f"{name}.obj") for name in names},
    )


@pytest.mark.realdata
@pytest.mark.slow
def test_lips_of_a_production_rig_are_eased_and_lids_are_not(
    ict: tuple[em.Mesh, dict[str, em.Mesh]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Signed distances of VTK see lips pass too deep without easing, not with it; lids never."""
    neutral, targets = ict
    extent = moved_extent(neutral.vertices, (target.vertices for target in targets.values()))
    eased = prepared(neutral, targets)
    monkeypatch.setattr("elastomorph.paths.rotation.without_passing", lambda morph, *_: morph)
    full = prepared(neutral, targets)
    for name in targets:
        choice = eased[name].choice
        assert choice is not None
        assert bool(choice.eased) == (name in {"mouthClose", "mouthFunnel"}), name
        assert choice.deeper <= ALLOWED
        if not choice.eased:
            np.testing.assert_array_equal(eased[name].bends, full[name].bends)
    lips = Halves(neutral, targets["jawOpen"], 0.06 * extent)
    for name in ("mouthClose", "mouthFunnel"):
        assert lips.excess(full[name]) > ALLOWED * extent
        assert lips.excess(eased[name]) < ALLOWED * extent
    for name in ("eyeBlink_L", "eyeBlink_R"):
        lids = Halves(neutral, targets[name], 0.03 * extent)
        assert lids.excess(eased[name]) < ALLOWED * extent


@pytest.mark.realdata
@pytest.mark.slow
def test_every_door_eases(ict: tuple[em.Mesh, dict[str, em.Mesh]], tmp_path: Path) -> None:
    """Arrays, a folder and a GLB of the same faces."""
    neutral, targets = ict
    few = {name: targets[name] for name in ("mouthFunnel", "eyeBlink_L")}
    expected = prepared(neutral, few)["mouthFunnel"].choice
    assert expected is not None
    assert expected.eased > 0
    (tmp_path / "rig").mkdir()
    em.write(tmp_path / "rig" / "neutral.obj", neutral)
    for name, target in few.items():
        em.write(tmp_path / "rig" / f"{name}.obj", target)
    folder = em.read_rig(tmp_path / "rig", method="auto")
    folder.save(tmp_path / "rig.glb")
    for rig in (folder, em.read_rig(tmp_path / "rig.glb", method="auto")):
        choice = rig.morphs["mouthFunnel"].choice
        assert choice is not None
        assert choice.eased == pytest.approx(expected.eased, rel=0.05)
        assert choice.deeper <= ALLOWED
