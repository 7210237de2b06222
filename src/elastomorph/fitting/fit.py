"""From captured motions to the material and the load they have in common."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import MeshError, ParameterError, TimeLawWarning, TopologyError
from elastomorph.evaluation.curve_errors import CurveVertices, curve_errors
from elastomorph.fitting.cross_validation import (
    Constants,
    Solution,
    Validated,
    constants,
    fit_curves,
    validated,
)
from elastomorph.fitting.modal_sums import LawSums, ModalSums, Objective, curve_sums
from elastomorph.fitting.results import Errors, Fit
from elastomorph.model.mesh import require_same_topology
from elastomorph.model.sequence import MeshSequence, require_motion
from elastomorph.paths import Method, interpolate
from elastomorph.physics import CLOSURES

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
