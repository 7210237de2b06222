"""Is the neutral a surface: two polygons at an edge, one fan at a vertex, one side outside?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.half_edges import HalfEdges
from elastomorph.doctor.words import counted, listed
from elastomorph.model.components import component_of
from elastomorph.model.inspection import MeshFacts, mesh_facts
from elastomorph.model.mesh import Mesh

__all__ = ["SurfaceFacts", "examine_surface", "surface_facts"]


@dataclass(frozen=True)
class SurfaceFacts:
    """What a surface is made of; facts, not faults.

    Attributes:
        counts: Vertices, polygons, edges, pieces, borders, poles and sizes.
        borders: Connected lines of border edges, such as mouth, eyes and neck.
        poles_by_valence: Vertices inside the surface without four edges, by their number of edges.
    """

    counts: MeshFacts
    borders: int
    poles_by_valence: dict[int, int]


def surface_facts(mesh: Mesh) -> SurfaceFacts:
    """Count what a surface is made of."""
    half = HalfEdges.of(mesh.faces, len(mesh.vertices))
    proper = half.proper
    border = proper & (half.alike + half.against == 1)
    ends = np.stack([half.start[border], half.end[border]], axis=1)
    lines = 0
    if len(ends):
        lines = len(np.unique(component_of(len(mesh.vertices), ends)[ends[:, 0]]))
    valence = np.bincount(mesh.edges.ravel(), minlength=len(mesh.vertices))
    inside = valence > 0
    inside[half.start[half.alike + half.against != 2]] = False
    inside[half.end[half.alike + half.against != 2]] = False
    values, counts = np.unique(valence[inside & (valence != 4)], return_counts=True)
    return SurfaceFacts(
        mesh_facts(mesh), lines, dict(zip(values.tolist(), counts.tolist(), strict=True))
    )


def examine_surface(mesh: Mesh, file: str) -> list[Finding]:
    """What keeps the polygons of a mesh from being a surface."""
    if not len(mesh.faces):
        return []
    half = HalfEdges.of(mesh.faces, len(mesh.vertices))
    lines = mesh.source.face_lines if mesh.source else None
    found = []
    crowded = half.proper & (half.alike + half.against > 2)
    if crowded.any():
        keys = np.unique(half.edge_keys[crowded])
        low, high = np.divmod(keys, len(mesh.vertices))
        names = listed(f"{a}-{b}" for a, b in zip(low.tolist(), high.tolist(), strict=True))
        message = f"{counted(keys, 'edge has', 'edges have')} more than two polygons: {names}"
        vertices = np.unique([low, high])
        found.append(finding("non-manifold-edges", file, message, vertices=vertices.tolist()))
    joints = _joints(half)
    if joints.size:
        message = f"{counted(joints, 'vertex joins', 'vertices join')} parts of it at a point"
        found.append(finding("non-manifold-vertices", file, message, vertices=joints.tolist()))
    found += _winding(half, file, lines)
    twice = _repeating(half)
    if twice.size:
        message = f"{counted(twice, 'polygon names', 'polygons name')} a vertex twice"
        found.append(
            finding(
                "repeated-corners",
                file,
                message,
                line=_line(twice, lines),
                vertices=_corners_of(half, twice),
            )
        )
    loose = np.flatnonzero(np.bincount(half.start, minlength=len(mesh.vertices)) == 0)
    if loose.size:
        message = f"{counted(loose, 'vertex is', 'vertices are')} on no polygon"
        found.append(finding("isolated-vertices", file, message, vertices=loose.tolist()))
    return found


def _joints(half: HalfEdges) -> NDArray[np.int64]:
    """Vertices whose polygons form several fans that share no edge."""
    proper = np.flatnonzero(half.proper)
    order = proper[np.argsort(half.edge_keys[proper], kind="stable")]
    same = half.edge_keys[order[1:]] == half.edge_keys[order[:-1]]
    first, second = order[:-1][same], order[1:][same]
    # Corners at the two ends of an edge: that of the half-edge, and the one after it.
    swap = half.start[first] != half.start[second]
    at_start = np.stack([first, np.where(swap, half.following[second], second)], axis=1)
    at_end = np.stack([half.following[first], np.where(swap, second, half.following[second])], 1)
    fans = component_of(len(half.start), np.concatenate([at_start, at_end]))
    pairs = np.unique(half.start * (int(fans.max()) + 1) + fans)
    at = pairs // (int(fans.max()) + 1)
    crowded = half.proper & (half.alike + half.against > 2)
    joints = np.unique(at[1:][at[1:] == at[:-1]])
    ends = np.concatenate([half.start[crowded], half.end[crowded]])
    return np.asarray(np.setdiff1d(joints, ends))


def _winding(half: HalfEdges, file: str, lines: NDArray[np.int32] | None) -> list[Finding]:
    """Polygons to reverse so that all neighbours run their common edge in opposite directions."""
    wrong = np.flatnonzero((half.alike == 2) & (half.against == 0) & half.proper)
    if not wrong.size:
        return []
    wrong = wrong[np.argsort(half.edge_keys[wrong], kind="stable")]
    faces = half.faces.corner_faces
    against = np.stack([faces[wrong[::2]], faces[wrong[1::2]]], axis=1).astype(np.int64)
    paired = np.flatnonzero(half.twin >= 0)
    along = np.stack([faces[paired], faces[half.twin[paired]]], axis=1).astype(np.int64)
    count = len(half.faces)
    # Each polygon twice, as it is and reversed: what is connected here must be decided together.
    ends = np.concatenate(
        [along, along + count, against + [0, count], against + [count, 0]], axis=0
    )
    part_of = component_of(2 * count, ends)
    as_is, reverse = part_of[:count], part_of[count:]
    if (as_is == reverse).any():
        one_sided = np.flatnonzero(as_is == reverse)
        message = (
            f"{len(one_sided):,} polygons form a surface with one side only, as a Möbius strip has"
        )
        vertices = _corners_of(half, one_sided)
        return [finding("inconsistent-winding", file, message, vertices=vertices)]
    # Of the two ways to agree, the one that reverses fewer polygons.
    kept = np.bincount(as_is, minlength=2 * count)
    fewer = kept[as_is] < kept[reverse]
    flipped = np.flatnonzero(fewer | ((kept[as_is] == kept[reverse]) & (as_is > reverse)))
    message = (
        f"{counted(flipped, 'polygon runs', 'polygons run')} against the others around: "
        f"{listed(flipped)}"
    )
    return [
        finding(
            "inconsistent-winding",
            file,
            message,
            line=_line(flipped, lines),
            vertices=_corners_of(half, flipped),
        )
    ]


def _repeating(half: HalfEdges) -> NDArray[np.int64]:
    """Polygons that name a vertex twice."""
    keys = half.faces.corner_faces.astype(np.int64) * half.vertex_count + half.start
    ordered = np.sort(keys)
    return np.asarray(np.unique(ordered[1:][ordered[1:] == ordered[:-1]] // half.vertex_count))


def _corners_of(half: HalfEdges, faces: NDArray[np.int64]) -> list[int]:
    chosen = np.zeros(len(half.faces), dtype=bool)
    chosen[faces] = True
    return [int(v) for v in np.unique(half.start[chosen[half.faces.corner_faces]])]


def _line(faces: NDArray[np.int64], lines: NDArray[np.int32] | None) -> int | None:
    return int(lines[faces[0]]) if lines is not None and faces.size else None
