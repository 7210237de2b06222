"""The head as a mesh: size, quads, manifold, closed where it should be, mirror symmetric."""

from __future__ import annotations

import numpy as np

from elastomorph.samples import head
from sculptor import groups
from sculptor.anatomy import EYE_CENTRE, EYE_RADIUS, skin
from sculptor.layout import COLUMNS, EYE

MIRROR = np.array([-1.0, 1.0, 1.0])


def test_size_and_quads(neutral):
    assert 4500 <= len(neutral.vertices) <= 5600
    assert (neutral.faces.sizes == 4).mean() > 0.95
    assert set(neutral.faces.sizes.tolist()) <= {3, 4}
    assert head() is neutral


def test_it_is_about_as_large_as_a_head_in_centimetres(neutral, whole):
    points = neutral.vertices[whole.part == "skin"]
    middle = points[np.abs(points[:, 0]) < 1e-9]
    chin = middle[(middle[:, 2] > 7.0)][:, 1].min()
    assert 22.0 < points[:, 1].max() - chin < 25.0
    assert 14.0 < np.ptp(points[points[:, 1] > 2.0][:, 0]) < 16.0
    assert points[:, 2].argmax() in np.flatnonzero(np.abs(points[:, 0]) < 0.5)  # the nose


def test_every_edge_has_one_polygon_on_each_side_wound_alike(runs):
    _, times = np.unique(runs, axis=0, return_counts=True)
    assert times.max() == 1, "two polygons run along an edge in the same direction"


def test_borders_are_the_neck_and_the_inner_ends_of_the_lids(runs, whole):
    there = {tuple(edge) for edge in runs.tolist()}
    border = np.array([edge for edge in there if edge[::-1] not in there])
    neck = whole.lay.grid[-1]
    lids = whole.lay.eye[-1]
    rims = [neck, lids]
    expected = {int(v) for rim in rims for v in (*rim, *whole.partner[rim])}
    assert set(border.ravel().tolist()) == expected
    assert len(border) == 2 * COLUMNS + 2 * len(EYE.outline())


def test_euler_characteristic_of_each_component(neutral, whole, pieces):
    """V − E + F: 2 for a closed piece, and −1 for the skin, a sphere with three holes."""
    corner_piece = pieces[neutral.faces.indices[neutral.faces.offsets[:-1]]]
    found = {}
    for piece in np.unique(pieces):
        vertices = int((pieces == piece).sum())
        edges = int((pieces[neutral.edges[:, 0]] == piece).sum())
        names = set(whole.part[pieces == piece].tolist())
        assert len(names) == 1
        found[names.pop()] = vertices - edges + int((corner_piece == piece).sum())
    assert found == {
        "skin": -1,
        "eye_L": 2,
        "eye_R": 2,
        "upper_teeth": 2,
        "lower_teeth": 2,
        "tongue": 2,
    }


def test_closed_pieces_are_wound_outward(neutral, whole):
    """The signed volume of a closed surface is positive when its polygons face outward."""
    a, b, c = neutral.vertices[neutral.faces.triangles()].swapaxes(0, 1)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    part = whole.part[neutral.faces.triangles()[:, 0]]
    for name in ("eye_L", "eye_R", "upper_teeth", "lower_teeth", "tongue"):
        assert volume[part == name].sum() > 0.1, name
    sphere = 4.0 / 3.0 * np.pi * EYE_RADIUS**3
    assert 0.93 * sphere < volume[part == "eye_L"].sum() < sphere


def test_the_skin_faces_outward(neutral, whole):
    """Its normals point away from the inside of the sculpted volume."""
    outer = [whole.lay.grid[row, column] for row in (2, 5, 30, 38) for column in range(0, 32, 3)]
    triangles = neutral.faces.triangles()
    a, b, c = neutral.vertices[triangles].swapaxes(0, 1)
    normals = np.zeros_like(neutral.vertices)
    for k in range(3):
        np.add.at(normals, triangles[:, k], np.cross(b - a, c - a))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = neutral.vertices[outer]
    assert (skin(points + 0.3 * normals[outer]) > skin(points - 0.3 * normals[outer])).all()


def test_mirror_symmetry_of_vertices(neutral, whole):
    image = neutral.vertices[whole.partner] * MIRROR
    np.testing.assert_array_equal(image, neutral.vertices)
    np.testing.assert_array_equal(whole.partner[whole.partner], np.arange(len(whole.partner)))


def test_mirror_symmetry_of_polygons_and_groups(neutral, whole):
    def canonical(face):
        first = face.index(min(face))
        return tuple(face[first:] + face[:first])

    side = str.maketrans("LR", "RL")
    names = neutral.groups.names
    groups_of = {
        canonical(face.tolist()): names[label]
        for face, label in zip(neutral.faces, neutral.groups.of_face, strict=True)
    }
    assert len(groups_of) == len(neutral.faces)
    for face, name in groups_of.items():
        mirrored = canonical([int(whole.partner[v]) for v in reversed(face)])
        expected = name.translate(side) if name[-2:] in ("_L", "_R") else name
        assert groups_of[mirrored] == expected


def test_left_is_plus_x(neutral):
    names = neutral.groups.names
    for name, sign in ((groups.EYES["L"], 1.0), (groups.EYES["R"], -1.0)):
        chosen = np.flatnonzero(neutral.groups.of_face == names.index(name))
        points = np.concatenate([neutral.vertices[neutral.faces[face]] for face in chosen])
        assert (sign * points[:, 0] > 0.0).all()


def test_no_two_vertices_coincide_and_no_edge_is_degenerate(neutral):
    from scipy.spatial import cKDTree

    nearest = cKDTree(neutral.vertices).query(neutral.vertices, k=2)[0][:, 1]
    assert nearest.min() > 1e-3
    ends = neutral.vertices[neutral.edges]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).min() > 1e-2


def test_no_polygon_of_the_neutral_is_folded(neutral):
    """All corners of a polygon turn the same way about its own normal."""
    for face in neutral.faces:
        points = neutral.vertices[face]
        corners = np.cross(points - np.roll(points, 1, 0), np.roll(points, -1, 0) - points)
        assert (corners @ corners.sum(axis=0) > -1e-9).all(), face


def test_teeth_and_tongue_are_inside_the_closed_face(neutral, whole):
    hidden = np.isin(whole.part, ("upper_teeth", "lower_teeth", "tongue"))
    points = neutral.vertices[hidden]
    points = np.c_[np.abs(points[:, 0]), points[:, 1:]]
    assert skin(points).max() < -0.2


def test_eyeballs_are_spheres(neutral, whole):
    for part, sign in (("eye_L", 1.0), ("eye_R", -1.0)):
        offset = neutral.vertices[whole.part == part] - EYE_CENTRE * [sign, 1.0, 1.0]
        np.testing.assert_allclose(np.linalg.norm(offset, axis=1), EYE_RADIUS, atol=1e-7)
