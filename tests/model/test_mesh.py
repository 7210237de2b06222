"""The mesh keeps what its author gave it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from elastomorph.errors import MeshError, TopologyError
from elastomorph.model.geometry import largest_distance
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap, require_same_topology
from elastomorph.model.polygons import Polygons
from elastomorph.paths import interpolate

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]], dtype=float)
PYRAMID = [[3, 2, 1, 0], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]


def test_vertices_are_a_read_only_copy() -> None:
    own = SQUARE.copy()
    mesh = Mesh(own, PYRAMID)
    own[0] = 9
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        mesh.faces.indices[0] = 1


@given(st.lists(st.lists(st.integers(0, 50), min_size=3, max_size=9), max_size=20))
def test_polygons_keep_their_order_and_size(faces: list[list[int]]) -> None:
    polygons = Polygons.of(faces)
    assert [list(face) for face in polygons] == faces
    assert [list(polygons[i]) for i in range(len(faces))] == faces
    assert [list(f) for f in polygons[1:3]] == faces[1:3]
    assert polygons == Polygons.of([list(f) for f in faces])
    starts = [c for face in faces for c in face[1:] + face[:1]]
    assert list(polygons.indices[polygons.next_corners]) == starts
    assert list(polygons.corner_faces) == [i for i, face in enumerate(faces) for _ in face]


def test_fan_triangles_of_a_pentagon() -> None:
    assert Polygons.of([[5, 6, 7, 8, 9], [0, 1, 2]]).triangles().tolist() == [
        [5, 6, 7],
        [5, 7, 8],
        [5, 8, 9],
        [0, 1, 2],
    ]


def test_edges_of_a_pyramid() -> None:
    """Four round the base, four to the top, each once."""
    assert Mesh(SQUARE, PYRAMID).edges.tolist() == [
        [0, 1],
        [0, 3],
        [0, 4],
        [1, 2],
        [1, 4],
        [2, 3],
        [2, 4],
        [3, 4],
    ]


def test_a_mesh_without_polygons_has_no_edges() -> None:
    assert Mesh(SQUARE).edges.shape == (0, 2)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0, 0, np.nan]], [], "vertex 0"),
        ([[0, 0, 0], [0, np.inf, 0]], [], "vertex 1"),
        ([[0, 0]], [], "shape"),
        ([], [], "shape"),
        ([["a", 0, 0]], [], "numbers"),
        (SQUARE, [[0, 1]], "polygon 0 has 2 vertices"),
        (SQUARE, [[0, 1, 2], [0, 1, 5]], "polygon 1 names vertex 5"),
        (SQUARE, [[0, 1, -1]], "between 0"),
        (SQUARE, [[0, 1, 1.5]], "whole numbers"),
    ],
)
def test_what_is_not_a_mesh_is_refused(vertices: object, faces: object, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        Mesh(vertices, faces)  # type: ignore[arg-type]


@pytest.mark.parametrize("number", [1.1e75, -1e300, np.inf, np.nan])
def test_coordinates_whose_products_are_no_numbers_are_refused(number: float) -> None:
    with pytest.raises(MeshError, match=r"vertex 1 has the coordinates .* at most 1e\+75"):
        Mesh([[0, 0, 0], [0, number, 0], [0, 0, 1]])


@pytest.mark.parametrize("size", [1e75, 1e-75])
def test_a_mesh_of_any_allowed_size_has_paths_that_scale_with_it(size: float) -> None:
    """Nothing overflows or vanishes on the way, whatever unit of length an author may use."""
    bent = [[0, 0, 0], [1, 0, 0], [1, 0.6, 0.8], [0, 0.6, 0.8]]
    flat = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    faces = [[0, 1, 2], [0, 2, 3]]
    for method in ("auto", "rotation", "arc", "plate:1", "beam"):
        small, large = (
            interpolate(Mesh(unit * flat, faces), Mesh(unit * np.array(bent), faces), method)
            for unit in (1.0, size)
        )
        np.testing.assert_allclose(large.at(0.4) / size, small.at(0.4), atol=1e-9)


def test_labels_must_fit_the_polygons() -> None:
    with pytest.raises(MeshError, match="materials"):
        Mesh(SQUARE, PYRAMID, materials=FaceLabels(("skin",), np.zeros(2, np.int32)))
    with pytest.raises(MeshError, match="texture"):
        Mesh(SQUARE, PYRAMID, uv=UVMap(np.zeros((1, 2)), np.zeros(3, np.int32)))


def test_other_positions_keep_polygons_and_labels() -> None:
    labels = FaceLabels(("skin",), np.zeros(5, np.int32))
    mesh = Mesh(SQUARE, PYRAMID, materials=labels, source=Source("a.obj"))
    assert mesh.diameter == pytest.approx(np.sqrt(2))
    moved = mesh.with_vertices(3 * SQUARE)
    assert moved.faces is mesh.faces
    assert moved.materials is labels
    assert moved.name == "a.obj"
    assert moved.diameter == pytest.approx(3 * np.sqrt(2))
    with pytest.raises(MeshError, match="5 vertices"):
        mesh.with_vertices(SQUARE[:4])


@given(st.integers(1, 200), st.integers(0, 3), st.integers(0, 10_000))
def test_diameter_equals_the_exhaustive_search(count: int, rank: int, seed: int) -> None:
    """In space, in a plane, on a line and at one point."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(count, rank)) @ random.normal(size=(rank, 3)) + 5
    expected = pdist(points).max() if count > 1 else 0.0
    assert largest_distance(points) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("place", [0.0, 2.0, 0.1])
def test_a_crowd_in_one_place_has_no_size(place: float) -> None:
    """Pairs of this many points would not end within an hour."""
    assert largest_distance(np.full((200_000, 3), place)) == pytest.approx(0.0, abs=1e-12)


def test_same_topology_passes_and_any_difference_is_named() -> None:
    neutral = Mesh(SQUARE, PYRAMID, source=Source("neutral.obj"))
    require_same_topology(neutral, neutral.with_vertices(2 * SQUARE))
    lines = np.arange(100, 105, dtype=np.int32)
    turned = [*PYRAMID[:3], [2, 4, 3], PYRAMID[4]]
    target = Mesh(SQUARE, turned, source=Source("smile.obj", lines))
    with pytest.raises(TopologyError, match=r"smile.obj and neutral.obj .* is 3 \(line 103\)"):
        require_same_topology(neutral, target)
    with pytest.raises(TopologyError, match="4 polygons instead of 5"):
        require_same_topology(neutral, Mesh(SQUARE, PYRAMID[:4]))
    with pytest.raises(TopologyError, match=r"6 vertices, neutral\.obj has 5"):
        require_same_topology(neutral, Mesh(np.vstack([SQUARE, SQUARE[:1]]), PYRAMID))


def test_a_difference_in_an_endless_polygon_is_told_in_short() -> None:
    one = Mesh(np.eye(3), [[0, 1, 2] * 100_000])
    other = Mesh(np.eye(3), [[0, 1, 2] * 99_999])
    with pytest.raises(TopologyError, match=r"\[0, 1, 2, .* and 299,985 more\] instead of") as why:
        require_same_topology(one, other)
    assert len(str(why.value)) < 500
