"""Is the neutral a surface: two polygons at an edge, one fan at a vertex, areas, no seams?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks.order import inconsistent_winding
from elastomorph.doctor.findings import Finding, counted, finding, listed, polygon_finding
from elastomorph.doctor.neutral import HalfEdges, Neutral
from elastomorph.model.geometry import component_of
from elastomorph.model.inspection import MeshFacts, mesh_facts
from elastomorph.model.mesh import Mesh


@dataclass(frozen=True)
class SurfaceFacts:
    """What a surface is made of; facts, not faults."""

    counts: MeshFacts
    borders: int  # connected lines of border edges, such as mouth, eyes and neck
    # Vertices inside the surface without four edges, by their number of edges.
    poles_by_valence: dict[int, int]


def surface_facts(mesh: Mesh) -> SurfaceFacts:
    """Count what a surface is made of."""
    count, half = len(mesh.vertices), HalfEdges.of(mesh.faces, len(mesh.vertices))
    ends = np.stack([half.start, half.end], axis=1)[half.border]
    borders = len(np.unique(component_of(count, ends)[ends[:, 0]])) if len(ends) else 0
    valence = np.bincount(mesh.edges.ravel(), minlength=count)
    inside = valence > 0
    inside[half.start[half.polygons_of_edge != 2]] = False
    inside[half.end[half.polygons_of_edge != 2]] = False
    values, numbers = np.unique(valence[inside & (valence != 4)], return_counts=True)
    poles = dict(zip(values.tolist(), numbers.tolist(), strict=True))
    return SurfaceFacts(mesh_facts(mesh), borders, poles)


def examine_surface(neutral: Neutral, file: str) -> list[Finding]:
    """What keeps the polygons of a neutral from being a sound surface."""
    checks = _SURFACE if len(neutral.mesh.faces) else (_unwelded_vertices,)
    return [found for check in checks for found in check(neutral, file)]


def _non_manifold_edges(neutral: Neutral, file: str) -> list[Finding]:
    half = neutral.half_edges
    crowded = half.proper & (half.polygons_of_edge > 2)
    if not crowded.any():
        return []
    keys = np.unique(half.edge_keys[crowded])
    low, high = np.divmod(keys, half.vertex_count)
    names = listed(f"{a}-{b}" for a, b in zip(low.tolist(), high.tolist(), strict=True))
    message = f"{counted(keys, 'edge has', 'edges have')} more than two polygons: {names}"
    return [finding("non-manifold-edges", file, message, vertices=np.unique([low, high]))]


def _non_manifold_vertices(neutral: Neutral, file: str) -> list[Finding]:
    """Vertices whose polygons form several fans that share no edge."""
    half = neutral.half_edges
    proper = np.flatnonzero(half.proper)
    order = proper[np.argsort(half.edge_keys[proper], kind="stable")]
    same = half.edge_keys[order[1:]] == half.edge_keys[order[:-1]]
    first, second = order[:-1][same], order[1:][same]
    # Corners at the two ends of an edge: that of the half-edge, and the one after it.
    swap = half.start[first] != half.start[second]
    at_start = np.stack([first, np.where(swap, half.following[second], second)], axis=1)
    at_end = np.stack([half.following[first], np.where(swap, second, half.following[second])], 1)
    fans = component_of(len(half.start), np.concatenate([at_start, at_end]))
    at = np.unique(half.start * len(fans) + fans) // len(fans)
    crowded = half.proper & (half.polygons_of_edge > 2)
    ends = np.concatenate([half.start[crowded], half.end[crowded]])
    joints = np.setdiff1d(at[1:][at[1:] == at[:-1]], ends)
    if not joints.size:
        return []
    message = f"{counted(joints, 'vertex joins', 'vertices join')} parts of it at a point"
    return [finding("non-manifold-vertices", file, message, vertices=joints)]


def _repeated_corners(neutral: Neutral, file: str) -> list[Finding]:
    half = neutral.half_edges
    keys = np.sort(half.faces.corner_faces.astype(np.int64) * half.vertex_count + half.start)
    polygons = np.unique(keys[1:][keys[1:] == keys[:-1]] // half.vertex_count)
    if not polygons.size:
        return []
    message = f"{counted(polygons, 'polygon names', 'polygons name')} a vertex twice"
    return [polygon_finding("repeated-corners", neutral.mesh, file, polygons, message)]


def _isolated_vertices(neutral: Neutral, file: str) -> list[Finding]:
    faces, count = neutral.mesh.faces, len(neutral.mesh.vertices)
    loose = np.flatnonzero(np.bincount(faces.indices, minlength=count) == 0)
    if not loose.size:
        return []
    message = f"{counted(loose, 'vertex is', 'vertices are')} on no polygon"
    return [finding("isolated-vertices", file, message, vertices=loose)]


def _zero_area(neutral: Neutral, file: str) -> list[Finding]:
    return _without_area(neutral.own_areas[1], neutral.mesh, file, "no area")


def lost_area(neutral: Neutral, mesh: Mesh, file: str) -> list[Finding]:
    """Polygons that have an area in the neutral and none in a target."""
    (before, none), (after, lost) = neutral.own_areas, neutral.areas(mesh.vertices)
    lost = (lost | (after <= neutral.limits.area * before)) & ~none
    return _without_area(lost, mesh, file, "no area, though they do in the neutral")


def _without_area(which: NDArray[np.bool_], mesh: Mesh, file: str, words: str) -> list[Finding]:
    polygons = np.flatnonzero(which)
    if not polygons.size:
        return []
    has = counted(polygons, "polygon has", "polygons have")
    message = f"{has} {words}: {listed(polygons)}"
    return [polygon_finding("zero-area", mesh, file, polygons, message)]


def _unwelded_vertices(neutral: Neutral, file: str) -> list[Finding]:
    """Vertices that share their position with another one."""
    mesh = neutral.mesh
    order = np.lexsort(mesh.vertices.T)
    ordered = mesh.vertices[order]
    new = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))
    place = np.cumsum(new) - 1
    shared = np.bincount(place)[place] > 1
    if not shared.any():
        return []
    parts = component_of(len(mesh.vertices), mesh.edges)[order[shared]]
    keys = place[shared] * len(order) + parts
    seams = int((np.unique(keys, return_counts=True)[1] > 1).sum())
    positions = len(np.unique(place[shared]))
    where = (
        f"{seams:,} of them twice on one piece, as an open seam has"
        if seams
        else "all where different pieces touch"
    )
    message = (
        f"{int(shared.sum()):,} vertices share {counted(positions, 'position', 'positions')}, "
        f"{where}"
    )
    return [finding("unwelded-vertices", file, message, vertices=np.sort(order[shared]))]


_SURFACE: tuple[Callable[[Neutral, str], list[Finding]], ...] = (
    _non_manifold_edges,
    _non_manifold_vertices,
    inconsistent_winding,
    _repeated_corners,
    _isolated_vertices,
    _zero_area,
    _unwelded_vertices,
)
