"""``elastomorph interpolate``: in-betweens of a neutral and a target."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.character import Settings
    from elastomorph.character.build import Part
    from elastomorph.model.mesh import Mesh
    from elastomorph.model.morph import Morph
    from elastomorph.rig.timing import Timing

_MOST_FRAMES = 10_000_000
_MOST_DRAWN = 25

Output = Annotated[
    str,
    typer.Option(
        "--output",
        "-o",
        help="A mesh file for one time; for several half.####.obj, .npz, .mdd or .pc2.",
    ),
]
Region = Annotated[
    str | None, typer.Option(help="Vertices to restrict it to: a .json list, or 0-9408,11248.")
]
Falloff = Annotated[
    float | None, typer.Option(help="Edge rings of blending inside the region; 3 by default.")
]
Rest = Annotated[
    str | None,
    typer.Option(help="Vertices outside the region: linear (default), or neutral (stay)."),
]


@verb
def interpolate(
    context: typer.Context,
    neutral: Annotated[Path, typer.Argument(help="The face at t = 0.")],
    target: Annotated[Path, typer.Argument(help="The face at t = 1, same topology.")],
    output: Output,
    method: options.MethodText = None,
    settings: options.SettingsFile = None,
    time: Annotated[
        list[float] | None, typer.Option("--time", "-t", help="A time; may be given repeatedly.")
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option(
            help="Equal steps from t = 0 to t = 1, ends included.", min=2, max=_MOST_FRAMES
        ),
    ] = None,
    keep: options.CurveFile = None,
    region: Region = None,
    falloff: Falloff = None,
    rest: Rest = None,
    timing: options.TimingText = None,
    picture: Annotated[
        Path | None,
        typer.Option(help=f"A picture (PNG) of up to {_MOST_DRAWN} in-betweens side by side."),
    ] = None,
    *,
    say: Say,
) -> Answer:
    """Interpolate between two known shapes, by any method.

    Example: elastomorph interpolate neutral.obj jawOpen.obj --frames 11 -o half.####.obj
    """
    from elastomorph.character import PathMaker
    from elastomorph.io import read
    from elastomorph.model.mesh import require_same_topology

    chosen = _settings(target, method, context.obj, settings, keep)
    part = _part(region, falloff, rest)
    say("reading")
    start = read(neutral)
    _require_output(output, start, frames or len(set(time or [])))
    times = _times(time, frames, options.timing(timing or chosen.timing))
    end = read(target)
    say("solving")
    require_same_topology(start, end)
    morph = PathMaker(chosen, start, part=part).path(target.stem, end)
    say("writing")
    _write(output, start, times, morph)
    if picture is not None:
        from elastomorph.draw.strips import expression_strip
        from elastomorph.rig.sliders import spread_rows

        say("drawing")
        drawn = times[spread_rows(len(times), _MOST_DRAWN)].tolist()
        expression_strip({morph.method: morph}, picture, times=drawn)
    facts = {
        "method": morph.method,
        "vertices": len(start.vertices),
        "bends": len(morph.bends),
        "times": times.tolist(),
        "output": output,
    }
    told = f"{morph.method}: {len(times)} shapes, {len(morph.bends)} bends → {output}"
    return Answer(facts, lambda: typer.echo(told))


def _settings(
    target: Path, method: str | None, said: dict[str, Any], file: Path | None, keep: Path | None
) -> Settings:
    """Settings of the target; options in their place, which must have an effect."""
    from elastomorph.character import Character, Settings
    from elastomorph.character.schema import MethodChoice

    if said["load"] is not None:
        try:
            said["load"] = tuple(map(float, said["load"].split(",")))
        except ValueError:
            raise ParameterError(
                f"--load must be numbers such as 0.2,0.8, found {said['load']!r}"
            ) from None
    choice = MethodChoice.of(method, **said)
    own = Settings(target, Character(target.parent, target.stem), choice)
    chosen = options.settings_of(None, file, choice) or own
    whole = chosen.choice_for(target.stem)
    for name, methods in whole.idle.items():
        if name in choice.stated:
            raise ParameterError(
                f"--{name.replace('_', '-')} is for {', '.join(methods)}; "
                f"{whole.method().name} has none: add --method {methods[0]}"
            )
    return chosen if keep is None else chosen.with_curves(keep)


def _part(region: str | None, falloff: float | None, rest: str | None) -> Part | None:
    from elastomorph.character.build import Part
    from elastomorph.io.vertex_lists import read_region

    said: dict[str, Any] = {"falloff": falloff, "rest": rest}
    said = {name: value for name, value in said.items() if value is not None}
    if region is None and said:
        raise ParameterError(f"--{next(iter(said))} is for a part of the face: add --region")
    return None if region is None else Part(read_region(region), **said)


def _times(
    times: list[float] | None, frames: int | None, timing: Timing | None
) -> NDArray[np.float64]:
    import numpy as np

    if times and frames:
        raise ParameterError("give --time or --frames, not both")
    clip = np.linspace(0, 1, frames) if frames else np.array(sorted(set(times or [0.5])))
    return clip if timing is None else timing.at(clip)


def _require_output(output: str, start: Mesh, count: int) -> None:
    """Refuse an output that could not be written, before a path is made."""
    from elastomorph.io.atomic import require_writable
    from elastomorph.io.registry import MESH_FORMATS, writer_of
    from elastomorph.io.sequences import require_frames

    if count > 1:
        require_frames(output, start, count)
    else:
        writer_of(output, MESH_FORMATS)
        require_writable(output)


def _write(output: str, start: Mesh, times: NDArray[np.float64], morph: Morph) -> None:
    """The shape at one time as a mesh, those at several one after another."""
    from elastomorph.io import write
    from elastomorph.io.sequences import write_frames

    if len(times) == 1:
        write(output, start.with_vertices(morph.at(times[0])))
    else:
        names = [f"t = {t:g}" for t in times]
        write_frames(output, start, map(morph.at, times), names=names)
