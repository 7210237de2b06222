"""``elastomorph capture``: photographs of poses become meshes of one topology."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import completion
from elastomorph.cli.options import NeutralPose, PosesFolder
from elastomorph.cli.output import Say, command_line, plain_table
from elastomorph.cli.verb import Answer, verb

if TYPE_CHECKING:
    from elastomorph.capturing.work.captured import Captured

_REPORT = "report.html"

Photos = Annotated[
    Path,
    typer.Argument(
        metavar="PHOTOS",
        help="A folder with a folder of photographs for each pose, or one with all of them, named "
        "by pose and number: smile_01.jpg.",
    ),
]
Template = Annotated[
    str | None,
    typer.Option(
        help="Whose vertices the poses get: a mesh, a rig (its neutral), 'built-in' for ours. Not "
        "needed for cameras."
    ),
]
LandmarksFile = Annotated[
    Path | None,
    typer.Option(
        help="Points of the face on the template and in photographs of the neutral, as "
        "'elastomorph landmarks' saves them. Default: landmarks.json beside the photographs."
    ),
]
Distance = Annotated[
    str | None,
    typer.Option(
        metavar="A,B=LENGTH",
        help="How far two points are apart, clicked ones or the cameras of photographs, by their "
        "names, in the unit of the template, for the poses to have the subject's size and not the "
        "template's.",
    ),
]
RigOfCameras = Annotated[
    str,
    typer.Option(
        help="walking: cameras stand elsewhere for each pose; fixed: they stay, and photographs "
        "of one camera have one name in all poses.",
        autocompletion=completion.rigs_of_cameras,
    ),
]
Masks = Annotated[
    Path | None,
    typer.Option(help="Folder of masks named as the photographs, white where the face is."),
]
Cameras = Annotated[
    Path | None,
    typer.Option(
        help="Where photographs were taken from, if another program found it: a folder with "
        "COLMAP's text model or a Bundler file (.out), or a folder with one of these for each "
        "pose, named as it."
    ),
]
To = Annotated[
    str,
    typer.Option(
        help="Stop after the cameras or the neutral; the same command goes on from there: "
        "cameras, neutral, poses.",
        autocompletion=completion.goals,
    ),
]
Working = Annotated[
    Path | None,
    typer.Option(
        help="Folder in which stages leave their results, to go on from. Default: .capture in the "
        "output."
    ),
]
Report = Annotated[
    bool,
    typer.Option(
        help="Write report.html into the output: cameras, what agrees, poses over photographs."
    ),
]


@verb
def capture(
    context: typer.Context,
    photos: Photos,
    output: PosesFolder,
    template: Template = None,
    landmarks: LandmarksFile = None,
    distance: Distance = None,
    neutral: NeutralPose = None,
    rig: RigOfCameras = "walking",
    masks: Masks = None,
    cameras: Cameras = None,
    to: To = "poses",
    working: Working = None,
    report: Report = True,
    *,
    say: Say,
) -> Answer:
    """Make poses of one topology from photographs, about 30 of each.

    Each stage leaves its result: after an interruption the same command goes on, and after a
    change it makes again what depends on it.

    Examples:
      elastomorph capture photos -o poses --template neutral.obj --landmarks landmarks.json
      elastomorph capture photos -o poses --to cameras
    """
    from elastomorph.capturing.work.capture import capture as captured_from

    try:
        captured = captured_from(
            photos,
            template,
            output=output,
            cameras=cameras,
            neutral=neutral,
            landmarks=landmarks,
            distance=distance,
            rig=rig,
            masks=masks,
            to=to,
            working=working,
            say=say,
        )
    except (KeyboardInterrupt, SystemExit):
        typer.echo("what was finished is kept: the same command goes on behind it", err=True)
        raise
    if report:
        from elastomorph.report.capture import write_capture_report

        call = command_line(context)
        name = photos.resolve().name
        write_capture_report(captured, output / _REPORT, name=name, call=call, say=say)
    return Answer(_facts(captured, output, report), lambda: _tell(captured, output))


def _facts(captured: Captured, output: Path, report: bool) -> dict[str, Any]:
    from elastomorph.capturing.work.captured import CAMERAS, as_json

    written = [str(output / f"{pose}.obj") for pose in captured.poses]
    written += [str(output / f"{captured.neutral}.glb")] * bool(captured.textures)
    written += [str(output / CAMERAS / pose) for pose in captured.cameras]
    written += [str(output / _REPORT)] * report
    return {"neutral": captured.neutral, **as_json(captured.figures), "written": written}


def _tell(captured: Captured, output: Path) -> None:
    from rich.console import Console

    console = Console()
    columns = ("pose", "cameras", "reprojection, px", "head, % of D", "flagged, %")
    table = plain_table(("pose",), columns)
    sentences = []
    for pose, own in captured.figures["poses"].items():
        errors = list(own["reprojection"].values())
        frame, flagged = own.get("frame"), own.get("flagged")
        table.add_row(
            pose,
            f"{own['cameras']} of {own['photographs']}",
            f"{sum(errors) / max(1, len(errors)):.2f}",
            "" if frame is None else f"{100 * frame['rms_of_extent']:.3f}",
            "" if flagged is None else f"{100 * flagged:.1f}",
        )
        sentences += [f"{pose}: {remark}" for remark in own["remarks"]]
        sentences += [f"{pose}: {name} is not used: {why}" for name, why in own["rejected"].items()]
    console.print(table)
    texture = captured.figures.get("texture")
    sentences += [texture] if isinstance(texture, str) else []
    for sentence in [*sentences, f"written to {output}/"]:
        console.print(sentence, markup=False, highlight=False, soft_wrap=True)
