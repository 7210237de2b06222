"""How fast a rig makes faces, as ratios to what bounds it, all in one run.

Run:  python benchmarks/rig_speed.py [--data FOLDER] [--faces 1000000]

- `rig.batch` of 7775 faces of 5071 vertices (5 expressions with 2 bends each, float32, into a given
  buffer) against the bare product of the same shapes and a copy of the same output, on the machine
  as it is and with every core kept busy by another process;
- `rig.pose` of a whole production rig with 15 sliders active against the dense product of all its
  targets in NumPy;
- `rig.stream` over a million faces: memory above the start, and rate against `rig.batch`.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.evaluation.speed import PAPER_MILLISECONDS, PAPER_VERTICES
from elastomorph.io import read_rig
from elastomorph.rig import Rig
from elastomorph.rig.sliders import weight_combinations
from measuring import busy_cores, data_folder

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from small_head import expressions, head

VERTICES = PAPER_VERTICES


def in_turn(tasks: Sequence[Callable[[], object]], rounds: int) -> list[float]:
    """Seconds of each, shortest of several rounds in turn, so that a busy moment hits all."""
    times: list[list[float]] = [[] for _ in tasks]
    for _ in range(rounds):
        for task, found in zip(tasks, times, strict=True):
            start = time.perf_counter()
            task()
            found.append(time.perf_counter() - start)
    return [min(found) for found in times]


def paper_rig() -> Rig:
    """Five expressions with two bends each on 5071 vertices."""
    neutral = em.Mesh(head().vertices[:VERTICES])
    curves = em.extract_curves(head()).restricted(np.arange(VERTICES))
    curves = em.CurveNetwork(curves.curves, VERTICES)
    to = em.prepare(neutral, "beam:3", curves=curves)
    targets = {n: neutral.with_vertices(m.vertices[:VERTICES]) for n, m in expressions().items()}
    return Rig(neutral, {name: to(mesh) for name, mesh in targets.items()})


def has_torch() -> bool:
    from importlib.util import find_spec

    return find_spec("torch") is not None


def batch(rig: Rig, rounds: int) -> float:
    """Faces per second at best."""
    rows, t = weight_combinations(5), 0.5
    out = np.zeros((len(rows), VERTICES, 3), dtype=np.float32)
    other = np.zeros_like(out)
    matrix, flat = rig.fields.matrix(np.float32), out.reshape(len(rows), -1)
    coefficients = np.full((len(rows), len(matrix)), 0.1, dtype=np.float32)
    print(f"{len(rows):,} faces × {VERTICES:,} vertices, matrix {matrix.shape}")
    varied = np.linspace(0.2, 0.8, rows.size).reshape(rows.shape)
    rate = 0.0
    bare = partial(np.matmul, coefficients, matrix, out=flat)
    copy = partial(np.copyto, out, other)
    for load, machine in (("", nullcontext()), (", every core busy elsewhere", busy_cores())):
        with machine:
            for when, times in (("one time for all", t), ("a time for each", varied)):
                for backend in ["numpy", "torch"] if has_torch() else ["numpy"]:
                    task = partial(rig.batch, rows, times, out, backend=backend)
                    ours, product, copied = in_turn((task, bare, copy), rounds)
                    rate = max(rate, len(rows) / ours)
                    faster = PAPER_MILLISECONDS / 1e3 / (ours / len(rows))
                    print(
                        f"  {backend:>5}, {when}{load}: {ours * 1e3:.1f} ms = "
                        f"{ours / product:.2f} × bare matmul = {ours / copied:.2f} × np.copyto, "
                        f"{faster:,.0f} × the paper per face"
                    )
    return rate


def stream(rig: Rig, faces: int) -> float:
    """Faces per second; run before anything large is allocated, so that the peak is its own."""
    rows = np.random.default_rng(0).random((faces, 5))
    rig.batch(rows[:1], 0.5)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    seen = sum(len(block) for block in rig.stream(rows, 0.5))
    rate = seen / (time.perf_counter() - start)
    above = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    print(f"rig.stream of {seen:,} faces × {VERTICES:,} vertices: {rate:,.0f} a second, ", end="")
    print(f"peak memory {above:.0f} MiB above start")
    return rate


def pose(folder: Path, rounds: int) -> None:
    if not (folder / "ict-facekit").is_dir():
        print(f"no production rig in {folder}: rig.pose not measured")
        return
    rig = read_rig(folder / "ict-facekit", method="beam:2")
    random = np.random.default_rng(1)
    names = random.choice(rig.names, 15, replace=False).tolist()
    weights = dict(zip(names, random.uniform(0.1, 1, 15).tolist(), strict=True))
    deltas = np.stack([m.delta.ravel() for m in rig.morphs.values()])[:53]
    rig.pose(weights)
    print(
        f"{len(rig.neutral.vertices):,} vertices, {len(rig.morphs)} targets with bends, 15 active"
    )
    for dtype in (np.float64, np.float32):
        dense, neutral = deltas.astype(dtype), rig.neutral.vertices.astype(dtype).ravel()
        row = np.zeros(len(dense), dtype=dtype)
        row[:15] = 0.5
        ours, product = in_turn(
            (
                lambda: rig.pose(weights),
                lambda neutral=neutral, row=row, dense=dense: neutral + row @ dense,
            ),
            rounds * 5,
        )
        print(f"  rig.pose         {ours * 1e3:7.2f} ms = {ours / product:.2f} × the dense", end="")
        print(f" {np.dtype(dtype)} product of {len(dense)} targets, {product * 1e3:.2f} ms")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    parser.add_argument("--faces", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    rig = paper_rig()
    rate = stream(rig, options.faces)
    batch_rate = batch(rig, options.rounds)
    print(f"  rig.stream takes {batch_rate / rate:.2f} × the time of rig.batch")
    pose(options.data, options.rounds)


if __name__ == "__main__":
    main()
