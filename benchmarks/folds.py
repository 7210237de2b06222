"""Visible folds of a take, before and after correctives of folds, counted by other code.

    python benchmarks/folds.py take.csv [--rig built-in] [--method auto] [--count 15] [--step 20]

Correctives are chosen on the first half of the take; both halves are counted, each `--step`-th
frame. A triangle is folded where its normal points against the sum of those of all triangles in
three rings, gathered here by walking from corner to corner; it is seen where that sum faces +Z and
a ray of VTK from the front reaches one of four points of it before, or less than 0.05 % of D after,
anything else. Nothing of what chose the correctives is used.
"""

from __future__ import annotations

import argparse
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.holding.folds import fold_correctives
from elastomorph.rig.performance import slider_weights

Points = NDArray[np.float64]
PLACES = np.array([[1, 1, 1], [2.4, 0.3, 0.3], [0.3, 2.4, 0.3], [0.3, 0.3, 2.4]]) / 3


class Counter:
    """Counts folds of one surface that are seen from the front."""

    def __init__(self, neutral: em.Mesh) -> None:
        self.triangles = np.array(
            [(f[0], f[k], f[k + 1]) for f in neutral.faces for k in range(1, len(f) - 1)]
        )
        around: list[list[int]] = [[] for _ in neutral.vertices]
        for number, triangle in enumerate(self.triangles.tolist()):
            for corner in triangle:
                around[corner].append(number)
        lists = []
        for triangle in self.triangles.tolist():
            reached = set(triangle)
            for _ in range(2):
                faces = {face for corner in reached for face in around[corner]}
                reached = {corner for face in faces for corner in self.triangles[face].tolist()}
            lists.append(sorted({face for corner in reached for face in around[corner]}))
        self.near = np.concatenate(lists)
        self.starts = np.cumsum([0, *map(len, lists[:-1])])
        self.free = 5e-4 * float(np.linalg.norm(np.ptp(neutral.vertices, axis=0)))
        self.rest = np.zeros(len(self.triangles), dtype=bool)
        self.rest = self._folded(neutral.vertices)[0]

    def _folded(self, points: Points) -> tuple[NDArray[np.bool_], Points]:
        a, b, c = (points[self.triangles[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        sums = np.add.reduceat(normals[self.near], self.starts, axis=0)
        return ((normals * sums).sum(axis=1) < 0) & ~self.rest, sums

    def count(self, points: Points) -> int:
        """How many there are in a pose."""
        arrays, core, model = (
            import_module(f"vtkmodules.{name}")
            for name in ("util.numpy_support", "vtkCommonCore", "vtkCommonDataModel")
        )
        folded, sums = self._folded(points)
        rows = np.flatnonzero(folded & (sums[:, 2] > 0))
        if not len(rows):
            return 0
        surface, places, cells = model.vtkPolyData(), core.vtkPoints(), model.vtkCellArray()
        places.SetData(arrays.numpy_to_vtk(np.ascontiguousarray(points), deep=True))
        three = np.insert(self.triangles, 0, 3, axis=1).astype(np.int64)
        cells.SetCells(len(three), arrays.numpy_to_vtkIdTypeArray(three.ravel(), deep=True))
        surface.SetPoints(places)
        surface.SetPolys(cells)
        locator = model.vtkStaticCellLocator()
        locator.SetDataSet(surface)
        locator.BuildLocator()
        front, seen = float(points[:, 2].max()) + 1.0, 0
        for row in rows:
            for place in PLACES @ points[self.triangles[row]]:
                hit = [0.0, 0.0, 0.0]
                crossed = locator.IntersectWithLine(
                    [place[0], place[1], front],
                    [place[0], place[1], place[2] + self.free],
                    0.0, core.mutable(0.0), hit, [0.0, 0.0, 0.0], core.mutable(0),
                )  # fmt: skip
                if not crossed:
                    seen += 1
                    break
        return seen


def main() -> None:
    """Print the correctives and both halves before and after."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("take")
    parser.add_argument("--rig", default="built-in")
    parser.add_argument("--method")
    parser.add_argument("--count", type=int, default=15)
    parser.add_argument("--step", type=int, default=20)
    chosen = parser.parse_args()
    rig = em.read_rig(chosen.rig, method=chosen.method)
    take = em.read_performance(chosen.take)
    found = fold_correctives(rig, chosen.count, take)
    print("| driven by | folds before | after | moved, % of D |\n|---|---|---|---|")
    for _, _, corrective, row in found:
        names = " and ".join(f"`{name}`" for name in corrective.drivers)
        print(f"| {names} | {row.before:.2f} | {row.after:.2f} | {100 * row.share:.2f} |")
    weights, counter = slider_weights(rig, take, clip=True), Counter(rig.neutral)
    places = {name: place for place, name in enumerate(rig.names)}
    half = (len(weights) + 1) // 2
    print("\n| frames | folds seen, before | after |\n|---|---|---|")
    for start, stop in ((0, half), (half, len(weights))):
        before, after = [], []
        for frame in weights[start : stop : chosen.step]:
            pose = rig.pose(frame)
            before.append(counter.count(pose))
            for _, morph, corrective, _ in found:
                least = min(frame[places[name]] for name in corrective.drivers)
                pose = pose + max(0.0, least) * morph.delta
            after.append(counter.count(pose))
        print(f"| {start} to {stop - 1} | {np.mean(before):.2f} | {np.mean(after):.2f} |")


if __name__ == "__main__":
    main()
