"""How fast data sets of faces are made and read, as ratios to what bounds it, all in one run.

Run:  python benchmarks/farm_speed.py [recipe ...]

- `recipe`: rows of weights of 57 sliders from `FaceSampler`, by one thread and by two, beside the
  random bits alone that they are made of, for several recipes. Both by the clock and by the time
  of the processor, for a machine may have other things to do.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

import elastomorph as em
from elastomorph.farm.lanes import random_lanes
from elastomorph.rig.performance.naming import ARKIT

WANTED = 2e6
"""Faces a second from the recipe alone."""

RECIPES: Mapping[str, dict[str, Any]] = {
    "sparse": {},
    "sparse, sizes squared": {"mixture": [{"kind": "sparse", "power": 2}]},
    "sparse, an exclusion": {"exclude": [{"sliders": ["mouthPress*", "jawOpen"], "most": 1}]},
    "sparse, time, scene": {"timing": {}, "pictures": {}},
    "uniform": {"mixture": [{"kind": "uniform"}]},
    "dirichlet": {"mixture": [{"kind": "dirichlet"}]},
    "three mixtures": {
        "mixture": [{"kind": "sparse"}, {"kind": "uniform"}, {"kind": "sparse", "active": 12}]
    },
}


class Rate(NamedTuple):
    """Faces a second, by the clock and by the time of the processor."""

    clock: float
    processor: float


def best_rate(task: Callable[[], object], faces: int, repeats: int) -> Rate:
    """The best of several runs."""
    clock, processor = [], []
    for _ in range(repeats):
        start, spent = time.perf_counter(), time.process_time()
        task()
        clock.append(time.perf_counter() - start)
        processor.append(time.process_time() - spent)
    return Rate(faces / min(clock), faces / min(processor))


def rig_of_57() -> em.Rig:
    """57 sliders; what they move is nothing to a sampler."""
    mesh = em.Mesh(np.eye(3), [[0, 1, 2]])
    moved = em.interpolate(mesh, mesh.with_vertices(mesh.vertices + 1), "linear")
    return em.Rig(mesh, dict.fromkeys([*ARKIT, *(f"own{i}" for i in range(5))], moved))


def recipe_speed(faces: int, repeats: int) -> None:
    rig = rig_of_57()
    # 57 sliders that are on or off and have a size, and what is common to a face: 128 lanes.
    bits = best_rate(lambda: random_lanes(0, 0, faces, 128), faces, repeats)
    print(f"recipe only, 57 sliders, {faces:,} faces at once; million faces a second")
    print(f"  {'':24}{'one thread':>12}{'processor':>11}{'two threads':>13}{'of bits':>9}")
    print(f"  {'random bits alone':24}{bits.clock / 1e6:>12.2f}{bits.processor / 1e6:>11.2f}")
    half = faces // 2
    for name, recipe in RECIPES.items():
        sampler = em.FaceSampler(rig, recipe)
        one = best_rate(lambda: sampler.codes(0, faces), faces, repeats)  # noqa: B023
        with ThreadPoolExecutor(2) as pool:
            both = best_rate(
                lambda: list(pool.map(sampler.codes, (0, half), (half, faces))),  # noqa: B023
                faces,
                repeats,
            )
        print(
            f"  {name:24}{one.clock / 1e6:>12.2f}{one.processor / 1e6:>11.2f}"
            f"{both.clock / 1e6:>13.2f}{one.processor / bits.processor:>9.2f}"
        )
        if name == "sparse":
            print(f"  {'wanted of two cores':24}{WANTED / 1e6:>36.2f}")


PARTS: Mapping[str, Callable[[argparse.Namespace], None]] = {
    "recipe": lambda given: recipe_speed(given.faces, given.repeats),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", default=[*PARTS], help=f"of {', '.join(PARTS)}")
    parser.add_argument("--faces", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=7)
    given = parser.parse_args()
    for part in given.parts:
        if part not in PARTS:
            parser.error(f"there is no part {part!r}: {', '.join(PARTS)}")
        PARTS[part](given)


if __name__ == "__main__":
    main()
