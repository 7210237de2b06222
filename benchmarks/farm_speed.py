"""How fast data sets of faces are made and read, as ratios to what bounds it, all in one run.

Run:  python benchmarks/farm_speed.py [recipe ...]

- `recipe`: rows of weights of 57 sliders from `FaceSampler`, by one thread and by two, beside the
  random bits alone that they are made of, for several recipes. Both by the clock and by the time
  of the processor, for a machine may have other things to do.
- `vertices`: int16 vertices made and written on a RAM disk by two threads beside `rig.stream` of
  the same faces into memory: five expressions of a small head, all its sliders, the ICT rig;
- `reading`: faces of a data set of the recipe alone, beside `rig.batch` of the same weights: by
  slices, and by shuffled batches of PyTorch, where it is installed, read by this process or by
  two workers, whose batches go through shared memory;
- `memory`: the most that a process takes, for two numbers of faces;
- `dask`: units of about 0.6 s, 100 a minute each, made by two workers of Dask, beside two processes
  that Python hands the same units: what part of the time they made none.
"""

from __future__ import annotations

import argparse
import multiprocessing
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from importlib.util import find_spec
from itertools import repeat
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

import elastomorph as em
from elastomorph.farm.making.executors import client_of, make_unit, make_units
from elastomorph.farm.making.run import begun, work_off
from elastomorph.farm.sampling.lanes import random_lanes
from elastomorph.farm.storage.stores import Order
from elastomorph.farm.storage.wanted import Wanted
from elastomorph.rig.naming import ARKIT
from measuring import data_folder

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from small_head import expressions, rig_file

_UNITS, _UNIT_SECONDS = 40, 0.6  # For Dask
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


def rigs(data: Path) -> dict[str, tuple[em.Rig, float]]:
    """Rigs by what they are, and how many sliders are on."""
    small = em.read_rig(rig_file())
    found = {"five expressions": (small.only([*expressions()]), 2.5), "small head": (small, 6.0)}
    if (data / "ict-facekit").is_dir():
        found["ICT rig"] = (em.read_rig(data / "ict-facekit"), 6.0)
    return found


def in_turn(tasks: Sequence[Callable[[], object]], faces: int, rounds: int) -> list[Rate]:
    """The best rate of each, in turn, so that a busy moment hits all."""
    runs = [[best_rate(task, faces, 1) for task in tasks] for _ in range(rounds)]
    return [Rate(*(max(own) for own in zip(*of, strict=True))) for of in zip(*runs, strict=True)]


def sampler_of(rig: em.Rig, active: float) -> em.FaceSampler:
    return em.FaceSampler(rig, {"mixture": [{"kind": "sparse", "active": active}]})


