"""``elastomorph render``: pictures, strips, clips and films of a rig, without a display.

How a take turns the head of a rig, for films and files.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from elastomorph.cli import completion, options, takes
from elastomorph.cli.output import Say
from elastomorph.cli.takes import (
    Shot,
    require_sense,
    written_picture,
)
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError, warn

if TYPE_CHECKING:
    from elastomorph.cli.takes import PoseWords
    from elastomorph.rig import Rig
    from elastomorph.rig.performance import HeadTurn, Performance


_FARTHEST = 2 * pi


def head_turn(rig: Rig, take: Performance, *, still: bool) -> HeadTurn | None:
    """How a head is turned in each frame of a take; None where it is still, or is to be."""
    from elastomorph.draw.head import head_of, neck_of
    from elastomorph.rig.performance import HeadTurn

    angles = take.head
    if still or not angles.any():
        return None
    most = float(np.abs(angles).max())
    if most > _FARTHEST:
        _tell_turn(
            f"{take.source} turns the head by up to {most:.3g} radians: should these be degrees, "
            "write them in radians, or leave the head still with --still-head"
        )
    morphs = rig.morphs.values()
    if head_of(rig.neutral, morphs) is not None:
        _tell_turn(
            "the whole character turns with its head, for a rig has no bones; --still-head leaves "
            "it as it is"
        )
    return HeadTurn(neck_of(rig.neutral, morphs), angles)


def at_frames(turn: HeadTurn | None, take: Performance) -> HeadTurn | None:
    """The same turn in the frames of a take that was resampled."""
    return None if turn is None else replace(turn, angles=take.head)


def turn_line(turn: HeadTurn) -> str:
    """How far a head turns, in a line."""
    most = np.degrees(np.abs(turn.angles).max(axis=0)).tolist()
    named = zip(most, ("yaw", "pitch", "roll"), strict=True)
    return f"the head turns by up to {', '.join(f'{angle:.3g}° {name}' for angle, name in named)}"


def _tell_turn(sentence: str) -> None:
    warn(sentence)


Output = Annotated[
    str,
    typer.Option(
        "--output",
        "-o",
        help="A picture: .png, .jpg, .webp; a clip: .mp4, .gif, .webp, frame.####.png.",
    ),
]
RigOrMesh = Annotated[
    str,
    typer.Argument(
        help="A rig (.glb, .vrm, .usd, .fbx, .npz, a folder of meshes), a mesh (.obj, .ply, "
        ".npz), or 'built-in'."
    ),
]
Pose = Annotated[
    list[str] | None,
    typer.Option(
        "--pose",
        "-p",
        help="smile=0.7, repeated or separated by commas; poses.json#Smile of a file; poses.json "
        "(or .csv) for a sheet of all of them.",
        autocompletion=completion.poses,
    ),
]
Methods = Annotated[
    list[str] | None,
    typer.Option(
        help="auto, linear, rotation, beam:R[:closure], …: paths made anew from the targets; "
        "repeated for the rows of a strip. Default: those of the file, auto where it has none.",
        autocompletion=completion.methods,
    ),
]
ViewText = Annotated[
    str,
    typer.Option(
        help="front, three-quarter, side, below, mouth, eyes, whole (the body too), or degrees "
        "LEFT,UP.",
        autocompletion=completion.views,
    ),
]
Size = Annotated[
    str | None,
    typer.Option(help="Pixels: 720x900 a picture, 480x600 a clip, 240x300 a face in a strip."),
]
Against = Annotated[
    str | None, typer.Option(help="Colours show the distance from another method, rig or mesh.")
]
Highest = Annotated[
    float | None,
    typer.Option(help="Distance of the last colour; the largest, rounded up, by default."),
]
Unit = Annotated[str, typer.Option(help="Unit of the coordinates, for legends.")]
Wireframe = Annotated[bool, typer.Option("--wireframe", help="Draw the polygons.")]
EdgeLoops = Annotated[
    bool, typer.Option("--edge-loops", help="Draw the curves that beams follow, in colours.")
]
Background = Annotated[
    str | None, typer.Option(help="white, #rrggbb, …, or transparent (PNG and WebP).")
]


@verb
def render(
    output: Output,
    rig: RigOrMesh = "built-in",
    pose: Pose = None,
    method: Methods = None,
    mesh: options.MeshNames = None,
    view: ViewText = "front",
    size: Size = None,
    shot: Shot = Shot(),  # noqa: B008
    of_take: takes.TakeOptions = takes.TakeOptions(),  # noqa: B008
    against: Against = None,
    highest: Highest = None,
    unit: Unit = "",
    wireframe: Wireframe = False,
    edge_loops: EdgeLoops = False,
    background: Background = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Draw a face: a picture, in-betweens side by side, a turn of the head, poses, a take.

    Examples:
      elastomorph render rig.glb --pose smile=0.7,jawOpen=0.4 --t 0.5 -o face.png
      elastomorph render rig.glb --pose poses.json#Smile -o smile.png
      elastomorph render rig.glb --pose poses.json -o sheet.png
      elastomorph render rig.glb --pose smile=1 --turntable -o turn.mp4
      elastomorph render rig.glb --take take.csv --audio take.wav -o take.mp4
      elastomorph render rig.glb -p smile=1 --strip 0,0.5,1 --method linear --method arc -o a.png
    """
    from elastomorph.cli import render_words as said
    from elastomorph.cli.takes import PoseWords
    from elastomorph.draw.sheet import Style

    posed, methods, colour = PoseWords.of(pose or ()), method or [], said.background_of(background)
    require_sense(shot, posed, methods, against, transparent=colour is None)
    if against is None and (highest is not None or unit):
        raise ParameterError(f"--{'unit' if highest is None else 'highest'} is for --against")
    sides, looked = shot.sides(size, sheet=posed.sheet), said.view_of(view)
    shot.require_format(output, sides, transparent=colour is None)
    film = shot.film(output, of_take, sides, say)
    said.parsed_methods(methods)
    full = said.drawn_rig(rig, say, settings, mesh, as_stored=bool(methods))
    curves = said.curves_of(full, say) if edge_loops else ()
    how: dict[str, Any] = {"view": looked, "style": Style(wireframe, curves, colour)}
    if film is not None:
        facts = _film(film, full, methods, of_take, how, say)
    elif posed.sheet:
        facts = _sheet(output, posed, full, methods, sides, how, say)
    else:
        rigs = said.posed_rigs(full, methods, posed.on(full)[""], say)
        how["comparison"] = said.comparison(rigs, shot.times(), against, highest, unit, say)
        facts = shot.draw(output, rigs, sides, how, say)
        if how["comparison"] is not None:
            facts["distance"] = {"from": against, **how["comparison"].facts}
    return Answer({"written": output, **facts}, lambda: _tell({"written": output, **facts}))


