"""From captured motions to the material and the load they have in common.

    python research/material_fit.py smile1.npz smile2.npz smile3.npz [-o fit.json]

The best material and load are found, and how far each constant may be from them. Motions are fitted
together, then each time without one of them; and every curve alone.
"""

from __future__ import annotations

import argparse
import json
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import MeshError, ParameterError, TimeLawWarning, TopologyError
from elastomorph.evaluation.curve_errors import CurveVertices, curve_errors
from elastomorph.io.sequences import read_recording, whole
from elastomorph.model.mesh import require_same_topology
from elastomorph.model.sequence import MeshSequence, require_motion
from elastomorph.paths import Method, interpolate
from elastomorph.physics import CLOSURES, Load, Material
from material_results import (
    EXCURSION,
    CurveFit,
    Errors,
    Fit,
    LawSums,
    ModalSums,
    Objective,
    Ratio,
    curve_sums,
)

CONFIDENCE = 0.95
# Captures that differ by less than a millionth of the movement are the same capture.
_PRECISION = 1e-12
_GRID = 14
_APART = 1.0
_LARGEST_STEP = 1.0
_BISECTIONS = 12


class Optimum(NamedTuple):
    """A point, (R + 1,) as in `material_results`, with its misfit and penalty."""

    point: NDArray[np.float64]
    cost: float


def minimised(objective: Objective, start: NDArray[np.float64], free: NDArray[np.bool_]) -> Optimum:
    """The optimum nearest to a start, with some parameters fixed."""
    from scipy.optimize import least_squares

    low, high = objective.bounds
    point = np.clip(start, low, high)
    if not free.any():
        return Optimum(point, objective.cost(point))

    def residuals(values: NDArray[np.float64]) -> NDArray[np.float64]:
        moved = point.copy()
        moved[free] = values
        return objective.residuals(moved)

    solved = least_squares(
        residuals,
        point[free],
        bounds=(low[free], high[free]),
        xtol=1e-12,
        ftol=1e-14,
        gtol=1e-15,
        max_nfev=200,
    )
    found = point.copy()
    found[free] = solved.x
    return Optimum(found, objective.cost(found))


def best_load(objective: Objective) -> Optimum:
    """The best load for curves so stiff that all follow it: p(t)/p(1) is linear in p."""
    if objective.degree == 1:
        return Optimum(objective.bounds[0], objective.cost(objective.bounds[0]))
    sums = objective.sums
    changes = np.zeros((sums.aims.shape[1], objective.degree - 1))
    changes[0] = -1.0
    changes[np.arange(1, objective.degree), np.arange(objective.degree - 1)] = 1.0
    linear = np.zeros_like(sums.aims)
    linear[:, 0] = 1.0
    rows = (sums.factors @ changes).reshape(-1, objective.degree - 1)
    shares = np.linalg.lstsq(rows, -sums.residuals(linear).ravel(), rcond=None)[0]
    start = np.concatenate([objective.bounds[0][:2], shares])
    return minimised(objective, start, np.arange(len(start)) >= 2)


def solve(
    objective: Objective, *, starts: int = 8, near: Sequence[NDArray[np.float64]] = ()
) -> Optimum:
    """The best point from the stiff limit, from `near`, and the best of a grid of materials."""
    stiff = best_load(objective)
    free = objective.free
    if not free[:2].any():
        return stiff
    points = [stiff.point, *near, *_grid(objective, stiff.point, starts)]
    found = [stiff] + [minimised(objective, point, free) for point in points]
    inside = [one for one in found if objective.excursion(one.point) <= EXCURSION]
    return min(inside or found, key=lambda one: one.cost)


def _grid(
    objective: Objective, stiff: NDArray[np.float64], count: int
) -> list[NDArray[np.float64]]:
    """The best materials of a grid around the stiffness of the modes, none close to another."""
    b = objective.sums.stiffness[1:]
    if not (count and b.size):
        return []
    steps = np.log(np.geomspace(1e-3 * b.min(), 3.0 * b.max(), _GRID))
    points = [
        np.concatenate([[damping, mass], stiff[2:]])
        for damping in steps
        for mass in (steps if objective.free[1] else stiff[1:2])
    ]
    chosen: list[NDArray[np.float64]] = []
    for point in sorted(points, key=objective.cost):
        if all(np.abs(point[:2] - other[:2]).max() > _APART for other in chosen):
            chosen.append(point)
        if len(chosen) == count:
            break
    return chosen


