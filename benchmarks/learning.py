"""Paths learned from recordings, beside the straight line: two takes of real faces, and our head.

    python benchmarks/learning.py [--data FOLDER] [--bends K …] [--picture FILE] [--dense]

Reads ``animface/jaw.npz`` and ``animface/eyebrows.npz`` (41 named markers at 60 frames a second).
Prints by how much the mean LME and LAE of all movements become smaller: from turn to turn with all
rests, whole, and with 5 % of their rise cut off at either end; how many movements became worse;
what is left of that once the path went through a GLB; and whether what repetitions share carries
over to one left out. The picture shows the ways of chin and lip corner. With ``--dense`` instead:
seconds and memory of 67 and of 1,000 frames of 35,000 vertices, each in a process of its own.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import elastomorph as em
from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import find_movements
from elastomorph.io.sequences import Recording, read_recording, write_mdd
from elastomorph.io.vertex_lists import read_curves
from elastomorph.samples import landmarks, recorded_motion
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
Take = tuple[Recording, CurveNetwork]
DENSE, SHEET = (67, 1000), (175, 200)
WAYS = ("jaw", "317-408", {"chin, markers": "Chin", "corner of the mouth, markers": "Mouth_Lend"})
WAYS_OF_HEAD = {"chin, built-in head": 8, "corner of the mouth, built-in head": 54}
"""Of the 68 landmarks."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder(), help="folder of the real data")
    parser.add_argument("--bends", type=int, nargs="+", default=(1, 2, 3), help="so many bends")
    parser.add_argument("--picture", type=Path, help="draw the ways of single markers there")
    parser.add_argument("--dense", action="store_true", help="time and memory of dense meshes")
    parser.add_argument("--dense-file", type=Path, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.dense_file is not None:
        _learn_dense(chosen.dense_file)
        return 0
    if chosen.dense:
        for frames in DENSE:
            _dense(frames)
        return 0
    takes = {name: marker_take(chosen.data, name) for name in ("jaw", "eyebrows")}
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
        _through_glb(takes, bends)
    for bends in chosen.bends[:2]:
        _carry_over(takes, bends)
    if chosen.picture is not None:
        _draw(takes, chosen.picture)
    return 0


def marker_take(data: Path, name: str) -> Take:
    """A take and the curves of its markers."""
    take = read_recording(data / "animface" / f"{name}.npz")
    count = len(take.names)
    return take, CurveNetwork(read_curves(CURVES, count, take.names), count)


def movements(
    takes: dict[str, Take], edge: float | None
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
    takes: dict[str, Take],
    edge: float | None,
    bends: int,
    shapes: str,
) -> None:
    rows, start = [], time.perf_counter()
    for motion, network in movements(takes, edge):
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


def _through_glb(takes: dict[str, Take], bends: int) -> None:
    """Whole movements and the built-in motion, as they are when the rig is read again."""
    motions = [*movements(takes, 0.0), (recorded_motion(), None)]
    rows, apart = [], 0.0
    with TemporaryDirectory() as folder:
        file = Path(folder) / "learned.glb"
        for motion, network in motions:
            path = em.learn(motion, bends, curves=network)
            em.write(file, em.Rig(path.neutral, {"learned": path}))
            again = em.read_rig(file).morphs["learned"]
            found = em.evaluate(motion, {"again": again}, network).results[0]
            rows.append((path.straight.lme, path.errors.lme, found.lme))
            off = np.linalg.norm(again.at(motion.times) - path.at(motion.times), axis=2).max()
            apart = max(apart, off / motion.mesh.diameter)
    straight, learned, once_more = np.array(rows)[:-1].mean(axis=0)
    line, own, stored = rows[-1]
    print(
        f"through GLB and back, {bends} bends: whole movements LME / {straight / learned:.4f} "
        f"before, / {straight / once_more:.4f} after; built-in motion / {line / own:.3f} before, "
        f"/ {line / stored:.3f} after; paths apart by at most {apart:.1e} of D"
    )


def _dense(frames: int) -> None:
    """A sheet that turns about an edge as a jaw does, with a pace of its own and noise."""
    x, y = np.meshgrid(*(np.linspace(0, 1, side) for side in SHEET), indexing="ij")
    rest = np.stack([x, y, 0 * x], axis=2).reshape(-1, 3)
    rows = np.arange(len(rest)).reshape(SHEET)
    corners = (rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:])
    sheet = em.Mesh(rest, np.stack([own.ravel() for own in corners], axis=1))
    random, angle = np.random.default_rng(1), 0.6 * np.clip(2 * rest[:, 0] - 0.5, 0, 1)

    def posed() -> Iterator[np.ndarray]:
        for time_now in np.linspace(0, 1, frames):
            turn = angle * time_now**2 * (3 - 2 * time_now)
            out = (rest[:, 0] - 0.25, rest[:, 1], 0 * turn)
            pose = np.stack([0.25 + np.cos(turn) * out[0], out[1], -np.sin(turn) * out[0]], axis=1)
            yield pose + 2e-4 * random.normal(size=pose.shape)

    with TemporaryDirectory() as folder:
        em.write(Path(folder) / "take.obj", sheet)
        write_mdd(Path(folder) / "take.mdd", posed(), count=frames)
        call = [sys.executable, __file__, "--dense-file", str(Path(folder) / "take.mdd")]
        subprocess.run(call, check=True)


