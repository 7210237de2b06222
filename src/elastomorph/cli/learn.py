"""``elastomorph learn``: the path of a recorded movement."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.comparing import confidence_for, read_motion
from elastomorph.cli.output import Say, plain_table, times_smaller
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rich.table import Table

    from elastomorph.evaluation.confidence import Confidence
    from elastomorph.evaluation.learning import Learned
    from elastomorph.model.sequence import MeshSequence

Recordings = Annotated[
    list[str],
    typer.Argument(
        metavar="RECORDING…",
        help=f"From neutral to target: {options.RECORDED}. Several are repetitions, of which one "
        "path is learned.",
    ),
]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="The path as a rig: .glb, .usd, .usda, .usdc, .usdz, .npz"),
]
Bends = Annotated[int, typer.Option("--bends", "-k", help="Shapes beside the target itself.")]
Shapes = Annotated[str, typer.Option(help="free, or scanned: each belongs to a recorded frame.")]
TimingKind = Annotated[
    str,
    typer.Option(
        help="recorded: in the path; even: beside it, as the timing of the clip in a .glb."
    ),
]
Knots = Annotated[
    int | None,
    typer.Option(
        help="Where the cubic pieces of weight curves meet: so often; by default as often as it "
        "takes."
    ),
]
Frames = Annotated[
    list[str] | None,
    typer.Option(
        help="A part of the recording, counted from 0: 84-132; 248-132 plays it backwards. Several "
        "are repetitions."
    ),
]
Movements = Annotated[
    bool, typer.Option("--movements", help="Learn from each onset and offset in a take by itself.")
]
Name = Annotated[str | None, typer.Option(help="Of the slider; by default that of the recording.")]


@verb
def learn(
    recording: Recordings,
    output: Output = None,
    bends: Bends = 1,
    shapes: Shapes = "free",
    timing: TimingKind = "recorded",
    knots: Knots = None,
    frames: Frames = None,
    movements: Movements = False,
    name: Name = None,
    clip: options.ClipName = None,
    confidence: options.ConfidenceFile = None,
    least: options.LeastConfidence = None,
    keep: options.CurveFile = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Learn the path of a recorded movement: target, its curve, and the best bends there are.

    Examples:
      elastomorph learn take.####.obj -o rig.glb
      elastomorph learn smile1.npz smile2.npz smile3.npz --bends 2 -o smile.glb
      elastomorph learn take.npz --curves markers.json --movements
    """
    from elastomorph.evaluation.learning import learn as learned

    _require_use(recording, output, frames, movements, name)
    say("reading")
    keep = options.curve_file(keep, settings)
    read = [read_motion(each, keep, clip) for each in recording]
    # Of points without polygons all are one curve, as in `em.learn`, and not each one of its own.
    network = read[0][1] if keep or len(read[0][0].motion.mesh.faces) else None
    masks = [
        confidence_for(each, found, confidence, least)
        for each, (found, _) in zip(recording, read, strict=True)
    ]
    takes = [found.motion for found, _ in read]
    how: dict[str, Any] = {"shapes": shapes, "timing": timing, "knots": knots, "curves": network}
    if movements:
        return _each_movement(takes[0], masks[0], bends, how, say)
    parts = [_ends(text, len(takes[0])) for text in frames or []]
    if parts:
        masks = [None if masks[0] is None else masks[0].part(*ends) for ends in parts]
        takes = [takes[0].part(*ends) for ends in parts]
    found = learned(takes, bends, **how, confidence=masks, progress=say)
    if output is not None:
        say(f"writing {output}")
        _write(output, name or _stem(recording[0]), found)
    facts = {"recordings": recording, "frames": [len(take) for take in takes], **found.to_dict()}
    facts["written"] = None if output is None else str(output)
    return Answer(facts, lambda: _tell(found, bends, output))


def _require_use(
    recording: Sequence[str],
    output: Path | None,
    frames: Sequence[str] | None,
    movements: bool,
    name: str | None,
) -> None:
    """Refuse options that would be passed over, and an output that could not be written."""
    if movements and (output is not None or frames):
        raise ParameterError(
            "--movements prints a table of all movements: leave --output and --frames out, or "
            "choose one movement with --frames"
        )
    if (movements or frames) and len(recording) > 1:
        option = "--movements" if movements else "--frames"
        raise ParameterError(f"{option} is for one recording, found {len(recording)}")
    if name is not None and output is None:
        raise ParameterError("--name is for the rig that is written: add --output")
    if output is not None:
        from elastomorph.io.registry import RIG_FORMATS, writer_of

        writer_of(output, RIG_FORMATS)


