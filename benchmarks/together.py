"""What two sliders at a time part that the straight rig keeps together, with pair bends and without.

    python benchmarks/together.py [RIG…] [--take FILE]

RIG is ``built-in``, or any file or folder; the built-in head and the FaceCap head by default. For
each: the largest slide of lips that touch, bent against straight, along jawOpen = mouthClose; the
same at what a take says of both, in both halves of its frames, where mouthClose is above 0.05; and
every pair of sliders on a grid of 9 × 9 weights, the worst first. Facing vertices and what holds
them are found here, by nothing of the product: vertices whose normals point at each other, less
than 1.2 % of D apart in the neutral, of lips 0.2 %; of every pair those count that the straight rig
keeps within 0.2 % of D of how they lay.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import elastomorph as em
from measuring import data_folder

Floats = NDArray[np.float64]

GRID = np.linspace(0.0, 1.0, 9)
NEAR, TOUCHING, KEPT = 1.2e-2, 2e-3, 2e-3  # fractions of D
WORST = 10
MET = 0.05  # the weight of mouthClose from which a frame counts


class Contacts:
    """Vertices of a rig that face each other, and what moves them against each other.

    Attributes:
        pairs: (C, 2) vertices.
        touching: (C,) bool, which of them touch in the neutral.
        extent: D of the skin, or of all that targets move.
    """

    def __init__(self, rig: em.Rig) -> None:
        self.rig = rig
        neutral = rig.neutral.vertices
        moved = np.zeros(len(neutral), dtype=bool)
        for name in rig.names:
            moved |= np.linalg.norm(rig[name].delta, axis=1) > 0
        self.extent = _diameter(neutral[moved])
        normals, places = _normals(rig.neutral), np.flatnonzero(moved)
        tree = cKDTree(neutral[places])
        found = set()
        for one in places.tolist():
            near = places[tree.query_ball_point(neutral[one], NEAR * self.extent)]
            near = near[normals[near] @ normals[one] < -0.3]
            # In front of it, not behind a sheet of two sides.
            near = near[(neutral[near] - neutral[one]) @ normals[one] > -0.2 * KEPT * self.extent]
            if len(near):
                other = int(near[np.linalg.norm(neutral[near] - neutral[one], axis=1).argmin()])
                found.add((min(one, other), max(one, other)))
        self.pairs = np.array(sorted(found)).reshape(-1, 2)
        rest = np.linalg.norm(neutral[self.pairs[:, 0]] - neutral[self.pairs[:, 1]], axis=1)
        self.touching = rest < TOUCHING * self.extent
        self.fields = {name: self._between(rig[name].delta) for name in rig.morphs}
        self.bends = {name: [self._between(b) for b in rig[name].bends] for name in rig.morphs}

    def _between(self, field: Floats) -> Floats:
        return field[self.pairs[:, 0]] - field[self.pairs[:, 1]]

    def straight(self, weights: Mapping[str, float]) -> Floats:
        """(C, 3) how the straight rig moves one against the other."""
        return sum((w * self.fields[name] for name, w in weights.items()), np.zeros(3))

    def bent(self, weights: Mapping[str, float], *, pairs: bool) -> Floats:
        """(C, 3) what the bends of the paths add, with pair bends or without."""
        added = np.zeros((len(self.pairs), 3))
        times = dict(weights)
        if pairs:
            for name, own in self.rig.pair_bends().items():
                times[name] = max(0.0, min(weights.get(driver, 0.0) for driver in own.drivers))
        for name, t in times.items():
            for curve, bend in zip(self.rig[name].bend_curves, self.bends[name], strict=True):
                added += curve.at(t) * bend
        return added

    def slide(self, weights: Mapping[str, float], *, pairs: bool) -> float:
        """The largest slide, of what the straight rig keeps, as a fraction of D."""
        kept = np.linalg.norm(self.straight(weights), axis=1) <= KEPT * self.extent
        slides = np.linalg.norm(self.bent(weights, pairs=pairs)[kept], axis=1)
        return float(slides.max(initial=0.0)) / self.extent


def _diameter(points: Floats) -> float:
    some = points[np.unique([f(points @ d) for d in _directions() for f in (np.argmin, np.argmax)])]
    return float(np.linalg.norm(some[:, None] - some, axis=2).max())


def _directions() -> Floats:
    random = np.random.default_rng(0)
    found = random.normal(size=(200, 3))
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def _normals(mesh: em.Mesh) -> Floats:
    corners = mesh.faces.triangles()
    a, b, c = (mesh.vertices[corners[:, k]] for k in range(3))
    found = np.zeros_like(mesh.vertices)
    for k in range(3):
        np.add.at(found, corners[:, k], np.cross(b - a, c - a))
    return np.asarray(found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-30))


def named(rig: em.Rig, name: str) -> str | None:
    """The slider of a name of ARKit, in any spelling."""
    spelt = {own.lower().replace("_", ""): own for own in rig.names}
    return spelt.get(name.lower())


def lips(contacts: Contacts, take: em.Performance) -> None:
    """Print what lips do that open and close."""
    rig = contacts.rig
    jaw, close = named(rig, "jawOpen"), named(rig, "mouthClose")
    if jaw is None or close is None:
        print("  no jawOpen and mouthClose")
        return
    moved = np.linalg.norm(rig[close].delta, axis=1) > 1e-3 * contacts.extent
    lip = contacts.touching & moved[contacts.pairs].all(axis=1)

    def slides(weights: Mapping[str, float]) -> list[float]:
        both = [contacts.bent(weights, pairs=own)[lip] for own in (False, True)]
        return [100 * float(np.linalg.norm(own, axis=1).max()) / contacts.extent for own in both]

    most = np.max([slides({jaw: t, close: t}) for t in np.linspace(0, 1, 33)], axis=0)
    print(f"  {lip.sum()} lip vertices that touch; jawOpen = mouthClose: largest slide "
          f"{most[0]:.3f} % of D without, {most[1]:.3f} with")  # fmt: skip
    columns = {name.lower().replace("_", ""): k for k, name in enumerate(take.names)}
    rows = take.weights[:, [columns["jawopen"], columns["mouthclose"]]]
    half = len(rows) // 2
    for title, part in (("first", rows[:half]), ("second", rows[half:])):
        met = part[part[:, 1] > MET]
        found = np.array(
            [slides(dict(zip((jaw, close), row.tolist(), strict=True))) for row in met]
        )
        print(
            f"  {title} half of the take, {len(met)} frames with mouthClose > {MET}: mean "
            f"{found[:, 0].mean():.3f} % of D without, {found[:, 1].mean():.3f} with; most "
            f"{found[:, 0].max():.3f}, {found[:, 1].max():.3f}"
        )


def every_pair(contacts: Contacts) -> None:
    """Print the pairs of sliders that part most."""
    rig, count = contacts.rig, 0
    drivers = {own.drivers: rig[name] for name, own in rig.pair_bends().items()}
    found = []
    for pair in combinations(rig.names, 2):
        if not all(contacts.fields[name].any() for name in pair):
            continue
        count += 1
        worst = max(
            (contacts.slide({pair[0]: s, pair[1]: t}, pairs=True), s, t)
            for s in GRID[1:]
            for t in GRID[1:]
        )
        alone = max(contacts.slide({name: t}, pairs=True) for name in pair for t in GRID[1:])
        before = (
            max(contacts.slide({pair[0]: s, pair[1]: t}, pairs=False) for s in GRID for t in GRID)
            if pair in drivers
            else np.nan
        )
        found.append((worst, alone, before, pair))
    found.sort(key=lambda own: -own[0][0])
    print(f"  {count} pairs move something that faces something:")
    shown = found[:WORST] + [own for own in found[WORST:] if own[3] in drivers]
    for (worst, s, t), alone, before, pair in shown:
        more = ""
        if pair in drivers:
            choice = drivers[pair].choice
            ratio = choice.meeting if choice is not None else 0.0
            more = f"; pair bend (ratio {ratio:.2f}), {100 * before:.3f} without"
        print(
            f"    {' + '.join(pair)}: {100 * worst:.3f} % of D at {s:g}, {t:g}; "
            f"{100 * alone:.3f} one alone{more}"
        )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    data = data_folder()
    default = ["built-in", str(data / "facecap" / "FaceCapHeadGeneric.fbx")]
    parser.add_argument("rigs", nargs="*", default=default)
    parser.add_argument("--take", type=Path, default=data / "livelink" / "rom_3.csv")
    options = parser.parse_args()
    take = em.read_performance(options.take)
    for path in options.rigs:
        contacts = Contacts(em.read_rig(path))
        print(
            f"{path}: D = {contacts.extent:.4g}, {len(contacts.pairs)} facing vertices, "
            f"pair bends {', '.join(contacts.rig.pair_bends()) or 'none'}"
        )
        lips(contacts, take)
        every_pair(contacts)


if __name__ == "__main__":
    main()
