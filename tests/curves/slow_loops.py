"""Edge loops as the definition reads, one vertex and one edge at a time, to compare with."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.mesh import Mesh

Edge = tuple[int, int]


def _edge(a: int, b: int) -> Edge:
    return (a, b) if a < b else (b, a)


def slow_straight(mesh: Mesh) -> dict[tuple[int, Edge], Edge]:
    """For each vertex and edge there, the edge that goes straight on, where there is one."""
    beside: dict[int, dict[Edge, list[Edge]]] = defaultdict(lambda: defaultdict(list))
    for polygon in map(_without_repeats, mesh.faces):
        for place, vertex in enumerate(polygon):
            following = polygon[(place + 1) % len(polygon)]
            one, other = _edge(polygon[place - 1], vertex), _edge(vertex, following)
            beside[vertex][one].extend([other] if one != other else [])
            beside[vertex][other].extend([one] if one != other else [])
    straight: dict[tuple[int, Edge], Edge] = {}
    for vertex, ring in beside.items():
        crowded = {edge for edge, others in ring.items() if len(others) > 2}
        border = {edge for edge, others in ring.items() if len(others) == 1}
        links = {
            edge: [] if edge in crowded else [other for other in others if other not in crowded]
            for edge, others in ring.items()
        }
        for edge in links:
            path, returns = _walk(links, edge)
            if returns and len(path) % 2 == 0:
                straight[vertex, edge] = path[len(path) // 2]
            elif edge in border and path[-1] in border and len(path) > 1:
                straight[vertex, edge] = path[-1]
    return straight


def _without_repeats(face: NDArray[np.int32]) -> list[int]:
    polygon = face.tolist()
    return [vertex for place, vertex in enumerate(polygon) if vertex != polygon[place - 1]]


def _walk(links: dict[Edge, list[Edge]], start: Edge) -> tuple[list[Edge], bool]:
    """The edges passed on the way around, and whether the walk came back to its start."""
    path, left = [start], {edge: list(others) for edge, others in links.items()}
    while left[path[-1]]:
        following = left[path[-1]].pop(0)
        left[following].remove(path[-1])
        if following == start:
            return path, True
        path.append(following)
    return path, False


def slow_loops(mesh: Mesh) -> set[tuple[frozenset[Edge], bool]]:
    """The edges of each loop, and whether it is closed."""
    straight = slow_straight(mesh)
    loops = set()
    for first in map(tuple, mesh.edges.tolist()):
        edges, closed = {first}, False
        for beginning, tip in (first, first[::-1]):
            edge = first
            while not closed and (tip, edge) in straight:
                edge = straight[tip, edge]
                closed = edge == first and tip == beginning
                tip = sum(edge) - tip
                edges.add(edge)
        loops.add((frozenset(edges), closed))
    return loops
