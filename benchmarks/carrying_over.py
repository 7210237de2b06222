"""What of a learned path carries over to another repetition: the path, its shapes, or the joint.

Run:  python benchmarks/carrying_over.py [--data FOLDER] [--bends K …]

Each of 18 recorded movements in eight groups of like gestures is left out once. Printed is by how
much its LME becomes smaller than that of a straight line, each frame at its own moment of both:

- path: shapes and weight curves learned from the others of its group;
- shapes: their shapes alone, with weight curves fitted to it;
- shapes of others: likewise with shapes from another gesture of the same take, to tell what such
  freedom is worth by itself;
- path of its own: learned from the recording itself, timing apart;
- joint, of movements of the jaw: markers turn about one axis, and slide along one way, each by its
  own share, x + w (R(θ) (x - c) - (x - c) + θ g), with c, R, g, w fitted to the others, and θ alone
  to the ends;
- arc: the same without any recording.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.curves import CurveNetwork
from elastomorph.evaluation.curve_errors import CurveVertices
from elastomorph.evaluation.learning import Learned, PathErrors, Recordings, Take, never_worse
from elastomorph.evaluation.path_fit import Splines, fitted
from elastomorph.model.bend_curve import BendCurve
from learning import REPETITIONS, marker_take
from measuring import data_folder

KNOTS, ROUNDS = 7, 2
BUMP = BendCurve(np.array([0.0, 1.0]), np.array([[0.0, 4.0, -4.0]]))
# Of the fit of a joint: frames of each recording, evaluations, the price of slides and odd shares.
FRAMES, EVALUATIONS, SLIDES, SHARES = 8, 20, 0.02, 0.05
DEPTH = 6.0  # Behind the middle of the markers, in cm: where the axis is first looked for

Floats = NDArray[np.float64]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder(), help="folder of the real data")
    parser.add_argument("--bends", type=int, nargs="+", default=(1, 2), help="so many bends")
    chosen = parser.parse_args()
    groups, networks = {}, {}
    for name, (source, parts) in REPETITIONS.items():
        recording, networks[name] = marker_take(chosen.data, source)
        groups[name] = [recording.motion.part(*map(int, part.split("-"))) for part in parts]
    for bends in chosen.bends:
        paths = {
            name: [
                em.learn(without(own, number), bends, timing="even", curves=networks[name])
                for number in range(len(own))
            ]
            for name, own in groups.items()
        }
        for words, of_others in (("path", None), ("shapes", False), ("shapes of others", True)):
            ratios(f"{words}, {bends} bends", groups, networks, paths, of_others)
        own = [
            em.learn(motion, bends, timing="even", curves=networks[name])
            for name, motions in groups.items()
            for motion in motions
        ]
        say(f"path of its own, {bends} bends", [(one.straight.lme, one.errors.lme) for one in own])
    joints(groups, networks)


def without(motions: Sequence[em.MeshSequence], number: int) -> list[em.MeshSequence]:
    return [motion for k, motion in enumerate(motions) if k != number]


def as_take(motion: em.MeshSequence, network: CurveNetwork) -> Take:
    return Take(motion, CurveVertices.of(network, len(motion.mesh.vertices)))


def say(words: str, pairs: Sequence[tuple[float, float]]) -> None:
    straight, own = np.array(pairs).T
    print(
        f"{words}: LME / {straight.mean() / own.mean():.2f}, worse on "
        f"{int((own > straight).sum())} of {len(own)}",
        flush=True,
    )


def ratios(
    words: str,
    groups: dict[str, list[em.MeshSequence]],
    networks: dict[str, CurveNetwork],
    paths: dict[str, list[Learned]],
    of_others: bool | None,
) -> None:
    pairs = []
    names = list(groups)
    for name, motions in groups.items():
        for number, motion in enumerate(motions):
            take = as_take(motion, networks[name])
            straight = take.closest(take.line)[0]
            path = paths[name][number]
            if of_others:
                same = [n for n in names if REPETITIONS[n][0] == REPETITIONS[name][0]]
                path = paths[same[(same.index(name) + 1) % len(same)]][0]
            found = take.closest(path)[0] if of_others is None else weighed(take, straight, path)
            pairs.append((straight.lme, found.lme))
    say(words, pairs)


def weighed(take: Take, straight: PathErrors, path: Learned) -> PathErrors:
    """The errors of the shapes of a path with weight curves of the recording's own."""
    if not len(path.bends):
        return straight
    shapes = path.bends.transpose(0, 2, 1) / take.motion.mesh.diameter
    moments = take.nearest
    for _ in range(ROUNDS):
        seen = Recordings([take.motion], [moments], take.along, None, False, [straight.lme])
        splines = Splines.at(moments, KNOTS)
        fit = fitted(seen.observed(slice(None)), splines, len(shapes), shapes=shapes)

        def measured(own: Learned) -> tuple[float, tuple[PathErrors, Floats]]:
            found = take.closest(own)
            return found[0].part_of(straight), found

        _, _, (errors, moments) = never_worse(take.line, fit, splines, measured)
    return errors


