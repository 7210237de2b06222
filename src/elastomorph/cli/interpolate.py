"""``elastomorph interpolate``: in-betweens of a neutral and a target."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.character.choice import MethodChoice
    from elastomorph.model.mesh import Mesh

__all__ = ["interpolate"]


def interpolate(
    context: typer.Context,
    neutral: Annotated[Path, typer.Argument(help="The face at t = 0.")],
    target: Annotated[Path, typer.Argument(help="The face at t = 1, same topology.")],
    output: Annotated[
        str,
        typer.Option(
            "--output", "-o", help="A mesh file for one time, a pattern half.####.obj for several."
        ),
    ],
    method: options.MethodText = None,
    settings: options.SettingsFile = None,
    time: Annotated[
        list[float] | None, typer.Option("--time", "-t", help="A time; may be given repeatedly.")
    ] = None,
    frames: Annotated[
        int | None, typer.Option(help="Equal steps from t = 0 to t = 1, ends included.", min=2)
    ] = None,
    keep: options.CurveFile = None,
    region: Annotated[
        str | None, typer.Option(help="Vertices to restrict it to: a .json list, or 0-9408,11248.")
    ] = None,
    falloff: Annotated[
        float | None, typer.Option(help="Edge rings of blending inside the region; 3 by default.")
    ] = None,
    rest: Annotated[
        str | None,
        typer.Option(help="Vertices outside the region: linear (default), or neutral (stay)."),
    ] = None,
    timing: options.TimingText = None,
    picture: Annotated[
        Path | None, typer.Option(help="A picture (PNG) of the in-betweens side by side.")
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Interpolate between two known shapes, by any method.

    Example: elastomorph interpolate neutral.obj jawOpen.obj --frames 11 -o half.####.obj
    """
    import numpy as np

    from elastomorph.character import Character, PathMaker, Settings
    from elastomorph.character.build import Part
    from elastomorph.errors import ParameterError
    from elastomorph.io import read
    from elastomorph.io.vertex_lists import read_region
    from elastomorph.model.mesh import require_same_topology

    if time and frames:
        raise ParameterError("give --time or --frames, not both")
    said: dict[str, Any] = {"falloff": falloff, "rest": rest}
    said = {name: value for name, value in said.items() if value is not None}
    if region is None and said:
        raise ParameterError(f"--{next(iter(said))} is for a part of the face: add --region")
    clip = np.linspace(0, 1, frames) if frames else np.array(sorted(set(time or [0.5])))
    choice = options.method_choice(method, context.obj)
    own = Settings(target, Character(target.parent, target.stem), choice)
    chosen = options.settings_of(None, settings, choice) or own
    _require_effect(choice, chosen.choice_for(target.stem))
    if keep is not None:
        chosen = chosen.with_curves(keep)
    part = None if region is None else Part(read_region(region), **said)
    law = options.timing(timing or chosen.timing)
    times = clip if law is None else law.at(clip)
    with options.progress(as_json) as say:
        say("reading")
        start, end = read(neutral), read(target)
        say("solving")
        require_same_topology(start, end)
        morph = PathMaker(chosen, start, part=part).path(target.stem, end)
        say("writing")
        _write(output, start, times, morph.at(times))
        if picture is not None:
            from elastomorph.draw.strips import expression_strip

            say("drawing")
            expression_strip({morph.method: morph}, picture, times=times.tolist())
    if as_json:
        options.print_json(
            {
                "method": morph.method,
                "vertices": len(start.vertices),
                "bends": len(morph.bends),
                "times": times.tolist(),
                "output": output,
            }
        )
    else:
        typer.echo(f"{morph.method}: {len(times)} shapes, {len(morph.bends)} bends → {output}")


def _write(
    output: str, start: Mesh, times: NDArray[np.float64], shapes: NDArray[np.float64]
) -> None:
    """The shape at one time as a mesh, those at several as a sequence."""
    from elastomorph.io import write, write_sequence
    from elastomorph.model.sequence import MeshSequence

    if len(times) == 1:
        write(output, start.with_vertices(shapes[0]))
    else:
        names = [f"t = {t:g}" for t in times]
        write_sequence(output, MeshSequence(start, shapes, names=names))


def _require_effect(said: MethodChoice, whole: MethodChoice) -> None:
    """Refuse options that the method has no use for."""
    from elastomorph.errors import ParameterError

    for name, methods in whole.idle.items():
        if name in said.stated:
            option = name.replace("_", "-")
            raise ParameterError(
                f"--{option} is for {', '.join(methods)}; {whole.method().name} has none: "
                f"add --method {methods[0]}"
            )
