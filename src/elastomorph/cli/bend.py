"""``elastomorph bend``: a character with its paths bent, in its own file."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import completion, options
from elastomorph.cli.output import Say, plain_table
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from elastomorph.bending import BendReport
    from elastomorph.paths import Method

CharacterFile = Annotated[
    Path, typer.Argument(metavar="CHARACTER", help="A character: .glb, .vrm, .gltf, USD.")
]


@verb
def bend(
    character: CharacterFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The bent file, of the same format.")
    ] = None,
    method: options.MethodText = None,
    settings: options.SettingsFile = None,
    only: Annotated[
        str | None,
        typer.Option(
            help="Names separated by commas; all by default.", autocompletion=completion.sliders
        ),
    ] = None,
    tolerance: Annotated[
        float, typer.Option(help="How closely bends hold paths, as a fraction of D.")
    ] = 1e-5,
    keys_tolerance: Annotated[
        float, typer.Option(help="How closely clips follow paths between keys, likewise.")
    ] = 1e-4,
    max_targets: Annotated[
        int | None,
        typer.Option(help="Most morph targets of a mesh; what gains most comes first.", min=0),
    ] = None,
    fold: Annotated[
        bool, typer.Option("--fold", help="Bends along their target cost no target, but a runtime.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say what would bend, and write nothing.")
    ] = False,
    *,
    say: Say,
) -> Answer:
    """Bend the paths of a character in its own file; all the rest of it stays.

    Example: elastomorph bend character.glb -o character.bent.glb
    """
    from elastomorph.bending import bend as bent

    if output is None and not dry_run:
        raise ParameterError("say where to write the bent character: -o character.bent.glb")
    report = bent(
        character,
        None if dry_run else output,
        method=_methods(character, settings, method),
        only=None if only is None else [name.strip() for name in only.split(",")],
        tolerance=tolerance,
        keys_tolerance=keys_tolerance,
        max_targets=max_targets,
        fold=fold,
        say=say,
    )
    return Answer(_facts(report), lambda: _tell(report))


def _methods(
    character: Path, settings: Path | None, method: str | None
) -> str | Mapping[str, str | Method] | None:
    """The method of each target, as settings state it; None where nothing does."""
    return method


def _facts(report: BendReport) -> dict[str, Any]:
    found = asdict(report)
    found |= {"path": str(report.path), "output": report.output and str(report.output)}
    return found | {"largest_error": report.largest_error}


def _tell(report: BendReport) -> None:
    from rich.console import Console

    console = Console()
    headers = ("target", "bends by\n% of D", "held to\n% of D", "bends", "targets", "bytes")
    table = plain_table(("target",), headers)
    for own in report.bent:
        table.add_row(
            own.name,
            f"{100 * own.gain:.3f}",
            f"{100 * own.error:.4f}",
            f"{own.bends}{' + fold' if own.folded else ''}",
            str(own.targets),
            f"{own.bytes:,}",
        )
    if report.bent:
        console.print(table)
    for line in _lines(report):
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def _lines(report: BendReport) -> list[str]:
    """What the table does not say."""
    count = len(report.bent)
    lines = [f"{count} of {count + len(report.straight) + len(report.left_out)} targets bend"]
    if report.left_out:
        names = ", ".join(own.name for own in report.left_out)
        lines.append(f"no room for {names}: allow more targets, or leave out others")
    lines.append(
        f"morph targets of a mesh: {report.targets}, before {report.targets_before}; "
        f"bytes: {report.bytes:,}, before {report.bytes_before:,} "
        f"({report.bytes / max(report.bytes_before, 1):.2f} ×)"
    )
    if report.clips:
        lines.append(
            f"{report.clips} animations play bent, with {report.added_keys:,} keys more and within "
            f"{100 * report.key_error:.2g} % of D"
        )
    lines.append(
        f"D is {report.extent:.4g}; a vertex is within {100 * report.largest_error:.2g} % of D of "
        "its path"
    )
    if report.was_bent:
        lines.append("the file was bent before: it was bent anew from its original")
    if report.output is None:
        return [*lines, "nothing was written"]
    return [*lines, f"written: {report.output}"]
