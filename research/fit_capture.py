"""Materials and loads fitted to real faces: onsets and offsets of two optical marker takes.

    python research/fit_capture.py [--data FOLDER] [--per-curve]

Reads the takes of ``benchmarks/real_capture.py`` and cuts out the same movements. Onsets and
offsets are fitted apart, for each take and for both; every fit is judged on movements left out.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from elastomorph.curves import CurveNetwork
from elastomorph.evaluation.movements import find_movements
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from material_fit import fit
from material_results import Fit

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from measuring import data_folder
from real_capture import TAKES, marker_curves

KINDS = ("onset", "offset")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder(), help="folder of the real data")
    parser.add_argument("--per-curve", action="store_true", help="also fit every curve alone")
    options = parser.parse_args()
    folder = options.data
    files = [folder / "animface" / f"{take}.npz" for take in TAKES]
    missing = [file for file in files if not file.is_file()]
    if missing:
        print(
            f"{missing[0]} does not exist: name the folder of the real data with --data or "
            "ELASTOMORPH_DATA",
            file=sys.stderr,
        )
        return 1
    console = Console(width=None if sys.stdout.isatty() else 100)
    fits: dict[str, Fit] = {}
    for kind in KINDS:
        every: list[MeshSequence] = []
        for file in files:
            motions, curves = movements(file, kind)
            every += motions
            fits[f"{file.stem} {kind}s"] = _shown(
                console, f"{file.stem}, {kind}s", motions, curves, options.per_curve
            )
        fits[f"all {kind}s"] = _shown(
            console, f"both takes, {kind}s", every, curves, options.per_curve
        )
    console.print(overview(fits))
    console.print(Text(conclusion(fits)))
    return 0


def movements(path: Path, kind: str) -> tuple[list[MeshSequence], CurveNetwork]:
    """The onsets or the offsets of a take, and the curves through its markers."""
    with np.load(path, allow_pickle=False) as file:
        frames = file["stab"].astype(np.float64)
        names = [str(name) for name in file["names"]]
    take = MeshSequence(Mesh(frames[0]), frames)
    found = [take.part(m.start, m.stop) for m in find_movements(frames) if m.kind == kind]
    return found, marker_curves(names)


def overview(fits: dict[str, Fit]) -> Table:
    """One row a fit: constants, and errors on movements left out."""
    table = Table(
        title="Errors on movements left out of the fit",
        title_justify="left",
        box=SIMPLE_HEAD,
        padding=0,
        pad_edge=False,
        caption="RMS and LME in % of D. –: not identified, ?: not reproducible. "
        "won: movements closer than linear",
        caption_justify="left",
    )
    table.add_column("movements")
    for header in ("n", "R", "c/k", "m/k"):
        table.add_column(header, justify="right")
    for method in ("linear", "ease", "beam"):
        for measure in ("RMS", "LME"):
            table.add_column(f"{method}\n{measure}", justify="right")
    table.add_column("won", justify="right")
    for name, one in fits.items():
        won = int((one.left_out_rms[:, 2] < one.left_out_rms[:, 0]).sum())
        ratios = [
            "–" if r.value is None else f"{r.value:.3g}{'' if r.reproducible else '?'}"
            for r in (one.damping, one.mass)
        ]
        errors = [f"{100 * value:.2f}" for e in one.left_out for value in (e.rms, e.lme)]
        table.add_row(name, str(one.motions), str(one.degree), *ratios, *errors, str(won))
    return table


def conclusion(fits: dict[str, Fit]) -> str:
    """What the numbers show, computed from them."""
    beaten = [name for name, one in fits.items() if one.beats_linear]
    added = [name for name, one in fits.items() if one.beats_ease]
    known = [n for n, one in fits.items() if one.damping.reproducible or one.mass.reproducible]
    gains = {name: 1 - one.left_out[2].rms / one.left_out[0].rms for name, one in fits.items()}
    return (
        f"On movements left out the fit beats linear in {len(beaten)} of {len(fits)} groups "
        f"({_listed(beaten)}); its RMS is {min(gains.values()):.1%} to {max(gains.values()):.1%} "
        f"smaller. It beats ease with a load fitted alike in {len(added)} "
        f"({_listed(added)}). c/k or m/k is bounded and reproducible in {len(known)} "
        f"({_listed(known)})."
    )


def _listed(names: list[str]) -> str:
    return ", ".join(names) or "none"


def _shown(
    console: Console,
    title: str,
    motions: list[MeshSequence],
    curves: CurveNetwork,
    per_curve: bool,
) -> Fit:
    started = time.perf_counter()
    found = fit(motions, curves, per_curve=per_curve)
    seconds = time.perf_counter() - started
    console.print(Text(f"\n{title} ({seconds:.1f} s)", style="bold"))
    console.print(Text(found.text(console.width)))
    return found


if __name__ == "__main__":
    sys.exit(main())
