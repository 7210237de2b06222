"""Recordings as what a path is fitted to: how far their frames are off straight lines.

The curves of a path are fitted to a sample of the vertices: those farthest from the straight lines,
and others spread evenly. Then every vertex is given the shapes that go best with these curves.
Vertices are looked at in blocks, so that long recordings of dense meshes need little memory beside
their own.

Bends may be recorded frames. The bend of a frame is how far it is off the straight path, so that an
artist can sculpt or clean the scan it comes from. Which frames: those whose shapes, with the best
splines for them, leave the least sum of squares, found one after the other and then exchanged while
that helps. All that is needed of the vertices is the matrix of the products of frames.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.evaluation.curve_errors import CurveVertices
from elastomorph.fitting.path_fit import (
    Observed,
    PathFit,
    Splines,
    fitted,
    unexplained,
    worst_mended,
)
from elastomorph.model.sequence import MeshSequence

Floats = NDArray[np.float64]

_RIDGE = 1e-9


def best_recorded(seen: Observed, splines: Splines, count: int) -> list[int]:
    """So many frames whose offsets are the best shapes, in their order."""
    offsets = seen.offsets if seen.counted is None else seen.offsets * seen.counted[:, None]
    rows = offsets.reshape(len(offsets), -1)
    if seen.fixed is not None:
        rows = np.concatenate([rows, seen.fixed.reshape(1, -1)])
    products = rows @ rows.T
    basis = np.linalg.qr(splines.values)[0]
    told = basis.T @ products[: len(offsets)]
    always = [len(offsets)] if seen.fixed is not None else []

    def explained(frames: list[int]) -> float:
        own = always + frames
        grams = products[np.ix_(own, own)]
        grams = grams + _RIDGE * np.trace(grams) * np.eye(len(own))
        return float(np.einsum("mi,mi->", told[:, own], np.linalg.solve(grams, told[:, own].T).T))

    inner = range(1, len(offsets) - 1)
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(max(set(inner) - set(chosen), key=lambda f: explained([*chosen, f])))
    known, better = explained(chosen), True
    while better:
        better = False
        for place in range(count):
            others = [f for k, f in enumerate(chosen) if k != place]
            best = max(set(inner) - set(others), key=lambda f: explained([*others, f]))
            if (found := explained([*others, best])) > known * (1 + 1e-12):
                chosen, known, better = [*others, best], found, True
    return sorted(chosen)


Vertices = NDArray[np.int64] | slice

# So many vertices times frames are fitted at once, and looked at at once.
_SAMPLE, _BLOCK = 150_000, 600_000
_LEAST_SAMPLE = 256
KNOTS, MOST_KNOTS = 7, 64
_NOTHING = 1e-9  # Of D: curves that leave no more are not what limits a path
# Vertices that turn out worse than the sample by this join it, so often at most.
_WORSE, _MORE_ROUNDS = 1.02, 2


@dataclass(frozen=True, eq=False)
class Recordings:
    """One recording or several, each with its ends and the moments of its frames on the path."""

    takes: Sequence[MeshSequence]
    moments: Sequence[Floats]  # (T,) of each, from 0 to 1
    along: CurveVertices
    counted: NDArray[np.bool_] | None = None  # (T, V) of all frames together
    paced: bool = True  # Whether Δ has a curve of its own; for one recording only
    units: Sequence[float] = (1.0,)  # What the errors of each are counted in

    @property
    def diameter(self) -> float:
        """D of the first recording, in the unit of the vertices."""
        return self.takes[0].mesh.diameter

    @property
    def vertex_count(self) -> int:
        """V."""
        return len(self.takes[0].mesh.vertices)

    @property
    def times(self) -> Floats:
        """(T,) the moments of all frames together."""
        return np.concatenate(self.moments)

    def observed(self, vertices: Vertices) -> Observed:
        """What some vertices do, in fractions of D."""
        offsets = np.concatenate(
            [
                _offsets(take, moments, vertices, self.diameter)
                for take, moments in zip(self.takes, self.moments, strict=True)
            ]
        )
        frames = self.takes[0].frames
        delta = (frames[-1, vertices] - frames[0, vertices]).T / self.diameter
        unit = np.repeat(self.units, [len(take) for take in self.takes])[:, None]
        counted = None if self.counted is None else self.counted[:, vertices].astype(np.float64)
        means = _means(self.along, self.vertex_count)[:, vertices]
        sizes = np.asarray(means.sum(axis=1)).ravel()
        some = sizes > 0
        means = means[some].multiply(1 / sizes[some, None]).tocsr()
        return Observed(offsets, delta if self.paced else None, counted, means, unit)

    def blocks(self) -> Iterator[NDArray[np.int64]]:
        """All vertices, some at a time."""
        step = max(1, _BLOCK // len(self.times))
        for start in range(0, self.vertex_count, step):
            yield np.arange(start, min(start + step, self.vertex_count))

    @cached_property
    def sampled(self) -> Observed:
        """What the sample does."""
        return self.observed(self.sample)

    @cached_property
    def sample(self) -> NDArray[np.int64]:
        """Vertices of curves to fit to: all, or those farthest from straight and some others."""
        known = np.unique(self.along.indices)
        room = max(_LEAST_SAMPLE, _SAMPLE // len(self.times))
        if room >= len(known):
            return known
        blocks = [self.observed(own).straight.max(axis=0) for own in self.blocks()]
        order = np.argsort(-np.concatenate(blocks)[known], kind="stable")
        farthest, others = known[order[: room // 2]], np.sort(known[order[room // 2 :]])
        evenly = np.linspace(0, len(others) - 1, room - len(farthest)).astype(np.int64)
        return np.union1d(farthest, others[evenly])


def enough_knots(recordings: Recordings, count: int, knots: int | None) -> tuple[int, bool]:
    """How many knots the curves of so many shapes have, and whether they are the limit.

    They are where curves on them leave more of the squares, with any number of shapes, than so many
    shapes leave with any curves. By default there are as many as it takes for that not to be so.
    """
    seen = recordings.sampled
    bar = unexplained(seen, None, count)
    least = max(KNOTS, count - 2)
    for number in range(least, MOST_KNOTS + 1) if knots is None else (knots,):
        basis = Splines.at(recordings.times, number).values
        if within := not basis.shape[1] or unexplained(seen, basis, count) <= bar + _NOTHING:
            break
    return number, not within


def path_through(
    recordings: Recordings,
    splines: Splines,
    count: int,
    *,
    recorded: bool = False,
    start: tuple[PathFit, Splines] | None = None,
) -> PathFit:
    """The path of so many shapes, over all vertices, that follows all recordings best.

    It starts at one of fewer shapes, on other splines of the same frames, where that is given.
    """
    # Nothing was recorded between the ends, or nothing is asked for.
    if not splines.values.shape[1] or not (count or recordings.paced):
        none = np.zeros((0, 3, recordings.vertex_count))
        return PathFit(np.zeros((0, 0)), none, 0.0, 0.0, paced=False)
    sample, seen = recordings.sample, recordings.sampled
    if recorded:
        return _of_frames(recordings, splines, seen, best_recorded(seen, splines, count))
    first = None
    if start is not None and len(start[0].weights):
        fewer, other = start
        own: Floats = np.linalg.pinv(splines.values) @ other.values @ fewer.weights
        first = replace(fewer, weights=own, shapes=fewer.shapes[:, :, sample])
    fit = fitted(seen, splines, count, first)
    for more in range(_MORE_ROUNDS + 1):
        if len(sample) == recordings.vertex_count:
            return _less_of_delta(fit)
        whole, worst = _to_all(recordings, splines, fit, sample)
        worse = np.flatnonzero(worst > _WORSE * fit.largest)
        unseen = np.setdiff1d(np.intersect1d(worse, recordings.along.indices), sample)
        if not len(unseen) or more == _MORE_ROUNDS:
            break
        worst_first = unseen[np.argsort(-worst[unseen], kind="stable")]
        sample = np.union1d(sample, worst_first[:_LEAST_SAMPLE])
        first = replace(whole, shapes=whole.shapes[:, :, sample])
        fit = fitted(recordings.observed(sample), splines, count, first)
    return _less_of_delta(whole)


def _less_of_delta(fit: PathFit) -> PathFit:
    """The same path, all that its shapes have of Δ given to the curve of Δ."""
    if not fit.paced:
        return fit
    fixed = fit.shapes[0]
    shares = np.einsum("sxn,xn->s", fit.shapes, fixed) / np.square(fixed).sum()
    shares[0] = 0.0
    weights = fit.weights.copy()
    weights[:, 0] += fit.weights @ shares
    return replace(fit, weights=weights, shapes=fit.shapes - shares[:, None, None] * fixed)


def _of_frames(
    recordings: Recordings, splines: Splines, seen: Observed, frames: list[int]
) -> PathFit:
    """The path whose shapes are the offsets of some frames."""
    fit = fitted(seen, splines, len(frames), shapes=seen.recorded(frames))
    every = [recordings.observed(own).recorded(frames) for own in recordings.blocks()]
    return replace(fit, shapes=np.concatenate(every, axis=2))


def _to_all(
    recordings: Recordings, splines: Splines, fit: PathFit, sample: NDArray[np.int64]
) -> tuple[PathFit, Floats]:
    """The path with shapes for all vertices, and (V,) the largest error of each."""
    shapes = np.empty((len(fit.shapes), 3, recordings.vertex_count))
    worst = np.empty(recordings.vertex_count)
    curves = splines.values @ fit.weights
    for own in recordings.blocks():
        seen = recordings.observed(own)
        shapes[:, :, own], worst[own] = worst_mended(seen, curves, fit.largest)
    shapes[:, :, sample] = fit.shapes
    return replace(fit, shapes=shapes), worst


def _offsets(take: MeshSequence, moments: Floats, vertices: Vertices, diameter: float) -> Floats:
    """(T, 3, N) how far frames are off the straight line at their moments."""
    part = take.frames[:, vertices].transpose(0, 2, 1) / diameter
    first, last = part[0].copy(), part[-1].copy()
    part -= first + moments[:, None, None] * (last - first)
    part[[0, -1]] = 0.0
    return part


def _means(along: CurveVertices, vertex_count: int) -> Any:
    """(C, V) sparse ones where a vertex is on a curve."""
    from scipy.sparse import csr_array

    bounds = np.append(along.starts, len(along.indices))
    ones = np.ones(len(along.indices))
    return csr_array((ones, along.indices, bounds), shape=(len(along.counts), vertex_count))
