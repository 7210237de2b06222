"""Faces stand upright whatever their file calls up; their numbers change as little as can be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph.errors import MeshError
from elastomorph.io.fbx.reader import FbxMesh, mesh_of
from elastomorph.io.joined_rig import RigPart, joined_rig, placings

Y_UP = np.eye(3)
Z_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def part(
    linear: np.ndarray = Y_UP, origin: tuple[float, float, float] = (0, 0, 0), name: str = "face"
) -> FbxMesh:
    """A tetrahedron whose polygons face outwards."""
    points = np.array([[0.1, 0, 0], [1, 0, -0.0], [0, 1, 0], [0, 0, 1.0]])
    indices = np.array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3])
    matrix = np.concatenate([linear.T, [origin]])
    return FbxMesh(name, True, matrix, points, indices, np.arange(0, 13, 3), None, None, {})


def turn(axis: int, degrees: float) -> np.ndarray:
    one, other = [i for i in range(3) if i != axis]
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(3)
    matrix[one, one] = matrix[other, other] = c
    matrix[one, other], matrix[other, one] = -s, s
    return matrix


def volume(vertices: np.ndarray, polygons: list[np.ndarray]) -> float:
    return sum(np.linalg.det(vertices[polygon]) for polygon in polygons) / 6


@pytest.mark.parametrize(
    ("axes", "node"),
    [(Y_UP, np.eye(3)), (Y_UP, 0.01 * np.eye(3)), (Z_UP, 100 * turn(0, 90))],
)
def test_a_mesh_that_is_upright_keeps_its_numbers_bit_for_bit(
    axes: np.ndarray, node: np.ndarray
) -> None:
    own = part(node, (5, 6, 7))
    placed = placings(axes, [own])[0].positions(own.vertices)
    assert placed.tobytes() == own.vertices.tobytes()


def test_a_mesh_lying_on_its_back_is_raised_exactly() -> None:
    """As Blender writes it: Z-up points under a node turned by -90° and scaled by 100."""
    own = part(100 * turn(0, -90))
    placed = placings(Y_UP, [own])[0].positions(own.vertices)
    assert placed.tolist() == [[x, z, -y] for x, y, z in own.vertices.tolist()]


@given(st.lists(st.floats(-180, 180), min_size=3, max_size=3), st.floats(1e-3, 1e3))
@settings(max_examples=50, deadline=None)
def test_any_turn_keeps_distances_and_ignores_scale(angles: list[float], scale: float) -> None:
    rotation = turn(0, angles[0]) @ turn(1, angles[1]) @ turn(2, angles[2])
    own = part(scale * rotation, (1, 2, 3))
    placed = placings(Y_UP, [own])[0].positions(own.vertices)
    assert placed == pytest.approx(own.vertices @ rotation.T, abs=1e-9)


@pytest.mark.parametrize("node", [np.diag([-1.0, 1, 1]), np.diag([2.0, 2, -2]) @ turn(1, 30)])
def test_a_mirrored_mesh_is_mirrored_and_not_inside_out(node: np.ndarray) -> None:
    own = part(node)
    places = placings(Y_UP, [own])
    whole = RigPart("face", mesh_of(own, "face.fbx"), {}, places[0])
    mesh, _ = joined_rig([whole], "face.fbx")
    assert places[0].mirrors
    before = volume(own.vertices, list(own.indices.reshape(-1, 3)))
    assert volume(mesh.vertices, list(mesh.faces)) == pytest.approx(before)
    assert [sorted(p.tolist()) for p in mesh.faces] == [
        sorted(p) for p in own.indices.reshape(-1, 3).tolist()
    ]
    assert mesh.faces[0][0] == own.indices[0]


@given(st.integers(0, 10_000))
@settings(max_examples=30, deadline=None)
def test_further_meshes_keep_their_place_beside_the_first(seed: int) -> None:
    """World positions of both differ from rig positions by one affine map only."""
    random = np.random.default_rng(seed)
    first = part(random.normal(size=(3, 3)) + 3 * turn(0, 40), tuple(random.normal(size=3)))
    other = part(random.normal(size=(3, 3)), tuple(random.normal(size=3)))
    places = placings(Z_UP, [first, other])

    def world(own: FbxMesh) -> np.ndarray:
        return own.vertices @ own.matrix[:3] + own.matrix[3]

    both = np.concatenate([world(first), world(other)])
    placed = np.concatenate(
        [p.positions(own.vertices) for p, own in zip(places, (first, other), strict=True)]
    )
    ones = np.ones((len(both), 1))
    found, *_ = np.linalg.lstsq(np.hstack([both[:4], ones[:4]]), placed[:4], rcond=None)
    assert np.hstack([both, ones]) @ found == pytest.approx(placed, abs=1e-6)


def test_a_node_squashed_flat_still_gives_a_mesh() -> None:
    own = part(np.diag([1.0, 0, 1]))
    assert placings(Y_UP, [own])[0].positions(own.vertices).tolist() == own.vertices.tolist()


def test_a_transform_that_is_no_numbers_is_no_place() -> None:
    with pytest.raises(MeshError, match="stand at no place"):
        placings(Y_UP, [part(np.full((3, 3), np.nan))])
