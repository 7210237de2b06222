"""Pair bends: what keeps together the paths of two targets that meet, as jawOpen and mouthClose.

Each of two paths is right by itself, and their bends add. Where their straight parts cancel, as
where one closes the lips that the other opens, little is left but the bends. A pair bend is the
difference of paths::

    P(m) = bend of the path to both - bend of the one - bend of the other,   m = min(a, b)

It has no shape of its own (Δ = 0) and moves nothing where one of both sliders is at 0, so that
single sliders stay what they are, and where both are at m the face is on the path to both.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from elastomorph.blas_threads import in_own_threads
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Choice, Morph
from elastomorph.rig.laws import Corrective

Floats = NDArray[np.float64]

RATIO = 2.5
"""Two paths meet where their bends depart from linear this many times farther than their straight
parts together move: lips that open and close have 3 to 6, no other two shapes of ARKit's more than
2.8."""

_VERTICES = 10
"""On so many vertices."""

_LEVELS = np.arange(1, 9) / 8.0
"""Weights of both sliders at which it is looked for."""

_STILL = 1e-4
"""Vertices that a pair bend moves by less, as a fraction of D, it does not move: paths are held no
closer, and where each of three is off by a little there is always some difference."""

_NOTHING = 1e-3
"""What bends depart by less, as a fraction of D, nobody sees; nor does the ratio to less count."""


def is_pair_bend(morph: Morph) -> bool:
    """Whether a morph has bends and no shape."""
    return bool(len(morph.bends)) and not morph.delta.any()


@dataclass(frozen=True, eq=False)
class _Moved:
    """A path where it moves anything: at rising vertices (N,)."""

    vertices: NDArray[np.intp]
    delta: Floats  # (N, 3)
    bent: Floats  # (8, N, 3) how far it is from linear at each level
    farthest: Floats  # (N,) how far at most
    share: Floats  # (N,) how far at most, over how far its straight part is there

    @classmethod
    def of(cls, morph: Morph) -> _Moved:
        moves = np.linalg.norm(morph.delta, axis=1)
        vertices = np.flatnonzero(moves > 0)
        weights = [curve(_LEVELS) for curve in morph.bend_curves]
        rows = np.array(weights).reshape(len(weights), len(_LEVELS)).T
        delta, bent = morph.delta[vertices], np.tensordot(rows, morph.bends[:, vertices], axes=1)
        lengths = np.linalg.norm(bent, axis=2)
        share = (lengths / _LEVELS[:, None]).max(axis=0) / moves[vertices]
        return cls(vertices, delta, bent, lengths.max(axis=0), share)


def _ratio(one: _Moved, other: _Moved, scale: float) -> float:
    """How many times farther bends depart than the straight sum moves: that of the tenth vertex."""
    _, at, to = np.intersect1d(one.vertices, other.vertices, True, return_indices=True)
    # Straight parts at an angle θ of more than a right one leave at least |Δ| sin θ of either, at
    # less none of them is shortened: only where little is left can the ratio be large.
    ends = one.delta[at], other.delta[to]
    cosine = np.einsum("ij,ij->i", *ends) / np.prod([np.linalg.norm(d, axis=1) for d in ends], 0)
    sine = np.sqrt(np.clip(1.0 - np.minimum(cosine, 0.0) ** 2, 1e-12, 1.0))
    some = one.share[at] + other.share[to] > RATIO * sine
    some &= one.farthest[at] + other.farthest[to] > _NOTHING * scale
    at, to = at[some], to[some]
    if len(at) < _VERTICES:
        return 0.0
    largest = np.zeros(len(at))
    for s, bent in zip(_LEVELS, one.bent[:, at], strict=True):
        for t, more in zip(_LEVELS, other.bent[:, to], strict=True):
            departs = np.linalg.norm(bent + more, axis=1)
            moves = np.linalg.norm(s * one.delta[at] + t * other.delta[to], axis=1)
            ratio = departs / np.maximum(moves, _NOTHING * scale)
            np.maximum(largest, np.where(departs > _NOTHING * scale, ratio, 0.0), out=largest)
    return float(np.partition(largest, -_VERTICES)[-_VERTICES])


def pair_bends(
    neutral: Mesh,
    morphs: Mapping[str, Morph],
    correctives: Mapping[str, Corrective],
    to: Callable[[Mesh], Morph],
    extent: float,
    among: Collection[str],
    say: Callable[[str], None] = lambda _: None,
    anew: Collection[str] | None = None,
) -> tuple[dict[str, Morph], dict[str, Corrective]]:
    """The pair bends of the paths that meet, and what drives each, by their names.

    Args:
        neutral: Where all paths begin.
        morphs: The paths of the rig.
        correctives: Those of them that others drive.
        to: Makes a path, as those were made that are looked at.
        extent: D.
        among: Names of the paths that are looked at.
        say: Told what is being made.
        anew: One of a pair at least is among these; by default all pairs are looked at.
    """
    moved = {n: _Moved.of(m) for n, m in morphs.items() if n in among and m.delta.any()}
    # Of a corrective its drivers decide where it is, and with what it meets.
    free = [name for name in moved if name not in correctives]
    ratios = {
        pair: _ratio(moved[pair[0]], moved[pair[1]], extent or 1.0)
        for pair in combinations(free, 2)
        if anew is None or not {*pair}.isdisjoint(anew)
    }
    found = [pair for pair, ratio in ratios.items() if ratio > RATIO]
    made: dict[tuple[str, str], Morph] = {}

    def make(task: tuple[int, tuple[str, str]]) -> None:
        number, pair = task
        one, other = (morphs[name] for name in pair)
        say(f"the path to {' and '.join(pair)}, {number} of {len(found)} that meet")
        made[pair] = _pair(neutral, one, other, to, ratios[pair], extent)

    in_own_threads(make, enumerate(found, start=1))
    names = _new_names(found, morphs)
    named = {name: pair for name, pair in zip(names, found, strict=True) if len(made[pair].bends)}
    laws = {name: Corrective(pair, "min") for name, pair in named.items()}
    return {name: made[pair] for name, pair in named.items()}, laws


def _new_names(pairs: Iterable[tuple[str, str]], taken: Collection[str]) -> Iterator[str]:
    known = set(taken)
    for pair in pairs:
        name = "_".join(pair)
        while name in known:
            name += "_"
        known.add(name)
        yield name


def _pair(
    neutral: Mesh,
    one: Morph,
    other: Morph,
    to: Callable[[Mesh], Morph],
    ratio: float,
    extent: float,
) -> Morph:
    both = to(neutral.with_vertices(neutral.vertices + one.delta + other.delta))
    bends: dict[tuple[bytes, bytes], tuple[BendCurve, Floats]] = {}
    for morph, sign in ((both, 1.0), (one, -1.0), (other, -1.0)):
        for curve, bend in zip(morph.bend_curves, morph.bends, strict=True):
            key = curve.breaks.tobytes(), curve.coefficients.tobytes()
            known = bends.get(key, (curve, np.zeros_like(bend)))[1]
            bends[key] = curve, known + sign * bend
    kept = [(curve, bend) for curve, bend in bends.values() if bend.any()]
    fields = np.array([bend for _, bend in kept]).reshape(-1, *neutral.vertices.shape)
    moves = np.zeros(len(neutral.vertices))
    for curve, bend in kept:
        moves += curve.height * np.linalg.norm(bend, axis=1)
    still = moves < _STILL * extent
    dropped = float(moves[still].max(initial=0.0)) / (neutral.diameter or 1.0)
    fields[:, still] = 0.0
    return Morph(
        neutral,
        neutral,
        fields,
        tuple(curve for curve, _ in kept),
        method="pair",
        bake_error=both.bake_error + one.bake_error + other.bake_error + dropped,
        choice=Choice(float(moves.max()) / (extent or 1.0), 0.0, exact=False, meeting=ratio),
    )
