"""``elastomorph doctor``: are these files one rig, and a sound one?"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli.output import Say
from elastomorph.cli.verb import STATUS_OF_ERRORS, Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.doctor import ExaminationSettings
    from elastomorph.holding.damage import Meeting

Number = float | None
Files = Annotated[
    list[Path],
    typer.Argument(
        help="A neutral and its targets, a folder of them, a rig (.glb, .usd, .fbx, "
        ".npz), settings (.toml), or 'built-in'."
    ),
]
RepairTo = Annotated[
    Path | None,
    typer.Option(
        "--repair", metavar="FOLDER", help="Write the rig as it should be into this folder."
    ),
]
Seeds = Annotated[
    str | None,
    typer.Option(
        help="Vertices known to belong together, neutral first: 12=40,13=41 or a JSON file."
    ),
]
Align = Annotated[
    str | None,
    typer.Option(
        help="Take the motion of the head out: 'auto', or vertices that should be still, "
        "as 0-9408,11248 or a JSON file."
    ),
]
Pairs = Annotated[
    str | None, typer.Option(help="How names tell left and right: _lft=_rgt,lf_=rt_.")
]
Bend = Annotated[
    float,
    typer.Option(
        min=0.0,
        help="Percent of D between the straight and the turning path at t = 0.5 from which "
        "an in-between pays.",
    ),
]
Together = Annotated[
    bool,
    typer.Option(
        "--together", help="Rank pairs and triples of sliders by the damage seen where they meet."
    ),
]
Take = Annotated[
    Path | None,
    typer.Option(help="With --together: a recording that says which sliders meet, and how far."),
]
Sheet = Annotated[
    Path | None, typer.Option(help="With --together: a picture of the ten worst meetings.")
]
FailOn = Annotated[
    str, typer.Option(help="Exit with status 1 from this severity on: error or warning.")
]


@verb
def doctor(
    files: Files,
    repair_to: RepairTo = None,
    seeds: Seeds = None,
    align: Align = None,
    pairs: Pairs = None,
    mass: Annotated[Number, typer.Option(help="Try a material with this m.")] = None,
    damping: Annotated[Number, typer.Option(help="Try a material with this c.")] = None,
    rigidity: Annotated[Number, typer.Option(help="Try a material with this k.")] = None,
    order: Annotated[int | None, typer.Option(help="Try a load t^R of this order.")] = None,
    closure: Annotated[
        str | None, typer.Option(help="Try this time law of a curve's mean.")
    ] = None,
    bend: Bend = 0.25,
    together: Together = False,
    take: Take = None,
    sheet: Sheet = None,
    fail_on: FailOn = "error",
    *,
    say: Say,
) -> Answer:
    """Examine the files of a rig: order, surface, units, motion of the head, sides, in-betweens.

    Exit status: 0 sound, 1 findings, 2 a file or an option that cannot be understood.

    With --together, also what goes wrong between sliders that are sound alone.

    Example: elastomorph doctor neutral.obj jawOpen.obj smile.obj --repair fixed
    """
    from elastomorph.doctor import as_document, as_text, examine_files, repair

    if fail_on not in ("error", "warning"):
        raise ParameterError(f"--fail-on must be error or warning, found {fail_on!r}")
    if align is not None and repair_to is None:
        raise ParameterError("--align changes targets: say with --repair where they go")
    if not together and (take is not None or sheet is not None):
        raise ParameterError("--take and --sheet are for --together: add it")
    beam = (mass, damping, rigidity, order, closure)
    examination = examine_files(files, _settings(seeds, align, pairs, beam, bend), say=say)
    written = None
    if repair_to is not None and examination.facts is not None:
        say(f"writing {repair_to}")
        written = repair(examination, repair_to)
    meetings = _meetings(files, take, sheet, say) if together else None
    failed = examination.worst_is("warning" if fail_on == "warning" else "error")
    return Answer(
        as_document(examination, written, meetings),
        lambda: typer.echo(as_text(examination, written, meetings)),
        STATUS_OF_ERRORS["doctor"] if examination.unreadable else int(failed),
    )


def _meetings(files: list[Path], take: Path | None, sheet: Path | None, say: Say) -> list[Meeting]:
    from elastomorph.holding.damage import rank_meetings
    from elastomorph.io.performance import read_performance
    from elastomorph.io.rig_folder import read_rig

    if len(files) > 1:
        raise ParameterError("--together needs a rig: a folder or one file, found mesh files")
    rig = read_rig(files[0])
    ranked = rank_meetings(rig, None if take is None else read_performance(take), say=say)
    if sheet is not None and ranked:
        from elastomorph.draw.pictures import write_picture
        from elastomorph.draw.posed import pose_sheet

        say(f"drawing {sheet}")
        worst = {
            " + ".join(one.sliders): dict(zip(one.sliders, one.weights, strict=True))
            for one in ranked[:10]
        }
        write_picture(pose_sheet(rig, worst, face=(360, 450)), sheet)
    return ranked


def _settings(
    seeds: str | None,
    align: str | None,
    pairs: str | None,
    beam: tuple[float | None, float | None, float | None, int | None, str | None],
    bend: float,
) -> ExaminationSettings:
    from elastomorph.doctor import BeamSettings, ExaminationSettings, Thresholds
    from elastomorph.doctor.checks.sides import parse_sides
    from elastomorph.doctor.files import read_seeds
    from elastomorph.doctor.settings import SIDES
    from elastomorph.io.vertex_lists import read_region
    from elastomorph.physics import Material

    mass, damping, rigidity, order, closure = beam
    material = None
    if any(value is not None for value in beam):
        constants = [1.0 if value is None else value for value in (mass, damping, rigidity)]
        material = BeamSettings(Material(*constants), order or 2, closure or "limit")
    return ExaminationSettings(
        seeds=() if seeds is None else read_seeds(seeds),
        sides=SIDES if pairs is None else parse_sides(pairs),
        still=None if align in (None, "auto") else read_region(str(align)),
        steady=align == "auto",
        beam=material,
        thresholds=Thresholds(bend=bend / 100.0),
    )
