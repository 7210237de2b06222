"""Whatever order vertices and polygons are in, the order of the neutral is found again."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from planted_faults import grid, shuffled, turned_over

from elastomorph.doctor.isomorphism import (
    Mismatch,
    Parts,
    Relabelling,
    find_relabelling,
    reversed_polygons,
)
from elastomorph.model.mesh import Mesh


def search(
    neutral: Mesh, target: Mesh, seeds: list[tuple[int, int]] | None = None
) -> Relabelling | Mismatch:
    pairs = seeds or []
    ours = Parts(neutral, seeds=[pair[0] for pair in pairs])
    rounds = ours.colouring.rounds
    theirs = Parts(target, seeds=[pair[1] for pair in pairs], rounds=rounds)
    return find_relabelling(ours, theirs)


def polygon_set(faces: list[list[int]]) -> list[tuple[int, ...]]:
    """Polygons as tuples from their least rotation, sorted: what must be equal, the slow way."""
    return sorted(min(tuple(f[i:] + f[:i]) for i in range(len(f))) for f in faces)


@st.composite
def any_meshes(draw: st.DrawFn) -> Mesh:
    """Polygons of any kind, joined at edges, at points, three at an edge, twice, or not at all."""
    count = draw(st.integers(4, 12))
    polygon = st.lists(st.integers(0, count - 1), min_size=3, max_size=5, unique=True)
    faces = draw(st.lists(polygon, min_size=1, max_size=9))
    points = np.random.default_rng(draw(st.integers(0, 99))).uniform(-1, 1, (count, 3))
    return Mesh(points, faces)


@given(mesh=any_meshes(), seed=st.integers(0, 1000))
@settings(max_examples=150, deadline=None)
def test_any_polygons_are_recovered(mesh: Mesh, seed: int) -> None:
    """Polygons come back, and of several ways to lay them on each other the one that fits."""
    target, number = shuffled(mesh, seed)
    found = search(mesh, target)
    assert isinstance(found, Relabelling)
    renamed = [found.new_index[face].tolist() for face in target.faces]
    assert polygon_set(renamed) == polygon_set([face.tolist() for face in mesh.faces])
    back = np.empty_like(mesh.vertices)
    back[found.new_index] = target.vertices
    np.testing.assert_array_equal(back, mesh.vertices)
    assert sorted(found.new_index[number].tolist()) == list(range(len(number)))


@given(columns=st.integers(1, 5), rows=st.integers(1, 5), seed=st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_corners_match_polygon_by_polygon(columns: int, rows: int, seed: int) -> None:
    """Each corner of the neutral gets a corner of the target at its own vertex."""
    mesh = grid(columns, rows, seed)
    target, _ = shuffled(mesh, seed)
    found = search(mesh, target)
    assert isinstance(found, Relabelling)
    at_corner = found.new_index[target.faces.indices[found.corners]]
    np.testing.assert_array_equal(at_corner, mesh.faces.indices)
    theirs = target.faces.corner_faces[found.corners]
    first = theirs[mesh.faces.offsets[:-1]]
    np.testing.assert_array_equal(theirs, np.repeat(first, mesh.faces.sizes))


@given(mesh=any_meshes(), seed=st.integers(0, 1000))
@settings(max_examples=60, deadline=None)
def test_a_changed_polygon_is_not_accepted(mesh: Mesh, seed: int) -> None:
    """With one polygon reversed or rewired the polygons differ, and nothing is found."""
    faces = [face.tolist() for face in mesh.faces]
    faces[seed % len(faces)] = faces[seed % len(faces)][::-1]
    changed = Mesh(mesh.vertices, faces)
    found = search(mesh, shuffled(changed, seed)[0])
    if isinstance(found, Relabelling):
        # Then the change is a symmetry: the two are the same but for the names of vertices.
        target = shuffled(changed, seed)[0]
        renamed = [found.new_index[face].tolist() for face in target.faces]
        assert polygon_set(renamed) == polygon_set([face.tolist() for face in mesh.faces])


def test_the_head_is_recovered_in_any_pose(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Vertex by vertex, although both eyeballs are alike and round."""
    for seed, target in enumerate(rig.values()):
        mixed, number = shuffled(target, seed)
        found = search(face, mixed)
        assert isinstance(found, Relabelling)
        np.testing.assert_array_equal(found.new_index[number], np.arange(len(number)))


def test_a_mesh_without_symmetry_has_no_mirror_image() -> None:
    """An L of five quads, one end longer: run backwards it is another mesh."""
    mesh = Mesh(
        np.random.default_rng(0).uniform(0, 1, (12, 3)),
        [[0, 1, 2, 3], [1, 4, 5, 2], [4, 6, 7, 5], [3, 2, 8, 9], [9, 8, 10, 11]],
    )
    lopsided = Mesh(mesh.vertices, [*mesh.faces[:4], [9, 8, 10]])
    assert isinstance(search(lopsided, shuffled(turned_over(lopsided))[0]), Mismatch)
    ours = Parts(lopsided)
    theirs = Parts(
        turned_over(lopsided),
        faces=reversed_polygons(turned_over(lopsided).faces),
        rounds=ours.colouring.rounds,
    )
    assert isinstance(find_relabelling(ours, theirs), Relabelling)


