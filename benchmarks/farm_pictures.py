"""How fast pictures with labels are drawn, and a sheet of them to look at.

Run:  python benchmarks/farm_pictures.py [RIG …] [--sizes 128 256 512] [--sheet SHEET.png]

Rates are of one core, by the time of the processor, for a machine may have other things to do.
Beside them: one picture as VTK draws it for `elastomorph.render`, colour alone; and what a picture
takes in a data set.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numcodecs import Blosc
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.capturing.landmarks import known_landmarks
from elastomorph.draw.stage import Stage
from elastomorph.farm.pictures.painter import Painter
from elastomorph.farm.pictures.settings import ARRAYS
from elastomorph.farm.reading.sheets import contact_sheet

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from small_head import expressions, head, landmarks

LABELS = tuple(name for name in ARRAYS if name != "colour")
SMALL = "small head"
RECIPE = {"seed": 11, "pictures": {}}


def rig_of(name: str) -> em.Rig:
    return em.Rig(head(), expressions()) if name == SMALL else em.read_rig(name)


def marks_of(name: str, mesh: em.Mesh) -> dict[str, int]:
    return landmarks() if name == SMALL else known_landmarks(name, mesh)


def faces_of(rig: em.Rig, count: int) -> tuple[NDArray[np.float32], dict[str, Any]]:
    """Positions and columns of the first faces of a recipe."""
    sampler = em.FaceSampler(rig, RECIPE)
    values = sampler.values(0, count)
    columns = dict(zip(sampler.columns.names, values.T, strict=True))
    return rig.batch(values[:, : len(rig.names)]), columns


def seconds(task: Callable[[], object]) -> float:
    """Of the processor."""
    task()
    start = time.process_time()
    task()
    return time.process_time() - start


def table(name: str, sizes: list[int], count: int) -> None:
    rig = rig_of(name)
    positions, columns = faces_of(rig, count)
    marks = marks_of(name, rig.neutral)
    print(f"{Path(name).name}: {len(rig.neutral.vertices):,} vertices, {count} faces")
    print(f"  pictures a second of one core\n  {'pixels':>8}{'all':>10}{'labels':>10}{'VTK':>10}")
    for size in sizes:
        rates = []
        for arrays in (ARRAYS, LABELS):
            painter = Painter(rig, (size, size), marks, arrays)
            rates.append(count / seconds(lambda: painter.draw(positions, columns)))  # noqa: B023
        with Stage(rig.neutral, size=(size, size)) as stage:
            drawn = seconds(lambda: [stage.picture(own) for own in positions])
        print(f"  {size:>8}{rates[0]:>10.1f}{rates[1]:>10.1f}{count / drawn:>10.1f}")


def bytes_of(name: str, count: int) -> None:
    rig = rig_of(name)
    positions, columns = faces_of(rig, count)
    made = Painter(rig, (256, 256)).draw(positions, columns)
    print(
        f"kB a picture of 256 pixels, {Path(name).name}\n  {'':10}{'bare':>8}{'lz4':>8}{'zstd':>8}"
    )
    for array in ("colour", "depth", "normals", "parts"):
        own = np.ascontiguousarray(made[array])
        sizes = [len(Blosc(codec).encode(own)) for codec in ("lz4", "zstd")]
        kilo = [size / count / 1000 for size in (own.nbytes, *sizes)]
        print(f"  {array:10}" + "".join(f"{each:>8.1f}" for each in kilo))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rigs", nargs="*", default=[SMALL], help="files of rigs")
    parser.add_argument("--sizes", nargs="+", type=int, default=[128, 256, 512])
    parser.add_argument("--faces", type=int, default=8)
    parser.add_argument("--sheet", help="draw a sheet of the first rig, and nothing else")
    given = parser.parse_args()
    if given.sheet:
        rig = rig_of(given.rigs[0])
        positions, columns = faces_of(rig, given.faces)
        painter = Painter(rig, (256, 256), marks_of(given.rigs[0], rig.neutral))
        contact_sheet(painter.draw(positions, columns), range(given.faces), given.sheet)
        return
    for name in given.rigs:
        table(name, given.sizes, given.faces)
        bytes_of(name, given.faces)


if __name__ == "__main__":
    main()
