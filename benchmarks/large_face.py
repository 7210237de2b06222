"""What paths cost on faces four and sixteen times as large: the rig with every polygon split.

Run:  python benchmarks/large_face.py [--data FOLDER] [--only METHOD ...]

Prints, in one run, seconds for the first target of a neutral (preparation included) and for a
further one, by beam, plate, arc, rotation and auto, the largest memory the process has had, and by
how much the time a vertex grows from the smallest face to the largest.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from pathlib import Path

import elastomorph as em
from curve_extraction import split
from measuring import data_folder

METHODS = ("beam:2", "plate:2", "arc", "rotation", "auto")
SIZES = 3
ROUNDS = 3


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    parser.add_argument("--only", nargs="*", default=METHODS, help="methods; all by default")
    options = parser.parse_args()
    rig = options.data / "ict-facekit"
    if not rig.is_dir():
        print(f"{rig} is missing: name the folder of the real data with --data", file=sys.stderr)
        return 1
    files = ("generic_neutral_mesh.obj", "jawOpen.obj", "mouthSmile_L.obj")
    meshes = [em.read(rig / file) for file in files]
    further: dict[str, list[float]] = {method: [] for method in options.only}
    sizes = []
    for size in range(SIZES):
        if size:
            meshes = [split(mesh) for mesh in meshes]
        neutral, first, second = (
            meshes[0],
            *(meshes[0].with_vertices(m.vertices) for m in meshes[1:]),
        )
        sizes.append(len(neutral.vertices))
        print(f"{sizes[-1]:,} vertices")
        for method in options.only:
            further[method].append(measure(method, neutral, first, second))
    for method, seconds in further.items():
        each = [one / count for one, count in zip(seconds, sizes, strict=True)]
        print(
            f"{method:<10} a further target {', '.join(f'{one:.2f}' for one in seconds)} s: "
            f"time a vertex grows {each[-1] / each[0]:.2f} times"
        )
    return 0


def measure(method: str, neutral: em.Mesh, first: em.Mesh, second: em.Mesh) -> float:
    """Print what a method takes; seconds of processor time for a further target, the jaw again.

    The shortest of several rounds: other programs on the machine can only add.
    """
    start = time.process_time()
    to = em.prepare(neutral.with_vertices(neutral.vertices), method)
    to(first)
    prepared = time.process_time() - start
    rounds = []
    for target in (first, second) * ROUNDS:
        start = time.process_time()
        to(target)
        rounds.append(time.process_time() - start)
    jaw, smile = min(rounds[::2]), min(rounds[1::2])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"  {method:<10} first {prepared:7.2f} s   further: jawOpen {jaw:6.2f} s, "
        f"mouthSmile_L {smile:6.2f} s   peak memory {peak:.2f} GiB"
    )
    return jaw


if __name__ == "__main__":
    sys.exit(main())
