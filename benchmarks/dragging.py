"""Dragging a face by `rig.solve`: milliseconds, weights found again, and the picture of the docs.

Run:  python benchmarks/dragging.py [RIG] [--take 4030] [--picture docs/dragging.png]

On the built-in head, or a rig, without its expressions, which are sums of other sliders. Poses of
five random sliders are asked for at one to twenty vertices that tell the sliders apart:

- processor time of a drag from rest, within reach and pulled away by noise of 1 % of D, and of each
  step of a drag by hand, beside one `rig.pose` of five sliders and the same least squares by SciPy;
- the largest error of a weight from twenty vertices without noise, and the error of the whole face
  with noise, at the prior that suits it;
- with --take, seconds and errors of `rig.track` on so many frames of 41 markers;
- the error of the face where a straight rig is brought to the handles of a bent one.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from elastomorph.draw import drag_picture
from elastomorph.io import read_rig
from elastomorph.rig import Rig
from elastomorph.rig.build import extent_of
from elastomorph.rig.handles import HandledPoints, asked
from elastomorph.rig.tracking import PRIOR
from elastomorph.samples import landmarks
from elastomorph.samples.paper_expressions import EXPRESSIONS

FACES, ACTIVE, HANDLES, GOAL = 24, 5, (1, 3, 10, 20), 5.0
DRAGS, STEPS = 6, 25
NOISE, NOISY_PRIOR, PLAIN_PRIOR = 0.01, 3e-3, 1e-3
MARKERS, MOVED = 41, 14
CHIN, RIGHT, LEFT = 8, 48, 54  # of the 68 landmarks; the corners are of the mouth


def telling_vertices(rig: Rig, count: int) -> list[int]:
    """Vertices whose movements tell the sliders apart, by a pivoted QR of all of them."""
    moves = np.stack([rig[n].delta.ravel() / np.abs(rig[n].delta).max() for n in rig.names])
    order = qr(moves, mode="r", pivoting=True)[1] // 3
    return list(dict.fromkeys(order[: 10 * count].tolist()))[:count]


def milliseconds(task: Callable[[], object], rounds: int = 5) -> float:
    """Processor time, shortest of several runs; other programs keep the machine busy."""
    found = []
    for _ in range(rounds):
        start = time.process_time()
        task()
        found.append(time.process_time() - start)
    return 1e3 * min(found)


def poses(rig: Rig, seed: int = 3) -> list[dict[str, float]]:
    random = np.random.default_rng(seed)
    return [
        dict(
            zip(
                random.choice(rig.names, ACTIVE, replace=False).tolist(),
                random.uniform(0.2, 1, ACTIVE).tolist(),
                strict=True,
            )
        )
        for _ in range(FACES)
    ]


def speed(rig: Rig, vertices: list[int], noise: float) -> None:
    random = np.random.default_rng(5)
    asked_for = poses(rig)
    posing = np.median([milliseconds(lambda w=w: rig.pose(w)) for w in asked_for])
    print(f"rig.pose of {ACTIVE} sliders, {len(rig.neutral.vertices):,} vertices: {posing:.2f} ms")
    for count in HANDLES:
        for away in (0.0, noise):
            times = []
            for weights in asked_for:
                face = rig.pose(weights)
                some = random.permutation(vertices)[:count].tolist()
                handles = {v: face[v] + away * random.normal(size=3) for v in some}
                times.append(milliseconds(lambda handles=handles: rig.solve(handles)))
            _say(count, "pulled away" if away else "within reach", times, posing)
        _say(count, f"in {STEPS} steps", in_steps(rig, vertices, count), posing)
    print(f"  SciPy, 10 handles, within reach: {scipy_milliseconds(rig, vertices[:10]):.0f} ms")


def _say(count: int, words: str, times: list[float], posing: float) -> None:
    print(
        f"  {count:2} handles, {words}: median {np.median(times):5.2f} ms = "
        f"{np.median(times) / posing:.1f} × rig.pose, slowest {max(times):.1f} ms, "
        f"{sum(each > GOAL for each in times)} of {len(times)} above {GOAL:g} ms"
    )


def in_steps(rig: Rig, vertices: list[int], count: int) -> list[float]:
    """Drags as a hand makes them: one handle goes straight, each step from the weights before.

    The others are pinned where they are at rest.
    """
    random, rest = np.random.default_rng(6), rig.neutral.vertices
    times = []
    for weights in poses(rig)[:DRAGS]:
        face = rig.pose(weights)
        some = random.permutation(vertices)[:count].tolist()
        moved = max(some, key=lambda v: float(np.linalg.norm(face[v] - rest[v])))
        at: Mapping[str, float] = {}
        for part in np.linspace(0, 1, STEPS + 1)[1:]:
            handles = {v: rest[v] for v in some}
            handles[moved] = rest[moved] + part * (face[moved] - rest[moved])
            times.append(milliseconds(lambda h=handles, w=at: rig.solve(h, w)))
            at = rig.solve(handles, at).weights
    return times


def scipy_milliseconds(rig: Rig, vertices: list[int]) -> float:
    """The same residuals and derivatives, a ridge for a prior, by ``least_squares``."""
    face = rig.pose(poses(rig)[0])
    mix, goals = asked({v: face[v] for v in vertices}, None, len(face))
    points = HandledPoints.of(rig, mix)
    ridge = 1e-4 * np.eye(len(rig.names))

    def residuals(row: NDArray[np.float64]) -> NDArray[np.float64]:
        away = (points.at(row).positions - goals).ravel() / points.reach
        return np.concatenate([away, ridge @ row])

    def rates(row: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.concatenate([points.at(row).rates / points.reach, ridge])

    start = np.full(len(rig.names), 1e-3)
    return milliseconds(lambda: least_squares(residuals, start, rates, (0, 1)), 1)


def found_again(rig: Rig, vertices: list[int], noise: float) -> None:
    random = np.random.default_rng(5)
    worst, rms = [], []
    for weights in poses(rig):
        face = rig.pose(weights)
        solved = rig.solve({v: face[v] for v in vertices})
        worst.append(max(abs(w - weights.get(n, 0.0)) for n, w in solved.weights.items()))
        noisy = {v: face[v] + noise * random.normal(size=3) for v in vertices}
        solved = rig.solve(noisy, prior=NOISY_PRIOR)
        rms.append(np.sqrt(np.square(rig.pose(solved.weights) - face).sum(axis=1).mean()))
    print(
        f"weights from {len(vertices)} vertices: largest error median {np.median(worst):.1e}, "
        f"worst {max(worst):.1e} of {len(worst)} poses, {np.mean(np.array(worst) < 1e-3):.0%} "
        f"below 1e-3\nwith noise of σ = {noise:.3g} an axis and prior={NOISY_PRIOR:g}: the whole "
        f"face is off by {np.mean(rms) / noise:.2f} σ (RMS of distances)"
    )


def bent_and_straight(rig: Rig, vertices: list[int], extent: float) -> None:
    targets = {name: rig[name].target for name in rig.names}
    straight = Rig(rig.neutral, targets, method="linear")
    bent_names = [name for name in rig.names if len(rig[name].bends)]
    errors = []
    for name in bent_names:
        face = rig.pose({name: 0.5})
        handles = {v: face[v] for v in vertices}
        errors.append(
            [
                np.linalg.norm(one.pose(one.solve(handles).weights) - face, axis=1).max() / extent
                for one in (rig, straight)
            ]
        )
    bent, linear = np.mean(errors, axis=0)
    print(
        f"{len(bent_names)} bent sliders halfway, from {len(vertices)} vertices: largest error of "
        f"the face {100 * bent:.4f} % of D on the bent rig, {100 * linear:.2f} % on the straight"
    )


def take(rig: Rig, frames: int) -> None:
    """A take of markers on a head that turns and walks, with and without what recordings lack."""
    random = np.random.default_rng(0)

    def wander(shape: tuple[int, ...], pace: float) -> NDArray[np.float64]:
        found: NDArray[np.float64] = gaussian_filter1d(random.normal(size=shape), pace, axis=0)
        return found

    vertices = telling_vertices(rig, MARKERS)
    weights = np.zeros((frames, len(rig.names)))
    moved = random.choice(len(rig.names), MOVED, replace=False)
    weights[:, moved] = np.clip(3.0 * wander((frames, MOVED), 6), 0, 1)
    faces = np.stack([rig.pose(row)[vertices] for row in weights])
    turns = Rotation.from_rotvec(wander((frames, 3), 15)).as_matrix()
    markers = 10 * np.einsum("fij,fmj->fmi", turns, faces) + 50 * wander((frames, 1, 3), 15)
    poor = markers + 0.5 * random.normal(size=markers.shape)
    poor[random.random(poor.shape[:2]) < 0.02] += [80.0, -40.0, 10.0]
    poor[random.random(poor.shape[:2]) < 0.05] = np.nan
    for words, taken in (("clean", markers), ("noise, jumps, gaps", poor)):
        start = time.process_time()
        found = rig.track(taken, vertices)
        seconds = time.process_time() - start
        shown = [rig.names.index(name) for name in found.names]
        off = np.sqrt(np.square(found.weights - weights[:, shown]).mean())
        print(
            f"{MARKERS} markers, {words}: {seconds:.1f} s, weights off by {off:.3f} (RMS); {found}"
        )


def draw(rig: Rig, path: Path) -> None:
    """Three goals: the face at rest, at the goals, and near them by few sliders."""
    rest, marks = rig.neutral.vertices, landmarks()
    moves = {CHIN: [0.0, -1.5, -1.3], LEFT: [0.5, 0.1, -1.0], RIGHT: [0.0, -0.7, -0.5]}
    goals = {marks[point]: rest[marks[point]] + move for point, move in moves.items()}
    faces = {"three goals": rest}
    for prior, label in ((PRIOR, "solved"), (PLAIN_PRIOR, f"prior={PLAIN_PRIOR:g}")):
        solved = rig.solve(goals, prior=prior)
        print(f"picture, prior={prior:g}: {solved}")
        faces[label] = rig.pose(solved.weights)
    drag_picture(rig.neutral, goals, faces, path, views=("front", (50.0, 0.0)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("rig", nargs="?", default="built-in")
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--take", type=int, metavar="FRAMES", help="a take of markers instead")
    options = parser.parse_args()
    rig = read_rig(options.rig)
    rig = rig.only([name for name in rig.names if name not in EXPRESSIONS])
    if options.picture:
        draw(rig, options.picture)
        return
    if options.take:
        take(rig, options.take)
        return
    extent = extent_of(rig)
    vertices = telling_vertices(rig, HANDLES[-1])
    print(f"{rig}, {len(rig.names)} sliders, D = {extent:.3g}")
    speed(rig, vertices, NOISE * extent)
    found_again(rig, vertices, NOISE * extent)
    bent_and_straight(rig, vertices, extent)


if __name__ == "__main__":
    main()
