from __future__ import annotations

import numpy as np
import pytest
from sheets import between, turn

import elastomorph as em
from elastomorph.rivals import ElasticSolid
from elastomorph.rivals.elastic_solid import Closed, Head, Lattice, Solid
from small_head import recorded_motion

AXIS = np.array([1.0, 2.0, -0.5])
CUBE = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def box(size: float, middle: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    """(8, 3) corners of a cube."""
    low = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]]
    corners = np.array(low + [[x, y, 1] for x, y, _ in low], dtype=float)
    return corners * size / 2 + middle


@pytest.fixture(scope="module")
def lattice() -> Lattice:
    cube = em.Mesh(box(2.0), CUBE)
    return Lattice.inside(Closed.of(cube), cube.vertices, cube.vertices, 150)


@pytest.fixture(scope="module")
def solid(lattice: Lattice) -> Solid:
    pytest.importorskip(
        "skfem", reason="needs the extra 'rivals': pip install 'elastomorph[rivals]'"
    )
    return Solid.of(lattice, 0.4, np.ones(len(lattice.tetrahedra)))


def rim(lattice: Lattice) -> np.ndarray:
    """(N,) nodes on the outside of the lattice, and some within."""
    sides = np.abs(lattice.nodes).max(axis=1)
    return sides > 0.8


def test_a_cube_is_closed_and_knows_its_inside() -> None:
    """Also where a side is missing, or all sides are turned inside out."""
    for faces in (CUBE, CUBE[:-1], [side[::-1] for side in CUBE]):
        cube = Closed.of(em.Mesh(box(2.0), faces))
        assert cube.volume == pytest.approx(8.0)
        x, y, z = np.linspace(-1.53, 1.51, 8), np.linspace(-1.2, 1.4, 6), np.linspace(-1.3, 1.1, 5)
        grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=3)
        np.testing.assert_array_equal(cube.inside(x, y, z), (np.abs(grid) < 1).all(axis=3))


def test_a_sheet_has_no_inside(sheet: em.Mesh) -> None:
    flat = sheet.with_vertices(sheet.vertices * [1, 1, 0])
    with pytest.raises(em.MeshError, match="next to nothing inside"):
        Closed.of(flat)


def test_tetrahedra_are_alike_and_fill_the_cube(lattice: Lattice) -> None:
    sides = lattice.nodes[lattice.tetrahedra]
    volumes = np.linalg.det(sides[:, 1:] - sides[:, :1]) / 6
    np.testing.assert_allclose(volumes, volumes[0])
    assert volumes[0] > 0
    assert volumes.sum() > 8.0
    assert (lattice.carrier >= 0).all()
    np.testing.assert_allclose(lattice.carried(lattice.nodes), box(2.0), atol=1e-12)
    bent = lattice.nodes @ turn(AXIS, 0.5).T * 1.2 + 3.0
    np.testing.assert_allclose(
        lattice.carried(bent), box(2.0) @ turn(AXIS, 0.5).T * 1.2 + 3.0, atol=1e-12
    )


def test_patch_of_constant_strain(lattice: Lattice, solid: Solid) -> None:
    """Nodes on the outside displaced linearly: those within follow exactly."""
    bone = rim(lattice)
    assert np.count_nonzero(~bone) > 5
    strain = np.array([[0.1, 0.02, 0.0], [-0.03, 0.05, 0.01], [0.04, 0.0, -0.1]])
    wanted = lattice.nodes @ (np.eye(3) + strain).T + 0.3
    np.testing.assert_allclose(solid.linear(wanted[bone], bone), wanted, atol=1e-5)
    found = solid.settled(lattice.nodes, wanted[bone], bone, 1e-9)
    np.testing.assert_allclose(found, wanted, atol=1e-5)


def test_what_turns_is_rigid_for_corotational_elasticity_only(
    lattice: Lattice, solid: Solid
) -> None:
    """Held at a few nodes, all others follow; linear elasticity swells."""
    bone = lattice.nodes[:, 0] < 0.0
    wanted = lattice.nodes @ turn(AXIS, 0.6).T
    found = lattice.nodes
    for part in (0.5, 1.0, 1.0, 1.0, 1.0):
        turned = lattice.nodes @ turn(AXIS, 0.6 * part).T
        found = solid.settled(found, turned[bone], bone, 1e-9)
    np.testing.assert_allclose(found, wanted, atol=1e-4)
    assert np.abs(solid.linear(wanted[bone], bone) - wanted).max() > 0.1


def head() -> tuple[em.Mesh, np.ndarray]:
    """A block with a jaw inside it, and that jaw turned with the lower part of the block."""
    count = 7
    along = np.linspace(-1.0, 1.0, count)
    points, faces = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            first = sum(len(own) for own in points)
            a, b = np.meshgrid(along, along, indexing="ij")
            own = np.insert(np.stack([a, b], 2).reshape(-1, 2), axis, side, axis=1)
            points.append(own)
            for i in range(count - 1):
                for j in range(count - 1):
                    at = first + i * count + j
                    quad = [at, at + count, at + count + 1, at + 1]
                    faces.append(quad if (side > 0) == (axis != 1) else quad[::-1])
    every = np.concatenate(points)
    unique, place = np.unique(every.round(9), axis=0, return_inverse=True)
    skin_faces = [place.ravel()[face].tolist() for face in faces]
    jaw = box(0.5, (0.0, -0.4, 0.3))
    vertices = np.concatenate([unique, jaw])
    mesh = em.Mesh(vertices, skin_faces + [[len(unique) + i for i in side] for side in CUBE])
    moved = vertices @ turn(np.array([1.0, 0.0, 0.0]), 0.5).T
    low = np.clip(-vertices[:, 1], 0, 0.5)[:, None] * 2
    low[len(unique) :] = 1.0
    return mesh, vertices + low * (moved - vertices)


@pytest.mark.usefixtures("skfem")
@pytest.mark.parametrize("elasticity", ["corotational", "linear"])
def test_the_jaw_turns_the_skull_stays_and_both_ends_are_met(elasticity: str) -> None:
    mesh, end = head()
    rival = ElasticSolid(elasticity, nodes=250, depth=0.2)
    found = rival.poses(between(mesh, end), [0.0, 0.5, 1.0])
    np.testing.assert_allclose(found[[0, -1]], [mesh.vertices, end], atol=1e-9)
    still = (end == mesh.vertices).all(axis=1)
    assert (found[:, still] == mesh.vertices[still]).all()
    halfway = mesh.vertices[-8:] @ turn(np.array([1.0, 0.0, 0.0]), 0.25).T
    np.testing.assert_allclose(found[1, -8:], halfway, atol=1e-6)


def test_flesh_is_between_jaw_and_skull() -> None:
    """On a head with throat and neck no tetrahedron joins the two, which would turn it over."""
    mesh, end = recorded_motion().mesh, recorded_motion().frames[-1]
    found = Head.between(between(mesh, end), 1500, 0.09)
    corners = found.lattice.tetrahedra
    of_jaw, of_skull = (
        own[corners].any(axis=1) for own in (found.turning, found.bone & ~found.turning)
    )
    assert of_jaw.any()
    assert of_skull.any()
    assert not (of_jaw & of_skull).any()


@pytest.mark.usefixtures("skfem")
def test_without_a_jaw_it_says_so() -> None:
    mesh, end = head()
    straight = mesh.vertices + 0.1 * (end - mesh.vertices)
    straight[-8:] = mesh.vertices[-8:]
    with pytest.raises(em.MeshError, match="no jaw to move"):
        ElasticSolid().poses(between(mesh, straight), [0.5])
