"""Meshes with polygons in another order, or wound otherwise than neighbours, rig and inside say."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, counted, finding, listed, polygon_finding
from elastomorph.doctor.isomorphism.polygons import reversed_corners
from elastomorph.doctor.neutral import HalfEdges, Neutral
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.polygons import Polygons

# 36 π V² / A³ is 1 of a ball and 0 of a sheet. Sheets have no inside; a face mask has 0.05 and
# more, sockets of eyes 0.014, gums 0.0002.
_HOLDS = 0.005


def with_reversed(mesh: Mesh, which: NDArray[np.bool_]) -> Mesh:
    """A mesh with some polygons (F,) run the other way round; every corner keeps its texture."""
    corners = reversed_corners(mesh.faces, which)
    return Mesh(
        mesh.vertices,
        Polygons(mesh.faces.indices[corners], mesh.faces.offsets),
        uv=mesh.uv and UVMap(mesh.uv.coordinates, mesh.uv.corners[corners]),
        materials=mesh.materials,
        groups=mesh.groups,
        material_library=mesh.material_library,
        source=mesh.source,
    )


def reordered(
    neutral: Mesh, target: Mesh, new_index: NDArray[np.int64], corners: NDArray[np.int64]
) -> Mesh:
    """The target in the order of the neutral, with labels and texture of its own.

    ``new_index`` (V,) is the number in the neutral of each vertex of the target, ``corners`` (C,)
    the corner of the target for each corner of the neutral.
    """
    vertices = np.empty_like(target.vertices)
    vertices[new_index] = target.vertices
    faces = target.faces.corner_faces[corners[neutral.faces.offsets[:-1]]]
    source = target.source
    if source is not None and source.face_lines is not None:
        source = replace(source, face_lines=source.face_lines[faces])
    return Mesh(
        vertices,
        neutral.faces,
        uv=target.uv and UVMap(target.uv.coordinates, target.uv.corners[corners]),
        materials=_moved(target.materials, faces),
        groups=_moved(target.groups, faces),
        material_library=target.material_library,
        source=source,
    )


def _moved(labels: FaceLabels | None, faces: NDArray[np.int32]) -> FaceLabels | None:
    """Labels in another order of polygons; their names stay in order of first use."""
    if labels is None:
        return None
    of_face = labels.of_face[faces]
    used, firsts = np.unique(of_face[of_face >= 0], return_index=True)
    order = used[np.argsort(firsts)]
    number = np.full(len(labels.names) + 1, -1, dtype=np.int32)
    number[order] = np.arange(len(order), dtype=np.int32)
    return FaceLabels(tuple(labels.names[i] for i in order.tolist()), number[of_face])


def inconsistent_winding(neutral: Neutral, file: str) -> list[Finding]:
    """Polygons to reverse so that all neighbours run their common edge in opposite directions."""
    half, mesh = neutral.half_edges, neutral.mesh
    wrong = np.flatnonzero((half.alike == 2) & (half.against == 0) & half.proper)
    if not wrong.size:
        return []
    wrong = wrong[np.argsort(half.edge_keys[wrong], kind="stable")]
    faces = half.faces.corner_faces.astype(np.int64)
    against = np.stack([faces[wrong[::2]], faces[wrong[1::2]]], axis=1)
    paired = np.flatnonzero(half.twin >= 0)
    along = np.stack([faces[paired], faces[half.twin[paired]]], axis=1)
    count = len(half.faces)
    # Each polygon twice, as it is and reversed: what is connected here must be decided together.
    ends = np.concatenate([along, along + count, against + [0, count], against + [count, 0]])
    part_of = component_of(2 * count, ends)
    as_is, reverse = part_of[:count], part_of[count:]
    if (as_is == reverse).any():
        strip = as_is == reverse
        message = (
            f"{int(strip.sum()):,} polygons form a surface with one side only, as a Möbius strip "
            "has"
        )
        vertices = np.unique(half.start[strip[faces]])
        return [finding("inconsistent-winding", file, message, vertices=vertices)]
    # Of the two ways to agree, the one that reverses fewer polygons.
    kept = np.bincount(as_is, minlength=2 * count)
    fewer = kept[as_is] < kept[reverse]
    flipped = np.flatnonzero(fewer | ((kept[as_is] == kept[reverse]) & (as_is > reverse)))
    runs = counted(flipped, "polygon runs", "polygons run")
    message = f"{runs} against the others around: {listed(flipped)}"
    return [polygon_finding("inconsistent-winding", mesh, file, flipped, message)]


def common_reversal(own: Sequence[NDArray[np.bool_]]) -> NDArray[np.bool_] | None:
    """(F,) polygons that most targets, two at least and alike, run the other way round, or None.

    It is the neutral that is wrong there. ``own`` is (F,) for each target.
    """
    alike = Counter(which.tobytes() for which in own)
    most = max(alike, key=lambda key: alike[key], default=b"")
    if not most or alike[most] < 2 or 2 * alike[most] <= len(own):
        return None
    wrong = np.frombuffer(most, dtype=bool)
    return wrong if wrong.any() else None


def reversed_finding(
    mesh: Mesh, file: str, polygons: NDArray[np.integer], others: str = "in the neutral"
) -> Finding:
    """The finding for polygons, rising, that run the other way round than others."""
    if len(polygons) == len(mesh.faces):
        which = "every polygon runs the other way round: its normals point inwards"
    else:
        which = (
            f"{counted(polygons, 'polygon runs', 'polygons run')} the other way round than "
            f"{others}: {listed(polygons)}"
        )
    return polygon_finding("reversed-winding", mesh, file, polygons, which)


def inside_out(mesh: Mesh) -> NDArray[np.bool_]:
    """(F,) polygons of parts that enclose a volume and are wound towards it.

    Borders are closed by a fan to their middle. Only the largest part and closed ones are looked
    at: a mouth socket that is open is rightly seen from within.
    """
    if not len(mesh.faces):
        return np.zeros(0, dtype=bool)
    points, half = mesh.vertices, HalfEdges.of(mesh.faces, len(mesh.vertices))
    part_of = component_of(len(points), mesh.edges)
    number = int(part_of.max()) + 1
    centres = np.stack([np.bincount(part_of, points[:, i], number) for i in range(3)], axis=1)
    arms = points - (centres / np.bincount(part_of, minlength=number)[:, None])[part_of]
    triangles = mesh.faces.triangles()
    a, b, c = (arms[triangles[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    part = part_of[triangles[:, 0]]
    areas = np.bincount(part, np.linalg.norm(across, axis=1), number) / 2.0
    volumes = np.bincount(part, (a * across).sum(axis=1), number) / 6.0
    start, end = half.start[half.border], half.end[half.border]
    if start.size:
        loop = component_of(len(points), np.stack([start, end], axis=1))[start]
        size = np.maximum(np.bincount(loop), 1)
        middles = np.stack([np.bincount(loop, arms[start][:, i]) for i in range(3)], axis=1)
        fans = ((middles / size[:, None])[loop] * np.cross(arms[end], arms[start])).sum(axis=1)
        volumes += np.bincount(part_of[start], fans, number) / 6.0
    closed = np.bincount(part_of[half.start[half.polygons_of_edge != 2]], minlength=number) == 0
    closed[int(np.argmax(areas))] = True
    holds = 36.0 * np.pi * volumes**2 > _HOLDS * areas**3
    bad = closed & holds & (volumes < 0)
    return np.asarray(bad[part_of[mesh.faces.indices[mesh.faces.offsets[:-1]]]])