def slack(objective: Objective, optimum: Optimum) -> float:
    """How much worse than the best is still as good, at 95 % and for independent residuals.

    misfit ≤ least misfit · (1 + F₁,ν / ν) with ν numbers more than parameters: the likelihood
    ratio of normal errors of unknown size.
    """
    from scipy.special import fdtri

    freedom = _degrees_of_freedom(objective)
    misfit = objective.misfit(optimum.point)
    return max(misfit * float(fdtri(1, freedom, CONFIDENCE)) / freedom, _PRECISION)


def interval(objective: Objective, optimum: Optimum, index: int) -> tuple[float, float]:
    """Where one parameter may be while the others adapt (profile likelihood), maybe infinite."""
    if not objective.free[index]:
        return -np.inf, np.inf
    free = objective.free.copy()
    free[index] = False
    limit = optimum.cost + slack(objective, optimum)
    border = [bound[index] for bound in objective.bounds]
    ends = []
    for sign, bound in zip((-1.0, 1.0), border, strict=True):
        inside, point, step = float(optimum.point[index]), optimum.point, 1e-3
        outside, bisected = np.nan, 0
        while bisected < _BISECTIONS:
            trial = point.copy()
            if not np.isnan(outside):
                trial[index] = 0.5 * (inside + outside)
                bisected += 1
            elif inside == bound:
                break
            else:
                trial[index] = np.clip(inside + sign * step, *border)
            others = minimised(objective, trial, free)
            if others.cost > limit:
                outside = float(trial[index])
            else:
                inside, point = float(trial[index]), others.point
                step = min(2.0 * step, _LARGEST_STEP)
        ends.append(sign * np.inf if np.isnan(outside) else outside)
    return ends[0], ends[1]


def load_intervals(
    objective: Objective, optimum: Optimum, free: NDArray[np.bool_]
) -> tuple[tuple[float, float], ...]:
    """Intervals of p₁ … p_R from the Jacobian at the optimum, with some parameters fixed.

    Infinite where a coefficient is not determined.
    """
    from scipy.special import stdtrit

    degree = objective.degree
    if degree == 1:
        return ((1.0, 1.0),)
    scale = np.sqrt(objective.sums.total)
    chosen = np.flatnonzero(free)
    columns = []
    for number in chosen:
        step = np.zeros(len(free))
        step[number] = 1e-6
        sides = [
            objective.sums.residuals(objective.laws(optimum.point + s * step)) for s in (1, -1)
        ]
        columns.append((sides[0] - sides[1]).ravel() / (2e-6 * scale))
    _, singular, right = np.linalg.svd(np.stack(columns, axis=1), full_matrices=False)
    freedom = _degrees_of_freedom(objective)
    variance = objective.misfit(optimum.point) / freedom
    reach = float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE))
    loads = np.zeros((degree, len(chosen)))
    shares = chosen >= 2
    loads[1:, shares] = np.eye(degree - 1)
    loads[0, shares] = -1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = (loads @ right.T) / np.where(singular > 1e-10 * singular[0], singular, 0.0)
    spread = np.nan_to_num(spread, nan=0.0, posinf=np.inf, neginf=-np.inf)
    half = reach * np.sqrt(variance * (spread**2).sum(axis=1))
    values = np.concatenate([[1.0 - optimum.point[2:].sum()], optimum.point[2:]])
    return tuple((float(v - h), float(v + h)) for v, h in zip(values, half, strict=True))


def _degrees_of_freedom(objective: Objective) -> int:
    """Numbers measured beyond those fitted."""
    return max(3 * objective.sums.count - int(objective.free.sum()), 1)


# Starts of a fit without one motion, besides the optimum of them all.
_FOLD_STARTS = 2
_UNKNOWN = Ratio(None, 0.0, float("inf"))
_STILL_SUM = 1e-18


