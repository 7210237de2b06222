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

    from rich.table import Table

    from elastomorph.bending import BendReport
    from elastomorph.bending.usd import UsdBendReport
    from elastomorph.paths import Method

CharacterFile = Annotated[
    Path,
    typer.Argument(
        metavar="CHARACTER", help="A character: .glb, .vrm, .gltf, USD, or its settings (.toml)."
    ),
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
        float | None,
        typer.Option(help="How closely bends hold paths, as a fraction of D: 1.1e-4; USD: 5e-4."),
    ] = None,
    keys_tolerance: Annotated[
        float | None,
        typer.Option(help="How closely clips follow paths between keys, likewise: 1e-4."),
    ] = None,
    max_targets: Annotated[
        int | None,
        typer.Option(help="Most morph targets of a mesh; what gains most comes first.", min=0),
    ] = None,
    fold: Annotated[
        bool, typer.Option("--fold", help="Bends along their target cost no target, but a runtime.")
    ] = False,
    compress: Annotated[
        bool, typer.Option("--compress", help="glTF: pack what is added (EXT_meshopt_compression).")
    ] = False,
    source: Annotated[
        Path | None,
        typer.Option("--from", help="The bent file this was made from: gives its curves back."),
    ] = None,
    curves: Annotated[
        Path | None,
        typer.Option(help="Write the curves here too (.json), for engines that read no extras."),
    ] = None,
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

    if output is None and not dry_run and (source is None or curves is None):
        raise ParameterError("say where to write the bent character: -o character.bent.glb")
    file, methods = _named(character, settings, method)
    report = bent(
        file,
        None if dry_run else output,
        method=methods,
        only=None if only is None else [name.strip() for name in only.split(",")],
        tolerance=tolerance,
        keys_tolerance=keys_tolerance,
        max_targets=max_targets,
        fold=fold,
        compress=compress,
        source=source,
        curves=None if dry_run else curves,
        say=say,
    )
    return Answer(_facts(report), lambda: _tell(report))


def _named(
    character: Path, file: Path | None, method: str | None
) -> tuple[Path, str | Mapping[str, str | Method] | None]:
    """The file to bend, and the method of each of its targets as settings state it."""
    settings = options.settings_of(character, file, method)
    if settings is None:
        return character, method
    for table, given in (("regions", settings.regions), ("inbetweens", settings.inbetweens)):
        if given:
            raise ParameterError(
                f"{settings.path} has [{table}], which bend does not take; leave the table out, or "
                "write the rig that it describes by 'elastomorph export'"
            )
    if settings.character.rig is None:
        raise ParameterError(
            f"{settings.path} describes meshes, and no character in one file; name the file as "
            "'rig' of [character], or write one by 'elastomorph export'"
        )
    from elastomorph.io.rig_folder import rig_as_stored

    rig = settings.file(settings.character.rig)
    names = rig_as_stored(rig).morphs
    settings.require_names(names)
    return rig, {name: settings.choice_for(name).method() for name in names}


def _facts(report: BendReport | UsdBendReport) -> dict[str, Any]:
    from elastomorph.bending import BendReport

    found = asdict(report)
    if isinstance(report, BendReport):
        found["largest_error"] = report.largest_error
    found["written"] = found["output"]
    return {name: str(own) if isinstance(own, Path) else own for name, own in found.items()}


def _tell(report: BendReport | UsdBendReport) -> None:
    from rich.console import Console

    from elastomorph.bending import BendReport

    console = Console()
    table, lines = _of_gltf(report) if isinstance(report, BendReport) else _of_usd(report)
    if table.row_count:
        console.print(table)
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def _of_gltf(report: BendReport) -> tuple[Table, list[str]]:
    headers = ("target", "bends by\n% of D", "held to\n% of D", "bends", "targets", "bytes")
    table = plain_table(("target",), headers)
    for own in report.bent:
        bends = f"{own.bends}{' + fold' if own.folded else ''}"
        gain, error = f"{100 * own.gain:.3f}", f"{100 * own.error:.4f}"
        table.add_row(own.name, gain, error, bends, str(own.targets), f"{own.bytes:,}")
    count = len(report.bent)
    lines = [f"{count} of {count + len(report.straight) + len(report.left_out)} targets bend"]
    if report.left_out:
        names = ", ".join(own.name for own in report.left_out)
        lines.append(f"no room for {names}: allow more targets, or leave out others")
    if not report.bent:
        original = "; 'elastomorph unbend' writes the original" if report.was_bent else ""
        return table, [*lines, _written(report) + original]
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
    rounded = f", {100 * report.storage_error:.2g} % by rounding to the numbers of the file"
    lines.append(
        f"D is {report.extent:.4g}; a vertex is within {100 * report.largest_error:.2g} % of D of "
        f"its path{rounded if report.storage_error > 1e-6 else ''}"
    )
    if report.matched:
        counts = ", ".join(f"{count} by {kind}" for kind, count in report.matched.items())
        lines.append(f"curves are given back; targets were known: {counts}")
    if report.was_bent:
        lines.append("the file was bent before: it was bent anew from its original")
    lines += report.notes
    return table, [*lines, _written(report)]


def _of_usd(report: UsdBendReport) -> tuple[Table, list[str]]:
    headers = ("target", "bends by\n% of D", "held to\n% of D", "in-betweens", "bytes")
    table = plain_table(("target",), headers)
    for own in report.bent:
        gain, error = f"{100 * own.gain:.3f}", f"{100 * own.error:.4f}"
        table.add_row(own.name, gain, error, str(len(own.inbetweens)), f"{own.bytes:,}")
    lines = [
        f"{len(report.bent)} of {len(report.targets)} targets bend",
        *report.notes,
    ]
    if not report.bent:
        return table, [*lines, _written(report)]
    lines[1:1] = [
        f"a layer of {report.bytes:,} bytes over {report.original}",
        f"D is {report.extent:.4g}; a vertex is within {100 * report.error:.2g} % of D of its path",
    ]
    return table, [*lines, _written(report)]


def _written(report: BendReport | UsdBendReport) -> str:
    if not report.bent:
        return "nothing bends, so nothing was written"
    return "nothing was written" if report.output is None else f"written: {report.output}"
