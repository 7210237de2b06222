"""``elastomorph evaluate``: compare methods with a recorded motion."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say, command_line
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.character import Settings
    from elastomorph.curves import CurveNetwork
    from elastomorph.evaluation import Evaluation
    from elastomorph.evaluation.rigid_bodies import Rigidity
    from elastomorph.model.morph import Morph
    from elastomorph.model.sequence import MeshSequence
    from elastomorph.paths import Method
    from elastomorph.physics import Material
    from elastomorph.report import About

_MOST_INBETWEENS = 3
_LONG = 200
_LONG_WORDS = (
    "A take this long holds several movements, and no path between its two ends can follow them: "
    "--movements judges each onset and offset by itself."
)

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
    movements: Movements = False,
    edge: Edge = None,
    rigid: Rigid = None,
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
    motion, network = _read(truth, keep)
    material = (said if character is None else said.over(character.method)).material
    call = command_line(context)
    asked = _Asked(named, every, material, network, keep, report, unit, call, pictures, say)
    if movements:
        return _movements(asked, truth, motion, 0.05 if edge is None else edge)
    result, written = _compared(asked, truth, motion, character, output)
    bodies = {}
    if rigid is not None:
        from elastomorph.evaluation import rigidity
        from elastomorph.io.vertex_lists import read_region

        body, times = read_region(rigid), motion.times[1:-1]
        bodies = {each.label: rigidity(each.morph, body, times) for each in result.results}
    found = json.loads(result.to_json())
    if bodies:
        found["rigid"] = {label: asdict(body) for label, body in bodies.items()}
    return Answer(found, lambda: _tell(result, motion, bodies, every, written))


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


def _read(truth: str, keep: Path | None) -> tuple[MeshSequence, CurveNetwork]:
    from elastomorph.io import read_sequence
    from elastomorph.io.npz.mesh import holds_markers, read_marker_take

    if holds_markers(truth):
        take = read_marker_take(truth)
        return take.motion, options.network(take.motion.mesh, keep, take.names)
    motion = read_sequence(truth)
    return motion, options.network(motion.mesh, keep)


@dataclass(frozen=True)
class _Asked:
    """What the comparison is to be made of, and the report that is wanted, if any."""

    named: list[str]
    every: bool
    material: Material
    network: CurveNetwork
    keep: Path | None
    report: Path | None
    unit: str
    call: str
    pictures: bool
    say: Say

    def methods(self, motion: MeshSequence) -> dict[str, Method | Morph]:
        """The methods for one motion by their labels: those named, or all and those named."""
        from elastomorph.evaluation.evaluation import every_method, method_of

        how: dict[str, Any] = {"material": self.material, "progress": self.say}
        found: dict[str, Method | Morph] = {}
        for text in self.named:
            label, method = method_of(text, motion, self.network, **how)
            if label in found:
                raise ParameterError(f"the method {text!r} was given twice")
            found[label] = method
        return every_method(motion, self.network, **how) | found if self.every else found

    def about(
        self,
        source: str,
        truth: MeshSequence,
        methods: Mapping[str, Method | Morph],
        *,
        movements: bool = False,
    ) -> About:
        """What the report says of its making."""
        from elastomorph.evaluation import left_out
        from elastomorph.report import About

        long = not movements and len(truth) >= _LONG
        remarks = [_LONG_WORDS if long else "", left_out(truth) if self.every else ""]
        said: dict[str, Any] = {"unit": self.unit, "call": self.call, "methods": methods}
        said["remarks"] = tuple(filter(None, remarks))
        about = About(Path(source).name or source, **said)
        if self.keep is None:
            return about
        rest = ", and the rest of the face traced along its edges" if len(truth.mesh.faces) else ""
        return replace(about, curves=f"the artists' curves of {self.keep.name}{rest}")


def _compared(
    asked: _Asked,
    source: str,
    motion: MeshSequence,
    character: Settings | None,
    output: Path | None,
) -> tuple[Evaluation, list[str]]:
    """The comparison, and the files and the report that were asked for, written."""
    from elastomorph.character import settings_tables
    from elastomorph.evaluation import evaluate as compare
    from elastomorph.io.atomic import made_folder

    methods = asked.methods(motion)
    if output is not None:
        made_folder(output)
    result = compare(motion, methods, asked.network, progress=asked.say)
    if character is not None:
        result = replace(result, settings=settings_tables(character))
    drawn, written = None, []
    if output is not None:
        from elastomorph.evaluation.summary import informed_methods
        from elastomorph.evaluation.words import Lengths
        from elastomorph.report.comparison import write_evaluation
        from elastomorph.report.faces import evaluation_pictures

        drawn = []
        if asked.pictures and len(motion.mesh.faces):
            lengths, informed = Lengths(result.diameter, asked.unit), informed_methods(result)
            drawn = evaluation_pictures(result, lengths, informed, asked.say)
        write_evaluation(result, output, graphs=asked.pictures, faces=drawn, say=asked.say)
        written.append(f"{output}/")
    if asked.report is not None:
        from elastomorph.evaluation import suggest_inbetweens
        from elastomorph.report import write_report

        count = min(_MOST_INBETWEENS, len(motion) - 2)
        how: dict[str, Any] = {"curves": result.curves, "progress": asked.say}
        found = suggest_inbetweens(motion, count, **how) if count else []
        how = {"suggestions": found, "faces": drawn, "draw": asked.pictures, "say": asked.say}
        write_report(result, asked.report, asked.about(source, motion, methods), **how)
        written.append(str(asked.report))
    return result, written


def _movements(asked: _Asked, source: str, motion: MeshSequence, edge: float) -> Answer:
    from rich.console import Console

    from elastomorph.evaluation import left_out
    from elastomorph.evaluation.conclusions import rankings
    from elastomorph.evaluation.movements import evaluate_movements, mean_lines
    from elastomorph.evaluation.table import method_table

    judged = evaluate_movements(motion, asked.network, asked.methods, edge=edge, progress=asked.say)
    if asked.report is not None:
        from elastomorph.report import write_movements_report

        methods = asked.methods(judged[0].evaluation.truth)
        about = asked.about(source, motion, methods, movements=True)
        write_movements_report(judged, motion, asked.report, about, draw=asked.pictures)
    means = mean_lines(judged)

    def tell() -> None:
        console = Console()
        for title, lines in means.items():
            console.print(method_table(lines, title, shape=len(motion.mesh.faces) > 0))
        said = [*rankings(means[list(means)[-1]]), left_out(motion) if asked.every else ""]
        said.append("" if asked.report is None else f"written to {asked.report}")
        for sentence in filter(None, said):
            console.print(sentence, highlight=False)

    facts = {
        "movements": [asdict(one.movement) for one in judged],
        "means": {title: [asdict(line) for line in lines] for title, lines in means.items()},
    }
    return Answer(facts, tell)


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
    if every:
        for sentence in filter(None, (*rankings(summaries(result)), left_out(motion))):
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