@dataclass(frozen=True, eq=False)
class Joint:
    """An axis that markers turn about, each by its share, while they slide."""

    centre: Floats  # (3,)
    axis: Floats  # (3,) of length 1
    slide: Floats  # (3,) a radian
    shares: Floats  # (N,)

    def moved(self, markers: Floats, angle: float) -> Floats:
        """(N, 3) how far markers are moved."""
        out = markers - self.centre
        turned = Rotation.from_rotvec(angle * self.axis).apply(out)
        return np.asarray(self.shares[:, None] * (turned - out + angle * self.slide))

    def path(self, take: Take) -> Learned:
        """That between the ends of a recording, by the angle that fits them best."""
        first, last = take.motion.frames[[0, -1]]

        def left(angle: Floats) -> Floats:
            return np.asarray((last - first - self.moved(first, float(angle[0]))).ravel())

        angle = float(least_squares(left, [0.2]).x[0])
        bend = self.moved(first, angle / 2) - self.moved(first, angle) / 2
        return replace(take.line, bends=bend[None], bend_curves=(BUMP,))


def joint_of(motions: Sequence[em.MeshSequence]) -> Joint:
    """The joint that goes best with some recordings, by least squares."""
    seen = [
        (motion.frames[0], motion.frames[np.linspace(0, len(motion) - 1, FRAMES).astype(int)])
        for motion in motions
    ]
    rest = seen[0][0]
    ways = np.mean([np.linalg.norm(m.frames[-1] - m.frames[0], axis=1) for m in motions], axis=0)

    def joint(own: Floats) -> Joint:
        axis = own[3:6] / np.linalg.norm(own[3:6])
        return Joint(own[:3], axis, own[6:9], own[9 : 9 + len(rest)])

    def left(own: Floats) -> Floats:
        found, angles = joint(own), iter(own[9 + len(rest) :])
        off = [
            frame - first - found.moved(first, float(next(angles)))
            for first, frames in seen
            for frame in frames
        ]
        odd = found.shares - np.clip(found.shares, 0, 1)
        length = np.linalg.norm(own[3:6]) - 1
        return np.concatenate([np.ravel(off), SLIDES * found.slide, SHARES * odd, [length]])

    found = []
    for sign in (1, -1):
        angles = np.tile(np.linspace(0, 0.3 * sign, FRAMES), len(seen))
        place = rest.mean(axis=0) - [0, 0, DEPTH]
        start = np.concatenate([place, [1, 0, 0], np.zeros(3), ways / ways.max(), angles])
        found.append(least_squares(left, start, max_nfev=EVALUATIONS))
    return joint(min(found, key=lambda each: each.cost).x)


def joints(groups: dict[str, list[em.MeshSequence]], networks: dict[str, CurveNetwork]) -> None:
    """The joint of the others, that of the recording itself, and `arc`."""
    pairs: dict[str, list[tuple[float, float]]] = {}
    for name, motions in groups.items():
        for number, motion in enumerate(motions if name.startswith("jaw") else ()):
            take = as_take(motion, networks[name])
            arc = em.interpolate(motion.neutral, motion.target, "arc", curves=networks[name])
            tried = {
                "joint of the others": joint_of(without(motions, number)).path(take),
                "joint of its own": joint_of([motion]).path(take),
                "arc": take.between(arc),
            }
            straight = take.closest(take.line)[0].lme
            for words, path in tried.items():
                pair = (straight, take.closest(path)[0].lme)
                pairs.setdefault(f"{words}, jaw", []).append(pair)
                if name == "jaw opens" and number > 1:
                    pairs.setdefault(f"{words}, large openings", []).append(pair)
    for words, own in pairs.items():
        say(words, own)


if __name__ == "__main__":
    main()
