"""What a data set of a billion faces with pictures takes on a hundred machines, on paper.

Run:  python benchmarks/farm_scale.py [--faces 1e9] [--machines 100] [--rig RIG]

Rates and bytes of a face are measured here, in this run, on one core; the machines, their network
and their store are assumed, and each assumption is printed and can be given. The farm is then
simulated, unit by unit: cores that take the next unit when they are free, pictures that take
longer in some faces and on some machines, a network that the cores of a machine share, requests
that the store answers one after another beyond its rate, and machines that are lost with what
they were making.
"""

from __future__ import annotations

import argparse
import heapq
import sys
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import elastomorph as em
from elastomorph.farm.making.executors import make_unit
from elastomorph.farm.making.run import begun
from elastomorph.farm.storage.stores import Order
from elastomorph.farm.storage.wanted import Wanted

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from small_head import head, shapes

SIZE = 256
RECIPE = {"seed": 3, "pictures": {"size": SIZE}}
UNITS = (64, 128, 256, 512, 1024, 4096, 16384)
TRIALS = (32, 128)
"""Faces in the units that are made to measure what a face costs, and what a unit costs besides."""

SIMULATED = 500_000
"""Units simulated at most; a run of more is taken to go on as evenly as it began."""


@dataclass(frozen=True)
class Work:
    """What a face costs, as measured."""

    seconds: float  # Of one core, to make a face
    unit_seconds: float  # Of one core, for a unit beside its faces
    bytes: float  # Stored of a face
    arrays: int  # Objects of a unit, beside its row of the manifest


@dataclass(frozen=True)
class Machines:
    """What makes the faces; assumed, and what others publish of such machines."""

    machines: int = 100
    cores: int = 16  # Of each
    network: float = 1.25e9  # Bytes a second of each: 10 Gbit/s
    stream: float = 80e6  # Bytes a second of one request
    latency: float = 0.1  # Seconds until a request is answered
    requests: float = 3500.0  # Writing requests a second that the store answers under one prefix
    tasks: float = 1000.0  # Units a second that the scheduler gives out
    spread: float = 0.15  # Of the time of units: standard deviation of its logarithm
    slow: float = 0.02  # Share of machines ...
    slowness: float = 3.0  # ... that take so many times as long
    lost_hours: float = 24.0  # A machine is lost once in so many hours on average ...
    back: float = 300.0  # ... and another is there after so many seconds


@dataclass(frozen=True)
class Run:
    """What a simulated run took."""

    hours: float
    ideal: float  # Hours of the same work spread evenly over the cores, none lost or slow
    lost: float  # Share of the cores' time whose work was lost
    drawing: float  # Share of the cores' time in which faces are made
    requests: float  # A second, on average


