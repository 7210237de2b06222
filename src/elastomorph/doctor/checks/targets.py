"""What targets do: nothing, the same as another, jump, shiver, or contain another one."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import extract_curves
from elastomorph.doctor.checks.sides import sided_pairs
from elastomorph.doctor.findings import Finding, counted, finding, listed, percent
from elastomorph.doctor.neutral import STILL_SHARE, Neutral
from elastomorph.doctor.settings import BeamSettings
from elastomorph.errors import (
    ElastomorphError,
    ElastomorphWarning,
    ResonanceError,
    TimeLawWarning,
)
from elastomorph.model.mesh import Mesh
from elastomorph.paths.arc import local_rotations
from elastomorph.paths.rotation import rotation_path
from elastomorph.paths.rotations import ArcBend
from elastomorph.physics import BeamModes, Load

Motions = NDArray[np.float64]

# A vertex alone leaves the mean of its neighbours as far as their median; the mean is cheap, so
# only vertices that leave it by this part of the threshold are looked at closely.
_WORTH_A_LOOK = 0.5

# Vertices that a target moves by at least this part of its largest motion are compared, so many.
_MOVED = 0.1
_SAMPLE = 1500
# Equal means equal but for rounding: within this part of the motion, and of the face.
_EQUAL, _ROUNDING = 2e-3, 3e-6
# A target that others make up but for this part of its motion is a combination of them.
_COMBINED = 0.05
_WEIGHT = 0.1
# Weights this near to 1 are 1: all of the other target.
_ALL = 0.02


def scrambled_vertices(neutral: Neutral, target: Mesh, file: str) -> list[Finding]:
    """Vertices renumbered while the polygons were not: half of the edges are far longer."""
    edges = neutral.mesh.edges
    before, after = (
        np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
        for mesh in (neutral.mesh, target)
    )
    known = before > 0
    times = float(np.median(after[known] / before[known])) if known.any() else 0.0
    if times <= neutral.limits.torn:
        return []
    message = (
        f"the polygons are those of the neutral, but half of the edges are more than {times:.2g} "
        "times longer: the vertices are in another order under the same polygons"
    )
    return [finding("scrambled-vertices", file, message)]


def does_nothing(neutral: Neutral, target: Mesh, file: str) -> list[Finding]:
    """Whether a target moves no vertex."""
    farthest = float(np.abs(neutral.moved(target)).max())
    if farthest > neutral.limits.nothing * neutral.scale:
        return []
    message = "it is the neutral" if farthest == 0 else "it differs from the neutral by rounding"
    return [finding("does-nothing", file, message)]


def jumping_vertices(neutral: Neutral, target: Mesh, file: str) -> list[Finding]:
    """Vertices that jump away from neighbours that agree among themselves."""
    limits, around, moved = neutral.limits, neutral.neighbours, neutral.moved(target)
    off, edge = around.off_mean(moved), around.edge
    indices, starts = around.adjacent.indices, around.adjacent.indptr
    # Of vertices that are all a little off, the one that is farthest does not jump.
    noise = limits.jump_noise * float(np.quantile(off, STILL_SHARE))
    least = np.maximum(limits.jump * edge, noise)
    jumping, far = [], 0.0
    for vertex in np.flatnonzero((off > _WORTH_A_LOOK * least) & (around.valence >= 3)).tolist():
        theirs = moved[indices[starts[vertex] : starts[vertex + 1]]]
        median = np.median(theirs, axis=0)
        leap = float(np.linalg.norm(moved[vertex] - median))
        spread = float(np.median(np.linalg.norm(theirs - median, axis=1)))
        clearly = limits.jump_clearly * edge[vertex] * spread
        alone = leap > limits.jump_alone * spread and leap**2 > clearly
        if alone and leap > least[vertex]:
            jumping.append(vertex)
            far = max(far, leap)
    if not jumping:
        return []
    message = (
        f"{counted(jumping, 'vertex leaves its', 'vertices leave their')} neighbours by up to "
        f"{percent(far / neutral.scale)} of D: {listed(jumping)}"
    )
    return [finding("jumping-vertices", file, message, vertices=jumping)]


def roughness(neutral: Neutral, target: Mesh) -> float:
    """How far, in mean edges, the smoothest quarter of the vertices leaves their neighbours' mean.

    An expression rests, or moves smoothly, in more than a quarter of the face; noise is everywhere.
    """
    around = neutral.neighbours
    joined = around.edge > 0
    if not joined.any():
        return 0.0
    off = around.off_mean(neutral.moved(target))
    return float(np.quantile(off[joined] / around.edge[joined], STILL_SHARE))


def noisy_targets(neutral: Neutral, targets: Mapping[str, Mesh]) -> list[Finding]:
    """Targets, by file, that are noisier than the others.

    Where most targets are noisy, that is how the face was captured and no fault of one of them.
    """
    rough = {file: roughness(neutral, mesh) for file, mesh in targets.items()}
    usual = float(np.median(list(rough.values()))) if len(rough) > 1 else 0.0
    least = max(neutral.limits.noise, neutral.limits.noise_alone * usual)
    return [
        finding(
            "noise",
            file,
            "three quarters of its vertices leave the mean of their neighbours by more than "
            f"{percent(own)} of an edge, where a clean target rests or moves smoothly",
        )
        for file, own in rough.items()
        if own > least
    ]


def duplicate_targets(neutral: Neutral, targets: Mapping[str, Mesh]) -> list[Finding]:
    """Targets, by file, of the same shape as one before."""
    if len(targets) < 2:
        return []
    limit, files = neutral.limits.nothing * neutral.scale, list(targets)
    # A few sums over all coordinates differ wherever shapes do; only where they are close is it
    # worth to compare all vertices. The weights sum to at most 1, so sums differ less than shapes.
    count = neutral.mesh.vertices.size
    weights = np.random.default_rng(0).uniform(-1.0, 1.0, (4, count)) / count
    sums = np.stack([weights @ mesh.vertices.ravel() for mesh in targets.values()])
    found = []
    for late in range(1, len(files)):
        near = np.flatnonzero(np.abs(sums[:late] - sums[late]).max(axis=1) <= limit)
        for early in near.tolist():
            difference = targets[files[early]].vertices - targets[files[late]].vertices
            if float(np.abs(difference).max()) <= limit:
                message = f"the same shape as {Path(files[early]).name}"
                found.append(finding("duplicate-targets", files[late], message))
                break
    return found


def baked_targets(
    neutral: Neutral,
    targets: Mapping[str, Mesh],
    sides: Sequence[tuple[str, str]],
    name_of: Callable[[str], str],
) -> list[Finding]:
    """Targets, by file, in which another one is baked: a smile sculpted while the jaw was open."""
    moved = {file: neutral.moved(mesh) for file, mesh in targets.items()}
    near, same = _ROUNDING * neutral.scale, neutral.limits.nothing * neutral.scale
    inside: dict[str, list[tuple[str, float]]] = {file: [] for file in moved}
    # Of two that contain each other, the one that moves more vertices, then farther, is the whole.
    reach = {
        file: (int((np.abs(own) > near).any(axis=1).sum()), float((own**2).sum()))
        for file, own in moved.items()
    }
    for part, own in moved.items():
        lengths = np.linalg.norm(own, axis=1)
        some = np.flatnonzero(lengths > max(_MOVED * lengths.max(), near))
        some = some[:: max(1, -(-len(some) // _SAMPLE))]
        for whole in moved if some.size else ():
            if whole == part:
                continue
            weight, share = _contained(moved[whole][some], own[some], near)
            partly = _WEIGHT <= weight < 1.0 - _ALL
            wholly = abs(weight - 1.0) <= _ALL and reach[whole] > reach[part]
            if not (partly or wholly) or share < neutral.limits.baked:
                continue
            if float(np.abs(moved[whole] - own).max()) > same:
                inside[whole].append((part, weight))

    is_combination = cache(lambda file: _is_combination(file, moved, sides, name_of))
    found = []
    for whole, parts in inside.items():
        parts = [part for part in parts if not is_combination(part[0])]
        if not parts or is_combination(whole):
            continue
        words = " and ".join(
            name_of(part) + ("" if abs(weight - 1.0) <= _ALL else f" ({percent(weight)} of it)")
            for part, weight in parts
        )
        wholly = any(weight >= 1.0 - _ALL for _, weight in parts)
        message = f"contains {words}: used together, it counts twice"
        found.append(
            finding("baked-in-target", whole, message, severity=None if wholly else "note")
        )
    return found


def _contained(whole: Motions, part: Motions, near: float) -> tuple[float, float]:
    """How much of a part a whole contains: its weight, and the share of it that is there."""
    squares = (part**2).sum(axis=1)
    weights = np.sort((whole * part).sum(axis=1) / squares)
    # The weight that a quarter agrees on: the rest of it also moves by what the whole does itself.
    quarter = -(-len(weights) // 4)
    first = int(np.argmin(weights[quarter - 1 :] - weights[: len(weights) - quarter + 1]))
    weight = float(np.median(weights[first : first + quarter]))
    lengths = np.sqrt(squares)
    off = np.linalg.norm(whole - weight * part, axis=1)
    same = off <= _EQUAL * abs(weight) * lengths + near
    return weight, float(lengths[same].sum() / lengths.sum())


def _is_combination(
    whole: str,
    moved: Mapping[str, Motions],
    sides: Sequence[tuple[str, str]],
    name_of: Callable[[str], str],
) -> bool:
    """Whether a target is made up of several others and nothing of its own, as combinations are.

    Two are only counted as such if they are the left and the right of one expression.
    """
    from scipy.optimize import nnls

    others = [file for file in moved if file != whole and moved[file].any()]
    basis = np.stack([moved[file].ravel() for file in others], axis=1)
    goal = moved[whole].ravel()
    weights, _ = nnls(basis.T @ basis, basis.T @ goal)
    if np.linalg.norm(basis @ weights - goal) > _COMBINED * np.linalg.norm(goal):
        return False
    used = [name_of(file) for file, own in zip(others, weights, strict=True) if own > _WEIGHT]
    return len(used) > 2 or bool(sided_pairs(used, sides)[0])


# How it will move: targets that turn, and a material on the curves of the face.

# The middle of an arc is off its chord by at most this part of the chord, for turns up to 90°.
_SAGITTA = np.tan(np.pi / 8) / 2
_RINGS = 2
_TIMES = np.linspace(0.0, 1.0, 17)
_IN_BETWEENS = (0.25, 0.375, 0.5, 0.625, 0.75)


def in_between_pays(neutral: Neutral, target: Mesh, file: str) -> list[Finding]:
    """Whether an in-between would pay, where, and how much.

    Targets are screened first: motions too short to bend so far, then arcs vertex by vertex, a
    larger guess of how far the whole surface bends.
    """
    if not len(target.faces):
        return []
    chords, limit = neutral.moved(target), neutral.limits.bend * neutral.scale
    if _SAGITTA * float(np.linalg.norm(chords, axis=1).max()) <= limit:
        return []
    mesh = neutral.mesh
    with warnings.catch_warnings():
        # Vertices on no polygon have a finding of their own.
        warnings.simplefilter("ignore", ElastomorphWarning)
        rotations = local_rotations(mesh, target, neutral.around, _RINGS)
        arcs = ArcBend.of(chords, rotations.vectors).at(0.5)
        if float(np.linalg.norm(arcs, axis=1).max()) <= limit:
            return []
        try:
            path = rotation_path(mesh, target, around=neutral.around, surface=neutral.surface)
        except ElastomorphError:  # no polygon has an area: a finding of its own
            return []
    off = np.linalg.norm(path(0.5) - (mesh.vertices + 0.5 * chords), axis=1)
    most, vertex = float(off.max()), int(off.argmax())
    if most <= limit:
        return []
    bending = off > 0.1 * limit
    time, left = _best_in_between(path, mesh.vertices[bending], chords[bending], bending)
    message = (
        f"at t = 0.5 the straight path is off the turning one by {percent(most / neutral.scale)} "
        f"of D (vertex {vertex}); an in-between at t = {time:g} leaves "
        f"{percent(left / neutral.scale)}"
    )
    return [finding("in-between-pays", file, message, vertices=(vertex,))]


def _best_in_between(
    path: Callable[[float], NDArray[np.float64]],
    start: NDArray[np.float64],
    chords: NDArray[np.float64],
    bending: NDArray[np.bool_],
) -> tuple[float, float]:
    """The time of the in-between that leaves least, and the distance it leaves at any time."""
    bends = np.stack([path(float(t))[bending] - start - t * chords for t in _TIMES])
    left = {}
    for time in _IN_BETWEENS:
        peak = bends[int(np.searchsorted(_TIMES, time))]
        share = np.minimum(_TIMES / time, (1.0 - _TIMES) / (1.0 - time))
        off = np.linalg.norm(bends - share[:, None, None] * peak, axis=2)
        left[time] = float(off.max())
    best = min(left, key=lambda time: (left[time], abs(time - 0.5)))
    return best, left[best]


def examine_material(neutral: Mesh, file: str, beam: BeamSettings) -> list[Finding]:
    """Try the material on every mode of every curve of the neutral."""
    network = extract_curves(neutral)
    curves = [(np.asarray(curve.vertices), curve.closed) for curve in network.curves]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", TimeLawWarning)
        try:
            BeamModes.prepare(curves, beam.material, Load.power(beam.order), closure=beam.closure)
        except ResonanceError as error:
            return [finding("resonant-material", file, str(error))]
    laws = (str(w.message) for w in caught if issubclass(w.category, TimeLawWarning))
    return [finding("overshooting-material", file, message) for message in dict.fromkeys(laws)]
