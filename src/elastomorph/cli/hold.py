"""``elastomorph hold``: correctives that keep lids and lips together where shapes add up."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say, plain_table
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from elastomorph.holding import Held
    from elastomorph.rig import Rig
    from elastomorph.rig.performance import Performance


@verb
def hold(
    rig: options.RigName,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Of glTF the same file with what is added, of USD a layer over it; else as of "
            "export.",
        ),
    ] = None,
    takes: Annotated[
        list[Path] | None,
        typer.Option("--take", help="Recorded weights that correctives are fitted to; repeatable."),
    ] = None,
    only: Annotated[
        str | None,
        typer.Option(help="lids, lips, folds, or some separated by commas; lids by default."),
    ] = None,
    lips: Annotated[
        int | None,
        typer.Option(help="Most correctives of lips that pass in takes; 0 by default.", min=0),
    ] = None,
    folds: Annotated[
        int | None,
        typer.Option(help="Most correctives against folds of the takes; 0 by default.", min=0),
    ] = None,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would be added, and write nothing.")
    ] = False,
    *,
    say: Say,
) -> Answer:
    """Add correctives where several shapes add up: lids and lips that pass, folds.

    Example: elastomorph hold character.glb --take take.csv -o character.held.glb
    """
    from elastomorph.bending import BendReport
    from elastomorph.bending.character import hold as hold_character
    from elastomorph.bending.character import in_place
    from elastomorph.holding import hold as held
    from elastomorph.io.performance import read_performance
    from elastomorph.io.registry import RIG_FORMATS, writer_of

    if output is None and not dry_run:
        raise ParameterError("say where to write the rig that is held: -o held.glb")
    wanted = _wanted(only, {"lips": lips, "folds": folds})
    recorded: list[Performance] = []
    for take in takes or []:
        say(f"reading {take}")
        recorded.append(read_performance(take))
    found: list[Held] = []

    def holding(given: Rig) -> Rig:
        say("holding")
        found.append(held(given, recorded, **wanted))
        return found[0].rig

    source = options.NamedRig.of(rig, settings, method, mesh)
    place = source.place
    whole = method is None and not mesh and source.settings is None
    if place is not None and whole and in_place(place, output):
        report = hold_character(place, None if dry_run else output, holding, say=say)
        written = report.output
    else:
        if output is not None:
            writer_of(output, RIG_FORMATS)
        held_rig, report = holding(source.full(say)), None
        added = any(own.targets for own in found[0].corrections)
        written = output if added and not dry_run else None
        if written is not None:
            from elastomorph.io import write

            say(f"writing {written}")
            write(written, held_rig)
    facts: dict[str, Any] = {
        "corrections": [asdict(own) for own in found[0].corrections],
        "written": None if written is None else str(written),
    }
    if report is not None:
        facts["notes"] = report.notes
    if isinstance(report, BendReport):
        facts |= {"targets": report.targets, "targets_before": report.targets_before}
    elif report is not None:
        facts["original"] = str(report.original)
    return Answer(facts, lambda: _tell(found[0], written, facts.get("notes", ())))


def _wanted(only: str | None, most: dict[str, int | None]) -> dict[str, Any]:
    kinds = {"lids", *(kind for kind, count in most.items() if count)}
    if only is not None:
        kinds = {kind.strip() for kind in only.split(",")}
    if strange := sorted(kinds - {"lids", *most}):
        raise ParameterError(f"--only is lids, lips or folds, found {strange[0]!r}")
    for kind, count in most.items():
        if kind in kinds and not count:
            raise ParameterError(f"--only {kind}: say how many correctives at most, as --{kind} 15")
        if count and kind not in kinds:
            raise ParameterError(f"--{kind} has no effect without {kind} in --only")
    return {"lids": "lids" in kinds, **{kind: count or 0 for kind, count in most.items()}}


def _tell(held: Held, written: Path | None, notes: Iterable[str]) -> None:
    from rich.console import Console

    console = Console()
    headers = ("corrective", "by", "sliders", "damage", "% of D", "frames")
    table = plain_table(("corrective", "by"), headers)
    for own in held.corrections:
        if own.law:
            before, after = own.fractions
            share = f"{100 * before:.2f} → {100 * after:.2f}" if own.diameter else "folds a frame"
            damage = f"{own.before:.2g} → {own.after:.2g}"
            row = (own.name, own.law, str(len(own.drivers)), damage, share, str(own.frames))
            table.add_row(*row)
    if table.row_count:
        console.print(table)
    lines = [*(own.note for own in held.corrections if own.note), *notes]
    cost = sum(own.targets for own in held.corrections)
    lines.append(f"{cost} morph targets are added" if cost else "nothing is added")
    lines.append("nothing was written" if written is None else f"written: {written}")
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)
