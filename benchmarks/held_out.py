"""Settings of solving, tracking and learning chosen on one take of real faces, tried on another.

Run:  python benchmarks/held_out.py [--data FOLDER]

The takes are ``animface/jaw.npz`` and ``animface/eyebrows.npz``, 41 markers. The rig is the markers
themselves, with a slider for the apex of each of nine gestures. Three of four markers are given,
as recorded and with noise of 1 % of D, and the others say how far off the face is: RMS of their
distances, in % of D. Printed for the defaults, or the prior that `benchmarks/dragging.py` gives for
such noise; for the settings that are best on the other take; and for those that are best on this
one, which nobody can know beforehand. Likewise of `learn` with one bend: the highest exponent that
its errors are raised to, by the mean LME of whole movements, and the number of knots, by that of
repetitions left out.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from dragging import NOISY_PRIOR
from elastomorph.evaluation import path_fit
from elastomorph.evaluation.learning import KNOTS
from elastomorph.rig import Rig
from elastomorph.rig.tracking import PRIOR, SMOOTH, TRACKING_PRIOR
from learning import REPETITIONS, Take, marker_take, movements
from measuring import data_folder

APEXES = {"jaw": (132, 408, 606, 848, 1006, 1123), "eyebrows": (203, 508, 625)}
NOISE, EVERY = 0.01, 4
SOLVE = (PRIOR, 1e-4, 1e-3, NOISY_PRIOR, 1e-2, 3e-2)
TRACK = ((1e-5, TRACKING_PRIOR, 1e-3, 1e-2, 1e-1), (3e-5, SMOOTH, 3e-3, 3e-2))
SCHEDULE = path_fit._ROUNDS
EXPONENTS = (4, 16, SCHEDULE[-1][0], 128)
SPLINES = (3, 5, KNOTS, 9, 12)

Floats = NDArray[np.float64]
Settings = tuple[float, ...]
Error = Callable[[Rig, Floats, Floats, Settings], float]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder(), help="folder of the real data")
    data = parser.parse_args().data
    takes = {name: marker_take(data, name) for name in APEXES}
    frames = {name: take.motion.frames for name, (take, _) in takes.items()}
    rest = {name: np.median(own, axis=0) for name, own in frames.items()}
    shapes = {
        f"{name} {apex}": frames[name][apex] - rest[name]
        for name, apexes in APEXES.items()
        for apex in apexes
    }
    rigs = {name: marker_rig(own, shapes) for name, own in rest.items()}
    for noise in (0.0, NOISE):

        def off(name: str, how: Settings, error: Error, noise: float = noise) -> float:
            size = rigs[name].neutral.diameter
            random = np.random.default_rng(2).normal(size=frames[name].shape)
            return error(rigs[name], frames[name], frames[name] + noise * size * random, how) / size

        words, advised = f"noise of {noise:.0%} of D", (NOISY_PRIOR if noise else PRIOR,)
        compare(f"solve, {words}", partial(off, error=solved), product(SOLVE), advised)
        usual = (TRACKING_PRIOR, SMOOTH)
        compare(f"track, {words}", partial(off, error=tracked), product(*TRACK), usual)
    compare("learn, exponent", partial(learned, takes), product(EXPONENTS), (SCHEDULE[-1][0],))
    compare("learn, knots", partial(carried, takes), product(SPLINES), (KNOTS,))


def compare(
    words: str,
    error: Callable[[str, Settings], float],
    settings: Iterable[Settings],
    usual: Settings,
) -> None:
    """Print the error of each take by the usual settings, those best on the other, and its own."""
    every = list(settings)
    found = {name: {each: 100 * error(name, each) for each in every} for name in APEXES}
    best = {name: min(own, key=own.__getitem__) for name, own in found.items()}
    for name, own in found.items():
        (other,) = set(best) - {name}
        print(
            f"{words}, {name}: {own[usual]:.3f} as advised {usual}, {own[best[other]]:.3f} "
            f"chosen on {other} {best[other]}, {own[best[name]]:.3f} at best {best[name]}",
            flush=True,
        )


def learned(takes: Mapping[str, Take], name: str, how: Settings) -> float:
    """The mean LME of whole movements, errors raised to no more than an exponent."""
    (most,) = how
    rounds = tuple(each for each in SCHEDULE if each[0] <= most)
    path_fit._ROUNDS = rounds if rounds[-1][0] == most else (*rounds, (int(most), 8))
    try:
        own = movements({name: takes[name]}, 0.0)
        return float(np.mean([em.learn(each, 1, curves=net).errors.lme for each, net in own]))
    finally:
        path_fit._ROUNDS = SCHEDULE


def carried(takes: Mapping[str, Take], name: str, how: Settings) -> float:
    """The mean LME of repetitions by paths learned from the others, with so many knots."""
    (knots,), (take, network) = how, takes[name]
    errors: list[float] = []
    for source, parts in REPETITIONS.values():
        if source == name:
            motions = [take.motion.part(*map(int, part.split("-"))) for part in parts]
            path = em.learn(motions, 1, knots=int(knots), curves=network)
            errors += [one.left_out.lme for one in path.repetitions]
    return float(np.mean(errors))


def marker_rig(rest: Floats, shapes: Mapping[str, Floats]) -> Rig:
    """A slider for each shape."""
    neutral = em.Mesh(rest)
    targets = {name: neutral.with_vertices(rest + own) for name, own in shapes.items()}
    return Rig(neutral, targets, method="linear")


def solved(rig: Rig, frames: Floats, seen: Floats, settings: Settings) -> float:
    """Each tenth frame by itself."""
    given, kept = apart(frames)
    off = []
    for frame, noisy in zip(frames[::10], seen[::10], strict=True):
        handles = {int(v): noisy[v] for v in given}
        face = rig.pose(rig.solve(handles, prior=settings[0]).weights)
        off.append(np.square(face[kept] - frame[kept]).sum(axis=1))
    return float(np.sqrt(np.mean(off)))


def tracked(rig: Rig, frames: Floats, seen: Floats, settings: Settings) -> float:
    """All frames together, where the head is being sought too."""
    given, kept = apart(frames)
    frames, seen = frames[::3], seen[::3]
    prior, smooth = settings
    found = rig.track(seen[:, given], given.tolist(), prior=prior, smooth=smooth)
    rows = [dict(zip(found.names, row, strict=True)) for row in found.weights]
    faces = np.stack([rig.pose(row)[kept] for row in rows])
    placed = found.scale * np.einsum("fij,fmj->fmi", found.rotations, faces)
    off = placed + found.offsets[:, None] - frames[:, kept]
    return float(np.sqrt(np.square(off).sum(axis=2).mean()))


def apart(frames: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The markers that are given, and those that are kept back."""
    every = np.arange(frames.shape[1])
    return every[every % EVERY > 0], every[every % EVERY == 0]


if __name__ == "__main__":
    main()
