"""How long an in-between takes: the closed form beside its storage, and beside a numerical solver.

Run:  python benchmarks/interpolation.py [--data FOLDER]

Prints, measured in one run on this machine, for a production face (or a small head where the
real rig is missing): time and peak memory of `interpolate(method="beam", order=2)`, curves given;
and the closed form against finite differences in u with an implicit scheme in t, both accurate to
0.1 % of the displacement.
"""

from __future__ import annotations

import argparse
import sys
import tracemalloc
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.rivals.stepped_beams import CurveProblem, integrate
from measuring import best_seconds, data_folder

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from small_head import expressions, head

ACCURACY = 1e-3


def face(folder: Path) -> tuple[str, em.Mesh, em.Mesh]:
    rig = folder / "ict-facekit"
    if rig.is_dir():
        neutral = em.read(rig / "generic_neutral_mesh.obj")
        return "ICT FaceKit, jawOpen", neutral, em.read(rig / "jawOpen.obj")
    return "small head, grinning", head(), expressions()["grinning"]


def smooth_curve(size: int) -> CurveProblem:
    """A closed curve the size of a face's, with a displacement of its three lowest harmonics."""
    u = np.arange(size)[:, None] / size
    turn = 2 * np.pi * u
    start = np.concatenate([np.cos(turn), np.sin(turn), 0.3 * np.cos(2 * turn)], axis=1)
    delta = np.concatenate(
        [0.1 + 0.1 * np.cos(turn), 0.3 - 0.2 * np.cos(2 * turn), 0.05 * np.sin(3 * turn)], axis=1
    )
    return CurveProblem(start, start + delta, True, em.Material(1, 1, 1), em.Load.power(2))


def coarsest_reference(size: int) -> tuple[int, int, float]:
    """Vertices and steps at which the numerical solution first is accurate enough."""
    while True:
        for steps in (4, 8, 16, 32, 64, 128, 256, 512, 1024):
            problem = smooth_curve(size)
            exact = problem.solution(np.linspace(0, 1, steps + 1))
            scale = np.linalg.norm(problem.end - problem.start, axis=1).max()
            error = np.linalg.norm(integrate(problem, steps) - exact, axis=2).max() / scale
            if error <= ACCURACY:
                return size, steps, float(error)
        size = size * 3 // 2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    name, neutral, target = face(parser.parse_args().data)

    curves = em.extract_curves(neutral)
    seconds = best_seconds(lambda: em.interpolate(neutral, target, "beam", order=2, curves=curves))
    copy = best_seconds(lambda: neutral.vertices.copy())
    to = em.prepare(neutral, "beam", order=2, curves=curves)
    again = best_seconds(lambda: to(target))
    tracemalloc.start()
    morph = em.interpolate(neutral, target, "beam", order=2, curves=curves)
    peak = tracemalloc.get_traced_memory()[1] / neutral.vertices.nbytes
    tracemalloc.stop()
    one = best_seconds(lambda: morph.at(0.5))
    print(f"{name}: {len(neutral.vertices):,} vertices on {len(curves):,} curves")
    print(f"  interpolate, curves given      {seconds * 1e3:8.2f} ms   (limit 100 ms)")
    print(f"  … a further target, prepared   {again * 1e3:8.2f} ms")
    print(f"  one in-between, morph.at(0.5)  {one * 1e3:8.2f} ms = {one / copy:.1f} array copies")
    print(f"  peak memory                    {peak:8.2f} × the vertex array   (limit 8 ×)")

    size, steps, error = coarsest_reference(24)
    problem = smooth_curve(size)
    times = np.linspace(0, 1, steps + 1)
    numerical = best_seconds(lambda: integrate(problem, steps))
    closed = best_seconds(lambda: problem.solution(times))
    print(f"one curve, within {ACCURACY:.1%} of the displacement at {steps + 1} times")
    print(f"  numerical, {size} vertices       {numerical * 1e3:8.3f} ms   (error {error:.3%})")
    print(f"  closed form, {size} vertices     {closed * 1e3:8.3f} ms   ", end="")
    print(f"{numerical / closed:.0f} × faster")

    def every_curve() -> None:
        for _ in curves:
            integrate(problem, steps)

    def every_in_between() -> None:
        em.interpolate(neutral, target, "beam", order=2, curves=curves).at(times)

    numerical, closed = best_seconds(every_curve, 2), best_seconds(every_in_between)
    print(f"as many curves as the face has ({len(curves):,}), the same accuracy and times")
    print(f"  numerical                      {numerical * 1e3:8.1f} ms")
    print(f"  closed form, solved from new   {closed * 1e3:8.1f} ms   ", end="")
    print(f"{numerical / closed:.0f} × faster")
    several = np.linspace(0, 1, 11)
    stored = best_seconds(lambda: morph.at(several)) / len(several)
    print(f"  closed form, stored, one time  {stored * 1e3:8.3f} ms   ", end="")
    print(f"{numerical / (steps + 1) / stored:,.0f} × faster per face")


if __name__ == "__main__":
    main()