def test_positions_choose_where_symmetry_leaves_a_choice() -> None:
    """A square grid fits on itself in four ways; the nearest is taken, and said to be a choice."""
    mesh = grid(3, 3, seed=4)
    target, number = shuffled(mesh, 1)
    found = search(mesh, target)
    assert isinstance(found, Relabelling)
    assert (found.chosen, found.chosen_vertices) == (1, 16)
    np.testing.assert_array_equal(found.new_index[number], np.arange(16))


def test_a_given_pair_outweighs_positions() -> None:
    """A grid turned by a quarter looks unturned by position; one corner pair tells."""
    mesh = grid(3, 3)
    middle = mesh.vertices.mean(axis=0)
    quarter = (mesh.vertices - middle) @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]) + middle
    target, number = shuffled(mesh.with_vertices(quarter), 2)
    by_position = search(mesh, target)
    by_pair = search(mesh, target, [(0, int(number[0]))])
    assert isinstance(by_position, Relabelling)
    assert isinstance(by_pair, Relabelling)
    np.testing.assert_array_equal(by_pair.new_index[number], np.arange(16))
    assert by_pair.chosen == 0
    assert (by_position.new_index[number] != np.arange(16)).any()


def test_a_wrong_pair_is_named() -> None:
    mesh = grid(3, 2, seed=0)
    target, number = shuffled(mesh)
    found = search(mesh, target, [(0, int(number[1]))])
    assert isinstance(found, Mismatch)
    assert found.seeds
    assert f"0={number[1]}" in found.reason


def test_pairs_that_contradict_each_other_are_refused() -> None:
    """Each corner of a square grid may be any corner, but not two of them exchanged."""
    mesh = grid(3, 3, seed=0)
    target, number = shuffled(mesh)
    pairs = [(0, int(number[0])), (3, int(number[12])), (12, int(number[3]))]
    found = search(mesh, target, pairs)
    assert isinstance(found, Mismatch)
    assert found.seeds


def test_surfaces_joined_at_a_point_are_matched() -> None:
    """Two grids that share one vertex: no walk over edges gets from one to the other."""
    first = grid(3, 2, seed=1)
    second = grid(2, 2, seed=2)
    shift = len(first.vertices) - 1
    faces = [*first.faces, *[[v + shift if v else 0 for v in f.tolist()] for f in second.faces]]
    mesh = Mesh(np.concatenate([first.vertices, second.vertices[1:] - 3]), faces)
    target, number = shuffled(mesh, 5)
    found = search(mesh, target)
    assert isinstance(found, Relabelling)
    np.testing.assert_array_equal(found.new_index[number], np.arange(len(number)))


@pytest.mark.parametrize("count", [3, 30])
def test_pieces_alike_are_told_apart_by_position(count: int) -> None:
    """Strips of hair: all the same, each where it is."""
    strip = grid(4, 1)
    strips = [strip.vertices + [0, 3.0 * i, i % 2] for i in range(count)]
    faces = [(f + 10 * i).tolist() for i in range(count) for f in strip.faces]
    mesh = Mesh(np.concatenate(strips), faces)
    moved = mesh.with_vertices(mesh.vertices + [0.4, 0.2, 0.1])
    target, number = shuffled(moved, 7)
    found = search(mesh, target)
    assert isinstance(found, Relabelling)
    np.testing.assert_array_equal(found.new_index[number], np.arange(len(number)))
    assert found.chosen == count


def test_pieces_go_with_what_they_lie_on() -> None:
    """Two lashes flip over with the lid they stand on, each past where the other was."""
    lid = grid(5, 2, seed=3)
    lid = Mesh(lid.vertices, [*lid.faces[:9], [16, 17, 11]])  # one triangle: no symmetry
    lash = grid(2, 1).vertices @ np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
    points = np.concatenate([lid.vertices, lash, lash + [0, 2, 0]])
    faces = [f.tolist() for f in lid.faces]
    faces += [(f + 18 + 6 * i).tolist() for i in range(2) for f in grid(2, 1).faces]
    mesh = Mesh(points, faces)
    flipped = mesh.with_vertices(points * [1.0, 1, 1] + [0, 2, 0])
    target, number = shuffled(flipped, 3)
    found = search(mesh, target)
    assert isinstance(found, Relabelling)
    np.testing.assert_array_equal(found.new_index[number], np.arange(len(points)))


@given(mesh=any_meshes())
@settings(max_examples=50, deadline=None)
def test_reversing_twice_is_nothing(mesh: Mesh) -> None:
    assume(len(mesh.faces))
    twice = reversed_polygons(reversed_polygons(mesh.faces))
    assert twice == mesh.faces
    once = reversed_polygons(mesh.faces)
    assert polygon_set([f.tolist() for f in once]) == polygon_set(
        [f[::-1].tolist() for f in mesh.faces]
    )
