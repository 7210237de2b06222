"""``elastomorph landmarks``: points of a face placed in photographs, on a template and on scans."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli.output import print_json, progress
from elastomorph.cli.verb import AsJson, verb
from elastomorph.cli.view import Open, Port, shown
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.viewer.landmarks import LandmarkTask

_PAGES = (".html", ".htm")

Files = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[PHOTOS|SCAN…]",
        help="Folders of photographs, one a pose or of several; scans (.obj, .ply, .glb, …).",
    ),
]
Template = Annotated[
    str | None,
    typer.Option(help="The mesh whose vertices are named; 'built-in' for ours, which needs none."),
]
File = Annotated[
    Path,
    typer.Option(
        "--output",
        "-o",
        help="The file of landmarks (.json), gone on with where it exists; or a page (.html).",
    ),
]
Working = Annotated[
    Path | None,
    typer.Option(
        help="Working folder of a capture whose cameras are solved: points clicked in two "
        "photographs are shown in the others."
    ),
]


@verb
def landmarks(
    files: Files = None,
    file: File = Path("landmarks.json"),
    template: Template = None,
    working: Working = None,
    port: Port = None,
    open_browser: Open = True,
    as_json: AsJson = False,
) -> None:
    """Place the points of a face in photographs and on meshes, in the browser.

    Everything placed is saved at once; Finish on the page, or Ctrl-C, ends it.

    Examples:
      elastomorph landmarks photos/neutral -o landmarks.json
      elastomorph landmarks --template neutral.obj -o landmarks.json
      elastomorph landmarks scan.ply --template built-in -o landmarks.json
    """
    page = file.suffix.lower() in _PAGES
    if page and port is not None:
        raise ParameterError("a written page is not served; leave out --port, or name a .json file")
    if not page and file.suffix.lower() != ".json":
        raise ParameterError(f"{file}: landmarks are saved as .json, or a page for them as .html")
    from elastomorph.io.atomic import require_writable
    from elastomorph.viewer.landmarks import serve_landmarks, write_landmark_page

    require_writable(file)  # or all that is placed is lost
    with progress(as_json) as say:
        say("reading")
        task = _task(files or [], template, None if page else file, working)
        if page:
            say(f"writing {file}")
            write_landmark_page(file, task)
    if page:
        size = file.stat().st_size
        if as_json:
            print_json({"written": str(file), "bytes": size})
        else:
            typer.echo(f"{task.title} → {file} ({size / 1e6:.1f} MB); it hands out landmarks.json")
        return
    shown(serve_landmarks(task, file, port or 0), open_browser, as_json)
    if not as_json:
        typer.echo(_outcome(file))


def _task(
    files: list[str], template: str | None, file: Path | None, working: Path | None
) -> LandmarkTask:
    """What is asked for, with what the file holds already."""
    from elastomorph.capturing.landmarks import read_landmarks
    from elastomorph.io.atomic import is_file
    from elastomorph.viewer.landmarks import landmark_task, solved_cameras

    cameras = None if working is None else solved_cameras(working)
    known = read_landmarks(file) if file is not None and is_file(file) else None
    return landmark_task(files, template, known=known, cameras=cameras)


def _outcome(file: Path) -> str:
    """What the file holds now, in a sentence."""
    from elastomorph.capturing.landmarks import LANDMARKS, read_landmarks
    from elastomorph.io.atomic import is_file

    if not is_file(file):
        return "nothing was placed"
    found = read_landmarks(file)
    parts = [f"{len(found.vertices)} vertices of the template"] if found.vertices else []
    for pose, photographs in found.photographs.items():
        names = {name for places in photographs.values() for name in places}
        points = f"{len(names)} of {len(LANDMARKS)} points"
        parts.append(f"{points} in {len(photographs)} photographs of {pose}")
    parts += [f"{len(places)} points on {scan}" for scan, places in found.points.items()]
    return f"{file}: {'; '.join(parts) or 'no points'}"
