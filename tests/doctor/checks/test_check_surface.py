"""What keeps polygons from being a surface, on meshes small enough to see it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planted_faults import grid, only

from elastomorph.doctor import Finding
from elastomorph.doctor.checks.surface import examine_surface, lost_area, surface_facts
from elastomorph.doctor.neutral import Neutral
from elastomorph.model.mesh import Mesh

POINTS = np.random.default_rng(0).uniform(0, 1, (12, 3))


def found_in(mesh: Mesh, name: str = "") -> list[Finding]:
    """What is found in a neutral, or what of one kind."""
    return [found for found in examine_surface(Neutral(mesh), "n") if name in ("", found.name)]


def test_a_plain_grid_has_no_faults_and_one_border() -> None:
    mesh = grid(4, 3)
    assert found_in(mesh) == []
    facts = surface_facts(mesh)
    assert (facts.borders, facts.counts.border_edges) == (1, 14)
    assert facts.poles_by_valence == {}


def test_the_head_has_no_faults(face: Mesh) -> None:
    assert found_in(face) == []


def test_a_cube_has_eight_poles_and_no_border() -> None:
    quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    cube = Mesh(np.random.default_rng(0).uniform(0, 1, (8, 3)), quads)
    assert found_in(cube) == []
    facts = surface_facts(cube)
    assert facts.borders == 0
    assert facts.poles_by_valence == {3: 8}


def test_three_polygons_at_an_edge() -> None:
    found = only(found_in(Mesh(POINTS[:5], [[0, 1, 2], [1, 0, 3], [0, 1, 4]])))
    assert found.name == "non-manifold-edges"
    assert found.vertices == (0, 1)
    assert "0-1" in found.message


def test_two_fans_at_a_vertex() -> None:
    """Neither a border nor an edge between two triangles is a joint."""
    bow = Mesh(POINTS[:6], [[0, 1, 2], [0, 2, 3], [0, 4, 5]])
    found = only(found_in(bow))
    assert (found.name, found.vertices) == ("non-manifold-vertices", (0,))


@pytest.mark.parametrize("wrong", [[0], [5], [2, 7], [0, 1, 2, 3, 4]])
def test_the_fewer_polygons_wound_otherwise_are_named(wrong: list[int]) -> None:
    mesh = grid(4, 3)
    faces = [f[::-1].tolist() if i in wrong else f.tolist() for i, f in enumerate(mesh.faces)]
    found = only(found_in(Mesh(mesh.vertices, faces)))
    assert found.name == "inconsistent-winding"
    assert found.message.endswith(", ".join(map(str, wrong)))
    assert found.vertices == tuple(sorted({v for i in wrong for v in faces[i]}))


@given(wrong=st.sets(st.integers(0, 19), max_size=9))
@settings(max_examples=30, deadline=None)
def test_what_is_named_is_what_was_reversed(wrong: set[int]) -> None:
    mesh = grid(5, 4)
    faces = [f[::-1].tolist() if i in wrong else f.tolist() for i, f in enumerate(mesh.faces)]
    found = found_in(Mesh(mesh.vertices, faces))
    assert [one.name for one in found] == ["inconsistent-winding"] * bool(wrong)
    if wrong:
        assert set(found[0].vertices) == {v for i in wrong for v in faces[i]}


def test_a_moebius_strip_has_one_side() -> None:
    strip = [[0, 1, 4, 3], [1, 2, 5, 4], [2, 3, 0, 5]]
    found = only(found_in(Mesh(POINTS[:6], strip)))
    assert found.name == "inconsistent-winding"
    assert "one side" in found.message


def test_vertices_on_no_polygon() -> None:
    found = only(found_in(Mesh(POINTS[:6], [[0, 1, 3]])))
    assert (found.name, found.vertices) == ("isolated-vertices", (2, 4, 5))


def test_a_polygon_that_names_a_vertex_twice() -> None:
    mesh = Mesh(POINTS[:6], [[0, 1, 2, 3], [3, 2, 4, 5], [4, 2, 1, 2]])
    names = [found.name for found in found_in(mesh)]
    assert "repeated-corners" in names


def test_markers_without_polygons_are_no_fault() -> None:
    assert found_in(Mesh(POINTS)) == []


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0, 0], [1, 0, 0], [3, 0, 0]],  # on a line
        [[1, 2, 3], [1, 2, 3], [1, 2, 3]],  # one point
        [[0, 0, 0], [1, 1, 1], [1, 1, 1]],  # two points
    ],
)
def test_polygons_without_an_area(corners: list[list[float]]) -> None:
    points = np.concatenate([POINTS[:3], corners])
    mesh = Mesh(points, [[0, 1, 2], [3, 4, 5]])
    found = only(found_in(mesh, "zero-area"))
    assert (found.name, found.vertices) == ("zero-area", (3, 4, 5))


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_a_small_or_slim_polygon_has_an_area(size: float) -> None:
    mesh = Mesh(size * np.array([[0, 0, 0], [1, 0, 0], [1, 1e-4, 0]]), [[0, 1, 2]])
    assert found_in(mesh, "zero-area") == []


def test_a_quad_folded_flat_still_has_an_area() -> None:
    """Its two halves point in opposite directions; they do not cancel."""
    bow = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
    mesh = Mesh(bow, [[0, 1, 2, 3]])
    assert found_in(mesh, "zero-area") == []


def test_only_what_a_target_loses_is_its_fault() -> None:
    """Polygon 0 has no area in the neutral, polygon 1 loses its own."""
    neutral = grid(2, 2)
    flat = neutral.vertices.copy()
    flat[[1, 3, 4]] = flat[0]
    neutral = neutral.with_vertices(flat)
    lost = flat.copy()
    lost[[2, 5]] = lost[1]
    assert only(found_in(neutral, "zero-area")).vertices == (0, 1, 3, 4)
    found = only(lost_area(Neutral(neutral), neutral.with_vertices(lost), "t"))
    assert found.vertices == (1, 2, 4, 5)


def test_touching_pieces_and_open_seams_are_told_apart() -> None:
    """Two grids side by side touch; one grid bent into a tube and not welded has a seam."""
    left = grid(1, 2)
    right = left.vertices + [1, 0, 0]
    faces = [*left.faces, *[f + 6 for f in left.faces]]
    touching = Mesh(np.concatenate([left.vertices, right]), [f.tolist() for f in faces])
    found = only(found_in(touching, "unwelded-vertices"))
    assert found.name == "unwelded-vertices"
    assert found.vertices == (1, 3, 5, 6, 8, 10)
    assert "different pieces touch" in found.message
    sheet = grid(4, 2)
    angle = 2 * np.pi * (sheet.vertices[:, 0] % 4) / 4
    tube = np.stack([np.cos(angle), np.sin(angle), sheet.vertices[:, 1]], axis=1)
    found = only(found_in(sheet.with_vertices(tube), "unwelded-vertices"))
    assert "6 vertices share 3 positions, 3 of them twice on one piece" in found.message
