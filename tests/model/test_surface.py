"""Polygons are split whatever their numbering; the cotangent Laplacian is that of a surface."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.model.polygons import Polygons
from elastomorph.model.surface import surface_operators, triangulate, winding_number


def areas(mesh: em.Mesh) -> np.ndarray:
    triangles, shares = triangulate(mesh)
    a, b, c = np.moveaxis(mesh.vertices[triangles], 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1) * shares


def test_a_quad_is_split_along_its_shorter_diagonal():
    kite = em.Mesh(vertices=[[-1, 0, 0], [0, -3, 0], [1, 0, 0], [0, 3, 0]], faces=[[0, 1, 2, 3]])
    triangles, shares = triangulate(kite)
    assert shares.tolist() == [1, 1]
    assert all({0, 2} <= set(triangle) for triangle in triangles.tolist())


def test_a_rectangle_has_both_splits_at_half_weight():
    rectangle = em.Mesh(vertices=[[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], faces=[[0, 1, 2, 3]])
    _, shares = triangulate(rectangle)
    assert shares.tolist() == [0.5] * 4
    assert areas(rectangle).sum() == pytest.approx(2)


@pytest.mark.parametrize("size", [3, 4, 5, 6, 9])
def test_convex_polygons_keep_their_area_and_winding(size):
    angle = np.sort(np.random.default_rng(size).uniform(0, 2 * np.pi, size))
    points = np.stack([2 * np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    mesh = em.Mesh(vertices=points, faces=[list(range(size))])
    x, y = points[:, 0], points[:, 1]
    shoelace = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    assert areas(mesh).sum() == pytest.approx(shoelace)
    a, b, c = np.moveaxis(points[triangulate(mesh)[0]], 1, 0)
    assert (np.cross(b - a, c - a)[:, 2] >= 0).all()


def test_a_regular_polygon_is_split_alike_from_every_corner():
    angle = np.arange(7) * 2 * np.pi / 7
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    triangles, shares = triangulate(em.Mesh(vertices=points, faces=[list(range(7))]))
    weight = np.bincount(triangles.ravel(), np.repeat(shares, 3), minlength=7)
    assert weight == pytest.approx(np.full(7, 15 / 7))  # 5 triangles of 3 corners each


def test_polygons_of_the_same_vertices_count_once():
    points = [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 1, 0]]
    once = em.Mesh(vertices=points, faces=[[0, 1, 2, 3]])
    twice = em.Mesh(vertices=points, faces=[[0, 1, 2, 3], [2, 3, 0, 1], [3, 2, 1, 0]])
    assert areas(twice).sum() == areas(once).sum()


def test_triangles_that_name_a_vertex_twice_are_left_out():
    mesh = em.Mesh(vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces=[[0, 1, 1], [0, 1, 2, 2]])
    triangles, _ = triangulate(mesh)
    assert {tuple(sorted(triangle)) for triangle in triangles.tolist()} == {(0, 1, 2)}


def grid(columns: int, rows: int) -> em.Mesh:
    x, y = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    index = np.arange(columns * rows).reshape(columns, rows)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return em.Mesh(vertices=points, faces=quads.reshape(-1, 4))


def sphere(rings: int) -> em.Mesh:
    """A cube of quads blown up to the unit sphere, corners shared."""
    flat = grid(rings + 1, rings + 1)
    uv = np.tan(np.pi / 4 * (flat.vertices[:, :2] * 2 / rings - 1))
    sides = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            side = np.zeros((len(uv), 3))
            side[:, axis] = sign
            side[:, (axis + 1) % 3] = uv[:, 0]
            side[:, (axis + 2) % 3] = sign * uv[:, 1]
            sides.append(side)
    points = np.concatenate(sides)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    unique, number = np.unique(points.round(9), axis=0, return_inverse=True)
    quads = flat.faces.indices.reshape(-1, 4)
    faces = np.concatenate([quads + side * len(uv) for side in range(6)])
    return em.Mesh(vertices=unique, faces=number.ravel()[faces])


def crumpled(seed: int = 0) -> em.Mesh:
    flat = grid(6, 5)
    noise = 0.3 * np.random.default_rng(seed).standard_normal(flat.vertices.shape)
    return flat.with_vertices(flat.vertices + noise)


def modes(mesh: em.Mesh) -> np.ndarray:
    surface = surface_operators(mesh)
    root = np.sqrt(surface.mass)
    return np.linalg.eigvalsh(surface.laplacian.toarray() / np.outer(root, root))


def test_equilateral_triangle_by_hand():
    """Every edge has ½ cot 60° = 1/(2√3); every corner a third of the area."""
    mesh = em.Mesh(vertices=[[0, 0, 0], [2, 0, 0], [1, 3**0.5, 0]], faces=[[0, 1, 2]])
    surface = surface_operators(mesh)
    expected = (3 * np.eye(3) - 1) / (2 * 3**0.5)
    assert surface.laplacian.toarray() == pytest.approx(expected)
    assert surface.mass == pytest.approx(np.full(3, 1 / 3))
    assert surface.area == pytest.approx(3**0.5)


def test_a_square_grid_has_the_five_point_stencil():
    surface = surface_operators(grid(5, 5))
    row = surface.laplacian.toarray()[12]
    assert row[12] == pytest.approx(4)
    assert row[[7, 11, 13, 17]] == pytest.approx(np.full(4, -1))
    assert np.count_nonzero(row) == 5
    assert surface.mass[12] == pytest.approx(1 / 16)


def test_linear_functions_on_a_flat_mesh_are_harmonic_inside_and_have_their_exact_energy():
    """xᵀLx = ∫|∇x|² = area for x itself, whatever the triangles."""
    flat = grid(7, 6)
    inside = (flat.vertices[:, 0] % 6 != 0) & (flat.vertices[:, 1] % 5 != 0)
    moved = flat.vertices.copy()
    moved[inside, :2] += np.random.default_rng(3).uniform(-0.3, 0.3, (inside.sum(), 2))
    surface = surface_operators(flat.with_vertices(moved))
    for axis in (0, 1):
        x = moved[:, axis]
        assert surface.laplacian @ x == pytest.approx(
            np.where(inside, 0, surface.laplacian @ x), abs=1e-12
        )
        assert x @ surface.laplacian @ x == pytest.approx(surface.area)


def test_spheres_have_the_eigenvalues_of_a_sphere_of_area_one():
    """μ = 4π l(l+1), 2l + 1 of each, approached at second order."""
    exact = 4 * np.pi * np.repeat([2.0, 6.0], [3, 5])
    errors = [np.abs(modes(sphere(rings))[1:9] / exact - 1).max() for rings in (5, 10)]
    assert errors[1] < 0.02
    assert errors[0] / errors[1] > 3.2


def test_nothing_depends_on_place_size_or_numbering():
    mesh = crumpled()
    surface = surface_operators(mesh)
    random = np.random.default_rng(1)
    turn = np.linalg.qr(random.standard_normal((3, 3)))[0]
    moved = surface_operators(mesh.with_vertices(1e-4 * mesh.vertices @ turn.T + [3, 4, 5]))
    assert moved.laplacian.toarray() == pytest.approx(surface.laplacian.toarray(), abs=1e-8)
    assert moved.mass == pytest.approx(surface.mass, rel=1e-8)
    assert moved.area == pytest.approx(1e-8 * surface.area)

    order = random.permutation(len(mesh.vertices))
    place = np.argsort(order)
    faces = [np.roll(place[face], random.integers(4)) for face in mesh.faces]
    renamed = em.Mesh(
        vertices=mesh.vertices[order], faces=[faces[i] for i in random.permutation(len(faces))]
    )
    other = surface_operators(renamed)
    assert other.laplacian.toarray() == pytest.approx(
        surface.laplacian.toarray()[np.ix_(order, order)], abs=1e-12
    )
    assert other.mass == pytest.approx(surface.mass[order])


def test_pieces_are_what_triangles_join():
    mesh = em.Mesh(
        vertices=np.random.default_rng(0).standard_normal((8, 3)),
        faces=[[0, 1, 2], [2, 3, 4], [5, 6, 0]],
    )
    surface = surface_operators(mesh)
    assert surface.component_of.max() + 1 == 2
    assert len(set(surface.component_of[:7])) == 1
    assert surface.component_of[7] != surface.component_of[0]
    assert surface.mass[7] > 0


@pytest.mark.parametrize(
    "broken",
    [
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]],
        [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [1e-9, 0, 0], [1, 0, 0], [1, 0, 0]],
        [[0, 0, 0], [1e-200, 0, 0], [0, 1e-200, 0], [1, 0, 0]],
        [[0, 0, 0], [1, 1e-14, 0], [2, 0, 0], [1, -1e-14, 0]],
    ],
)
def test_degenerate_polygons_tie_their_corners_together(broken):
    """They join their vertices with finite weights, and never change the sign of an energy."""
    points = np.concatenate([broken, [[0, 0, 1], [1, 0, 1], [0, 1, 1]]])
    faces = [[0, 1, 2, 3], [3, 2, 1], [0, 1, 2], [0, 1, 4], [4, 5, 6], [0, 1, 5]]
    surface = surface_operators(em.Mesh(vertices=points, faces=faces))
    dense = surface.laplacian.toarray()
    assert np.isfinite(dense).all()
    assert np.abs(dense).max() < 1e4
    assert np.linalg.eigvalsh(dense)[0] > -1e-10
    assert surface.component_of.max() + 1 == 1
    assert np.linalg.eigvalsh(dense)[1] > 1e-6
    assert (surface.mass > 0).all()


@settings(max_examples=60, deadline=None)
@given(
    faces=st.lists(st.lists(st.integers(0, 8), min_size=3, max_size=6), min_size=1, max_size=12),
    seed=st.integers(0, 1000),
)
def test_any_soup_of_polygons_gives_a_laplacian(faces, seed):
    """Symmetric, positive semi-definite, constants on each piece its kernel and nothing else."""
    points = np.random.default_rng(seed).integers(-2, 3, (9, 3)).astype(float)
    points[6:] = np.random.default_rng(seed).standard_normal((3, 3))
    mesh = em.Mesh(vertices=points, faces=faces)
    a, b, c = np.moveaxis(points[triangulate(mesh)[0]], 1, 0)
    if not np.cross(b - a, c - a).any():
        with pytest.raises(em.ElastomorphError, match="no surface"):
            surface_operators(mesh)
        return
    surface = surface_operators(mesh)
    dense = surface.laplacian.toarray()
    assert np.array_equal(dense, dense.T)
    assert dense.sum(axis=1) == pytest.approx(np.zeros(9), abs=1e-9)
    values = np.linalg.eigvalsh(dense)
    assert values[0] > -1e-9
    assert np.count_nonzero(values < 1e-6) == surface.component_of.max() + 1
    assert (surface.mass > 0).all()
    assert surface.mass.sum() == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize("faces", [[], [[0, 1, 2]]])
def test_a_mesh_without_area_is_refused(faces):
    mesh = em.Mesh(vertices=[[0, 0, 0], [1, 0, 0], [2, 0, 0]], faces=faces)
    with pytest.raises(em.ElastomorphError, match="no surface"):
        surface_operators(mesh)


@pytest.mark.realdata
def test_a_real_face_has_its_teeth_and_eyes_as_pieces(data_dir):
    surface = surface_operators(em.read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj"))
    assert surface.component_of.max() + 1 > 30
    assert surface.mass.sum() == pytest.approx(1)
    assert abs(surface.laplacian.sum(axis=0)).max() < 1e-10


def test_a_surface_winds_around_what_is_inside_it() -> None:
    """Once around the inside of a box, and less by the solid angle of a side that is open."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    for polygons, centre in ((quads, 1.0), (quads[1:], 5 / 6)):
        triangles = corners[Polygons.of(polygons).triangles()]
        for points, side in ((triangles, 1.0), (triangles[:, ::-1], -1.0)):
            assert winding_number(np.zeros(3), points) == pytest.approx(side * centre)
    assert winding_number(np.array([0.9, -0.9, 0.9]), corners[Polygons.of(quads).triangles()]) == (
        pytest.approx(1.0)
    )
    assert winding_number(np.array([1.1, 0.5, 0.0]), corners[Polygons.of(quads).triangles()]) == (
        pytest.approx(0.0, abs=1e-12)
    )
