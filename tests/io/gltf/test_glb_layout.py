"""Vertices are split only along texture seams, and polygons become fans in their order."""

from __future__ import annotations

import numpy as np
import pytest
from glb_samples import meshes, seamed_mesh, triangle
from hypothesis import given, settings

from elastomorph.io.gltf.mesh_extras import lay_out, restored_surface, surface_extras
from elastomorph.model.mesh import Mesh, UVMap


def test_a_mesh_without_texture_is_not_split() -> None:
    layout = lay_out(triangle())
    assert layout.vertex_of.tolist() == [0, 1, 2]
    assert [part.triangles.tolist() for part in layout.primitives] == [[[0, 1, 2]]]
    assert layout.texture is None


def test_a_seam_splits_the_vertices_on_it_and_no_others() -> None:
    """Vertices 1 and 2 have two texture coordinates each, on both sides of the seam."""
    layout = lay_out(seamed_mesh())
    assert layout.vertex_of.tolist() == [0, 1, 2, 3, 4, 5, 6, 1, 2]
    assert layout.corners.tolist() == [0, 1, 2, 3, 7, 4, 5, 8, 4, 6, 5]
    assert layout.uv_of.tolist() == [0, 1, 2, 3, 6, 7, 6, 4, 5]
    assert layout.texture is not None
    np.testing.assert_allclose(layout.texture[[0, 2, 7]], [[0, 1], [0.5, 0], [0.6, 1]], rtol=1e-6)


def test_a_part_a_material_in_the_order_of_the_labels_and_the_unlabelled_last() -> None:
    parts = lay_out(seamed_mesh()).primitives
    assert [part.label for part in parts] == [0, 2, -1]
    assert parts[0].triangles.tolist() == [[7, 4, 5], [7, 5, 8]]
    assert parts[1].triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert parts[2].triangles.tolist() == [[4, 6, 5]]


def test_two_entries_with_the_same_coordinates_do_not_split_a_vertex() -> None:
    uv = UVMap(np.array([[0.5, 0.5], [0.5, 0.5], [0.0, -0.0]]), np.array([0, 2, 2, 1, 2, 2]))
    mesh = Mesh(np.eye(3), [[0, 1, 2], [0, 2, 1]], uv=uv)
    assert lay_out(mesh).vertex_of.tolist() == [0, 1, 2]


@given(meshes())
@settings(max_examples=150, deadline=None)
def test_the_surface_is_restored_from_the_triangles(mesh: Mesh) -> None:
    """Also with texture coordinates that no corner uses, or that have three components."""
    layout = lay_out(mesh)
    stored = surface_extras(mesh, layout)
    texture = None if layout.texture is None else layout.texture.astype(float)
    parts = [part.triangles for part in layout.primitives if len(part.triangles)]
    vertices = mesh.vertices[layout.vertex_of]
    back = Mesh(mesh.vertices, **restored_surface(stored, parts, vertices, texture))
    assert back.faces == mesh.faces
    assert back.material_library == mesh.material_library
    for mine, theirs in ((mesh.materials, back.materials), (mesh.groups, back.groups)):
        assert (mine is None) == (theirs is None)
        if mine is not None and theirs is not None:
            assert mine.names == theirs.names
            assert np.array_equal(mine.of_face, theirs.of_face)
    assert (mesh.uv is None) == (back.uv is None)
    if mesh.uv is not None and back.uv is not None:
        assert mesh.uv.coordinates.tobytes() == back.uv.coordinates.tobytes()
        assert np.array_equal(mesh.uv.corners, back.uv.corners)


def test_triangles_in_another_order_are_noticed() -> None:
    mesh = seamed_mesh()
    layout = lay_out(mesh)
    stored = surface_extras(mesh, layout)
    assert layout.texture is not None
    parts = [part.triangles for part in layout.primitives if len(part.triangles)]
    texture, vertices = layout.texture.astype(float), mesh.vertices[layout.vertex_of]
    for changed in (
        [parts[0][::-1], *parts[1:]],
        parts[:2],
        [parts[0][:1], *parts[1:]],
    ):
        with pytest.raises(ValueError, match=r"fans|parts|triangles"):
            restored_surface(stored, changed, vertices, texture)
    turned = [parts[0][:, [1, 2, 0]], *parts[1:]]  # both triangles of a quad
    assert restored_surface(stored, turned, vertices, texture)["faces"] == mesh.faces
    moved = vertices.copy()
    moved[7] += 1
    with pytest.raises(ValueError, match="copies"):
        restored_surface(stored, parts, moved, texture)
