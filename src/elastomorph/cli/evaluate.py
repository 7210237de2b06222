"""``elastomorph evaluate``: compare methods with a recorded motion."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.evaluation_page import EvaluationPage
from elastomorph.cli.output import call_words

if TYPE_CHECKING:
    from elastomorph.character import Settings
    from elastomorph.curves import CurveNetwork
    from elastomorph.evaluation import Evaluation
    from elastomorph.evaluation.rigid_bodies import Rigidity
    from elastomorph.model.morph import Morph
    from elastomorph.model.sequence import MeshSequence
    from elastomorph.paths import Method
    from elastomorph.physics import Material

__all__ = ["evaluate"]


Truth = Annotated[
    str,
    typer.Argument(help="Frames: scan.####.obj, a folder, 'scan.*.ply', .npz; a marker take."),
]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="Folder for tables, graphs and pictures."),
]
Report = Annotated[
    Path | None,
    typer.Option(help="One page with everything found, to read and to pass on: report.html."),
]
Unit = Annotated[str, typer.Option(help="Unit of the coordinates, for the report: cm.")]
Every = Annotated[
    bool, typer.Option("--all", help="Every method beside those named, not only these.")
]
Methods = Annotated[
    list[str] | None,
    typer.Option(
        help="linear, auto, rotation, beam:R[:closure], through:N[:law] (the best N frames as "
        "in-betweens), …; may be given repeatedly. Without it every method, ranked."
    ),
]
Movements = Annotated[
    bool, typer.Option(help="Find onsets and offsets in a long take and evaluate each.")
]
Edge = Annotated[
    float | None,
    typer.Option(help="Share of a movement's rise left out at either end; 0.05 by default."),
]
Rigid = Annotated[
    str | None,
    typer.Option(help="Vertices known to be rigid: a .json list, or 0-99,120."),
]
Pictures = Annotated[
    bool, typer.Option(help="Draw graphs and faces into the output folder and the report.")
]


def evaluate(
    context: typer.Context,
    truth: Truth,
    output: Output = None,
    report: Report = None,
    unit: Unit = "",
    every: Every = False,
    method: Methods = None,
    movements: Movements = False,
    edge: Edge = None,
    rigid: Rigid = None,
    mass: options.Mass = None,
    damping: options.Damping = None,
    stiff: options.Rigidity = None,
    keep: options.CurveFile = None,
    settings: options.SettingsFile = None,
    pictures: Pictures = True,
    as_json: options.AsJson = False,
) -> None:
    """Judge methods by recorded frames: from the first to the last, against those between.

    Examples:
      elastomorph evaluate scan.####.obj --report report.html --unit cm
      elastomorph evaluate scan.####.obj -o out --method linear --method beam:2
      elastomorph evaluate take.npz --curves markers.json --movements
    """
    from elastomorph.character.choice import MethodChoice

    named, every = method or [], every or not method
    _require_use(movements, edge, rigid, output, report, unit)
    said = MethodChoice.of(mass=mass, damping=damping, rigidity=stiff)
    if said and not every:
        _require_elastic(named)
    with options.progress(as_json) as say:
        say("reading")
        character = options.settings_of(None, settings, said)
        if character is not None and keep is not None:
            character = character.with_curves(keep)
        keep = options.curve_file(keep, settings)
        motion, network = _read(truth, keep)
        material = options.material(mass, damping, stiff, character)
        methods = partial(_methods, named, every, network, material, say)
        page = EvaluationPage(report, call_words(context), truth, unit, keep, pictures, every)
        if movements:
            edge = 0.05 if edge is None else edge
            _movements(motion, network, methods, every, edge, as_json, page, say)
            return
        result = _compared(motion, network, methods(motion), character, output, page, say)
        bodies = _bodies(result, motion, rigid)
    if as_json:
        found = json.loads(result.to_json())
        bodies_found = {label: asdict(body) for label, body in bodies.items()}
        options.print_json(found | ({"rigid": bodies_found} if bodies else {}))
    else:
        _tell(result, motion, bodies, every, [f"{output}/"] * bool(output) + page.names)


def _require_use(
    movements: bool,
    edge: float | None,
    rigid: str | None,
    output: Path | None,
    report: Path | None,
    unit: str,
) -> None:
    """Refuse options that would be passed over, and a page that could not be written."""
    from elastomorph.errors import ParameterError

    if movements and (rigid or output):
        raise ParameterError(
            "--movements prints tables and writes reports only: leave --rigid and --output out"
        )
    if edge is not None and not movements:
        raise ParameterError("--edge is for --movements: it says where they begin and end")
    if unit and output is None and report is None:
        raise ParameterError("--unit is for pictures and pages: add --report or --output")
    if report is not None:
        from elastomorph.report.document import require_page_path

        require_page_path(report)


def _require_elastic(texts: Sequence[str]) -> None:
    """Refuse a material where no method has a use for one."""
    from elastomorph.errors import ParameterError
    from elastomorph.paths import Method

    own = [text for text in texts if not text.strip().startswith("through")]
    if not any(Method.parse(text).has("material") for text in own):
        having = ", ".join(Method.with_option("material"))
        raise ParameterError(
            f"a material is for {having}; {', '.join(texts)} has none: add --method beam, or "
            "leave --mass, --damping and --rigidity out"
        )


def _read(truth: str, keep: Path | None) -> tuple[MeshSequence, CurveNetwork]:
    from elastomorph.io import read_sequence
    from elastomorph.io.npz.mesh import holds_markers, read_marker_take

    if holds_markers(truth):
        take = read_marker_take(truth)
        return take.motion, options.network(take.motion.mesh, keep, take.names)
    motion = read_sequence(truth)
    return motion, options.network(motion.mesh, keep)


def _methods(
    texts: Sequence[str],
    every: bool,
    network: CurveNetwork,
    material: Material,
    say: Callable[[str], None],
    motion: MeshSequence,
) -> dict[str, Method | Morph]:
    """The methods for one motion by their labels: those named, or all and those named."""
    from elastomorph.errors import ParameterError
    from elastomorph.evaluation.methods import every_method, method_of

    found: dict[str, Method | Morph] = {}
    for text in texts:
        label, method = method_of(text, motion, network, material=material, progress=say)
        if label in found:
            raise ParameterError(f"the method {text!r} was given twice")
        found[label] = method
    if not every:
        return found
    return every_method(motion, network, material=material, progress=say) | found


def _compared(
    motion: MeshSequence,
    network: CurveNetwork,
    methods: Mapping[str, Method | Morph],
    character: Settings | None,
    output: Path | None,
    page: EvaluationPage,
    say: Callable[[str], None],
) -> Evaluation:
    """Compare the methods, and write what was asked for."""
    from elastomorph.character import settings_tables
    from elastomorph.evaluation import evaluate as compare
    from elastomorph.io.atomic import made_folder

    if output is not None:
        made_folder(output)
    result = compare(motion, methods, network, progress=say)
    if character is not None:
        result = replace(result, settings=settings_tables(character))
    drawn = None
    if output is not None:
        from elastomorph.report.comparison import write_evaluation

        drawn = page.drawn(result, say)
        write_evaluation(result, output, graphs=page.draw, faces=drawn, say=say)
    page.write(result, methods, say, drawn)
    return result


def _bodies(result: Evaluation, motion: MeshSequence, rigid: str | None) -> dict[str, Rigidity]:
    from elastomorph.evaluation import rigidity
    from elastomorph.io.vertex_lists import read_region

    if rigid is None:
        return {}
    body = read_region(rigid)
    times = motion.times[1:-1]
    return {each.label: rigidity(each.morph, body, times) for each in result.results}


def _movements(
    motion: MeshSequence,
    network: CurveNetwork,
    methods: Callable[[MeshSequence], Any],
    every: bool,
    edge: float,
    as_json: bool,
    page: EvaluationPage,
    say: Callable[[str], None],
) -> None:
    from rich.console import Console

    from elastomorph.evaluation import left_out
    from elastomorph.evaluation.conclusions import rankings
    from elastomorph.evaluation.movements import evaluate_movements, mean_lines
    from elastomorph.evaluation.table import method_table

    judged = evaluate_movements(motion, network, methods, edge=edge, progress=say)
    page.write_movements(judged, motion, methods(judged[0].evaluation.truth))
    means = mean_lines(judged)
    if as_json:
        options.print_json(
            {
                "movements": [asdict(one.movement) for one in judged],
                "means": {
                    title: [asdict(line) for line in lines] for title, lines in means.items()
                },
            }
        )
        return
    console = Console()
    shape = len(motion.mesh.faces) > 0
    for title, lines in means.items():
        console.print(method_table(lines, title, shape=shape))
    for sentence in (*rankings(means[list(means)[-1]]), *([left_out(motion)] if every else [])):
        if sentence:
            console.print(sentence, highlight=False)
    if page.names:
        console.print(f"written to {page.names[0]}", highlight=False)


def _tell(
    result: Evaluation,
    motion: MeshSequence,
    bodies: dict[str, Rigidity],
    every: bool,
    written: list[str],
) -> None:
    from rich.console import Console

    from elastomorph.evaluation import left_out
    from elastomorph.evaluation.conclusions import rankings
    from elastomorph.evaluation.summary import summaries

    console = Console()
    if motion.missing:
        console.print(f"missing from the numbering: {', '.join(motion.missing)}")
    console.print(result.table())
    for sentence in (*rankings(summaries(result)), left_out(motion)) if every else ():
        if sentence:
            console.print(sentence, highlight=False)
    if bodies:
        ends = next(iter(bodies.values())).ends
        console.print(
            f"\nrigid body, as its ends show within {100 * ends:.3f} % of D", highlight=False
        )
        console.print("change of distances, distance from its screw, % of D:")
    for label, found in bodies.items():
        console.print(
            f"  {label:<22}{100 * found.change:8.3f}{100 * found.off_screw:8.3f}", highlight=False
        )
    if written:
        console.print(f"written to {' and '.join(written)}", highlight=False)
