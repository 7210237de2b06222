"""Interpolation judged against real faces: onsets and offsets of two optical marker takes.

    python benchmarks/real_capture.py [--data FOLDER] [--each] [--inbetweens N] [--cuts EDGE …]

Reads ``animface/jaw.npz`` and ``animface/eyebrows.npz`` (41 named markers at 60 frames a second)
from the folder of real data: ``--data``, or ``ELASTOMORPH_DATA``, or ``../shared/data`` beside
the checkout. How a movement is cut out of a take matters, so one table shows what becomes of the
errors when less or more of the rest and of the apex belongs to it. Another shows what recorded
frames as in-betweens are worth, by the law between them; the last whether any method has a worse
path than ``linear``, on the motion of the built-in head too, which has a surface.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from rich.text import Text

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ElastomorphWarning, MeshError
from elastomorph.evaluation import (
    DEFAULT_METHODS,
    CurveVertices,
    Evaluation,
    MethodResult,
    curve_errors,
    evaluate,
    suggest_inbetweens,
)
from elastomorph.evaluation.movements import Movement, evaluate_movements
from elastomorph.evaluation.summary import mean_summaries, same
from elastomorph.evaluation.table import method_table
from elastomorph.io.sequences import read_recording
from elastomorph.io.vertex_lists import read_curves
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import interpolate
from elastomorph.paths.through import LAWS, through
from elastomorph.samples import recorded_motion
from measuring import data_folder

TAKES = ("jaw", "eyebrows")
METHODS = (*DEFAULT_METHODS, "beam:2:compatible", "beam:2:unforced", "arc")
ON_SURFACES = ("rotation", "auto")
ALLOWED = 2e-4
MOST_INBETWEENS = 3
EASE, BEAM = "ease R=2", "beam R=2"
CUT_METHODS = ("linear", "ease:2", "auto")
EDGE = 0.05
EDGES = (0.0, 0.02, EDGE, 0.1, 0.2)


@dataclass(frozen=True)
class Judged:
    """One movement and how the methods did on it."""

    take: str
    movement: Movement
    evaluation: Evaluation

    @property
    def name(self) -> str:
        """Take and frames, as in "jaw 331-366"."""
        return f"{self.take} {self.movement.start}-{self.movement.stop}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder(), help="folder of the real data")
    parser.add_argument("--each", action="store_true", help="print the full table of each movement")
    parser.add_argument("--inbetweens", type=int, default=MOST_INBETWEENS, help="at most so many")
    parser.add_argument("--cuts", type=float, nargs="+", default=EDGES, help="shares left out")
    options = parser.parse_args()
    folder = options.data
    missing = [take for take in TAKES if not (folder / "animface" / f"{take}.npz").is_file()]
    if missing:
        print(
            f"{folder} has no animface/{missing[0]}.npz: name the folder of the real data with "
            "--data or ELASTOMORPH_DATA",
            file=sys.stderr,
        )
        return 1

    console = Console(width=None if sys.stdout.isatty() else 120)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ElastomorphWarning)
        takes = [folder / "animface" / f"{take}.npz" for take in TAKES]
        methods, reasons = usable(takes[0])
        judged = [one for take in takes for one in judge(take, methods=methods)]
        scan = evaluate(recorded_motion(), (*METHODS, *ON_SURFACES))
        cuts = {
            edge: judged
            if edge == EDGE
            else [one for take in takes for one in judge(take, edge, CUT_METHODS)]
            for edge in options.cuts
        }
    for message in dict.fromkeys(str(warning.message) for warning in caught):
        console.print(Text(f"Warning: {message}", style="yellow"))

    if options.each:
        for one in judged:
            console.print(Text(f"\n{one.name}, {one.movement.kind}", style="bold"))
            console.print(one.evaluation.table())
    console.print(movement_table(judged, "LME of each movement", lambda result: result.lme))
    console.print(
        movement_table(
            judged, "LME of each movement with free timing", lambda result: result.path_lme
        )
    )
    kinds = {
        "onsets": [one for one in judged if one.movement.kind == "onset"],
        "offsets": [one for one in judged if one.movement.kind == "offset"],
        "movements": judged,
    }
    for kind, group in kinds.items():
        means = mean_summaries([one.evaluation for one in group])
        console.print(method_table(means, f"Mean over {len(group)} {kind}", shape=False))
    console.print(cut_table(cuts))
    console.print(law_table(judged, options.inbetweens))
    console.print(path_table(judged, scan, reasons))
    console.print(Text(conclusion(kinds)))
    console.print(Text(what_auto_did(cuts)))
    return 0


def judge(path: Path, edge: float = EDGE, methods: Sequence[str] = METHODS) -> list[Judged]:
    """Find the movements of a take and evaluate every method on each."""
    take = read_recording(path)
    return [
        Judged(path.stem, one.movement, one.evaluation)
        for one in evaluate_movements(
            take.motion, marker_curves(take.names), lambda _: methods, edge=edge
        )
    ]


def usable(path: Path) -> tuple[list[str], dict[str, str]]:
    """The methods that work on markers, and why the others do not."""
    take = read_recording(path)
    curves = marker_curves(take.names)
    methods, reasons = list(METHODS), {}
    for method in ON_SURFACES:
        try:
            interpolate(take.motion.mesh, take.motion.target, method, curves=curves)
        except MeshError as error:
            reasons[method] = str(error)
        else:
            methods.append(method)
    return methods, reasons


def marker_curves(names: Sequence[str]) -> CurveNetwork:
    """The curves through markers of these names."""
    file = Path(__file__).with_name("animface_curves.json")
    return CurveNetwork(read_curves(file, len(names), names), len(names))


def movement_table(
    judged: Sequence[Judged], title: str, measured: Callable[[MethodResult], float]
) -> Table:
    """One row a movement, one column a method, in % of D."""
    table = Table(title=title, title_justify="left", caption="% of D", caption_justify="left")
    table.add_column("movement", no_wrap=True)
    table.add_column("kind")
    for result in judged[0].evaluation.results:
        table.add_column(result.label.replace(" ", "\n"), justify="right")
    for one in judged:
        values = [f"{100 * measured(result):.2f}" for result in one.evaluation.results]
        best = min(values, key=float)
        cells = [Text(value, style="bold" if value == best else "") for value in values]
        table.add_row(one.name, one.movement.kind, *cells)
    return table


def cut_table(cuts: Mapping[float, Sequence[Judged]]) -> Table:
    """Mean LME by how much of the rise is cut off at both ends of a movement."""
    table = Table(
        title="Mean LME by where movements are cut",
        title_justify="left",
        caption="% of D. cut: share of the rise left out at either end",
        caption_justify="left",
    )
    for header in ("cut", "kind", "movements", "frames", "linear", EASE, "free timing"):
        table.add_column(header, justify="left" if header == "kind" else "right")
    table.add_column(f"{EASE} loses", justify="right")
    for edge, judged in cuts.items():
        for kind in ("onset", "offset"):
            group = [one for one in judged if one.movement.kind == kind]
            linear = [one.evaluation["linear"] for one in group]
            ease = [one.evaluation[EASE] for one in group]
            table.add_row(
                f"{edge:.0%}",
                kind,
                str(len(group)),
                f"{np.mean([len(one.evaluation.truth) for one in group]):.0f}",
                f"{100 * np.mean([result.lme for result in linear]):.2f}",
                f"{100 * np.mean([result.lme for result in ease]):.2f}",
                f"{100 * np.mean([result.path_lme for result in linear]):.2f}",
                str(sum(e.lme > s.lme for e, s in zip(ease, linear, strict=True))),
            )
    return table


def law_table(judged: Sequence[Judged], most: int) -> Table:
    """How many times smaller the mean LME is with in-betweens than without, by number and law."""
    table = Table(
        title=f"Mean LME of linear over that with the best in-betweens, {len(judged)} movements",
        title_justify="left",
        caption="better: of smooth and spline, on each movement the one that leaves less; evenly: "
        "at evenly spaced frames instead of the best, smooth through one, else spline",
        caption_justify="left",
    )
    for header in ("in-betweens", *LAWS, "better", "evenly"):
        table.add_column(header, justify="right")
    by_law = {law: best_errors(judged, law, most) for law in LAWS}
    better = np.minimum(by_law["smooth"], by_law["spline"])
    columns = [*by_law.values(), better, evenly_errors(judged, most)]
    for number in range(1, most + 1):
        ratios = [np.mean(errors[:, 0]) / np.mean(errors[:, number]) for errors in columns]
        table.add_row(str(number), *(f"{ratio:.2f}" for ratio in ratios))
    return table


def best_errors(judged: Sequence[Judged], law: str, most: int) -> NDArray[np.float64]:
    """(movements, 1 + most) LME with none, one, two, … best placed in-betweens."""
    truths: list[tuple[MeshSequence, CurveNetwork]]
    truths = [(one.evaluation.truth, one.evaluation.curves) for one in judged]
    return np.array(
        [
            [each.lme for each in suggest_inbetweens(truth, most, curves=curves, method=law)]
            for truth, curves in truths
        ]
    )


def evenly_errors(judged: Sequence[Judged], most: int) -> NDArray[np.float64]:
    """The same at evenly spaced frames, by the law that is the default."""
    found = []
    for one in judged:
        truth = one.evaluation.truth
        along = CurveVertices.of(one.evaluation.curves, len(truth.mesh.vertices))
        found.append([one.evaluation["linear"].lme])
        for number in range(1, most + 1):
            keys = np.linspace(0, len(truth) - 1, number + 2).round().astype(int)[1:-1]
            shapes = {float(truth.times[key]): truth[key] for key in keys}
            path = through(truth.mesh, truth.target, shapes).at(truth.times)
            errors = [
                curve_errors(positions, frame, along, truth.mesh.diameter)[1].max()
                for positions, frame in zip(path, truth.frames, strict=True)
            ]
            found[-1].append(float(max(errors)))
    return np.array(found)


def path_table(judged: Sequence[Judged], scan: Evaluation, reasons: Mapping[str, str]) -> Table:
    """Path error of each method: the mean, and how much worse than linear on the worst movement."""
    table = Table(
        title="Path error, LME with free timing",
        title_justify="left",
        caption="\n".join(
            [
                f"% of D. worse: than linear, on the worst movement; bold above {ALLOWED:.2%}",
                *(f"{method} on markers: {reason}" for method, reason in reasons.items()),
            ]
        ),
        caption_justify="left",
    )
    table.add_column("method", no_wrap=True)
    for header in (f"{len(judged)} movements", "worse", "built-in scans", "worse"):
        table.add_column(header, justify="right")
    for result in scan.results:
        label = result.label
        if label in reasons:
            means = [Text("-"), Text("-")]
        else:
            own = np.array([one.evaluation[label].path_lme for one in judged])
            straight = np.array([one.evaluation["linear"].path_lme for one in judged])
            means = [Text(f"{100 * own.mean():.3f}"), worse(float((own - straight).max()))]
        beyond = result.path_lme - scan["linear"].path_lme
        table.add_row(Text(label), *means, f"{100 * result.path_lme:.3f}", worse(beyond))
    return table


def worse(difference: float) -> Text:
    """How much worse than linear, in % of D."""
    return Text(
        f"{round(100 * difference, 3) + 0.0:+.3f}", style="bold" if difference > ALLOWED else ""
    )


def what_auto_did(cuts: Mapping[float, Sequence[Judged]]) -> str:
    """By how much the path of auto is closer than the straight line, at best and at worst."""
    said = []
    for edge, judged in cuts.items():
        changes = {
            one.name: one.evaluation["auto"].path_lme - one.evaluation["linear"].path_lme
            for one in judged
        }
        best, worst = min(changes, key=lambda n: changes[n]), max(changes, key=lambda n: changes[n])
        said.append(
            f"cut at {edge:.0%}, {len(changes)} movements: {changes[best]:+.3%} ({best}) to "
            f"{changes[worst]:+.3%} ({worst})"
        )
    return "Path LME of auto against linear, in % of D: " + "; ".join(said) + "."


def conclusion(kinds: Mapping[str, Sequence[Judged]]) -> str:
    """What the numbers show, in one paragraph computed from them."""
    said = []
    for kind in ("onsets", "offsets"):
        group = kinds[kind]
        means = {line.label: line.lme for line in mean_summaries([o.evaluation for o in group])}
        best = min(means, key=lambda label: means[label])
        lost = sum(one.evaluation[BEAM].lme > one.evaluation["linear"].lme for one in group)
        against = "" if best == "linear" else f" against {means['linear']:.2%} for linear"
        said.append(
            f"On {len(group)} {kind} {best} has the smallest mean LME, {means[best]:.2%} of "
            f"D{against}; {BEAM} has {means[BEAM]:.2%} and loses to linear on {lost}."
        )
    everything = kinds["movements"]
    for label in (BEAM, f"{BEAM} compatible"):
        pairs = [(one.evaluation[label].lme, one.evaluation[EASE].lme) for one in everything]
        apart = [abs(ours - ease) for ours, ease in pairs]
        share = [abs(ours - ease) / ease for ours, ease in pairs]
        said.append(
            f"{label} differs from {EASE} in LME by {np.mean(apart):.3%} of D on average and "
            f"{max(apart):.3%} at most ({np.mean(share):.2%} and {max(share):.2%} of the LME)."
        )
    lines = {line.label: line for line in mean_summaries([o.evaluation for o in everything])}
    linear = lines["linear"]
    said.append(
        f"One free timing brings the mean LME of linear from {linear.lme:.2%} to "
        f"{linear.path_lme:.2%} of D, {linear.lme / linear.path_lme:.2f} times less."
    )
    closest = min(lines.values(), key=lambda line: line.path_lme)
    if same(closest.path_lme, linear.path_lme):
        said.append("With it no method's path is closer than the straight line by 1 % or more.")
    else:
        said.append(f"With it {closest.label} has the closest path, {closest.path_lme:.2%}.")
    halfway = [
        float(np.interp(0.5, one.evaluation.truth.times, one.evaluation["linear"].path_times))
        for one in everything
    ]
    said.append(
        f"Half the time into a movement the face is between {min(halfway):.0%} and "
        f"{max(halfway):.0%} of the way: no one law of time fits them all."
    )
    return " ".join(said)


if __name__ == "__main__":
    sys.exit(main())
