"""What sliders at a time do to each other: bends that meet, lids and folds, before and after.

    python benchmarks/together.py [RIG…] [--take FILE] [--only pairs|lids|lips|folds] [--count 15]
                                  [--step 20]

RIG is ``built-in``, or any file or folder; the built-in head and the FaceCap head by default.
Nothing of the product measures (`oracles.py`). Four sections for each:

- ``pairs``, bends without pair bends and with them: the largest slide of lips that touch, bent
  against straight, along jawOpen = mouthClose; the same in frames of the take where mouthClose is
  above 0.05; and every pair of sliders on a grid of 9 × 9 weights, the worst first. Facing vertices
  have normals that point at each other and are less than 1.2 % of D apart in the neutral, of lips
  0.2 %; of every pair those count that the straight rig keeps within 0.2 % of D of how they lay.
- ``lids``, by pictures of both lids, from the front and without perspective, in every frame in
  which a hinge is not 0: by how much lids pass each other, beyond what one slider does alone there,
  and stand open where they were shut before. Hinges mean them to lie over each other by 6 % of the
  widest opening at least. Where that shows no open slit in the neutral, it is said.
- ``lips``, in every ``--step``-th frame: how much deeper a vertex is behind the other lip than any
  slider of the frame takes it alone, as far as it is deeper than 0.05 % of D; and how far lips are
  apart where they touched before, which is closer than 0.05 % of D.
- ``folds``, in every ``--step``-th frame: triangles that are seen folded.

Pair bends are chosen by the rig alone, correctives by the first half of the take; both halves are
measured.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from itertools import combinations
from pathlib import Path

import numpy as np

import elastomorph as em
from elastomorph.rig.performance import slider_weights
from measuring import data_folder
from oracles import Contacts, Floats, Folds, Lids, Lips, diameters, named

SECTIONS = "pairs", "lids", "lips", "folds"
GRID = np.linspace(0.0, 1.0, 9)
WORST = 10
DEEP = 5e-4  # fraction of D
MET = 0.05  # the weight of mouthClose from which a frame counts


def halves(frames: Floats) -> Iterator[tuple[str, Floats]]:
    """Both halves of (T, J) weights, with what they are."""
    half = (len(frames) + 1) // 2
    yield f"first half of the take, frames 0 to {half - 1}", frames[:half]
    yield f"second half, frames {half} to {len(frames) - 1}", frames[half:]


def slides_of_lips(contacts: Contacts, weights: Floats) -> None:
    """Print what lips do that open and close."""
    rig = contacts.rig
    jaw, close = named(rig, "jawOpen"), named(rig, "mouthClose")
    if jaw is None or close is None:
        print("  no jawOpen and mouthClose")
        return
    moved = np.linalg.norm(rig[close].delta, axis=1) > 1e-3 * contacts.extent
    lip = contacts.touching & moved[contacts.pairs].all(axis=1)
    if not lip.any():
        print("  no lip vertices touch")
        return

    def slides(weights: Mapping[str, float]) -> list[float]:
        both = [contacts.bent(weights, pairs=own)[lip] for own in (False, True)]
        return [100 * float(np.linalg.norm(own, axis=1).max()) / contacts.extent for own in both]

    most = np.max([slides({jaw: t, close: t}) for t in np.linspace(0, 1, 33)], axis=0)
    print(f"  {lip.sum()} lip vertices that touch; jawOpen = mouthClose: largest slide "
          f"{most[0]:.3f} % of D without, {most[1]:.3f} with")  # fmt: skip
    for title, part in halves(weights[:, [rig.names.index(jaw), rig.names.index(close)]]):
        met = part[part[:, 1] > MET]
        rows = [slides({jaw: own[0], close: own[1]}) for own in met.tolist()] or [[np.nan] * 2]
        mean, worst = np.mean(rows, axis=0), np.max(rows, axis=0)
        print(f"  {title}, {len(met)} of them with mouthClose > {MET}: mean {mean[0]:.3f} % of D "
              f"without, {mean[1]:.3f} with; most {worst[0]:.3f}, {worst[1]:.3f}")  # fmt: skip


def every_pair(contacts: Contacts) -> None:
    """Print the pairs of sliders that part most."""
    rig, count = contacts.rig, 0
    drivers = {own.drivers: rig[name] for name, own in rig.pair_bends().items()}
    found = []
    for pair in combinations(rig.names, 2):
        if not all(contacts.fields[name].any() for name in pair):
            continue
        count += 1
        grid = [(s, t) for s in GRID[1:].tolist() for t in GRID[1:].tolist()]
        worst = max((contacts.slide({pair[0]: s, pair[1]: t}, pairs=True), s, t) for s, t in grid)
        alone = max(contacts.slide({name: t}, pairs=True) for name in pair for t in GRID[1:])
        before = max(
            (contacts.slide({pair[0]: s, pair[1]: t}, pairs=False) for s, t in grid)
            if pair in drivers
            else [np.nan]
        )
        found.append((worst, alone, before, pair))
    found.sort(key=lambda own: -own[0][0])
    print(f"  {count} pairs move something that faces something:")
    shown = found[:WORST] + [own for own in found[WORST:] if own[3] in drivers]
    for (most, s, t), alone, before, pair in shown:
        more = ""
        if pair in drivers:
            choice = drivers[pair].choice
            ratio = choice.meeting if choice is not None else 0.0
            more = f"; pair bend (ratio {ratio:.2f}), {100 * before:.3f} without"
        print(f"    {' + '.join(pair)}: {100 * most:.3f} % of D at {s:g}, {t:g}; "
              f"{100 * alone:.3f} one alone{more}")  # fmt: skip


def lids(rig: em.Rig, take: em.Performance, extent: float) -> None:
    """Print what hinges do, one row an eye and half of the take."""
    weights = slider_weights(rig, take)
    held = em.hold(rig, take.part(stop=float(take.times[(len(take) + 1) // 2 - 1])))
    places = list(held.rig.sliders.morphs)
    for row in held.corrections:
        print(f"  {row.name}: " + (row.note or f"{row.law} of {len(row.drivers)} sliders"))
    for blink in ("eyeBlinkLeft", "eyeBlinkRight"):
        own = named(rig, blink)
        hinges = [places.index(row.name) for row in held.corrections if own and row.law
                  and row.name.startswith(f"hold_{own}_")]  # fmt: skip
        if own is None or not hinges:
            print(f"  {blink}: not held")
            continue
        eye = Lids(rig, own)
        opening = 100 * np.nanmax(eye.slit(rig.neutral.vertices)) / extent
        if not opening >= 1:
            print(f"  {own}: not measured, for no open slit is drawn between what lies above and "
                  f"below the ends of what the blink moves")  # fmt: skip
            continue
        print(f"  {own}: widest opening {opening:.2f} % of D")
        alone = np.min([eye.slit(rig.pose({name: 1.0})) for name in rig.names], axis=0)
        for title, part in halves(weights):
            frames = part[held.rig.sliders.drive(part)[:, hinges].any(axis=1)]
            slits = np.array(
                [[eye.slit(each.pose(w)) for each in (rig, held.rig)] for w in frames]
            ).reshape(-1, 2, len(alone))
            past = np.nanmax(np.maximum(alone - slits, 0), axis=(0, 2), initial=0.0)
            shut = slits[:, 0] <= 0
            opened = np.nanmax(np.where(shut, slits[:, 1], 0), initial=0.0)
            past, opened = 100 * past / extent, 100 * opened / extent
            print(f"    {title}, {len(frames)} of them with a hinge that is not 0: past "
                  f"each other at most {past[0]:.2f} % of D before, {past[1]:.2f} after; open "
                  f"where shut before {opened:.2f} after")  # fmt: skip


def lips(rig: em.Rig, take: em.Performance, extent: float, step: int, count: int) -> None:
    """Print the correctives of lips and both halves before and after."""
    close = named(rig, "mouthClose")
    if close is None:
        print("  no mouthClose")
        return
    held = em.hold(rig, take, lids=False, lips=count)
    print("  chosen on 100 frames of the first half; largest depth in these beyond single sliders:")
    for row in held.corrections:
        moved = np.linalg.norm(held.rig[row.name].delta, axis=1)
        before, after = (100 * own / extent for own in (row.before, row.after))
        print(f"    {' + '.join(row.drivers)}: {before:.2f} % of D before, {after:.2f} after; "
              f"moves {np.count_nonzero(moved)} vertices by at most "
              f"{100 * moved.max() / extent:.2f} % of D")  # fmt: skip
    mouth = Lips(rig, extent, close)
    rest = np.maximum(mouth.depths(rig.neutral.vertices), 0)
    for title, part in halves(slider_weights(rig, take, clip=True)):
        excess, apart, largest = [], [], 0.0
        for frame in part[::step]:
            poses = [each.pose(frame) for each in (rig, held.rig)]
            before, after = depths = np.array([mouth.depths(pose) for pose in poses])
            alone = rest
            for slider in np.flatnonzero(frame) if (depths > DEEP * extent).any() else ():
                single = np.zeros(len(frame))
                single[slider] = frame[slider]
                alone = np.maximum(alone, mouth.depths(rig.pose(single)))
            deeper = 100 * (depths - alone) / extent
            excess.append(np.where(depths > DEEP * extent, np.maximum(deeper, 0), 0))
            touching = np.abs(before) < DEEP * extent
            apart.append(-100 * after[touching & np.isfinite(after)].min(initial=0) / extent)
            farthest = np.linalg.norm(poses[1] - poses[0], axis=1).max()
            largest = max(largest, 100 * float(farthest) / extent)
        deep = np.mean(np.sum(np.array(excess) > 100 * DEEP, axis=2), axis=0)
        worst = np.max(excess, axis=2)
        mean, most = worst.mean(axis=0), worst.max(axis=0)
        print(f"  {title}, {len(worst)} of them: deepest on average {mean[0]:.3f} % of D before, "
              f"{mean[1]:.3f} after; at most {most[0]:.2f}, {most[1]:.2f}; {deep[0]:.1f} vertices "
              f"too deep a frame, {deep[1]:.1f}; apart where they touched {np.mean(apart):.3f} on "
              f"average, at most {np.max(apart):.2f}; moved by at most {largest:.2f}")  # fmt: skip


def folds(rig: em.Rig, take: em.Performance, extent: float, step: int, count: int) -> None:
    """Print the correctives against folds and both halves before and after."""
    held = em.hold(rig, take, lids=False, folds=count)
    print("  chosen on 250 frames of the first half; folds a frame of these:")
    for row in held.corrections:
        moved = np.linalg.norm(held.rig[row.name].delta, axis=1)
        print(f"    {' + '.join(row.drivers)}: {row.before:.2f} before, {row.after:.2f} after; "
              f"moves {np.count_nonzero(moved)} vertices by at most "
              f"{100 * moved.max() / extent:.2f} % of D")  # fmt: skip
    counter = Folds(rig.neutral)
    for title, part in halves(slider_weights(rig, take, clip=True)):
        frames = part[::step]
        seen = [[counter.count(each.pose(w)) for each in (rig, held.rig)] for w in frames]
        before, after = np.mean(seen, axis=0)
        print(f"  {title}, {len(frames)} of them: folds seen a frame {before:.2f} before, "
              f"{after:.2f} after")  # fmt: skip


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    data = data_folder()
    default = ["built-in", str(data / "facecap" / "FaceCapHeadGeneric.fbx")]
    parser.add_argument("rigs", nargs="*", default=default)
    parser.add_argument("--take", type=Path, default=data / "livelink" / "rom_3.csv")
    parser.add_argument("--only", choices=SECTIONS)
    parser.add_argument("--count", type=int, default=15, help="most correctives of lips or folds")
    parser.add_argument("--step", type=int, default=20, help="lips, folds: every so many-th frame")
    options = parser.parse_args()
    take = em.read_performance(options.take)
    for path in options.rigs:
        rig = em.read_rig(path)
        extent, of_targets = diameters(rig)
        print(f"{path}: D = {extent:.4g}; of what targets move {of_targets:.4g}")
        for section in [options.only] if options.only else SECTIONS:
            print(f" {section}", flush=True)
            if section == "pairs":
                contacts = Contacts(rig, extent)
                print(f"  {len(contacts.pairs)} facing vertices, pair bends "
                      f"{', '.join(rig.pair_bends()) or 'none'}")  # fmt: skip
                slides_of_lips(contacts, slider_weights(rig, take))
                every_pair(contacts)
            elif section == "lids":
                lids(rig, take, extent)
            elif section == "lips":
                lips(rig, take, extent, options.step, options.count)
            else:
                folds(rig, take, extent, options.step, options.count)


if __name__ == "__main__":
    main()
