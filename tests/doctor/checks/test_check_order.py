"""Each way in which the files of a rig do not fit together is told from the others."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from planted_faults import grid, only, shuffled, split_at, turned_over, welded

from elastomorph.doctor.checks.order import NeutralOrder
from elastomorph.doctor.findings import Outcome
from elastomorph.io import read, write
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap


def examined(neutral: Mesh, target: Mesh, seeds: tuple[tuple[int, int], ...] = ()) -> Outcome:
    return NeutralOrder(neutral, seeds).examine(target, "smile.obj")


@pytest.fixture
def neutral() -> Mesh:
    """A bent grid with one triangle, so that no symmetry is left."""
    mesh = grid(4, 3, seed=1)
    return Mesh(mesh.vertices, [*mesh.faces[:11], [13, 14, 19]])


@pytest.fixture
def smile(neutral: Mesh) -> Mesh:
    return neutral.with_vertices(neutral.vertices + 0.2 * np.sin(neutral.vertices[:, ::-1]))


def test_the_same_order_is_right(neutral: Mesh, smile: Mesh) -> None:
    found = examined(neutral, smile)
    assert found.mesh is smile
    assert not found.findings
    assert not found.repair


def test_another_order_of_vertices_is_undone(neutral: Mesh, smile: Mesh) -> None:
    found = examined(neutral, shuffled(smile)[0])
    assert only(found.findings).name == "vertex-order"
    assert found.mesh is not None
    assert found.mesh.faces == neutral.faces
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_labels_and_texture_go_with_their_polygons(neutral: Mesh, smile: Mesh) -> None:
    """What is one polygon's stays with it, corner by corner, under names in order of use."""
    mixed, number = shuffled(smile)
    corners = np.arange(mixed.faces.indices.size, dtype=np.int32)
    uv = UVMap(np.stack([corners, -corners], axis=1).astype(float), corners)
    of_face = np.arange(len(mixed.faces), dtype=np.int32) % 3 - 1
    labelled = Mesh(
        mixed.vertices, mixed.faces, uv=uv, materials=FaceLabels(("skin", "lip"), of_face)
    )
    mesh = examined(neutral, labelled).mesh
    assert mesh is not None
    assert mesh.uv is not None
    assert mesh.materials is not None
    at = mesh.uv.corners
    np.testing.assert_array_equal(mixed.faces.indices[at], number[neutral.faces.indices])
    own = of_face[mixed.faces.corner_faces[at[neutral.faces.offsets[:-1]]]]
    names = [labelled.materials.names[i] if i >= 0 else "" for i in own]  # type: ignore[union-attr]
    kept = [mesh.materials.names[i] if i >= 0 else "" for i in mesh.materials.of_face]
    assert kept == names
    assert list(mesh.materials.names) == list(dict.fromkeys(filter(None, kept)))


def test_another_order_of_polygons_is_undone(neutral: Mesh, smile: Mesh) -> None:
    faces = [np.roll(face, 1).tolist() for face in smile.faces][::-1]
    found = examined(neutral, Mesh(smile.vertices, faces))
    assert only(found.findings).name == "polygon-order"
    assert found.mesh is not None
    assert found.mesh.faces == neutral.faces


def test_reversed_polygons_are_wound_again(neutral: Mesh, smile: Mesh) -> None:
    """Winding only: every position stays bit for bit where it was."""
    found = examined(neutral, turned_over(smile))
    assert only(found.findings).name == "reversed-winding"
    assert found.mesh is not None
    assert found.mesh.faces == neutral.faces
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


