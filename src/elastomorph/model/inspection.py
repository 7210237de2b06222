"""What a mesh is made of, and how a target differs from its neutral."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import Mesh, require_same_topology


@dataclass(frozen=True)
class MeshFacts:
    """Counts and sizes of one mesh."""

    vertices: int  # Number of vertices
    # Number of polygons by their number of vertices, such as {3: 548, 4: 25836}.
    polygons: dict[int, int]
    edges: int  # Number of edges
    border_edges: int  # Edges with one polygon
    non_manifold_edges: int  # Edges with more than two polygons
    components: int  # Connected pieces, isolated vertices not counted
    isolated_vertices: int  # Vertices on no polygon
    poles: int  # Vertices inside the surface with a valence other than 4
    diameter: float  # D, the largest distance between two vertices, in the unit of the file
    lowest: tuple[float, float, float]  # Smallest x, y, z
    highest: tuple[float, float, float]  # Largest x, y, z
    materials: tuple[str, ...]  # Names of materials, in order of use
    groups: tuple[str, ...]  # Names of groups, in order of use


@dataclass(frozen=True)
class Displacement:
    """How far a target is from its neutral."""

    moved: int  # Vertices that move at all
    largest: float  # Largest distance, as a fraction of D
    mean_of_moved: float  # Mean distance of the vertices that move, as a fraction of D
    farthest_vertex: int  # The vertex that moves most


def mesh_facts(mesh: Mesh) -> MeshFacts:
    """Count what a mesh is made of."""
    count = len(mesh.vertices)
    corners = mesh.faces.indices.astype(np.int64)
    following = corners[mesh.faces.next_corners] if corners.size else corners
    keys = np.minimum(corners, following) * count + np.maximum(corners, following)
    polygons_of_edge = np.unique(keys[corners != following], return_counts=True)[1]
    edges = mesh.edges
    used = np.unique(corners)
    pieces = int(component_of(count, edges).max()) + 1
    valence = np.bincount(edges.ravel(), minlength=count)
    on_border = np.zeros(count, dtype=bool)
    on_border[edges[polygons_of_edge != 2].ravel()] = True
    inside = np.zeros(count, dtype=bool)
    inside[used] = True
    sizes, numbers = np.unique(mesh.faces.sizes, return_counts=True)
    low, high = mesh.vertices.min(axis=0).tolist(), mesh.vertices.max(axis=0).tolist()
    return MeshFacts(
        vertices=count,
        polygons=dict(zip(sizes.tolist(), numbers.tolist(), strict=True)),
        edges=len(edges),
        border_edges=int((polygons_of_edge == 1).sum()),
        non_manifold_edges=int((polygons_of_edge > 2).sum()),
        components=int(pieces - (count - used.size)),
        isolated_vertices=int(count - used.size),
        poles=int((inside & ~on_border & (valence != 4)).sum()),
        diameter=mesh.diameter,
        lowest=(low[0], low[1], low[2]),
        highest=(high[0], high[1], high[2]),
        materials=mesh.materials.names if mesh.materials else (),
        groups=mesh.groups.names if mesh.groups else (),
    )


def displacement(neutral: Mesh, target: Mesh) -> Displacement:
    """Measure how far a target is from its neutral."""
    require_same_topology(neutral, target)
    distance = np.linalg.norm(target.vertices - neutral.vertices, axis=1)
    scale = neutral.diameter or 1.0
    moved = distance > 0
    return Displacement(
        moved=int(moved.sum()),
        largest=float(distance.max()) / scale,
        mean_of_moved=float(distance[moved].mean()) / scale if moved.any() else 0.0,
        farthest_vertex=int(distance.argmax()),
    )
