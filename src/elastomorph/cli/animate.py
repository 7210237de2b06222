"""``elastomorph animate``: a recorded performance on a rig."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import completion, options, takes
from elastomorph.cli.output import print_json, progress
from elastomorph.cli.render import at_frames, head_turn, turn_line
from elastomorph.cli.verb import AsJson, verb
from elastomorph.errors import FileError, ParameterError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.rig import Rig
    from elastomorph.rig.performance import HeadTurn, Match, Performance

Take = Annotated[str, typer.Argument(help=takes.TAKES)]
Output = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        help="take.glb, .usd (weights); .mdd, .pc2, .npz, folder/, frame.####.obj (positions); "
        "take.mp4, .gif, .webp, frame.####.png (a film).",
    ),
]
Rate = Annotated[
    float | None,
    typer.Option(
        "--rate",
        "--fps",
        help="Frames a second; as recorded by default, made even for positions and films.",
    ),
]
OnlyList = Annotated[
    bool, typer.Option("--list", help="Only say which weights drive which sliders.")
]
Picture = Annotated[Path | None, typer.Option(help="A picture (PNG) of five frames of the take.")]
Timing = Annotated[
    str | None, typer.Option(help="Between poses: smoothstep, minimum-jerk, cosine, linear, …")
]
View = Annotated[
    str | None,
    typer.Option(
        help="Of a film: front, three-quarter, side, …, or degrees LEFT,UP.",
        autocompletion=completion.views,
    ),
]
Size = Annotated[str | None, typer.Option(help="Pixels of a film, 480x600 by default.")]


@verb
def animate(
    rig: options.RigName,
    performance: Take,
    output: Output = None,
    rate: Rate = None,
    part: takes.TakeOptions = takes.TakeOptions(),  # noqa: B008
    timing: Timing = None,
    view: View = None,
    size: Size = None,
    only_list: OnlyList = False,
    picture: Picture = None,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    as_json: AsJson = False,
) -> None:
    """Play a recorded performance on a rig, or poses one after another: a file or a film.

    Examples:
      elastomorph animate rig.glb take.csv -o take.glb --from 10 --to 20
      elastomorph animate rig.glb take.csv -o take.mp4 --audio take.wav
      elastomorph animate rig.glb poses.json --pose-times 0,0.5,2 -o poses.glb
    """
    from elastomorph.character.schema import export_options
    from elastomorph.cli.render_words import picture_size, view_of
    from elastomorph.cli.takes import FRAME
    from elastomorph.rig.performance import match, slider_weights

    if output is None and not only_list:
        _require_nothing_to_write(picture, rate)
    output = None if only_list else output
    filmed = output is not None and _is_film(output)
    if not filmed:
        _require_none_of_film(output, part, view, size)
    with progress(as_json) as say:
        say(f"reading {performance}")
        whole = part.read(performance, timing=timing, rate=rate)
        take, film = part.part(whole), None
        source = options.NamedRig.of(rig, settings, method, mesh)
        if output is not None:
            _require_apart(source.place, Path(output))
            if filmed:
                film = part.film(output, whole, rate, picture_size(size, FRAME))
        face_rig = source.full(say)
        found = match(take.names, face_rig.names)
        if output is not None:
            takes.require_driven(found, take)
        written = take if film is None else film.take
        turn = head_turn(face_rig, written, still=part.still_head or not (output or picture))
        if film is not None:
            weights = slider_weights(face_rig, film.take, found, clip=part.clip)
            film.write(face_rig, weights, {"view": view_of(view or "front"), "turn": turn}, say)
    if output is not None and not filmed:
        export = {} if source.settings is None else export_options(source.settings, output)
        how = {"clip": part.clip, "export": export, "turn": turn}
        written = _write(output, face_rig, take, found, rate, how, quiet=as_json)
    if picture is not None:
        weights = slider_weights(face_rig, take, found, clip=part.clip)
        _draw(picture, face_rig, take, weights, at_frames(turn, take), as_json)
    _tell(take, written, found, turn, output, as_json)


def _write(
    output: str,
    rig: Rig,
    take: Performance,
    found: Match,
    rate: float | None,
    how: dict[str, Any],
    *,
    quiet: bool,
) -> Performance:
    """Write a take that is no film; the frames that are in the file."""
    from elastomorph.io.takes import holds_positions, write_take

    positions = holds_positions(output)
    if rate is not None or positions:
        take = take.resampled(take.rate if rate is None else rate)
    with _counting(quiet, len(take) if positions else None) as watch:
        how = {**how, "turn": at_frames(how["turn"], take)}
        write_take(output, rig, take, found, watch=watch, **how)
    return take


def _is_film(output: str) -> bool:
    """Whether an output is drawn: a movie, a moving picture, or numbered pictures."""
    from elastomorph.draw.movie import CLIP_SUFFIXES
    from elastomorph.draw.pictures import SUFFIXES

    suffix = Path(output).suffix.lower()
    return suffix in CLIP_SUFFIXES or ("#" in Path(output).name and suffix in SUFFIXES)


def _require_nothing_to_write(picture: Path | None, rate: float | None) -> None:
    if picture is None:
        raise ParameterError("say where to write the take (-o take.glb), or ask for --list")
    if rate is not None:
        raise ParameterError("--rate is for what is written: add --output")


def _require_none_of_film(
    output: str | None, part: takes.TakeOptions, view: str | None, size: str | None
) -> None:
    """Refuse other formats, and options that are for films, before anything is read."""
    from elastomorph.io.takes import holds_positions

    if output is not None:
        holds_positions(output)
    why = "a film: write one with -o take.mp4"
    part.require_none(why, ["audio", "audio_offset", "draft"])
    if view is not None or size is not None:
        raise ParameterError(f"--{'size' if view is None else 'view'} is for {why}")


def _draw(
    path: Path,
    rig: Rig,
    take: Performance,
    weights: NDArray[np.float64],
    turn: HeadTurn | None,
    quiet: bool,
) -> None:
    from elastomorph.draw.strips import take_strip

    with progress(quiet) as say:
        say("drawing")
        take_strip(rig, take, weights, path, turn=turn)


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
    take: Performance,
    written: Performance,
    found: Match,
    turn: HeadTurn | None,
    output: str | None,
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
        "head_turns": turn is not None,
        "written": output,
    }


def _tell(
    take: Performance,
    written: Performance,
    found: Match,
    turn: HeadTurn | None,
    output: str | None,
    as_json: bool,
) -> None:
    if as_json:
        print_json(_facts(take, written, found, turn, output))
        return
    recorded = takes.frames_line(len(take), take.rate)
    typer.echo(f"{take.source}: {recorded}, {take.duration:.2f} s")
    for what, names in (("dropped", take.dropped), ("came twice", take.duplicates)):
        if names:
            shown = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
            typer.echo(f"{what}: {len(names):,} ({shown})")
    typer.echo(found.text(None if output is None else takes.MOST_NAMED))
    if turn is not None:
        typer.echo(turn_line(turn))
    if output is not None:
        typer.echo(f"{takes.frames_line(len(written), written.rate)} → {output}")
