"""How much deeper a rig's paths pass through their own surface than straight ones, and the cost.

    python benchmarks/passing.py [RIG ...] [--least 0.0002] [--only mouthClose]

Each target of a rig alone, by `auto`: how much deeper, at most and in % of D, and how many vertices
cross that the straight line does not lead through, before bends are eased and after. The last line
is the processor time of all paths with that and without, in turns. The built-in head where no rig
is named.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from unittest.mock import patch

import elastomorph as em
from elastomorph.model.geometry import moved_extent
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths import rotation
from elastomorph.paths.method import Prepared
from elastomorph.paths.rotations.passing import Sheets, passing, without_passing

EASES = f"{rotation.__name__}.without_passing"


def prepared(neutral: Mesh, targets: list[Mesh]) -> Prepared:
    """The method `auto`, as for a whole rig."""
    extent = moved_extent(neutral.vertices, (target.vertices for target in targets))
    return em.prepare(neutral, "auto", extent=extent or None, targets=targets)


def figures(neutral: Mesh, targets: dict[str, Mesh], least: float) -> None:
    """Print a row for each target whose path passes deeper than a part of D, or is eased."""
    before = (0.0, 0)

    def watched(morph: Morph, around: object, sheets: Sheets, *others: object) -> Morph:
        nonlocal before
        before = passing(morph, sheets, others[-1])[:2]  # type: ignore[arg-type]
        return without_passing(morph, around, sheets, *others)  # type: ignore[arg-type]

    to = prepared(neutral, list(targets.values()))
    print("| target | deeper | crossing | eased vertices | deeper | crossing |")
    print("|---|---|---|---|---|---|")
    with patch(EASES, watched):
        for name, target in targets.items():
            before = (0.0, 0)
            choice = to(target).choice
            if choice is not None and (before[0] >= least or choice.eased):
                row = f"{100 * before[0]:.3f} | {before[1]} | {choice.eased:,}"
                after = f"{100 * choice.deeper:.3f} | {choice.crossing}"
                print(f"| `{name}` | {row} | {after} |", flush=True)


def seconds(neutral: Mesh, targets: dict[str, Mesh]) -> tuple[float, float]:
    """Processor time of all paths with easing and without, target by target in turns."""
    to = prepared(neutral, list(targets.values()))
    to(next(iter(targets.values())))
    spent = [0.0, 0.0]
    for target in targets.values():
        for place, eases in enumerate((without_passing, lambda morph, *_: morph)):
            with patch(EASES, eases):
                start = time.process_time()
                to(target)
                spent[place] += time.process_time() - start
    return spent[0], spent[1]


def main() -> None:
    """Print a table and the cost for each rig."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("rigs", nargs="*", default=["built-in"])
    parser.add_argument("--least", type=float, default=2e-4, help="fraction of D")
    parser.add_argument("--only", help="a target")
    chosen = parser.parse_args()
    for path in chosen.rigs:
        rig = em.read_rig(path, method="linear")
        targets = {name: morph.target for name, morph in rig.morphs.items()}
        print(f"\n{Path(path).name}\n")
        few = {chosen.only: targets[chosen.only]} if chosen.only else targets
        figures(rig.neutral, few, chosen.least)
        with_easing, without = seconds(rig.neutral, few)
        more = 100 * (with_easing / without - 1) if without else 0.0
        print(f"\n{with_easing:.2f} s with easing, {without:.2f} s without: {more:.1f} % more")


if __name__ == "__main__":
    main()
