"""``elastomorph animate``: a recorded performance on a rig."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import print_json, progress
from elastomorph.cli.verb import AsJson, verb
from elastomorph.errors import FileError, ParameterError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.rig import Rig
    from elastomorph.rig.performance import Match, Performance

Take = Annotated[
    Path,
    typer.Argument(help="A take of Live Link Face (.csv), or columns time,jawOpen,… (.csv)."),
]
Output = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        help="take.glb, .usd (weights); .mdd, .pc2, .npz, folder/, frame.####.obj (positions).",
    ),
]
Rate = Annotated[
    float | None,
    typer.Option(help="Frames a second; as recorded by default, made even for positions."),
]
TimecodeRate = Annotated[
    float | None,
    typer.Option(help="What the timecodes count, such as 29.97, if they do not show it."),
]
OnlyList = Annotated[
    bool, typer.Option("--list", help="Only say which weights drive which sliders.")
]
Picture = Annotated[Path | None, typer.Option(help="A picture (PNG) of five frames of the take.")]


@verb
def animate(
    rig: options.RigName,
    performance: Take,
    output: Output = None,
    rate: Rate = None,
    start: Annotated[float | None, typer.Option(help="First second of the take.")] = None,
    stop: Annotated[float | None, typer.Option(help="Last second of the take.")] = None,
    clip: Annotated[bool, typer.Option(help="Keep weights within 0 and 1.")] = False,
    timecode_rate: TimecodeRate = None,
    only_list: OnlyList = False,
    picture: Picture = None,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    as_json: AsJson = False,
) -> None:
    """Play a recorded performance on a rig: a file for other programs.

    Example: elastomorph animate rig.glb take.csv -o take.glb --start 10 --stop 20
    """
    from elastomorph.character.schema import export_options
    from elastomorph.io.performance import read_performance
    from elastomorph.io.sequences.takes import holds_positions, write_take
    from elastomorph.rig.performance import match, slider_weights

    if output is None and picture is None and not only_list:
        raise ParameterError("say where to write the take (-o take.glb), or ask for --list")
    if rate is not None and output is None and not only_list:
        raise ParameterError("--rate is for what is written: add --output")
    positions = output is not None and holds_positions(output)
    output = None if only_list else output
    with progress(as_json) as say:
        say(f"reading {performance}")
        take = read_performance(performance, timecode_rate)
        if start is not None or stop is not None:
            take = take.part(-inf if start is None else start, inf if stop is None else stop)
        source = options.NamedRig.of(rig, settings, method, mesh)
        if output is not None:
            _require_apart(source.place, Path(output))
        face_rig = source.full(say)
        found = match(take.names, face_rig.names)
    written = take
    if output is not None:
        if not found.drives:
            raise ParameterError(
                f"no weight of {performance} drives a slider of the rig ({len(face_rig.names)} "
                "sliders); see --list for the names of both"
            )
        if rate is not None or positions:
            written = take.resampled(take.rate if rate is None else rate)
        with _counting(as_json, len(written) if positions else None) as watch:
            export = {} if source.settings is None else export_options(source.settings, output)
            write_take(output, face_rig, written, found, clip=clip, watch=watch, export=export)
    if picture is not None:
        _draw(picture, face_rig, take, slider_weights(face_rig, take, found, clip=clip), as_json)
    _tell(take, written, found, output, as_json)


def _draw(
    path: Path, rig: Rig, take: Performance, weights: NDArray[np.float64], quiet: bool
) -> None:
    from elastomorph.draw.strips import take_strip

    with progress(quiet) as say:
        say("drawing")
        take_strip(rig, take, weights, path)


def _require_apart(rig: Path | None, output: Path) -> None:
    """Refuse frames in the folder of a rig: it would take them for targets from then on."""
    from elastomorph.io.atomic import is_folder, same_file

    if rig is None or not is_folder(output):
        return
    folder = rig if is_folder(rig) else rig.parent
    if same_file(output, folder) and (is_folder(rig) or rig.suffix == ".toml"):
        raise FileError(
            output,
            "this is the folder of the rig, which would take the frames for targets; name another",
        )


@contextmanager
def _counting(quiet: bool, count: int | None) -> Iterator[Callable[[Iterator[Any]], Iterable[Any]]]:
    """A bar on the terminal that counts frames, where they come one by one."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    if count is None or quiet or not console.is_terminal:
        with progress(quiet) as say:
            say("writing")
            yield lambda frames: frames
        return
    with Progress(console=console, transient=True) as bar:
        yield lambda frames: bar.track(frames, total=count, description="writing frames")


def _facts(
    take: Performance, written: Performance, found: Match, output: str | None
) -> dict[str, Any]:
    return {
        "frames": len(written),
        "rate": written.rate,
        "seconds": written.duration,
        "recorded_frames": len(take),
        "recorded_rate": take.rate,
        "dropped": list(take.dropped),
        "duplicates": list(take.duplicates),
        "drives": {
            slider: dict(zip(drive.names, drive.factors, strict=True))
            for slider, drive in found.drives.items()
        },
        "unmatched_weights": list(found.unmatched_weights),
        "unmatched_sliders": list(found.unmatched_sliders),
        "rotations": list(found.rotations),
        "written": output,
    }


def _tell(
    take: Performance, written: Performance, found: Match, output: str | None, as_json: bool
) -> None:
    if as_json:
        print_json(_facts(take, written, found, output))
        return
    typer.echo(f"{take.source}: {len(take):,} frames at {take.rate:.5g} fps, {take.duration:.2f} s")
    for what, names in (("dropped", take.dropped), ("came twice", take.duplicates)):
        if names:
            shown = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
            typer.echo(f"{what}: {len(names):,} ({shown})")
    typer.echo(found.text())
    if output is not None:
        typer.echo(f"{len(written):,} frames at {written.rate:.5g} fps → {output}")