def _film(
    film: takes.Film,
    rig: Rig,
    methods: Sequence[str],
    of_take: takes.TakeOptions,
    how: dict[str, Any],
    say: Say,
) -> dict[str, Any]:
    """Write the film of a take; what it holds, and which weights drove which sliders."""
    from elastomorph.cli.render_words import posed_rigs
    from elastomorph.rig.performance import match, slider_weights

    found = match(film.take.names, rig.names)
    takes.require_driven(found, film.take)
    posed = posed_rigs(rig, methods, dict.fromkeys(found.drives, 1.0), say)[0]
    weights = slider_weights(posed.rig, film.take, found, clip=of_take.clip)
    turn = head_turn(posed.rig, film.take, still=of_take.still_head)
    written = film.write(posed.rig, weights, {**how, "turn": turn}, say)
    said = {"take": film.take.source, "match": found.text(takes.MOST_NAMED)}
    return {**written, **said} if turn is None else {**written, **said, "head": turn_line(turn)}


def _sheet(
    output: str,
    words: PoseWords,
    rig: Rig,
    methods: Sequence[str],
    face: tuple[int, int],
    how: dict[str, Any],
    say: Say,
) -> dict[str, Any]:
    """Write a picture of all poses of a file with their names; its size, and the poses."""
    from elastomorph.cli.render_words import posed_rigs
    from elastomorph.draw.posed import pose_sheet

    poses = words.on(rig)
    moved = {slider: 1.0 for weights in poses.values() for slider in weights}
    posed = posed_rigs(rig, methods, moved, say)[0]
    say("drawing")
    image = pose_sheet(posed.rig, poses, face=face, title=posed.label, **how)
    return {**written_picture(image, output), "poses": poses}


def _tell(facts: dict[str, Any]) -> None:
    typer.echo(takes.film_line(facts))
    if "match" in facts:
        typer.echo(facts["match"])
    if "head" in facts:
        typer.echo(facts["head"])
    if "distance" in facts:
        found = facts["distance"]
        shares = {kind: 100 * found[kind] / found["diameter"] for kind in ("largest", "mean")}
        typer.echo(
            f"distance from {found['from']}: largest {found['largest']:.4g} "
            f"({shares['largest']:.2g} % of D), mean {found['mean']:.4g} "
            f"({shares['mean']:.2g} % of D)"
        )