@dataclass(frozen=True, eq=False)
class Solution:
    """One degree fitted to some motions; `stiff` is the best load for curves that all follow it."""

    objective: Objective
    optimum: Optimum
    stiff: Optimum

    @property
    def load(self) -> Load:
        """p(t) with p(1) = 1."""
        return self.objective.load(self.optimum.point)

    @property
    def method(self) -> Method:
        """The beam."""
        return Method(
            "beam",
            material=self.objective.material(self.optimum.point),
            load=self.load,
            closure=self.objective.closure,
        )

    @property
    def ease(self) -> Method:
        """The straight line at the best pace of this degree."""
        return Method("ease", load=self.objective.load(self.stiff.point))

    @property
    def laws(self) -> NDArray[np.float64]:
        """(G, K) coefficients of the law of each B."""
        return self.objective.laws(self.optimum.point)

    @property
    def rms(self) -> float:
        """RMS distance to the motions that were fitted."""
        sums = self.objective.sums
        return float(np.sqrt(sums.misfit(self.laws) / sums.count))

    @property
    def bic(self) -> float:
        """n ln(misfit) + parameters · ln n; what is exact to six digits is exact."""
        sums = self.objective.sums
        misfit = max(sums.misfit(self.laws) / sums.total, 1e-12)
        parameters = int(self.objective.free.sum())
        return float(sums.frames * np.log(misfit) + parameters * np.log(sums.frames))


@dataclass(frozen=True, eq=False)
class Validated:
    """One degree fitted to all motions, and to all but one: no folds of a single motion.

    `left_out_rms` is the RMS distance of each motion to the solution without it; NaN for one alone.
    """

    whole: Solution
    folds: tuple[Solution, ...]
    left_out_rms: float


def solved(
    parts: Sequence[LawSums],
    degree: int,
    closure: str,
    starts: int,
    near: Sequence[NDArray[np.float64]] = (),
) -> Solution:
    """All motions together."""
    sums = LawSums.together(parts)
    objective = Objective(sums, degree, closure)
    stiff = best_load(Objective(sums, degree, "limit"))
    return Solution(objective, solve(objective, starts=starts, near=near), stiff)


def validated(parts: Sequence[LawSums], degree: int, closure: str, starts: int) -> Validated:
    """All motions together, and without each of them."""
    whole = solved(parts, degree, closure, starts)
    if len(parts) < 2:
        return Validated(whole, (), float("nan"))
    others = [[*parts[:i], *parts[i + 1 :]] for i in range(len(parts))]
    fewer, near = min(starts, _FOLD_STARTS), [whole.optimum.point]
    folds = tuple(solved(fewer_parts, degree, closure, fewer, near) for fewer_parts in others)
    squared = sum(part.misfit(fold.laws) for part, fold in zip(parts, folds, strict=True))
    return Validated(whole, folds, float(np.sqrt(squared / sum(part.count for part in parts))))


@dataclass(frozen=True, eq=False)
class Constants:
    """What a solution says of material and load, and how surely.

    Ratios that nothing bounds from below are at the stiff end of their range in the solution; there
    is no material where neither ratio matters.
    """

    solution: Solution
    damping: Ratio
    mass: Ratio
    load_intervals: tuple[tuple[float, float], ...]
    material: Material | None


def constants(fitted: Validated) -> Constants:
    """Intervals of a solution; constants that may be as small as you like are made so."""
    whole = fitted.whole
    objective, optimum = whole.objective, whole.optimum
    allowed = optimum.cost + slack(objective, optimum)
    free = objective.free.copy()
    ends = [interval(objective, optimum, index) for index in (0, 1)]
    stiff = objective.bounds[0]
    for index in (1, 0):
        if np.isinf(ends[index][0]):
            smallest, others = optimum.point.copy(), free.copy()
            smallest[index], others[index] = stiff[index], False
            simpler = minimised(objective, smallest, others)
            if simpler.cost <= allowed:
                optimum, free = simpler, others
    ratios = []
    for index, (low, high) in enumerate(ends):
        known = np.isfinite(low) and np.isfinite(high)
        refits = [float(np.exp(fold.optimum.point[index])) for fold in fitted.folds]
        ratios.append(
            Ratio(
                float(np.exp(optimum.point[index])) if known else None,
                float(np.exp(low)),
                float(np.exp(high)),
                (min(refits), max(refits)) if refits and known else None,
            )
        )
    needless = objective.closure == "limit" and (optimum.point[:2] == stiff[:2]).all()
    return Constants(
        Solution(objective, optimum, whole.stiff),
        ratios[0],
        ratios[1],
        load_intervals(objective, optimum, free),
        None if needless else objective.material(optimum.point),
    )


