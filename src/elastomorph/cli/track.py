"""``elastomorph track``: slider weights from a take of markers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import FormatError, ParameterError

if TYPE_CHECKING:
    from elastomorph.io.npz.mesh import Markers
    from elastomorph.rig.handles import Handle
    from elastomorph.rig.tracking import Tracked

Take = Annotated[
    Path,
    typer.Argument(
        metavar="MARKERS",
        help="A .npz with 'names' (M,), 'markers' (T, M, 3), NaN where missing, and perhaps "
        "'vertices' (M,) of the rig and 'times' (T,) in seconds.",
    ),
]
Output = Annotated[
    Path, typer.Option("--output", "-o", help="Columns of weights (.csv), as animate reads them.")
]
Vertices = Annotated[
    Path | None,
    typer.Option(
        "--landmarks", help="Vertices by names of markers (.json), as 'landmarks' writes them."
    ),
]
Rest = Annotated[
    int | None,
    typer.Option(help="A frame with the face at rest: takes out how it differs from the rig's."),
]
Rate = Annotated[float, typer.Option(help="Frames a second of a file without times.")]
Smooth = Annotated[float, typer.Option(help="More for noise, less for quick movements.")]


@verb
def track(
    rig: options.RigName,
    markers: Take,
    output: Output,
    landmarks: Vertices = None,
    rest: Rest = None,
    rate: Rate = 60.0,
    smooth: Smooth = 3e-4,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Solve a rig to a take of markers, wherever the head is.

    Example: elastomorph track rig.glb markers.npz --landmarks markers.json --rest 0 -o take.csv
    """
    import numpy as np

    from elastomorph.io.npz.mesh import read_markers
    from elastomorph.io.performance import write_performance_csv
    from elastomorph.rig.performance import Performance
    from elastomorph.rig.tracking import track as tracked

    if output.suffix.lower() != ".csv":
        raise ParameterError(f"weights are written as .csv, not as {output.name}")
    if not rate > 0 or not np.isfinite(rate):
        raise ParameterError(f"--rate must be frames a second above 0, found {rate:g}")
    say(f"reading {markers}")
    taken = read_markers(markers)
    columns, places = _places(markers, taken, landmarks)
    face_rig = options.NamedRig.of(rig, settings, method, mesh).full(say)
    found = tracked(
        face_rig, taken.frames[:, columns], places, rest=rest, smooth=smooth, progress=say
    )
    times = np.arange(len(taken.frames)) / rate if taken.times is None else taken.times
    pace = rate if taken.times is None else 1.0 / float(np.median(np.diff(times)))
    write_performance_csv(output, Performance(found.names, times, found.weights, pace))
    left_out = [name for i, name in enumerate(taken.names) if i not in columns]
    facts = {
        "frames": len(times),
        "markers": len(columns),
        "left_out": left_out,
        "scale": found.scale,
        "written": str(output),
    }
    return Answer(facts, lambda: _tell(found, left_out, output))


def _places(path: Path, taken: Markers, landmarks: Path | None) -> tuple[list[int], list[Handle]]:
    """Columns of the markers whose place on the rig is known, and their places."""
    from elastomorph.capturing.landmarks.landmarks import read_landmarks

    if landmarks is not None:
        known = read_landmarks(landmarks).vertices
        columns = [i for i, name in enumerate(taken.names) if name in known]
        if not columns:
            raise FormatError(
                landmarks, f"none of its vertices has the name of a marker of {path.name}"
            )
        return columns, [known[taken.names[i]] for i in columns]
    if taken.vertices is None:
        raise FormatError(
            path, "there is no array 'vertices' of where the markers are: add it, or --landmarks"
        )
    return list(range(len(taken.names))), list(taken.vertices)


def _tell(found: Tracked, left_out: list[str], output: Path) -> None:
    from rich.console import Console

    console = Console()
    console.print(str(found), highlight=False, soft_wrap=True)
    if left_out:
        console.print(
            f"without a place on the rig: {', '.join(left_out)}", markup=False, highlight=False
        )
    console.print(f"written to {output}", markup=False, highlight=False, soft_wrap=True)
