"""Paths around joints on a production rig: how true the jaw turns, what folds, what it costs.

Run:  python benchmarks/rotation_speed.py [--data FOLDER] [--only NAME ...]

Prints, for linear, arc, rotation and auto: the largest distance of teeth and gums from the hinge's
true arc on the way to jawOpen, how far the lids of eyeBlink_L sink towards the eye below both ends,
polygons that point against both ends, the number of bends and the bake error, and the seconds of
processor time, all of the real rig's targets at t = 0.25, 0.5 and 0.75. Then which targets auto
bends and by how much, and how long the rig takes with auto, from its folder and from the cache.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from elastomorph.evaluation.shape import ShapeProbe
from elastomorph.io import read
from elastomorph.io.rig_folder import read_rig_folder
from elastomorph.model.geometry import fit_rigid
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Choice, Morph
from elastomorph.paths.method import Method
from measuring import data_folder

NEUTRAL = "generic_neutral_mesh"
TIMES = (0.25, 0.5, 0.75)
GUMS, TEETH = slice(14062, 17039), slice(17039, 21451)
SKIN, SCLERA = slice(0, 9409), slice(21451, 22221)
SCLERA_RADIUS = 1.577


def off_the_hinge(morph: Morph) -> tuple[int, float, int, float]:
    """Number of moving teeth vertices and their largest error / D; the same of the gums."""
    start, end = morph.neutral.vertices, morph.target.vertices
    teeth = TEETH.start + np.flatnonzero((start != end)[TEETH].any(axis=1))
    screw, residual = fit_rigid(start[teeth], end[teeth])
    left_over = np.linalg.norm(screw.at(1.0, start[GUMS]) - end[GUMS], axis=1)
    gums = GUMS.start + np.flatnonzero(left_over <= residual.max())
    worst = []
    for part in (teeth, gums):
        off = [morph.at(t)[part] - screw.at(t, start[part]) for t in TIMES]
        worst.append(float(np.linalg.norm(off, axis=2).max()) / morph.neutral.diameter)
    return len(teeth), worst[0], len(gums), worst[1]


def lid_sinking(morph: Morph) -> float:
    """How far the lids come closer to the eye's centre than at both ends, in units of the rig."""
    start, end = morph.neutral.vertices, morph.target.vertices
    sclera = start[SCLERA]
    sphere = np.column_stack([2 * sclera, np.ones(len(sclera))])
    centre = np.linalg.lstsq(sphere, (sclera**2).sum(axis=1), rcond=None)[0][:3]
    away = [np.linalg.norm(points[SKIN] - centre, axis=1) for points in (start, end)]
    closest = np.minimum(*away)
    moved = np.linalg.norm((end - start)[SKIN], axis=1) > 0.05
    lids = moved & (closest < 1.25 * SCLERA_RADIUS)
    depths = [closest - np.linalg.norm(morph.at(t)[SKIN] - centre, axis=1) for t in TIMES]
    return float(np.array(depths)[:, lids].max())


def measure(
    name: str, prepare: Callable[[], Callable[[Mesh], Morph]], rig: dict[str, Mesh]
) -> None:
    """Print what a method does to every target, and the sums."""
    start, wall = process_time(), perf_counter()
    to = prepare()
    print(f"{name}: prepared in {process_time() - start:.2f} s of processor time")
    seconds, folded = [], 0
    for target_name, target in rig.items():
        start = process_time()
        morph = to(target)
        seconds.append(process_time() - start)
        nobody = np.zeros(len(target.vertices), dtype=int)
        probe = ShapeProbe.of(morph.neutral, target, nobody)
        flips = [probe.flips(morph.at(t)) for t in TIMES]
        folded += max(flips)
        chosen = "" if morph.choice is None else f"  {morph.method}: {_why(morph.choice)}"
        print(
            f"  {target_name:<18} flips {flips}  bends {len(morph.bends)}  "
            f"bake error {morph.bake_error:.1e} of D  {seconds[-1]:5.2f} s{chosen}"
        )
        if target_name == "jawOpen":
            teeth, teeth_off, gums, gums_off = off_the_hinge(morph)
            print(
                f"    {teeth:,} vertices of teeth within {teeth_off:.3%} of D of the true arc, "
                f"{gums:,} of gums within {gums_off:.3%}"
            )
        if target_name == "eyeBlink_L":
            print(f"    lids sink by up to {lid_sinking(morph):.4f} of {SCLERA_RADIUS}")
    print(
        f"  {len(rig)} targets: {sum(seconds):.1f} s of processor time, the slowest "
        f"{max(seconds):.2f} s; {folded} flips; wall clock with these checks "
        f"{perf_counter() - wall:.1f} s"
    )


def _why(choice: Choice) -> str:
    return f"{'' if choice.exact else 'at most '}{choice.distance:.3%} of D from straight halfway"


def load(folder: Path) -> None:
    """Print how long the whole rig takes, files read and curves of time and all."""
    with tempfile.TemporaryDirectory() as scratch:
        for words in ("read, with auto", "from the cache"):
            start, wall = process_time(), perf_counter()
            rig = read_rig_folder(folder, method="auto", cache=Path(scratch))
            bent = sum(len(morph.bends) > 0 for morph in rig.morphs.values())
            print(
                f"the rig {words}: {perf_counter() - wall:.2f} s, {process_time() - start:.2f} s "
                f"of processor time; {bent} of {len(rig.morphs)} targets bend"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    parser.add_argument("--only", nargs="*", help="names of targets; all by default")
    options = parser.parse_args()
    rig = options.data / "ict-facekit"
    if not rig.is_dir():
        parser.error(f"there is no rig in {rig}: name the folder with --data")
    neutral = read(rig / f"{NEUTRAL}.obj")
    names = options.only or sorted(p.stem for p in rig.glob("*.obj") if p.stem != NEUTRAL)
    # Targets share the polygons of the neutral, so that comparing them costs nothing.
    targets = {name: neutral.with_vertices(read(rig / f"{name}.obj").vertices) for name in names}
    for name in ("linear", "arc", "rotation", "auto"):
        measure(name, lambda name=name: Method(name).prepare(neutral), targets)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"peak memory, all targets loaded: {peak:.2f} GiB")
    load(rig)


if __name__ == "__main__":
    main()