def fit_curves(
    sums: Sequence[Sequence[ModalSums]],
    curves: CurveNetwork,
    degree: int,
    closure: str,
    starts: int,
    diameter: float,
    say: Callable[[str], None],
) -> tuple[CurveFit, ...]:
    """Each curve fitted alone: do all parts of a face have one material and one load?

    Of each motion, the sums of each curve are given.
    """
    found = []
    for number, curve in enumerate(curves):
        name = curve.name or str(number)
        say(f"curve {name} ({number + 1} of {len(curves)})")
        motions = [parts[number] for parts in sums]
        moving = [
            p for p in motions if p.displacement.sum() > _STILL_SUM * diameter**2 and len(p.times)
        ]
        if not moving:
            found.append(CurveFit(name, None, _UNKNOWN, _UNKNOWN, 0.0, 0.0, float("nan")))
            continue
        fitted = validated([LawSums.of(p, degree + 1) for p in moving], degree, closure, starts)
        known = constants(fitted)
        together = fitted.whole.objective.sums
        linear = np.zeros_like(together.aims)
        linear[:, 0] = 1.0
        found.append(
            CurveFit(
                name,
                known.solution.load,
                known.damping,
                known.mass,
                known.solution.rms / diameter,
                float(np.sqrt(together.misfit(linear) / together.count)) / diameter,
                fitted.left_out_rms / diameter,
            )
        )
    return tuple(found)


DEGREES = (1, 2, 3, 4)
HIGHEST = 6
_STILL = 1e-9
# Degrees whose errors differ by less are equally good, and the lowest of them is taken.
_ALIKE = 1e-3
_EXACT = 1e-6


def fit(
    motions: MeshSequence | Sequence[MeshSequence],
    curves: CurveNetwork | None = None,
    *,
    degree: int | None = None,
    per_curve: bool = False,
    closure: str = "limit",
    starts: int = 8,
    progress: Callable[[str], None] | None = None,
) -> Fit:
    """Estimate c/k, m/k and the load p(t) that captured motions have in common.

    The mean squared distance between the beams and the motions, over the curves' vertices and the
    frames between first and last, is made small among materials whose laws leave [0, 1], or run
    back, by 10 % of the way at most: away from resonance. First and last frames are taken as
    exact. Every motion has its own; they may be repetitions or different expressions.

    Args:
        motions: One captured motion or more, of one mesh.
        curves: The curves the beams follow; found by `extract_curves` by default.
        degree: Degree of the load, from 1 to 6. By default the smallest of 1 to 4 whose error on
            motions left out of the fit is within 0.1 % of the best; with a single motion the one of
            least Bayesian information criterion, each frame counted as one observation.
        per_curve: Also fit every curve alone.
        closure: Time law of the means, see `elastomorph.physics.mean_response`.
        starts: How many materials the search starts from, 0 or more, besides the stiff limit.
        progress: Called with what is being done.

    Raises:
        ParameterError: A setting is out of its range, there is no motion, or there are fewer
            frames than parameters.
        TopologyError: The motions have different meshes.
        CurveError: The curves belong to another mesh, or there are none.
        MeshError: A motion ends where it starts, or D is 0.
    """
    say = progress or (lambda _: None)
    _check_settings(degree, closure, starts)
    takes = _one_mesh(motions)
    network = extract_curves(takes[0].mesh) if curves is None else curves
    along = _along(takes, network)
    say("adding up the modes")
    sums = [curve_sums(take, list(network)) for take in takes]
    found = _by_degree(sums, degree, closure, starts, say)
    best, rms = _best_degree(found)
    how = "given" if degree is not None else "leave-one-out" if found[best].folds else "BIC"
    say("finding intervals")
    known = constants(found[best])
    say("measuring")
    diameter = takes[0].mesh.diameter
    alone = fit_curves(sums, network, best, closure, starts, diameter, say) if per_curve else ()
    settings: dict[str, Any] = {
        "degree": best,
        "chosen": how,
        "degree_rms": rms,
        "closure": closure,
    }
    return _measured(takes, network, along, known, found[best].folds, per_curve=alone, **settings)


