"""How long files take: a production mesh in every format, and a recorded take.

Run:  python benchmarks/file_speed.py [--data FOLDER]

Prints milliseconds, shortest of several runs, and what they are to a plain copy of the file.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from elastomorph.io import read, write
from elastomorph.io.performance import read_livelink
from measuring import best_seconds, data_folder


def best(task: Callable[[], object]) -> float:
    """Shortest of several runs, in milliseconds."""
    return 1e3 * best_seconds(task, 9)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    folder = parser.parse_args().data
    source = folder / "ict-facekit" / "generic_neutral_mesh.obj"
    if not source.is_file():
        print(f"{source} is missing: name the folder of real data with --data", file=sys.stderr)
        return 1
    mesh = read(source)
    print(f"{len(mesh.vertices):,} vertices, {len(mesh.faces):,} polygons; milliseconds")
    print(f"  OBJ as it came   read {best(lambda: read(source)):7.1f}   (limit 250)")
    with tempfile.TemporaryDirectory() as place:
        for suffix in (".obj", ".ply", ".npz"):
            path = Path(place) / f"face{suffix}"
            written = best(lambda path=path: write(path, mesh))
            again = best(lambda path=path: read(path))
            copied = best(path.read_bytes)
            print(f"  {suffix:<16} read {again:7.1f}   write {written:7.1f}", end="")
            print(f"   read in {again / copied:.0f} × the time of its bytes")
    take = folder / "livelink" / "rom_3.csv"
    print(f"  {take.name:<16} read {best(lambda: read_livelink(take)):7.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