def _learn_dense(file: Path) -> None:
    start = time.perf_counter()
    motion = em.read_sequence(file)
    read = time.perf_counter()
    network = em.extract_curves(motion.mesh)
    curved = time.perf_counter()
    path = em.learn(motion, 1, curves=network)
    learned = time.perf_counter()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"{len(motion):,} frames of {len(motion.mesh.vertices):,} vertices: read in "
        f"{read - start:.1f} s, curves in {curved - read:.1f} s, learned in "
        f"{learned - curved:.1f} s, LME / {path.gain:.1f}, {peak:.2f} GiB at most",
        flush=True,
    )


def _carry_over(takes: dict[str, Take], bends: int) -> None:
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


def _draw(takes: dict[str, Take], file: Path) -> None:
    """The ways of markers and of vertices of our head, each in the plane in which it moves most."""
    from matplotlib.figure import Figure

    source, part, names = WAYS
    take, network = takes[source]
    markers = take.motion.part(*map(int, part.split("-")))
    head, marks = recorded_motion(), landmarks()
    ways = {title: marks[number] for title, number in WAYS_OF_HEAD.items()}
    rows = (
        (markers, network, {title: take.names.index(name) for title, name in names.items()}, "arc"),
        (head, em.extract_curves(head.mesh), ways, "auto"),
    )
    figure = Figure(figsize=(10, 6.4), layout="constrained")
    panels = figure.subplots(len(rows), len(names))
    for own, (motion, curves, points, method) in zip(panels, rows, strict=True):
        paths = {"linear": em.interpolate(motion.neutral, motion.target, "linear")}
        paths[method] = em.interpolate(motion.neutral, motion.target, method, curves=curves)
        paths |= {
            f"learned, {bends} bend{'s' * (bends > 1)}": em.learn(motion, bends, curves=curves)
            for bends in (1, 2)
        }
        for panel, (name, point) in zip(own, points.items(), strict=True):
            _ways(panel, motion, point, paths)
            panel.set(title=name, xlabel="cm", aspect="equal", adjustable="datalim")
        own[0].legend(loc="lower center", ncols=2)
    figure.savefig(file, dpi=110)


def _ways(panel: Any, motion: em.MeshSequence, point: int, paths: dict[str, em.Morph]) -> None:
    """One vertex, recorded and along paths."""
    start = motion.frames[0, point]
    own = motion.frames[:, point] - start
    plane = np.linalg.svd(own - own.mean(axis=0), full_matrices=False)[2][:2]
    panel.plot(*(own @ plane.T).T, "o", color="0.7", label="recorded")
    for number, (label, path) in enumerate(paths.items()):
        way = path.at(np.linspace(0, 1, 101))[:, point] - start
        panel.plot(*(way @ plane.T).T, "--" if number == 3 else "-", label=label)


if __name__ == "__main__":
    sys.exit(main())
