"""Small meshes, and copies of meshes with one fault each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import small_meshes
from elastomorph.doctor import Examination, Finding
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons


def shuffled(mesh: Mesh, seed: int = 0) -> tuple[Mesh, NDArray[np.int64]]:
    """A copy with vertices, polygons and first corners in another order; the new number of each."""
    random, faces = np.random.default_rng(seed), mesh.faces
    number, order = random.permutation(len(mesh.vertices)), random.permutation(len(faces))
    sizes = faces.sizes[order]
    offsets = np.append(0, np.cumsum(sizes))
    place = np.arange(offsets[-1]) + np.repeat(random.integers(sizes) - offsets[:-1], sizes)
    corners = np.repeat(faces.offsets[order], sizes) + place % np.repeat(sizes, sizes)
    vertices = np.empty_like(mesh.vertices)
    vertices[number] = mesh.vertices
    return Mesh(vertices, Polygons(number[faces.indices[corners]], offsets)), number


def turned_over(mesh: Mesh) -> Mesh:
    """A copy with every polygon run the other way round."""
    return Mesh(mesh.vertices, [face[::-1].tolist() for face in mesh.faces])


def with_noise(mesh: Mesh, part: float, seed: int = 0) -> Mesh:
    """A copy with every vertex moved at random, by a part of D in each coordinate."""
    noise = np.random.default_rng(seed).normal(size=mesh.vertices.shape)
    return mesh.with_vertices(mesh.vertices + part * mesh.diameter * noise)


def as_deltas(neutral: Mesh, target: Mesh) -> Mesh:
    """A target as displacements from its neutral."""
    return target.with_vertices(target.vertices - neutral.vertices)


def baked(neutral: Mesh, target: Mesh, other: Mesh, weight: float = 1.0) -> Mesh:
    """A target that also moves as another one does."""
    return target.with_vertices(target.vertices + weight * (other.vertices - neutral.vertices))


def split_at(mesh: Mesh, vertex: int) -> Mesh:
    """A copy in which each polygon around a vertex has a vertex of its own there."""
    corners = np.flatnonzero(mesh.faces.indices == vertex)
    indices = mesh.faces.indices.copy()
    indices[corners[1:]] = len(mesh.vertices) + np.arange(len(corners) - 1)
    copies = np.repeat(mesh.vertices[[vertex]], len(corners) - 1, axis=0)
    points = np.concatenate([mesh.vertices, copies])
    return Mesh(points, Polygons(indices, mesh.faces.offsets))


def welded(mesh: Mesh, kept: int, lost: int) -> Mesh:
    """A copy in which one vertex takes the place of another, and later ones move up."""
    number = np.arange(len(mesh.vertices))
    number[lost] = kept
    number[number > lost] -= 1
    points = np.delete(mesh.vertices, lost, axis=0)
    return Mesh(points, Polygons(number[mesh.faces.indices], mesh.faces.offsets))


def grid(columns: int, rows: int, seed: int | None = None) -> Mesh:
    """Columns × rows flat quads, all wound alike; bent at random with a seed."""
    mesh = small_meshes.grid(columns + 1, rows + 1)
    if seed is None:
        return mesh
    bent = np.random.default_rng(seed).uniform(-0.3, 0.3, mesh.vertices.shape)
    return mesh.with_vertices(mesh.vertices + bent)


def turn(points: NDArray[np.float64], degrees: float, axis: int = 1) -> NDArray[np.float64]:
    """Points turned about a coordinate axis."""
    angle = np.radians(degrees)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turned = points.copy()
    turned[:, first] = np.cos(angle) * points[:, first] - np.sin(angle) * points[:, second]
    turned[:, second] = np.sin(angle) * points[:, first] + np.cos(angle) * points[:, second]
    return turned


def names(examination: Examination) -> list[tuple[str, str]]:
    """Name and file of all findings."""
    return sorted((found.name, found.file) for found in examination.findings)


def only(findings: list[Finding] | tuple[Finding, ...]) -> Finding:
    """The one finding there must be."""
    assert len(findings) == 1, [found.message for found in findings]
    return findings[0]