@pytest.mark.parametrize("turns", [0, 1, 3])
@pytest.mark.parametrize("wrong", [(4,), (0, 3, 11)])
def test_some_reversed_polygons_are_named(
    neutral: Mesh, smile: Mesh, wrong: tuple[int, ...], turns: int
) -> None:
    """Polygons and vertices exactly, from whichever corner they begin."""
    faces = [f.tolist() for f in smile.faces]
    for face in wrong:
        faces[face] = np.roll(faces[face][::-1], turns).tolist()
    found = examined(neutral, Mesh(smile.vertices, faces))
    one = only(found.findings)
    assert one.name == "reversed-winding"
    assert one.message.endswith(": " + ", ".join(map(str, wrong)))
    assert set(one.vertices) == {v for face in wrong for v in faces[face]}
    assert found.mesh is not None
    assert found.mesh.faces == neutral.faces
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_reversed_polygons_in_another_order_are_two_findings(neutral: Mesh, smile: Mesh) -> None:
    """With the numbers of the neutral, positions are never touched."""
    faces = [f.tolist()[::-1] if i < 4 else f.tolist() for i, f in enumerate(smile.faces)]
    found = examined(neutral, Mesh(smile.vertices, faces[::-1]))
    assert [f.name for f in found.findings] == ["reversed-winding", "polygon-order"]
    assert "8, 9, 10, 11" in found.findings[0].message
    assert found.mesh is not None
    assert found.mesh.faces == neutral.faces
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_reversed_triangles_of_polygons_are_put_back(neutral: Mesh, smile: Mesh) -> None:
    triangles = smile.faces.triangles().tolist()
    triangles[6] = triangles[6][::-1]
    found = examined(neutral, Mesh(smile.vertices, triangles))
    assert [f.name for f in found.findings] == ["triangulated", "reversed-winding"]
    assert set(found.findings[1].vertices) == set(triangles[6])
    assert found.mesh is not None
    assert found.mesh.faces == neutral.faces
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_texture_stays_at_its_corner_of_a_reversed_polygon(neutral: Mesh, smile: Mesh) -> None:
    over = turned_over(smile)
    corners = np.arange(over.faces.indices.size, dtype=np.int32)
    uv = UVMap(np.stack([over.faces.indices, corners], axis=1).astype(float), corners)
    mesh = examined(neutral, Mesh(over.vertices, over.faces, uv=uv)).mesh
    assert mesh is not None
    assert mesh.uv is not None
    np.testing.assert_array_equal(mesh.uv.coordinates[mesh.uv.corners][:, 0], neutral.faces.indices)


def test_a_mesh_without_symmetry_is_known_backwards_in_any_order(
    neutral: Mesh, smile: Mesh
) -> None:
    found = examined(neutral, shuffled(turned_over(smile))[0])
    assert [f.name for f in found.findings] == ["vertex-order", "reversed-winding"]
    assert found.mesh is not None
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_a_piece_run_backwards_is_not_laid_on_its_mirror_image(
    face: Mesh, rig: dict[str, Mesh]
) -> None:
    """Shuffled, with the eyeball of one side reversed: each vertex is itself again."""
    smile = rig["mouthSmile_L.obj"]
    part = component_of(len(face.vertices), face.edges)
    for piece in np.unique(part).tolist():
        faces = [f.tolist()[::-1] if part[f[0]] == piece else f.tolist() for f in smile.faces]
        found = examined(face, shuffled(Mesh(smile.vertices, faces), piece)[0])
        if found.mesh is None:
            assert only(found.findings).name in ("different-polygons", "reversed-winding")
            continue
        assert [f.name for f in found.findings] == ["vertex-order", "reversed-winding"]
        np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


@pytest.mark.parametrize("flat", [True, False])
def test_a_mirror_image_is_not_taken_for_a_new_order(flat: bool) -> None:
    """A symmetric grid run backwards fits on itself with left and right exchanged."""
    mesh = grid(6, 2)
    bump = np.exp(-(mesh.vertices[:, 0] ** 2))[:, None] * [[0, 0, 0.0 if flat else 2.0]]
    mesh = mesh.with_vertices(mesh.vertices + bump)
    found = examined(mesh, shuffled(turned_over(mesh), 3)[0])
    assert only(found.findings).name == "reversed-winding"
    assert found.mesh is None


def test_the_head_run_backwards_is_not_taken_for_a_new_order(
    face: Mesh, rig: dict[str, Mesh]
) -> None:
    found = examined(face, shuffled(turned_over(rig["mouthSmile_L.obj"]))[0])
    assert only(found.findings).name == "reversed-winding"


def test_triangles_of_the_same_polygons_are_put_back(neutral: Mesh, smile: Mesh) -> None:
    """Split along either diagonal."""
    triangles = [
        t
        for i, f in enumerate(smile.faces)
        for t in (
            [f.tolist()]
            if len(f) == 3
            else [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]
            if i % 2
            else [[f[1], f[2], f[3]], [f[3], f[0], f[1]]]
        )
    ]
    found = examined(neutral, Mesh(smile.vertices, triangles))
    assert only(found.findings).name == "triangulated"
    assert found.mesh is not None
    assert found.mesh.faces == neutral.faces
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_a_triangle_across_polygons_is_no_split(neutral: Mesh, smile: Mesh) -> None:
    triangles = smile.faces.triangles().tolist()
    triangles[0] = [0, 1, 7]
    found = examined(neutral, Mesh(smile.vertices, triangles))
    assert only(found.findings).name == "different-counts"
    assert "triangulated" in only(found.findings).message