def simulate(work: Work, farm: Machines, faces: int, unit: int, seed: int = 0) -> Run:
    """One run, in units of so many faces, of which the last counts as a whole one.

    What the scheduler and the store cannot do at once they do in the order in which they are asked.
    """
    random = np.random.default_rng(seed)
    units, slots = -(-faces // unit), farm.machines * farm.cores
    pace = np.where(random.random(farm.machines) < farm.slow, farm.slowness, 1.0)
    mean = work.unit_seconds + unit * work.seconds
    bandwidth = min(farm.stream * work.arrays, farm.network / farm.cores)
    writing = 2 * farm.latency + unit * work.bytes / bandwidth  # Shards at once, then the manifest
    lost = random.exponential(farm.lost_hours * 3600, (farm.machines, 1000)).cumsum(axis=1)
    lost += farm.back * np.arange(1000)

    def lost_after(moment: float, slot: int) -> float:
        own = lost[slot // farm.cores]
        return float(own[np.searchsorted(own, moment)])

    # When a core is free (begun < 0), or has made the faces of the unit that it began.
    events = [(0.0, slot, -1.0) for slot in range(slots)]
    scheduler = store = end = drawing = wasted = 0.0
    waiting = units
    while events:
        now, slot, begun = heapq.heappop(events)
        if begun < 0 and not waiting:
            continue
        if begun < 0:
            waiting -= 1
            begun = scheduler = max(now, scheduler + 1 / farm.tasks)
            ready = begun + mean * pace[slot // farm.cores] * float(
                np.exp(random.normal(-(farm.spread**2) / 2, farm.spread))
            )
            after = (ready, slot, begun)
        else:
            drawing += now - begun
            store = max(now, store + (work.arrays + 1) / farm.requests)
            ready = store + writing
            after = (ready, slot, -1.0)
        if (gone := lost_after(begun, slot)) < ready:
            waiting += 1
            wasted += gone - begun
            after = (gone + farm.back, slot, -1.0)
        elif after[2] < 0:
            end = max(end, ready)
        heapq.heappush(events, after)
    return Run(
        end / 3600,
        units * (mean + writing) / slots / 3600,
        wasted / (end * slots),
        drawing / (end * slots),
        units * (work.arrays + 1) / end,
    )


def measured(rig: em.Rig) -> tuple[Work, dict[str, float]]:
    """What a face costs on one core here, and the bytes of a face in each array."""
    seconds, sizes = [], {}
    for unit in TRIALS:
        with TemporaryDirectory() as folder:
            order = Order(str(Path(folder) / "trial.zarr"))
            data = begun(order, rig, em.FaceSampler(rig, RECIPE), unit, Wanted(unit=unit))
            data.prepare()
            start = time.process_time()
            made = make_unit(order, data.identity, 0)
            seconds.append(time.process_time() - start)
            sizes = {
                name: sum(data.objects.sizes(name).values()) / unit for name in data.plan.arrays
            }
    face = (seconds[1] - seconds[0]) / (TRIALS[1] - TRIALS[0])
    once = max(seconds[0] - TRIALS[0] * face, 0.0)
    return Work(face, once, made.bytes / made.faces, len(sizes)), sizes


def table_of_units(work: Work, farm: Machines, faces: int) -> None:
    print(
        f"{'faces a unit':>12}{'units':>12}{'objects':>14}{'MB each':>9}{'hours':>8}{'even':>7}"
        f"{'drawing':>9}{'lost':>8}{'requests/s':>12}{'listing':>9}"
    )
    for unit in UNITS:
        part = min(faces, SIMULATED * unit)
        run = simulate(work, farm, part, unit)
        units = -(-faces // unit)
        objects = units * (work.arrays + 1)
        print(
            f"{unit:>12,}{units:>12,}{objects:>14,}"
            f"{unit * work.bytes / work.arrays / 1e6:>9.1f}{run.hours * faces / part:>8.1f}"
            f"{run.ideal * faces / part:>7.1f}{run.drawing:>9.1%}{run.lost:>8.2%}"
            f"{run.requests:>12.0f}{objects / 1000 * farm.latency / 60:>7.1f} m"
        )


def table_of_limits(work: Work, farm: Machines, faces: int) -> None:
    """What each part would take if it were alone."""
    cores = farm.machines * farm.cores
    parts = {
        "drawing": faces * work.seconds / cores,
        "network of the machines": faces * work.bytes / (farm.network * farm.machines),
        **{
            f"requests, {unit:,} faces a unit": faces / unit * (work.arrays + 1) / farm.requests
            for unit in (64, 1024)
        },
        "scheduler, 64 faces a unit": faces / 64 / farm.tasks,
    }
    for name, seconds in parts.items():
        print(f"  {name:<34}{seconds / 3600:>8.2f} hours")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faces", type=float, default=1e9)
    parser.add_argument("--rig", help="a file or folder; a small head by default")
    for name, value in asdict(Machines()).items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=type(value), default=value)
    given = vars(parser.parse_args())
    faces, name = int(given.pop("faces")), given.pop("rig")
    farm = Machines(**given)
    rig = em.Rig(head(), shapes()) if name is None else em.read_rig(name)
    work, sizes = measured(rig)
    print(f"measured here, {len(rig.neutral.vertices):,} vertices, {SIZE} x {SIZE} pixels:")
    print(
        f"  {work.seconds * 1e3:.1f} ms of a core a face, {work.unit_seconds * 1e3:.0f} ms a unit"
    )
    print(f"  {work.bytes / 1e3:.1f} kB a face: ", end="")
    print(", ".join(f"{key} {size / 1e3:.1f}" for key, size in sizes.items() if size > 1e3))
    print("assumed:")
    print("\n".join(f"  {key:<12}{value:>14,g}" for key, value in asdict(farm).items()))
    print(f"{faces:,} faces: {faces * work.bytes / 1e12:,.1f} TB; each part alone:")
    table_of_limits(work, farm, faces)
    print("simulated:")
    table_of_units(work, farm, faces)
    print("the same without losses and slow machines:")
    table_of_units(work, replace(farm, lost_hours=1e9, slow=0.0), faces)


if __name__ == "__main__":
    main()