def vertices_speed(given: argparse.Namespace) -> None:
    print("int16 vertices on a RAM disk beside rig.stream into memory, two threads; faces a second")
    print(
        f"  {'':18}{'codec':>6}{'stream':>10}{'stored':>10}{'ratio':>7}{'processor':>11}{'MB':>8}"
    )
    for name, (rig, active) in rigs(given.data).items():
        faces = max(256, int(given.bytes * 1e6 / rig.neutral.vertices.size / 2) // 128 * 128)
        sampler = sampler_of(rig, active)
        values = sampler.values(0, faces)
        for codec in ("lz4", "none"):
            with TemporaryDirectory(dir="/dev/shm") as folder, threadpool_limits(2):
                order = Order(f"{folder}/faces.zarr")
                wanted = Wanted(vertices="int16", codec=codec)

                def stream() -> None:
                    for _ in rig.stream(values):  # noqa: B023
                        pass

                runs = []
                for _ in range(given.rounds):
                    rmtree(order.url, ignore_errors=True)
                    data = begun(order, rig, sampler, faces, wanted)
                    data.prepare()  # once for a data set, whatever its size
                    store = partial(work_off, data)
                    runs.append([best_rate(task, faces, 1) for task in (stream, store)])
                bare, stored = (
                    Rate(*map(max, zip(*of, strict=True))) for of in zip(*runs, strict=True)
                )
                size = sum(own.stat().st_size for own in Path(order.url).rglob("c.*"))
            print(
                f"  {name:18}{codec:>6}{bare.clock:>10,.0f}{stored.clock:>10,.0f}"
                f"{stored.clock / bare.clock:>7.2f}{stored.processor / bare.processor:>11.2f}"
                f"{size / 1e6:>8.0f}"
            )


def reading_speed(given: argparse.Namespace) -> None:
    print("faces read from a recipe beside rig.batch of as many, two threads; faces a second")
    print(f"  {'':18}{'at once':>16}{'batch':>10}{'read':>10}{'ratio':>7}{'processor':>11}")
    for name, (rig, active) in rigs(given.data).items():
        most = int(given.bytes * 1e6 / rig.neutral.vertices.size / 4)
        with TemporaryDirectory() as folder, threadpool_limits(2):
            recipe = {"mixture": [{"kind": "sparse", "active": active}]}
            found = em.make_faces(rig, f"{folder}/faces.zarr", 65536, recipe=recipe)
            for size in (256, min(4096, most // 256 * 256)):
                values = found.weights[:size]
                tasks = [partial(rig.batch, values), partial(found.__getitem__, slice(0, size))]
                told(name, f"{size:,}", *in_turn(tasks, size, given.rounds))
            if find_spec("torch") is None:
                print("  without PyTorch: no batches of it")
                continue
            told(name, "256, PyTorch", *by_loader(found, 32, 0))
            told(name, "256, 2 workers", *by_loader(found, 32, 2))


def by_loader(faces: em.FaceSet, batches: int, workers: int) -> tuple[Rate, Rate]:
    """Batches of 256 by `rig.batch`, and shuffled by PyTorch, once its workers run."""
    batch = partial(faces.rig.batch, faces.weights[:256])
    before = best_rate(batch, 256, 5)
    loader = faces.as_torch("vertices").batches(256, faces=slice(256 * batches), workers=workers)
    with threadpool_limits(1 if workers else 2):  # in each process
        own = iter(loader)
    next(own)
    read = best_rate(lambda: deque(own, maxlen=0), 256 * (batches - 1), 1)
    rate = max(before, best_rate(batch, 256, 5))
    return rate, read._replace(processor=np.nan) if workers else read


def told(name: str, size: str, batch: Rate, read: Rate) -> None:
    print(
        f"  {name:18}{size:>16}{batch.clock:>10,.0f}{read.clock:>10,.0f}"
        f"{read.clock / batch.clock:>7.2f}{read.processor / batch.processor:>11.2f}"
    )


def memory(given: argparse.Namespace) -> None:
    print("the most that a process takes, MB")
    program = (
        "import sys, resource, elastomorph as em\n"
        "place, faces, kind, out = sys.argv[1:]\n"
        "rig = em.read_rig(place)\n"
        "em.make_faces(rig, out, int(faces), vertices=kind or None)\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)\n"
    )
    places = {"small head": (str(rig_file()), 10_000, 1_000_000)}
    if (given.data / "ict-facekit").is_dir():
        places["ICT rig"] = (str(given.data / "ict-facekit"), 512, 1_000_000)
    for name, (place, some, many) in places.items():
        for kind, count in (("int16", some), ("", many)):
            found = []
            for faces in (count, 4 * count):
                with TemporaryDirectory(dir="/dev/shm") as folder:
                    words = [sys.executable, "-c", program, place, str(faces), kind, f"{folder}/f"]
                    found.append(f"{faces:,} faces {int(subprocess.check_output(words))}")
            print(f"  {name:10}{kind or 'recipe alone':14}{', '.join(found)}")


def dask_overhead(given: argparse.Namespace) -> None:
    rig = em.read_rig(rig_file())
    sampler = sampler_of(rig, 6.0)
    print(f"{_UNITS} units made by two processes, in seconds, and the time in which they made none")
    print(f"  {'handed by':12}{'each':>8}{'a minute':>10}{'all':>9}{'lost':>9}")
    with TemporaryDirectory(dir="/dev/shm") as folder:
        unit = _unit_of(_UNIT_SECONDS, rig, sampler, folder)
        wanted = Wanted(vertices="int16", unit=unit)
        data = begun(Order(f"{folder}/faces.zarr"), rig, sampler, _UNITS * unit, wanted)
        units = list(range(_UNITS))
        context = multiprocessing.get_context("spawn")
        with (
            ProcessPoolExecutor(2, context, threadpool_limits, (1,)) as pool,
            client_of("local") as client,
        ):
            ways = {
                "Python": lambda: list(
                    pool.map(make_unit, repeat(data.order), repeat(data.identity), units)
                ),
                "Dask": lambda: list(make_units(data, units, client)),
            }
            found: dict[str, list[Handed]] = {name: [] for name in ways}
            for run in range(given.rounds + 1):  # the first opens rig and data set everywhere
                for name, way in ways.items():
                    for entry in Path(data.order.url, "manifest").glob("c.*"):
                        entry.unlink()  # nothing is finished
                    start = time.perf_counter()
                    spent = sum(made.seconds for made in way())
                    found[name] += [Handed(time.perf_counter() - start, spent)] if run else []
    for name, own in found.items():
        best = min(own, key=lambda handed: handed.lost)
        each = best.making / _UNITS
        print(
            f"  {name:12}{each:>8.2f}{60 * _UNITS / best.clock:>10.0f}{best.clock:>9.2f}"
            f"{best.lost:>9.1%}"
        )


class Handed(NamedTuple):
    """Seconds by the clock, and of both processes within units."""

    clock: float
    making: float

    @property
    def lost(self) -> float:
        """What part of the time the two processes did not make units."""
        return 1 - self.making / (2 * self.clock)


def _unit_of(seconds: float, rig: em.Rig, sampler: em.FaceSampler, folder: str) -> int:
    """Faces that take one process about so long."""
    unit = 32
    while unit < 2**15:
        order = Order(f"{folder}/{unit}.zarr")
        data = begun(order, rig, sampler, 2 * unit, Wanted(vertices="int16", unit=unit))
        with threadpool_limits(1):
            make_unit(order, data.identity, 0)
            spent = make_unit(order, data.identity, 1).seconds
        rmtree(data.order.url)
        if spent > seconds / 1.5:
            break
        unit *= 2
    return unit


PARTS: Mapping[str, Callable[[argparse.Namespace], None]] = {
    "recipe": lambda given: recipe_speed(given.faces, given.repeats),
    "vertices": vertices_speed,
    "reading": reading_speed,
    "memory": memory,
    "dask": dask_overhead,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", default=[*PARTS], help=f"of {', '.join(PARTS)}")
    parser.add_argument("--faces", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--data", type=Path, default=data_folder())
    parser.add_argument("--bytes", type=float, default=200, help="MB of vertices in a run")
    parser.add_argument("--rounds", type=int, default=5)
    given = parser.parse_args()
    for part in given.parts:
        if part not in PARTS:
            parser.error(f"there is no part {part!r}: {', '.join(PARTS)}")
        PARTS[part](given)


if __name__ == "__main__":
    main()