def _ends(text: str, count: int) -> tuple[int, int]:
    """The first and the last frame that a text such as 84-132 names."""
    found = re.fullmatch(r"(\d{1,9})-(\d{1,9})", text.strip())
    if found is None:
        raise ParameterError(f"--frames must be two numbers such as 84-132, found {text!r}")
    start, stop = int(found[1]), int(found[2])
    if start == stop or max(start, stop) >= count:
        raise ParameterError(
            f"--frames {text}: expected two different frames from 0 to {count - 1}"
        )
    return start, stop


def _stem(recording: str) -> str:
    """A name for the slider: that of the files without number and suffix."""
    place = Path(recording)
    return place.name.split(".")[0].strip("#*_- ") or place.parent.name or "learned"


def _write(output: Path, name: str, found: Learned) -> None:
    from elastomorph.io import write
    from elastomorph.rig import Rig
    from elastomorph.rig.timing import linear

    # A GLB plays what was recorded, at its timing.
    options: dict[str, object] = {"clips": True} if output.suffix.lower() == ".glb" else {}
    if options and found.timing is not linear:
        options["timing"] = found.timing
    write(output, Rig(found.neutral, {name: found}), **options)


def _each_movement(
    take: MeshSequence, mask: Confidence | None, bends: int, how: Mapping[str, Any], say: Say
) -> Answer:
    """Each movement of a take by itself."""
    from elastomorph.evaluation.learning import learn as learned
    from elastomorph.evaluation.movements import find_movements

    found: dict[str, Learned] = {}
    for move in find_movements(take.frames, edge=0.0):
        title = f"{move.kind} {move.start}-{move.stop}"
        say(title)
        own = None if mask is None else mask.part(move.start, move.stop)
        part = take.part(move.start, move.stop)
        found[title] = learned(part, min(bends, len(part) - 2), **how, confidence=own)
    if not found:
        raise ParameterError(
            "no movement was found: from rest to an apex and back, of at least 0.5 % of D"
        )
    facts = [{"movement": title, **each.to_dict()} for title, each in found.items()]
    return Answer({"movements": facts}, lambda: _print(_table(found)))


def _tell(found: Learned, bends: int, output: Path | None) -> None:
    from rich.console import Console

    console = Console()
    _print(_table({"1 bend" if bends == 1 else f"{bends} bends": found}))
    console.print(found.conclusion, highlight=False)
    if found.knots_are_the_limit:
        console.print(
            f"knots, not bends, are the limit: curves that meet {found.knots} times leave more "
            "than so many bends do; raise --knots or leave it out",
            highlight=False,
            soft_wrap=True,
        )
    if found.timing.name != "linear":
        console.print(f"timing  {found.timing.name}", highlight=False, soft_wrap=True)
    if output is not None:
        console.print(f"written to {output}", markup=False, highlight=False, soft_wrap=True)


def _print(table: Table) -> None:
    from rich.console import Console

    Console().print(table)


def _table(found: Mapping[str, Learned]) -> Table:
    """Errors of the straight line and of what was learned, and their mean where there are many."""
    legend = "Errors in % of D, of the straight line and of the learned path; ÷: of LME and LAE."
    headers = ("", "linear\nLME", "learned\nLME", "÷", "linear\nLAE", "learned\nLAE", "÷")
    table = plain_table(("",), headers, caption=legend, caption_justify="left")
    rows = {
        title: (each.straight.lme, each.errors.lme, each.straight.lae, each.errors.lae)
        for title, each in found.items()
    }
    if len(rows) > 1:
        means = [sum(column) / len(rows) for column in zip(*rows.values(), strict=True)]
        rows["mean"] = (means[0], means[1], means[2], means[3])
    for title, (lme, own_lme, lae, own_lae) in rows.items():
        cells = (lme, own_lme, lae, own_lae)
        first, second, third, fourth = (f"{100 * cell:.3f}" for cell in cells)
        gains = [times_smaller(lme, own_lme), times_smaller(lae, own_lae)]
        table.add_row(title, first, second, gains[0], third, fourth, gains[1])
    return table
