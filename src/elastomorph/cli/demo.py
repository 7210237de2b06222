"""``elastomorph demo``: the whole paper and what goes beyond it, on the built-in face or a rig."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli import options
from elastomorph.cli.output import command_line, plain_table, print_json, steps
from elastomorph.cli.verb import AsJson, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from rich.table import Table

    from elastomorph.evaluation import Evaluation
    from elastomorph.report.walkthrough import Walkthrough

ICT_FOLDER = "ict-facekit"
"""In a folder of data, the one that holds a rig."""


@verb
def demo(
    context: typer.Context,
    data: Annotated[
        Path | None,
        typer.Option(
            help="A rig: a folder with a neutral and its targets, .glb, .vrm, .usd, .fbx, .npz. "
            "Default: built-in."
        ),
    ] = None,
    mesh: options.MeshNames = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for everything it makes.")
    ] = Path("out"),
    settings: options.SettingsFile = None,
    as_json: AsJson = False,
) -> None:
    """Show on a face what each target needs, how every method does, and the paper's pictures.

    Example: elastomorph demo --data path/to/rig -o out
    """
    from elastomorph.io.registry import require_there
    from elastomorph.report.subject import built_in_subject, rig_subject
    from elastomorph.report.walkthrough import walk_through

    if data is not None:
        require_there(data)
    start = time.perf_counter()
    with steps(as_json) as say:
        if data is None and settings is None:
            if mesh:
                raise ParameterError("--mesh is for a rig: name it with --data, or leave it out")
            say("building the head")
            subject = built_in_subject()
        else:
            if data is not None and (data / ICT_FOLDER).is_dir():
                data = data / ICT_FOLDER
            # The targets are what counts, for every method is tried: straight lines cost nothing.
            named = options.NamedRig.of(
                None if data is None else str(data), settings, "linear", mesh
            )
            rig = named.full(say)
            folder = named.settings.character.folder if named.settings else None
            subject = rig_subject(data or folder or Path(), rig)
        found = walk_through(subject, output, say, call=command_line(context))
    seconds = time.perf_counter() - start
    if as_json:
        print_json(_facts(found, seconds))
    else:
        _tell(found, seconds, output)


def _facts(found: Walkthrough, seconds: float) -> dict[str, object]:
    return {
        "face": found.subject.name,
        "vertices": len(found.subject.neutral.vertices),
        "curves": len(found.curves),
        "targets": {
            path.name: {
                "needs": path.words,
                "off the straight line": path.choice.distance,
                "allowed": path.choice.allowed,
                "bends": path.bends,
                "bytes": path.bytes,
                "bake error": path.bake_error,
            }
            for path in found.paths.targets
        },
        "off the hinge": {each.label: [each.parts, each.along] for each in found.hinge},
        "eyelid": found.eyelid,
        "seams": {seam.closure: seam.shape.seam for seam in found.seams},
        "flips": {seam.closure: seam.shape.flips for seam in found.seams},
        "methods": {
            result.label: {"LME": result.lme, "LAE": result.lae, "path LME": result.path_lme}
            for result in (found.evaluation.results if found.evaluation else ())
        },
        "files": [str(path) for path in found.written],
        "seconds": round(seconds, 2),
    }


def _tell(found: Walkthrough, seconds: float, output: Path) -> None:
    from rich.console import Console

    from elastomorph.evaluation.words import counted
    from elastomorph.report.walkthrough import beam_words, truth_words

    console = Console(markup=False)  # of names too: they may hold brackets
    subject = found.subject
    console.print(
        f"{subject.name}: {len(subject.neutral.vertices):,} vertices on "
        f"{counted(len(found.curves), 'curve')}, {counted(len(subject.targets), 'target')}"
    )
    console.print("\n" + found.paths.summary, soft_wrap=True, highlight=False)
    if any(path.inbetween_pays or not path.choice.straight for path in found.paths.targets):
        console.print("In % of D:", highlight=False)
        console.print(_target_table(found))
    if found.hinge:
        console.print(f"{subject.jaw}, farthest off the arc of its hinge, % of D:", highlight=False)
        console.print(_hinge_table(found))
    if found.eyelid:
        console.print("the edge of a lid, farthest towards the eye, % of D:", highlight=False)
        console.print(_eyelid_table(found))
    if found.evaluation is not None:
        console.print(truth_words(subject), soft_wrap=True, highlight=False)
        console.print(found.evaluation.table())
        if subject.take is not None:
            console.print("The paper's Table 1, fractions of D:", highlight=False)
            console.print(_paper_table(found.evaluation))
    console.print(f"{subject.jaw}, quadratic beam at t = 0.5, by closure:", highlight=False)
    console.print(_closure_table(found))
    console.print(beam_words(found.beam, len(subject.targets)), highlight=False)
    console.print(f"\n{len(found.written)} files in {output}/, {seconds:.1f} s", highlight=False)
    console.print(f"Begin with {output / 'report.html'}", highlight=False)


def _target_table(found: Walkthrough) -> Table:
    """The targets that need more than a straight line."""
    headers = ("target", "needs", "off\nstraight", "more\ntargets", "kB", "stored\nwithin")
    table = plain_table(("target", "needs"), headers, padding=(0, 1))
    for path in found.paths.targets:
        if not path.choice.straight or path.inbetween_pays:
            way = "straight" if path.choice.straight else "rotation"
            table.add_row(
                path.name,
                f"{way}; in-between pays" if path.inbetween_pays else way,
                f"{100 * path.choice.distance:.3f}",
                str(path.bends),
                f"{path.bytes / 1000:.0f}",
                f"{100 * path.bake_error:.4f}",
            )
    return table


def _hinge_table(found: Walkthrough) -> Table:
    columns = 3 if any(error.along for error in found.hinge) else 2
    headers = ("method", "rigid parts", "along with them")[:columns]
    table = plain_table(("method",), headers, padding=(0, 1))
    for error in found.hinge:
        cells = (error.label, f"{100 * error.parts:.3f}", f"{100 * error.along:.3f}")
        table.add_row(*cells[:columns])
    return table


def _eyelid_table(found: Walkthrough) -> Table:
    table = plain_table(("method",), ("method", "sinks by"), padding=(0, 1))
    for label, dip in found.eyelid.items():
        table.add_row(label, f"{100 * dip:.3f}")
    return table


def _paper_table(evaluation: Evaluation) -> Table:
    from elastomorph.evaluation.table import PAPER_TABLE_1, table_1

    headers = ("", *(name.replace(" ", "\n") for name, *_ in PAPER_TABLE_1.values()))
    table = plain_table(("",), headers, padding=(0, 1))
    for name, cells in table_1(evaluation):
        table.add_row(name, *cells)
    return table


def _closure_table(found: Walkthrough) -> Table:
    headers = ("closure", "seam, % of D", "flips", "stretch")
    table = plain_table(("closure",), headers, padding=(0, 1))
    for seam in found.seams:
        shape = seam.shape
        table.add_row(
            seam.closure, f"{100 * shape.seam:.3f}", f"{shape.flips:,}", f"{shape.stretch:.2f}"
        )
    return table