@pytest.mark.parametrize("triangles", [False, True])
def test_vertices_split_at_seams_are_joined(neutral: Mesh, smile: Mesh, triangles: bool) -> None:
    """Every polygon with vertices of its own, as real-time formats store texture seams."""
    split = Mesh(
        smile.vertices[smile.faces.indices],
        [list(range(a, b)) for a, b in pairwise(smile.faces.offsets)],
    )
    if triangles:
        split = Mesh(split.vertices, split.faces.triangles())
    found = examined(neutral, split)
    one = only(found.findings)
    assert one.name == "split-vertices"
    used = np.bincount(neutral.faces.indices, minlength=20)
    assert one.vertices == tuple(np.flatnonzero(used > 1))
    assert found.mesh is not None
    assert found.mesh.faces == neutral.faces
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_one_split_vertex_is_named(neutral: Mesh, smile: Mesh) -> None:
    found = examined(neutral, split_at(smile, 6))
    one = only(found.findings)
    assert (one.name, one.vertices) == ("split-vertices", (6,))
    assert "23 vertices instead of 20" in one.message
    assert found.mesh is not None
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_copies_that_moved_apart_are_not_joined(neutral: Mesh, smile: Mesh) -> None:
    split = split_at(smile, 6)
    points = split.vertices.copy()
    points[-1] += 0.5
    found = examined(neutral, split.with_vertices(points))
    assert only(found.findings).name == "different-counts"
    assert found.mesh is None


def test_welded_vertices_are_parted_where_they_lie_together(neutral: Mesh) -> None:
    """Two grids that touch at one vertex, which an exporter welded."""
    second = neutral.vertices - neutral.vertices[0] + neutral.vertices[19]
    faces = [f.tolist() for f in neutral.faces]
    both = Mesh(
        np.concatenate([neutral.vertices, second]),
        [*faces, *[[v + 20 for v in face] for face in faces]],
    )
    points = both.vertices + 0.1 * np.cos(both.vertices)
    smile = both.with_vertices(points)
    found = examined(both, welded(smile, 19, 20))
    one = only(found.findings)
    assert (one.name, one.vertices) == ("welded-vertices", (19, 20))
    assert found.mesh is not None
    assert found.mesh.faces == both.faces
    np.testing.assert_array_equal(found.mesh.vertices, smile.vertices)


def test_welded_vertices_that_lay_apart_are_named_and_left(neutral: Mesh, smile: Mesh) -> None:
    """Where the second one was is lost."""
    found = examined(neutral, welded(smile, 2, 13))
    one = only(found.findings)
    assert (one.name, one.vertices) == ("welded-vertices", (2, 13))
    assert found.mesh is None


def test_a_lost_vertex_is_counted(neutral: Mesh, smile: Mesh) -> None:
    found = only(examined(neutral, Mesh(smile.vertices[:-1], smile.faces[:9])).findings)
    assert found.name == "different-counts"
    assert "19 vertices and 9 polygons instead of 20 and 12" in found.message


def test_one_rewired_polygon_is_named_with_its_line(
    neutral: Mesh, smile: Mesh, tmp_path: Path
) -> None:
    path = tmp_path / "smile.obj"
    faces = [face.tolist() for face in smile.faces]
    faces[5] = [faces[5][0], faces[5][2], faces[5][1], faces[5][3]]
    write(path, Mesh(smile.vertices, faces))
    target = read(path)
    found = only(NeutralOrder(neutral).examine(target, str(path)).findings)
    assert found.name == "different-polygons"
    assert "1 polygons differ, the first is 5" in found.message
    lines = path.read_text().splitlines()
    assert found.line is not None
    assert [int(w) - 1 for w in lines[found.line - 1].split()[1:]] == faces[5]


def test_a_wrong_pair_is_a_finding_of_its_own(neutral: Mesh, smile: Mesh) -> None:
    mixed, number = shuffled(smile)
    for wrong in (int(number[1]), 999):
        found = only(examined(neutral, mixed, ((0, wrong),)).findings)
        assert found.name == "wrong-seed"
        assert f"0={wrong}" in found.message
