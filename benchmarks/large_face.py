"""What paths cost on a face four times as large: the rig, and the rig with every polygon split.

Run:  python benchmarks/large_face.py [--data FOLDER]

Prints, in one run, seconds for the first target of a neutral (preparation included) and for a
further one, by beam, plate, arc and rotation, and the largest memory the process has had.
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

METHODS = ("beam:2", "plate:2", "arc", "rotation")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    rig = parser.parse_args().data / "ict-facekit"
    if not rig.is_dir():
        print(f"{rig} is missing: name the folder of the real data with --data", file=sys.stderr)
        return 1
    files = ("generic_neutral_mesh.obj", "jawOpen.obj", "mouthSmile_L.obj")
    meshes = [em.read(rig / file) for file in files]
    for _ in range(2):
        neutral, first, further = meshes
        print(f"{len(neutral.vertices):,} vertices")
        for method in METHODS:
            start = time.perf_counter()
            to = em.prepare(neutral, method)
            to(first)
            middle = time.perf_counter()
            to(further)
            end = time.perf_counter()
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
            print(
                f"  {method:<10} first {middle - start:7.2f} s   further {end - middle:7.2f} s",
                end="",
            )
            print(f"   peak memory {peak:.2f} GiB")
        meshes = [split(mesh) for mesh in meshes]
    return 0


if __name__ == "__main__":
    sys.exit(main())
