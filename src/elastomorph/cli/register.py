"""``elastomorph register``: scans become poses with the vertices of a template."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli.options import NeutralPose, PosesFolder
from elastomorph.cli.output import Say, command_line, plain_table
from elastomorph.cli.verb import Answer, verb

if TYPE_CHECKING:
    from collections.abc import Mapping

    from elastomorph.capturing.work.registered import Registered

Scans = Annotated[
    list[Path],
    typer.Argument(
        metavar="SCAN…",
        help="Scans in the order of the movement: .obj with its .mtl and images, .ply, .glb, …; "
        "any topology, units and orientation.",
    ),
]
Template = Annotated[
    str,
    typer.Option(
        help="Whose vertices the poses get: a mesh; or a rig, whose expressions help: .glb, .usd, "
        ".fbx, .npz, a folder of meshes; 'built-in' for ours."
    ),
]
LandmarksFile = Annotated[
    Path | None,
    typer.Option(
        help="Points of the face on the template and on scans, as 'elastomorph landmarks' saves "
        "them. Later scans need none."
    ),
]
Texture = Annotated[
    bool, typer.Option(help="Follow the skin by the colours of scans that have them.")
]

Report = Annotated[
    bool, typer.Option(help="Write report.html into the output: pose by pose, and how sure.")
]


@verb
def register(
    context: typer.Context,
    scans: Scans,
    template: Template,
    output: PosesFolder,
    landmarks: LandmarksFile = None,
    neutral: NeutralPose = None,
    texture: Texture = True,
    report: Report = True,
    *,
    say: Say,
) -> Answer:
    """Register scans of any topology: meshes with the template's vertices.

    Each pose is kept as it is finished; the same command goes on where it was stopped.

    Examples:
      elastomorph register scan_*.obj --template neutral.obj --landmarks landmarks.json -o poses
      elastomorph register neutral.ply smile.ply --template rig.glb -o poses
    """
    from elastomorph.capturing.scans.registered_files import described, require_place, written_to
    from elastomorph.capturing.scans.registration import register_all

    inputs = [] if context.params["overwrite"] else [*scans, Path(template)]
    require_place(output, [scan.stem for scan in scans], inputs, template)
    start, finished = time.monotonic(), 0

    def done(name: str, pose: Registered) -> None:
        """A line for each pose, where the line of a terminal does not say it."""
        nonlocal finished
        finished += 1
        if not sys.stderr.isatty() and not context.params.get("as_json"):
            left = (time.monotonic() - start) / finished * (len(scans) - finished) / 60
            more = f", about {left:.0f} min left" if left >= 1 else ""
            sys.stderr.write(f"{name}: {pose!r}, {finished} of {len(scans)}{more}\n")

    try:
        poses = register_all(
            scans,
            template,
            landmarks=landmarks,
            neutral=neutral,
            texture=texture,
            output=output,
            done=done,
            say=say,
        )
    except (KeyboardInterrupt, SystemExit) as stop:  # Ctrl-C, or the end of a job's time
        sys.stderr.write(
            f"interrupted: {finished} of {len(scans)} poses are in {output}; the same command goes"
            " on from there\n"
        )
        raise typer.Exit(getattr(stop, "code", 130)) from None
    written = written_to(output, poses)
    if report:
        from elastomorph.report.capture import write_register_report

        say("writing the report")
        written.append(output / "report.html")
        name, call = output.resolve().name, command_line(context)
        write_register_report(poses, written[-1], name=name, call=call)
    facts = {**described(poses), "written": [str(file) for file in written]}
    return Answer(facts, lambda: _tell(poses, output))


def _tell(poses: Mapping[str, Registered], output: Path) -> None:
    from rich.console import Console

    console = Console()
    table = plain_table(
        ("pose", "correspondence"),
        ("pose", "surface, % of D", "shown, %", "flagged, %", "correspondence"),
    )
    for name, pose in poses.items():
        own = pose.figures
        table.add_row(
            name,
            f"{own['surface_mean']:.3f}",
            f"{100 * own['shown']:.0f}",
            f"{100 * own['flagged']:.1f}",
            own["correspondence"],
        )
    console.print(table)
    console.print(f"written to {output}/", markup=False, highlight=False, soft_wrap=True)