def _measured(
    takes: Sequence[MeshSequence],
    network: CurveNetwork,
    along: CurveVertices,
    known: Constants,
    folds: Sequence[Solution],
    *,
    degree_rms: dict[int, float],
    **rest: Any,
) -> Fit:
    """The fit with its errors on the motions, and on each motion without it."""
    diameter = takes[0].mesh.diameter
    inside = _errors(takes, [known.solution] * len(takes), network, along, diameter)
    outside = _errors(takes, folds, network, along, diameter)
    frames = np.array([len(take) - 2 for take in takes])
    return Fit(
        material=known.material,
        load=known.solution.load,
        damping=known.damping,
        mass=known.mass,
        load_intervals=known.load_intervals,
        degree_errors={degree: rms / diameter for degree, rms in degree_rms.items()},
        excursion=known.solution.objective.excursion(known.solution.optimum.point),
        in_sample=_pooled(inside, frames),
        left_out=_pooled(outside, frames) if folds else (),
        left_out_rms=outside[:, :, 0] if folds else np.zeros((0, 3)),
        motions=len(takes),
        frames=int(frames.sum()),
        curves=len(network),
        vertices=len(along.indices),
        diameter=diameter,
        **rest,
    )


def _by_degree(
    sums: Sequence[Sequence[ModalSums]],
    degree: int | None,
    closure: str,
    starts: int,
    say: Callable[[str], None],
) -> dict[int, Validated]:
    """The loads of the degree asked for, or of all, on the sums of each motion's curves."""
    degrees = DEGREES if degree is None else (degree,)
    motions = [LawSums.of(ModalSums.joined(parts), max(degrees) + 1) for parts in sums]
    found = {}
    for each in _with_enough_frames(motions, degrees, closure):
        say(f"fitting loads of degree {each}")
        found[each] = validated(motions, each, closure, starts)
    return found


def _check_settings(degree: int | None, closure: str, starts: int) -> None:
    whole = isinstance(degree, int) and not isinstance(degree, bool)
    if degree is not None and not (whole and 1 <= degree <= HIGHEST):
        raise ParameterError(
            f"the degree of the load must be a whole number from 1 to {HIGHEST}, found {degree!r}"
        )
    if closure not in CLOSURES:
        raise ParameterError(f"closure must be one of {', '.join(CLOSURES)}, found {closure!r}")
    if not isinstance(starts, int) or starts < 0:
        raise ParameterError(f"starts must be a whole number of 0 or more, found {starts!r}")


def _one_mesh(motions: MeshSequence | Sequence[MeshSequence]) -> list[MeshSequence]:
    """The motions, if they share a mesh."""
    several = isinstance(motions, Sequence) and not isinstance(motions, str)
    takes: list[Any] = list(motions) if several else [motions]
    if not takes:
        raise ParameterError("there is no motion to fit: give at least one captured sequence")
    for number, take in enumerate(takes, start=1):
        require_motion(take, f"motion {number}")
        try:
            require_same_topology(takes[0].mesh, take.mesh)
        except TopologyError as error:
            raise TopologyError(
                f"motion {number} is of another mesh than motion 1, but a fit needs one: {error}"
            ) from error
    return takes


def _along(takes: Sequence[MeshSequence], network: CurveNetwork) -> CurveVertices:
    """The vertices of the curves, if they fit the motions and move in each."""
    count = len(takes[0].mesh.vertices)
    require_curves_of(network, count, "the first frame")
    along = CurveVertices.of(network, count)
    diameter = takes[0].mesh.diameter
    if not diameter > 0:
        raise MeshError(
            "all vertices of the first frame are at one place, so its diameter D is 0 and errors "
            "cannot be given as a fraction of it"
        )
    for number, take in enumerate(takes, start=1):
        moved = np.abs((take.frames[-1] - take.frames[0])[along.indices]).max()
        if moved <= _STILL * diameter:
            raise MeshError(
                f"motion {number} does not move: its last frame is its first one, so no path leads "
                "from one to the other; give a part that ends at the apex of a movement"
            )
    return along


