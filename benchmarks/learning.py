"""Paths learned from recordings, beside the straight line: two takes of real faces, and our head.

    python benchmarks/learning.py [--data FOLDER] [--bends K …] [--picture FILE]

Reads ``animface/jaw.npz`` and ``animface/eyebrows.npz`` (41 named markers at 60 frames a second).
Prints by how much the mean LME and LAE of all movements become smaller: from turn to turn with all
rests, whole, and with 5 % of their rise cut off at either end; how many movements became worse; and
whether what repetitions share carries over to one left out. The picture shows the ways of chin and
lip corner.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import find_movements
from elastomorph.io.sequences.recordings import Recording, read_recording
from elastomorph.io.vertex_lists import read_curves
from elastomorph.samples import recorded_motion
from measuring import data_folder

CURVES = Path(__file__).parent / "animface_curves.json"
REPETITIONS = {
    "jaw opens": ("jaw", ["84-132", "248-132", "317-408", "502-408"]),
    "jaw, second gesture": ("jaw", ["532-606", "699-606"]),
    "jaw, third gesture": ("jaw", ["742-848", "878-848"]),
    "jaw, fourth gesture": ("jaw", ["919-1006", "1065-1006"]),
    "jaw, fifth gesture": ("jaw", ["1099-1123", "1222-1123"]),
    "brows, first gesture": ("eyebrows", ["140-203", "335-203"]),
    "brows, second gesture": ("eyebrows", ["366-508", "531-508"]),
    "brows, third gesture": ("eyebrows", ["540-625", "747-625"]),
}
"""Movements of like directions; an offset is played backwards."""
WAYS = ("jaw", "317-408", ("Chin", "Mouth_Lend"))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder(), help="folder of the real data")
    parser.add_argument("--bends", type=int, nargs="+", default=(1, 2, 3), help="so many bends")
    parser.add_argument("--picture", type=Path, help="draw the ways of single markers there")
    chosen = parser.parse_args()
    takes = {name: _take(chosen.data, name) for name in ("jaw", "eyebrows")}
    cuts = ((None, "turn to turn"), (0.0, "whole movements"), (0.05, "movements cut at 5 %"))
    for edge, words in cuts:
        for bends in chosen.bends:
            for shapes in ("free", "scanned"):
                _judge(f"{words}, {shapes} shapes", takes, edge, bends, shapes)
    for bends in chosen.bends:
        found = em.learn(recorded_motion(), bends)
        print(
            f"built-in motion, {bends} bends: LME / {found.gain:.1f}, "
            f"LAE / {found.straight.lae / found.errors.lae:.1f}"
        )
    for bends in chosen.bends[:2]:
        _carry_over(takes, bends)
    if chosen.picture is not None:
        _draw(takes, chosen.picture)
    return 0


def _take(data: Path, name: str) -> tuple[Recording, CurveNetwork]:
    take = read_recording(data / "animface" / f"{name}.npz")
    count = len(take.names)
    return take, CurveNetwork(read_curves(CURVES, count, take.names), count)


def _movements(
    takes: dict[str, tuple[Recording, CurveNetwork]], edge: float | None
) -> Iterator[tuple[em.MeshSequence, CurveNetwork]]:
    for take, network in takes.values():
        for start, stop in _turns(take) if edge is None else ():
            yield take.motion.part(start, stop), network
        if edge is None:
            continue
        for move in find_movements(take.motion.frames, edge=edge):
            yield take.motion.part(move.start, move.stop), network


def _turns(take: Recording) -> Iterator[tuple[int, int]]:
    """From each turn of a take to the next apex and back, all rests and hesitations included."""
    from scipy.ndimage import gaussian_filter1d
    from scipy.signal import find_peaks

    away = take.motion.frames - np.median(take.motion.frames, axis=0)
    level = np.linalg.norm(away, axis=2).max(axis=1) / take.motion.mesh.diameter
    level = gaussian_filter1d(level, 6)
    turns = np.concatenate([[0], find_peaks(-level, prominence=0.015)[0], [len(level) - 1]])
    for apex in find_peaks(level, prominence=0.03)[0]:
        for start, stop in ((turns[turns < apex].max(), apex), (apex, turns[turns > apex].min())):
            if stop - start >= 10:
                yield int(start), int(stop)


def _judge(
    words: str,
    takes: dict[str, tuple[Recording, CurveNetwork]],
    edge: float | None,
    bends: int,
    shapes: str,
) -> None:
    rows, start = [], time.perf_counter()
    for motion, network in _movements(takes, edge):
        found = em.learn(motion, bends, shapes=shapes, curves=network)
        rows.append((found.straight.lme, found.straight.lae, found.errors.lme, found.errors.lae))
    table = np.array(rows)
    lme, lae = table[:, :2].mean(axis=0) / table[:, 2:].mean(axis=0)
    worse = int((table[:, 2:] > table[:, :2]).any(axis=1).sum())
    seconds = time.perf_counter() - start
    print(
        f"{words}, {bends} bends: LME / {lme:.2f}, LAE / {lae:.2f}, worse {worse} of "
        f"{len(table)}, {seconds:.1f} s"
    )


def _carry_over(takes: dict[str, tuple[Recording, CurveNetwork]], bends: int) -> None:
    straight, own, others = [], [], []
    for name, (source, parts) in REPETITIONS.items():
        take, network = takes[source]
        motions = [take.motion.part(*map(int, part.split("-"))) for part in parts]
        found = em.learn(motions, bends, curves=network)
        print(f"{name}, {bends} bends, {len(parts)} repetitions: {found.conclusion}")
        straight += [one.straight.lme for one in found.repetitions]
        own += [one.errors.lme for one in found.repetitions]
        others += [one.left_out.lme for one in found.repetitions]
    print(
        f"all {len(straight)}, {bends} bends, timing free: learned together / "
        f"{np.mean(straight) / np.mean(own):.2f}, left out / "
        f"{np.mean(straight) / np.mean(others):.2f}, worse "
        f"{int((np.array(others) > np.array(straight)).sum())}"
    )


def _draw(takes: dict[str, tuple[Recording, CurveNetwork]], file: Path) -> None:
    """The ways of two markers, each in the plane in which it moves most."""
    from matplotlib.figure import Figure

    source, part, words = WAYS
    take, network = takes[source]
    motion = take.motion.part(*map(int, part.split("-")))
    paths = {
        "linear": em.interpolate(motion.neutral, motion.target, "linear"),
        "arc": em.interpolate(motion.neutral, motion.target, "arc", curves=network),
        "learned, 1 bend": em.learn(motion, 1, curves=network),
        "learned, 2 bends": em.learn(motion, 2, curves=network),
    }
    figure = Figure(figsize=(10, 5), layout="constrained")
    for panel, word in zip(figure.subplots(1, len(words)), words, strict=True):
        marker = take.names.index(word)
        own = motion.frames[:, marker] - motion.frames[0, marker]
        plane = np.linalg.svd(own - own.mean(axis=0), full_matrices=False)[2][:2]
        panel.plot(*(own @ plane.T).T, ".", color="0.6", label="recorded")
        for label, path in paths.items():
            way = path.at(np.linspace(0, 1, 101))[:, marker] - motion.frames[0, marker]
            panel.plot(*(way @ plane.T).T, label=label)
        panel.set(title=take.names[marker], xlabel="cm", aspect="equal", adjustable="datalim")
    figure.axes[0].legend()
    figure.savefig(file, dpi=110)


if __name__ == "__main__":
    sys.exit(main())
