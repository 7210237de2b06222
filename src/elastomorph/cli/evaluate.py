"""``elastomorph evaluate``: compare methods with a recorded motion."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.comparing import Asked, compared, confidence_for, read_motion
from elastomorph.cli.output import Say, command_line
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from rich.console import Console

    from elastomorph.evaluation import Evaluation
    from elastomorph.evaluation.movements import JudgedMovement
    from elastomorph.evaluation.rigid_bodies import Rigidity
    from elastomorph.model.sequence import MeshSequence
    from elastomorph.rivals import Comparison

Truth = Annotated[
    str,
    typer.Argument(help=f"A recorded motion: {options.RECORDED}."),
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
Rivals = Annotated[
    bool,
    typer.Option(
        help="Also what the literature compares with, and what each face costs: mass-spring, "
        "elastic-solid, pde-surface, … (minutes)."
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
Mass = Annotated[float | None, typer.Option(help="m of the material, above 0; 1 by default.")]
Damping = Annotated[float | None, typer.Option(help="c of the material, above 0; 1 by default.")]
Stiffness = Annotated[
    float | None,
    typer.Option("--rigidity", help="k = EI of the material, above 0; 1 by default."),
]


@verb
def evaluate(
    context: typer.Context,
    truth: Truth,
    output: Output = None,
    report: Report = None,
    unit: Unit = "",
    every: Every = False,
    method: Methods = None,
    rivals: Rivals = False,
    movements: Movements = False,
    edge: Edge = None,
    rigid: Rigid = None,
    clip: options.ClipName = None,
    confidence: options.ConfidenceFile = None,
    least: options.LeastConfidence = None,
    mass: Mass = None,
    damping: Damping = None,
    stiff: Stiffness = None,
    keep: options.CurveFile = None,
    settings: options.SettingsFile = None,
    pictures: Pictures = True,
    *,
    say: Say,
) -> Answer:
    """Judge methods by recorded frames: from the first to the last, against those between.

    Examples:
      elastomorph evaluate scan.####.obj --report report.html --unit cm
      elastomorph evaluate scan.####.obj -o out --method linear --method beam:2
      elastomorph evaluate scan.####.obj --all --rivals
      elastomorph evaluate take.npz --curves markers.json --movements
    """
    from elastomorph.character.schema import MethodChoice

    named, every = method or [], every or not method
    _require_use(movements, edge, rigid, output, report, unit)
    said = MethodChoice.of(mass=mass, damping=damping, rigidity=stiff)
    if said and not every:
        _require_elastic(named)
    say("reading")
    character = options.settings_of(None, settings, said)
    if character is not None and keep is not None:
        character = character.with_curves(keep)
    keep = options.curve_file(keep, settings)
    taken, network = read_motion(truth, keep, clip)
    material = (said if character is None else said.over(character.method)).material
    mask = confidence_for(truth, taken, confidence, least)
    call = command_line(context)
    wanted = (named, every, material, network, mask, keep, report, unit, call, pictures)
    asked = Asked(*wanted, say, rivals)
    if movements:
        return _movements(asked, truth, taken.motion, 0.05 if edge is None else edge)
    result, written, beside = compared(asked, truth, taken.motion, character, output)
    bodies = {} if rigid is None else _rigidity(rigid, result)
    found = json.loads(result.to_json())
    if bodies:
        found["rigid"] = {label: asdict(body) for label, body in bodies.items()}
    if beside is not None:
        found["rivals"] = beside.facts()
    return Answer(found, lambda: _tell(result, taken.motion, bodies, every, written, beside))


def _rigidity(rigid: str, result: Evaluation) -> dict[str, Rigidity]:
    """How each method treats vertices known to be rigid."""
    from elastomorph.evaluation import rigidity
    from elastomorph.io.vertex_lists import read_region

    body, times = read_region(rigid), result.truth.times[1:-1]
    return {each.label: rigidity(each.morph, body, times) for each in result.results}


def _require_use(
    movements: bool,
    edge: float | None,
    rigid: str | None,
    output: Path | None,
    report: Path | None,
    unit: str,
) -> None:
    """Refuse options that would be passed over, and a page that could not be written."""
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
    from elastomorph.paths import Method

    own = [text for text in texts if not text.strip().startswith("through")]
    if not any(Method.parse(text).has("material") for text in own):
        having = ", ".join(Method.with_option("material"))
        raise ParameterError(
            f"a material is for {having}; {', '.join(texts)} has none: add --method beam, or "
            "leave --mass, --damping and --rigidity out"
        )


def _movements(asked: Asked, source: str, motion: MeshSequence, edge: float) -> Answer:
    from rich.console import Console

    from elastomorph.evaluation import left_out
    from elastomorph.evaluation.conclusions import rankings
    from elastomorph.evaluation.movements import coverage_of, evaluate_movements, mean_lines
    from elastomorph.evaluation.table import method_table

    how: dict[str, Any] = {"edge": edge, "confidence": asked.mask, "progress": asked.say}
    judged = evaluate_movements(motion, asked.network, asked.methods, **how)
    judged, beside = _beside_rivals(judged, asked.say) if asked.rivals else (judged, None)
    if asked.report is not None:
        from elastomorph.report import write_movements_report

        first = judged[0].evaluation
        methods = asked.methods(first.truth, first.confidence)
        about = asked.about(source, motion, methods, movements=True)
        write_movements_report(judged, motion, asked.report, about, draw=asked.pictures)
    means = mean_lines(judged)

    def tell() -> None:
        console = Console()
        for title, lines in means.items():
            console.print(method_table(lines, title, shape=len(motion.mesh.faces) > 0))
        said = [*rankings(means[list(means)[-1]]), left_out(motion) if asked.every else ""]
        covered = coverage_of(judged)
        said.append(f"Confidence: {covered}." if covered else "")
        said.append("" if asked.report is None else f"written to {asked.report}")
        for sentence in filter(None, said):
            console.print(sentence, highlight=False)
        _tell_costs(console, beside)

    facts: dict[str, Any] = {
        "movements": [asdict(one.movement) for one in judged],
        "means": {title: [line.facts() for line in lines] for title, lines in means.items()},
    }
    if asked.mask is not None:
        covered = [one.evaluation.covered for one in judged]
        facts["confidence"] = {"least": asked.mask.least, "covered": covered}
    if beside is not None:
        facts["rivals"] = beside.facts()
    return Answer(facts, tell)


def _beside_rivals(
    judged: Sequence[JudgedMovement], say: Say
) -> tuple[list[JudgedMovement], Comparison]:
    """Movements with rivals in their tables, and what a face costs in the longest of them."""
    from elastomorph.rivals import RIVALS, with_rivals

    found = []
    for number, one in enumerate(judged, start=1):
        at = f"{one.movement.kind} {number} of {len(judged)}"
        say(at)
        found.append(with_rivals(one.evaluation, RIVALS, progress=say))
    longest = max(found, key=lambda each: len(each.evaluation.truth))
    pairs = zip(judged, found, strict=True)
    return [replace(one, evaluation=each.evaluation) for one, each in pairs], longest


def _tell(
    result: Evaluation,
    motion: MeshSequence,
    bodies: dict[str, Rigidity],
    every: bool,
    written: list[str],
    beside: Comparison | None,
) -> None:
    from rich.console import Console

    from elastomorph.evaluation import left_out
    from elastomorph.evaluation.conclusions import rankings
    from elastomorph.evaluation.summary import summaries

    console = Console()
    if motion.missing:
        console.print(f"missing from the numbering: {', '.join(motion.missing)}")
    console.print(result.table())
    if every:
        for sentence in filter(None, (*rankings(summaries(result)), left_out(motion))):
            console.print(sentence, highlight=False)
    _tell_costs(console, beside)
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


def _tell_costs(console: Console, beside: Comparison | None) -> None:
    """What rivals cost, and which were left out and why."""
    if beside is not None:
        console.print(beside.cost_table())
        for sentence in beside.sentences():
            console.print(sentence, highlight=False)