def _with_enough_frames(
    motions: Sequence[LawSums], degrees: Sequence[int], closure: str
) -> tuple[int, ...]:
    """The degrees with no more parameters than frames, also when one motion is left out.

    Refused where that is no degree but the first, which has no parameters, or not the one given.
    """
    frames = [motion.frames for motion in motions]
    least = sum(frames) - (max(frames) if len(frames) > 1 else 0)
    needed = {r: int(Objective(motions[0], r, closure).free.sum()) for r in degrees}
    enough = tuple(r for r in degrees if needed[r] <= least)
    if not sum(frames) or not enough or (enough == (1,) and len(degrees) > 1):
        wanted = max(min((n for n in needed.values() if n), default=1), 1)
        without = " when one motion is left out" if len(frames) > 1 else ""
        raise ParameterError(
            f"there are {least} frames between first and last ones{without}, fewer than the "
            f"{wanted} parameters of the fit: give motions with more frames"
        )
    return enough


def _best_degree(by_degree: dict[int, Validated]) -> tuple[int, dict[int, float]]:
    """The degree to take, and the RMS by degree of motions left out (of all, for a single one)."""
    sums = next(iter(by_degree.values())).whole.objective.sums
    if not any(one.folds for one in by_degree.values()):
        best = min(by_degree, key=lambda r: by_degree[r].whole.bic)
        return best, {r: one.whole.rms for r, one in by_degree.items()}
    rms = {r: one.left_out_rms for r, one in by_degree.items()}
    alike = (1.0 + _ALIKE) * min(rms.values()) + _EXACT * math.sqrt(sums.total / sums.count)
    return min(r for r, error in rms.items() if error <= alike), rms


def _errors(
    motions: Sequence[MeshSequence],
    solutions: Sequence[Solution],
    network: CurveNetwork,
    along: CurveVertices,
    diameter: float,
) -> NDArray[np.float64]:
    """(motions, 3, 3) RMS, LME and LAE over D of linear, ease and beam, each by its solution."""
    return np.array(
        [
            [
                _method_errors(motion, method, network, along, diameter)
                for method in (Method("linear"), solution.ease, solution.method)
            ]
            for motion, solution in zip(motions, solutions, strict=False)
        ]
    )


def _method_errors(
    motion: MeshSequence,
    method: Method,
    network: CurveNetwork,
    along: CurveVertices,
    diameter: float,
) -> tuple[float, float, float]:
    """RMS, LME and LAE over D of a method between the first and the last frame."""
    with warnings.catch_warnings():
        # The fit says itself how far its laws run back.
        warnings.simplefilter("ignore", TimeLawWarning)
        morph = interpolate(motion.neutral, motion.target, method, curves=network)
    squared, largest, average = 0.0, 0.0, 0.0
    for time, captured in zip(motion.times[1:-1], motion.frames[1:-1], strict=True):
        positions = morph.at(float(time))
        mean, most = curve_errors(positions, captured, along, diameter)
        squared += float(((positions - captured)[along.indices] ** 2).sum())
        largest, average = max(largest, float(most.max())), max(average, float(mean.max()))
    count = max(len(along.indices) * (len(motion) - 2), 1)
    return float(np.sqrt(squared / count)) / diameter, largest, average


def _pooled(errors: NDArray[np.float64], frames: NDArray[np.integer]) -> tuple[Errors, ...]:
    """Over motions with so many inner frames: RMS of all frames, the mean of LME and LAE."""
    rms = np.sqrt(np.average(errors[:, :, 0] ** 2, axis=0, weights=frames))
    means = errors[frames > 0, :, 1:].mean(axis=0)
    return tuple(
        Errors(label, float(r), float(lme), float(lae))
        for label, r, (lme, lae) in zip(("linear", "ease", "beam"), rms, means, strict=True)
    )


def main(words: Sequence[str] | None = None) -> None:
    """Print what recordings have in common, and store it as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("motions", nargs="+", help="recordings of one mesh, as `evaluate` reads")
    parser.add_argument("-o", "--output", type=Path, help="JSON of what was found")
    parser.add_argument("--degree", type=int, help="of the load, 1 to 6; the best by default")
    parser.add_argument("--per-curve", action="store_true", help="also fit every curve alone")
    parser.add_argument("--closure", default="limit", choices=CLOSURES, help="law of the means")
    given = parser.parse_args(words)
    takes = [whole(motion, read_recording(motion)) for motion in given.motions]
    found = fit(takes, degree=given.degree, per_curve=given.per_curve, closure=given.closure)
    print(found.text())
    if given.output is not None:
        facts = {"sources": given.motions, **found.to_dict()}
        given.output.write_text(json.dumps(facts, indent=2, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
