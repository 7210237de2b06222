"""Time to turn a face into curves, and how it grows with the face.

The face is extracted as it is, and again after every polygon was split into quads by a point on
each edge and one inside (the topology of Catmull-Clark subdivision), three times over. Without the
real face, a cube split the same way until it has as many vertices stands in for it.

    python benchmarks/curve_extraction.py [--data FOLDER | FACE.obj] [--splits 3] [--repeats 3]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import perf_counter

import numpy as np

from elastomorph.curves import extract_curves
from elastomorph.io import read
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons
from measuring import data_folder

FACE = Path("ict-facekit") / "generic_neutral_mesh.obj"


def split(mesh: Mesh) -> Mesh:
    """Every polygon of n corners split into n quads."""
    count = len(mesh.vertices)
    corners = mesh.faces.indices.astype(np.int64)
    following = mesh.faces.next_corners
    low = np.minimum(corners, corners[following])
    high = np.maximum(corners, corners[following])
    keys, edge = np.unique(low * count + high, return_inverse=True)
    edge_points = mesh.vertices[np.stack(np.divmod(keys, count))].mean(axis=0)
    sums = np.add.reduceat(mesh.vertices[corners], mesh.faces.offsets[:-1])
    face_points = sums / mesh.faces.sizes[:, None]
    after = count + edge
    before = np.empty_like(after)
    before[following] = after
    inside = count + len(keys) + mesh.faces.corner_faces
    return Mesh(
        np.concatenate([mesh.vertices, edge_points, face_points]),
        np.stack([corners, after, inside, before], axis=1),
    )


def cube(least_vertices: int) -> Mesh:
    """A cube, split until it has at least so many vertices."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    mesh = Mesh(corners, sides)
    while len(mesh.vertices) < least_vertices:
        mesh = split(mesh)
    return mesh


def shortest_time(mesh: Mesh, repeats: int) -> tuple[float, int, int]:
    """Seconds of the fastest of several extractions, the number of curves and of closed ones."""
    seconds = []
    for _ in range(repeats):
        # A fresh mesh each time: nothing computed for the last extraction is there to be reused.
        fresh = Mesh(mesh.vertices, Polygons(mesh.faces.indices, mesh.faces.offsets))
        start = perf_counter()
        network = extract_curves(fresh)
        seconds.append(perf_counter() - start)
    return min(seconds), len(network), sum(curve.closed for curve in network)


def face_from(given: Path) -> tuple[str, Mesh]:
    """The face at a path or in a data folder, or what stands in for it."""
    path = given / FACE if given.is_dir() else given
    if path.is_file():
        return path.name, read(path)
    return f"a cube ({path} is not there)", cube(20_000)


def report_line(name: str, mesh: Mesh, repeats: int) -> float:
    """Print one measurement; returns the microseconds a vertex."""
    seconds, curves, closed = shortest_time(mesh, repeats)
    per_vertex = seconds / len(mesh.vertices) * 1e6
    print(
        f"{name:<8} {len(mesh.vertices):>10,} vertices  {curves:>7,} curves ({closed:,} closed)"
        f"  {seconds:8.3f} s  {per_vertex:6.2f} µs a vertex"
    )
    return per_vertex


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("face", nargs="?", type=Path, help="a mesh file")
    parser.add_argument("--data", type=Path, default=data_folder())
    parser.add_argument("--splits", type=int, default=3, help="times every polygon is split")
    parser.add_argument("--repeats", type=int, default=3, help="extractions; the fastest counts")
    options = parser.parse_args()

    name, mesh = face_from(options.face or options.data)
    print(f"{name}: {len(mesh.faces):,} polygons")
    extract_curves(cube(8))  # loads what is loaded on first use
    plain = report_line("as it is", mesh, options.repeats)
    for _ in range(options.splits):
        mesh = split(mesh)
    large = report_line(f"split ×{options.splits}", mesh, options.repeats)
    print(f"time a vertex grows by a factor of {large / plain:.2f}")


if __name__ == "__main__":
    main()
