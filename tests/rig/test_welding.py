"""Vertices split at seams are one again while paths are made, and what hangs on them is there."""

from __future__ import annotations

import numpy as np

from elastomorph.model.mesh import Mesh, Source
from elastomorph.model.polygons import Polygons
from elastomorph.rig.welding import Welding, seams_of


def strip(x: float, y: float = 0.0) -> np.ndarray:
    """Six vertices of two quads side by side, from a place to the right."""
    return np.array([[x + i, y + j, 0.0] for i in range(3) for j in range(2)])


QUADS = np.array([[0, 2, 3, 1], [2, 4, 5, 3]])


def sheet(*strips: np.ndarray) -> Mesh:
    """Strips that share no vertex, as a format that splits vertices has them."""
    quads = np.concatenate([QUADS + 6 * k for k in range(len(strips))])
    source = Source("sheet.glb", split=True)
    return Mesh(np.concatenate(strips), Polygons.of(quads), source=source)


def test_an_island_at_rest_hangs_on_one_that_moves_by_their_seam() -> None:
    """It holds the others: without it, a path would end at the seam as at a border."""
    mesh = sheet(strip(0), strip(2), strip(50))
    target = mesh.vertices.copy()
    target[:2] += [0, 0, 1]
    welding = Welding.of(mesh, [target])
    assert (welding.place[:12] >= 0).all()
    assert (welding.place[12:] == -1).all()  # far away, and at rest
    assert welding.place[[4, 5]].tolist() == welding.place[[6, 7]].tolist()
    assert len(welding.first) == 10
    assert welding.joins
    assert len(welding.neutral.faces) == 4


def test_what_only_touches_in_the_neutral_is_not_one() -> None:
    """Closed lids touch, and open: a seam is at one place in every shape."""
    mesh = sheet(strip(0), strip(2))
    target = mesh.vertices.copy()
    target[:6] += [0, 0, 1]
    welding = Welding.of(mesh, [target])
    assert not welding.joins
    assert (welding.place[:6] >= 0).all()
    assert (welding.place[6:] == -1).all()


def test_fields_are_those_of_the_vertex_that_each_is() -> None:
    mesh = sheet(strip(0), strip(2), strip(50))
    target = mesh.vertices.copy()
    target[[4, 5, 6, 7]] += [0, 1, 0]
    target[3] += [0, 0, 2]
    welding = Welding.of(mesh, [target])
    whole = mesh.with_vertices(target)
    moved = welding.mesh(whole).vertices - welding.neutral.vertices
    assert np.array_equal(welding.fields(moved), target - mesh.vertices)


def test_formats_that_keep_vertices_have_no_seams() -> None:
    """There, two vertices at one place are two because an artist wants them to be."""
    split = sheet(strip(0), strip(2))
    kept = Mesh(split.vertices, split.faces, source=Source("sheet.obj"))
    target = split.vertices.copy()
    target[:2] += [0, 0, 1]
    assert seams_of(split, {"up": split.with_vertices(target)}) is not None
    assert seams_of(kept, {"up": kept.with_vertices(target)}) is None
