"""The cover: every vertex on one curve, along edges, with no short curve that could be avoided."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from topologies import anything, cube, fan, grid, patiently, together, triangulated

from elastomorph.curves import Curve, CurveNetwork, edge_loops, extract_curves
from elastomorph.errors import CurveError
from elastomorph.io import read
from elastomorph.model.mesh import Mesh


def kinds(curves: CurveNetwork) -> Counter[tuple[int, bool]]:
    """How many curves there are of each number of vertices, open or closed."""
    return Counter((len(curve), curve.closed) for curve in curves)


def edge_pairs(mesh: Mesh) -> set[tuple[int, int]]:
    low_high = {tuple(edge) for edge in mesh.edges.tolist()}
    return low_high | {(b, a) for a, b in low_high}


def assert_covers(mesh: Mesh, curves: CurveNetwork) -> None:
    """Every vertex on exactly one curve, and consecutive vertices share an edge."""
    passed = np.concatenate([curve.vertices for curve in curves])
    assert np.array_equal(np.sort(passed), np.arange(len(mesh.vertices)))
    edges = edge_pairs(mesh)
    assert all(tuple(edge) in edges for curve in curves for edge in curve.edges.tolist())


def avoidable_short_curves(
    mesh: Mesh, curves: CurveNetwork, kept: int = 0
) -> list[tuple[int, str]]:
    """Curves of one or two vertices that a curve beside them could take, and how."""
    around: dict[int, set[int]] = {vertex: set() for vertex in range(len(mesh.vertices))}
    for a, b in edge_pairs(mesh):
        around[a].add(b)
    found = []
    for number, short in enumerate(curves):
        if number < kept or len(short) > 2:
            continue
        first, last = int(short.vertices[0]), int(short.vertices[-1])
        for other_number, other in enumerate(curves):
            if other_number < kept or other_number == number:
                continue
            vertices = other.vertices.tolist()
            for end, far in ((first, last), (last, first)):
                beside = [place for place, v in enumerate(vertices) if v in around[end]]
                if other.closed and beside:
                    found.append((number, "open a ring"))
                if {0, len(vertices) - 1} & set(beside):
                    found.append((number, "append"))
                if any(a in around[end] and b in around[far] for a, b in pairwise(vertices)):
                    found.append((number, "insert"))
                # one part takes the short curve and the vertex beside it, the other keeps three
                if any(max(place, len(vertices) - 1 - place) >= 3 for place in beside):
                    found.append((number, "cut"))
    return found


def test_a_grid_is_its_border_and_the_longer_lines_inside():
    assert kinds(extract_curves(grid(5, 8))) == {(22, True): 1, (6, False): 3}
    inner = [curve.vertices.tolist() for curve in extract_curves(grid(5, 8)) if not curve.closed]
    assert inner == [list(range(9, 15)), list(range(17, 23)), list(range(25, 31))]


def test_a_tube_is_its_rings():
    assert kinds(extract_curves(grid(9, 6, around=True))) == {(6, True): 9}


def test_a_torus_is_the_longer_family_of_its_rings():
    assert kinds(extract_curves(grid(5, 8, around=True, through=True))) == {(8, True): 5}
    assert kinds(extract_curves(grid(8, 5, around=True, through=True))) == {(8, True): 5}


def test_a_single_vertex_inside_a_ring_opens_it():
    assert kinds(extract_curves(grid(3, 3))) == {(9, False): 1}


def test_a_fan_is_one_closed_curve():
    assert kinds(extract_curves(fan(6))) == {(7, True): 1}


def test_a_cube_has_no_loops_to_choose_from_but_is_covered_without_short_curves():
    curves = extract_curves(cube())
    assert_covers(cube(), curves)
    assert min(len(curve) for curve in curves) >= 3


def test_vertices_without_edges_are_curves_of_their_own():
    mesh = Mesh(np.random.default_rng(0).random((6, 3)), [[1, 2, 4]])
    assert kinds(extract_curves(mesh)) == {(3, True): 1, (1, False): 3}


def test_a_set_of_markers_without_polygons_is_covered_by_single_vertices():
    assert kinds(extract_curves(Mesh(np.eye(3)))) == {(1, False): 3}


def test_curves_come_longest_first():
    lengths = [len(curve) for curve in extract_curves(together([grid(4, 9), grid(7, 7)]))]
    assert lengths == sorted(lengths, reverse=True)


def test_a_second_call_gives_the_same_curves():
    mesh = triangulated(grid(9, 11))
    assert extract_curves(mesh) == extract_curves(mesh)


@patiently
@given(anything)
def test_every_vertex_lies_on_one_curve_along_edges(mesh):
    assert_covers(mesh, extract_curves(mesh))


@patiently
@given(anything)
def test_no_short_curve_is_left_that_a_curve_beside_it_could_take(mesh):
    assert avoidable_short_curves(mesh, extract_curves(mesh)) == []


@patiently
@given(anything, st.data())
def test_kept_curves_stay_as_they_are_and_the_rest_is_filled_in(mesh, data):
    count = len(mesh.vertices)
    order = data.draw(st.permutations(range(count)))
    size = data.draw(st.integers(1, max(1, count // 3)))
    kept = [Curve(order[:size], closed=size >= 3, name="drawn")]
    if count > 2 * size:
        kept.append(Curve(order[size : 2 * size]))
    curves = extract_curves(mesh, keep=kept)
    assert list(curves[: len(kept)]) == kept
    passed = np.concatenate([curve.vertices for curve in curves])
    assert np.array_equal(np.sort(passed), np.arange(count))
    edges = edge_pairs(mesh)
    filled = curves[len(kept) :]
    assert all(tuple(edge) in edges for curve in filled for edge in curve.edges.tolist())
    assert avoidable_short_curves(mesh, curves, kept=len(kept)) == []


def test_keeping_all_curves_gives_them_back():
    mesh = grid(6, 7)
    curves = extract_curves(mesh)
    assert extract_curves(mesh, keep=curves) == curves


def test_a_kept_row_leaves_the_rest_to_be_covered():
    mesh = grid(5, 8)
    kept = Curve(range(16, 24), name="middle row")
    curves = extract_curves(mesh, keep=[kept])
    assert curves[0] == kept
    # of the border two halves of ten are left, of the rows inside the two beside the kept one
    assert kinds(curves) == {(8, False): 1, (10, False): 2, (6, False): 2}


def test_kept_curves_that_do_not_fit_are_refused():
    with pytest.raises(CurveError, match="curve 0 names vertex 9, but the mesh has 9 vertices"):
        extract_curves(grid(3, 3), keep=[Curve([8, 9])])
    with pytest.raises(CurveError, match="vertex 4 lies on curve 0 and on curve 1"):
        extract_curves(grid(3, 3), keep=[Curve([3, 4]), Curve([4, 5])])


@pytest.mark.realdata
@pytest.mark.parametrize("triangles", [False, True])
def test_the_face_is_covered_without_short_curves(data_dir: Path, triangles: bool):
    mesh = read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")
    mesh = triangulated(mesh) if triangles else mesh
    curves = extract_curves(mesh)
    assert_covers(mesh, curves)
    assert min(len(curve) for curve in curves) >= 3


@pytest.mark.realdata
def test_each_edge_of_the_face_lies_on_one_loop(data_dir: Path):
    mesh = read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")
    along = np.sort(np.concatenate([loop.edges for loop in edge_loops(mesh)]), axis=1)
    assert len(along) == len(mesh.edges)
    assert np.array_equal(np.unique(along, axis=0), mesh.edges)


@pytest.mark.realdata
def test_every_closed_loop_around_the_mouth_and_the_eyes_is_a_curve(data_dir: Path):
    mesh = read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")
    loops = [loop for loop in edge_loops(mesh) if loop.closed and loop.vertices.max() < 14062]
    chosen = {frozenset(c.vertices.tolist()) for c in extract_curves(mesh) if c.closed}
    openings = {"mouth": ([0.0, -3.4, 10.0], 36), "left eye": ([3.1, 3.5, 8.7], 9)}
    openings["right eye"] = ([-3.1, 3.5, 8.7], 9)
    for middle, count in openings.values():
        rings = [
            frozenset(loop.vertices.tolist())
            for loop in loops
            if np.linalg.norm(mesh.vertices[loop.vertices].mean(axis=0) - middle) < 1.6
        ]
        assert len(rings) == count
        assert chosen.issuperset(rings)
