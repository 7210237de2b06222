"""The choice of runs as its definition reads, with sets and lists, to compare with."""

from __future__ import annotations

from elastomorph.curves.extraction import Chains

Run = tuple[list[int], bool]


def slow_choice(loops: Chains, taken: set[int]) -> list[Run]:
    """The runs chosen, each with whether it is closed."""
    strands = [
        _from_longest_part(items.tolist(), closed)
        for items, closed in zip(loops.arrays(), loops.closed.tolist(), strict=True)
    ]
    chosen: list[Run] = []
    while True:
        runs = [run for strand in strands for run in _candidates(strand, taken)]
        runs = [run for run in runs if len(run[0]) >= 3]
        if not runs:
            return chosen
        through: dict[int, int] = {}
        for vertices, closed in runs:
            for vertex in vertices:
                through[vertex] = through.get(vertex, 0) + closed * len(vertices)
        keys = []
        for number, (vertices, closed) in enumerate(runs):
            crossed = sum(through[v] - len(vertices) for v in vertices) if closed else 0
            keys.append((not closed, crossed, -len(vertices), min(vertices), number))
        best: dict[int, tuple[bool, int, int, int, int]] = {}
        for key, (vertices, _) in zip(keys, runs, strict=True):
            for vertex in vertices:
                best[vertex] = min(key, best.get(vertex, key))
        for key, run in zip(keys, runs, strict=True):
            if all(best[vertex] == key for vertex in run[0]):
                chosen.append(run)
                taken |= set(run[0])


def _from_longest_part(vertices: list[int], closed: bool) -> Run:
    """A closed loop through a vertex twice starts where most of it passes none twice."""
    count = len(vertices)
    if not closed or len(set(vertices)) == count:
        return vertices, closed
    twice = vertices * 2
    extents = [_extent_back(twice, last) for last in range(2 * count)]
    last = extents.index(max(extents))
    first = (last - extents[last] + 1) % count
    return vertices[first:] + vertices[:first], closed


def _extent_back(vertices: list[int], last: int) -> int:
    """How many vertices up to the last one are all different."""
    seen: set[int] = set()
    for vertex in reversed(vertices[: last + 1]):
        if vertex in seen:
            break
        seen.add(vertex)
    return len(seen)


def _candidates(strand: Run, taken: set[int]) -> list[Run]:
    vertices, closed = strand
    gone = [place for place, vertex in enumerate(vertices) if vertex in taken]
    if closed and not gone:
        simple = len(set(vertices)) == len(vertices)
        return [(vertices, True) if simple else (_longest_simple(vertices), False)]
    if closed:
        after = gone[-1] + 1
        vertices = vertices[after:] + vertices[:after]
    runs: list[list[int]] = [[]]
    for vertex in vertices:
        if vertex in taken:
            runs.append([])
        else:
            runs[-1].append(vertex)
    return [(_longest_simple(run), False) for run in runs if run]


def _longest_simple(run: list[int]) -> list[int]:
    extents = [_extent_back(run, last) for last in range(len(run))]
    last = extents.index(max(extents))
    return run[last - extents[last] + 1 : last + 1]
