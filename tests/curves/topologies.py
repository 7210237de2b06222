"""Meshes whose loops can be counted by hand, and random ones that nobody would model."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from elastomorph.model.mesh import Mesh

patiently = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def grid(rows: int, columns: int, *, around: bool = False, through: bool = False) -> Mesh:
    """Quads between rows × columns vertices, numbered row by row.

    With ``around`` the last column meets the first (a tube of rings), with ``through`` the last
    row meets the first as well (a torus).
    """
    row, column = np.meshgrid(
        np.arange(rows - (not through)), np.arange(columns - (not around)), indexing="ij"
    )

    def at(down: int, right: int) -> ArrayLike:
        return ((row + down) % rows * columns + (column + right) % columns).reshape(-1)

    faces = np.stack([at(0, 0), at(0, 1), at(1, 1), at(1, 0)], axis=1)
    i, j = np.divmod(np.arange(rows * columns), columns)
    turn = 2 * np.pi * j / columns
    flat = np.stack([j, -i, 0 * i], axis=1)
    bent = np.stack([np.cos(turn), -i, np.sin(turn)], axis=1)
    return Mesh(bent if around else flat, faces)


def triangulated(mesh: Mesh) -> Mesh:
    """Every polygon split into triangles."""
    return Mesh(mesh.vertices, mesh.faces.triangles())


def cube() -> Mesh:
    """Six quads, eight vertices where three edges meet."""
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    return Mesh(
        corners,
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
    )


def fan(spokes: int) -> Mesh:
    """Triangles all around vertex 0."""
    turn = 2 * np.pi * np.arange(spokes) / spokes
    rim = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    ring = np.arange(spokes)
    faces = np.stack([0 * ring, 1 + ring, 1 + (ring + 1) % spokes], axis=1)
    return Mesh(np.concatenate([[[0.0, 0.0, 0.0]], rim]), faces)


def figure_eight() -> tuple[Mesh, list[int], list[int]]:
    """A band of quads that crosses itself, and the two lobes of the loop along its middle."""
    length, second = 8, 5  # the middle passes the crossing at its steps 1 and 5

    def place(step: int, side: int) -> tuple[str, int, int]:
        step %= length
        if abs(step - 1) <= 1:
            return ("crossing", step - 1, side)
        if abs(step - second) <= 1:
            return ("crossing", side, second - step)
        return ("band", step, side)

    quads = {
        frozenset(corners): corners
        for step in range(length)
        for side in (-1, 0)
        for corners in [
            [
                place(step, side),
                place(step + 1, side),
                place(step + 1, side + 1),
                place(step, side + 1),
            ]
        ]
    }
    names = sorted({name for quad in quads.values() for name in quad})
    index = {name: i for i, name in enumerate(names)}
    mesh = Mesh(
        np.random.default_rng(0).random((len(names), 3)),
        [[index[name] for name in quad] for quad in quads.values()],
    )
    return (
        mesh,
        [index[place(step, 0)] for step in (1, 2, 3, 4)],
        [index[place(step, 0)] for step in (5, 6, 7, 8)],
    )


def together(meshes: Iterable[Mesh]) -> Mesh:
    """Several meshes as the components of one."""
    vertices: list[np.ndarray] = []
    faces: list[list[int]] = []
    count = 0
    for mesh in meshes:
        vertices.append(mesh.vertices + [10.0 * count, 0.0, 0.0])
        faces.extend((face + count).tolist() for face in mesh.faces)
        count += len(mesh.vertices)
    return Mesh(np.concatenate(vertices), faces)


def relabelled(mesh: Mesh, new_index: np.ndarray, face_order: Iterable[int]) -> Mesh:
    """Vertex i renamed to new_index[i], polygons in another order and starting elsewhere."""
    vertices = np.empty_like(mesh.vertices)
    vertices[new_index] = mesh.vertices
    faces = [np.roll(new_index[mesh.faces[face]], face).tolist() for face in face_order]
    return Mesh(vertices, faces)


@st.composite
def surfaces(draw: Callable[..., object]) -> Mesh:
    """Quads, triangles or both, with holes, flipped polygons, islands and lone vertices."""
    parts = []
    for _ in range(draw(st.integers(1, 2))):
        around = draw(st.booleans())
        through = around and draw(st.booleans())
        shortest = 3 if around else 2
        rows, columns = draw(st.integers(shortest, 7)), draw(st.integers(shortest, 7))
        parts.append(grid(rows, columns, around=around, through=through))
    whole = together(parts)
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    split, missing, flipped = (draw(st.sampled_from([0.0, 0.1, 0.5, 1.0])) for _ in range(3))
    faces: list[list[int]] = []
    for face in whole.faces:
        a, b, c, d = face.tolist()
        pieces = [[a, b, c, d]]
        if random.random() < split:
            pieces = [[a, b, c], [a, c, d]] if random.random() < 0.5 else [[a, b, d], [b, c, d]]
        faces.extend(
            piece[::-1] if random.random() < flipped else piece
            for piece in pieces
            if random.random() >= missing / 2
        )
    count = len(whole.vertices) + draw(st.integers(0, 2))
    new_index = random.permutation(count)
    positions = random.normal(size=(count, 3))
    return Mesh(positions, [new_index[face].tolist() for face in faces])


@st.composite
def soups(draw: Callable[..., object]) -> Mesh:
    """Polygons at random: non-manifold, degenerate, doubled, anything a file may hold."""
    count = draw(st.integers(1, 8))
    vertex = st.integers(0, count - 1)
    faces = draw(st.lists(st.lists(vertex, min_size=3, max_size=5), max_size=10))
    return Mesh(np.random.default_rng(count).normal(size=(count, 3)), faces)


anything = st.one_of(surfaces(), soups())
