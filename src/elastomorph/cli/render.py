"""``elastomorph render``: pictures, strips and clips of a rig, without a display."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import completion, options

if TYPE_CHECKING:
    from elastomorph.draw.pictures import Image
    from elastomorph.draw.pose_pictures import Comparison
    from elastomorph.draw.posed import PosedRig
    from elastomorph.draw.stage import Lines

__all__ = ["render"]

_STILL, _FACE, _FRAME = (720, 900), (240, 300), (480, 600)
_TURN_FRAMES, _SWING_FRAMES = 100, 50
_RATE = 25.0


def render(
    output: Annotated[
        str,
        typer.Option(
            "--output",
            "-o",
            help="A picture: .png, .jpg, .webp; a clip: .mp4, .gif, .webp, frame.####.png.",
        ),
    ],
    rig: Annotated[
        str,
        typer.Argument(
            help="A rig (.glb, .vrm, .usd, .fbx, .npz, a folder of meshes), a mesh (.obj, .ply, "
            ".npz), or 'built-in'."
        ),
    ] = "built-in",
    pose: Annotated[
        list[str] | None,
        typer.Option(
            "--pose",
            "-p",
            help="smile=0.7, repeated or separated by commas.",
            autocompletion=completion.poses,
        ),
    ] = None,
    t: Annotated[
        float | None,
        typer.Option(
            "--time", "--t", "-t", help="Master time: each path is at its weight × t; 1 by default."
        ),
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option(
            help="auto, linear, rotation, beam:R[:closure], …: paths made anew from the targets; "
            "repeated for the rows of a strip. Default: those of the file, auto where it has none.",
            autocompletion=completion.methods,
        ),
    ] = None,
    mesh: options.MeshNames = None,
    view: Annotated[
        str,
        typer.Option(
            help="front, three-quarter, side, below, mouth, eyes, or degrees LEFT,UP.",
            autocompletion=completion.views,
        ),
    ] = "front",
    size: Annotated[
        str | None,
        typer.Option(help="Pixels: 720x900 a picture, 480x600 a clip, 240x300 a face in a strip."),
    ] = None,
    turntable: Annotated[bool, typer.Option("--turntable", help="Turn the head round.")] = False,
    degrees: Annotated[
        float | None, typer.Option(help="How far it turns; 360 by default, -360 the other way.")
    ] = None,
    animate: Annotated[
        bool, typer.Option("--animate", help="Run t from 0 to --time and back.")
    ] = False,
    timing: options.TimingText = None,
    frames: Annotated[
        int | None,
        typer.Option(help=f"Of a clip: {_TURN_FRAMES} of a turn, else {_SWING_FRAMES}."),
    ] = None,
    fps: Annotated[
        float | None, typer.Option(help=f"Frames a second of a clip, {_RATE:g} by default.")
    ] = None,
    strip: Annotated[
        str | None, typer.Option(help="Times side by side in one picture: 0,0.25,0.5,0.75,1.")
    ] = None,
    against: Annotated[
        str | None,
        typer.Option(help="Colours show the distance from another method, rig or mesh."),
    ] = None,
    highest: Annotated[
        float | None,
        typer.Option(help="Distance of the last colour; the largest, rounded up, by default."),
    ] = None,
    unit: Annotated[str, typer.Option(help="Unit of the coordinates, for legends.")] = "",
    wireframe: Annotated[bool, typer.Option("--wireframe", help="Draw the polygons.")] = False,
    edge_loops: Annotated[
        bool, typer.Option("--edge-loops", help="Draw the curves that beams follow, in colours.")
    ] = False,
    background: Annotated[
        str | None,
        typer.Option(help="white, #rrggbb, …, or transparent (PNG and WebP)."),
    ] = None,
    settings: options.SettingsFile = None,
    as_json: options.AsJson = False,
) -> None:
    """Draw a face: a picture, in-betweens side by side, a turn of the head, a moving expression.

    Examples:
      elastomorph render rig.glb --pose smile=0.7,jawOpen=0.4 --t 0.5 -o face.png
      elastomorph render rig.glb --pose smile=1 --turntable -o turn.mp4
      elastomorph render rig.glb --pose smile=1 --animate --timing smoothstep -o smile.gif
      elastomorph render rig.glb -p smile=1 --strip 0,0.5,1 --method linear --method arc -o a.png
    """
    from elastomorph.cli.picture_options import background_of, numbers, picture_size, view_of
    from elastomorph.cli.posed_rigs import posed_rigs
    from elastomorph.draw.clips import write_clip
    from elastomorph.draw.framing import turn_angles
    from elastomorph.draw.pose_pictures import clip_frames, pose_picture, pose_strip
    from elastomorph.draw.posed import swing
    from elastomorph.draw.sheet import Style
    from elastomorph.rig.timing import by_name

    moving = turntable or animate
    weights = options.named_numbers(_apart(pose), "--pose")
    colour = background_of(background)
    _refuse(
        (moving and strip is not None, "give --strip, or --turntable and --animate, not both"),
        (degrees is not None and not turntable, "--degrees says how far a --turntable goes"),
        (timing is not None and not animate, "--timing is for --animate"),
        (
            not moving and (frames is not None or fps is not None),
            "--frames and --fps are for clips: add --turntable or --animate",
        ),
        (highest is not None and against is None, "--highest is for --against"),
        (bool(unit) and against is None, "--unit is for the legend of --against"),
        (
            t is not None and strip is not None,
            "--strip names its times: leave out --time, or --strip",
        ),
        (
            len(method or ()) > 1 and strip is None,
            "several methods are the rows of a strip: add --strip 0,0.5,1",
        ),
        (
            (animate or strip is not None) and not weights,
            "nothing would move: say what does, as in --pose smile=1",
        ),
        (
            colour is None and (strip is not None or against is not None),
            "captions and legends need paper: no transparent background with --strip or --against",
        ),
        (
            not weights and (t is not None or bool(method)),
            f"--{'time' if t is not None else 'method'} is for what a --pose moves: say what, as "
            "in --pose smile=1",
        ),
    )
    count = frames if frames is not None else _TURN_FRAMES if turntable else _SWING_FRAMES
    rate = _RATE if fps is None else fps
    sides = picture_size(size, _FRAME if moving else _STILL if strip is None else _FACE)
    looked = view_of(view)
    _require_format(output, moving, sides, count, rate, transparent=colour is None)
    time = 1.0 if t is None else t
    times = [time] * count if moving else [time] if strip is None else numbers(strip, "--strip")
    if animate:
        times = swing(count, by_name(timing or "smoothstep"), time).tolist()
    angles = turn_angles(count, 360.0 if degrees is None else degrees) if turntable else None
    with options.progress(as_json) as say:
        rigs = posed_rigs(rig, method or (), weights, say, settings, mesh)
        compared = _comparison(rigs, times, against, highest, unit, say)
        lines = _edge_loops(rigs[0], say) if edge_loops else ()
        style = Style(wireframe, lines, colour)
        say("drawing")
        if moving:
            drawn = clip_frames(
                rigs[0], times, angles, size=sides, view=looked, style=style, comparison=compared
            )
            with closing(drawn):
                write_clip(output, _counted(drawn, count, say), count=count, fps=rate)
        elif strip is None:
            image = pose_picture(
                rigs[0], time, size=sides, view=looked, style=style, comparison=compared
            )
            _write(output, image)
        else:
            image = pose_strip(
                rigs,
                times,
                face=sides,
                view=looked,
                style=style,
                comparison=compared,
                title=", ".join(f"{name} {weight:g}" for name, weight in weights.items()),
            )
            _write(output, image)
    across, down = sides if moving else image.shape[1::-1]
    facts: dict[str, Any] = {"written": output, "width": across, "height": down}
    if moving:
        facts |= {"frames": count, "fps": rate, "seconds": count / rate}
    facts |= {"pose": weights} | ({} if moving else {"times": times})
    if compared is not None:
        facts["distance"] = {
            "from": against,
            "largest": compared.largest,
            "mean": compared.mean,
            "diameter": rigs[0].rig.neutral.diameter,
        }
    if as_json:
        options.print_json(facts)
    else:
        _tell(facts)


def _apart(texts: Sequence[str] | None) -> list[str]:
    return [part.strip() for text in texts or () for part in text.split(",")]


def _refuse(*mistakes: tuple[bool, str]) -> None:
    from elastomorph.errors import ParameterError

    for made, sentence in mistakes:
        if made:
            raise ParameterError(sentence)


def _require_format(
    output: str, moving: bool, size: tuple[int, int], count: int, fps: float, *, transparent: bool
) -> None:
    """Refuse a file name that does not fit what is to be written, before anything is read."""
    from elastomorph.draw.clips import check_clip, is_clip
    from elastomorph.draw.pictures import SUFFIXES

    suffix = Path(output).suffix.lower()
    if moving:
        check_clip(output, size, count, fps)
    _refuse(
        (
            not moving and is_clip(output),
            f"{output} is for a clip: add --turntable or --animate, or write a picture such as "
            "face.png",
        ),
        (
            not moving and suffix not in SUFFIXES,
            f"{output}: a picture is written as {', '.join(SUFFIXES)}, "
            f"found {suffix or 'no suffix'}",
        ),
        (
            transparent and suffix not in (".png", ".webp"),
            f"{output}: only PNG and WebP are transparent; name one, or another --background",
        ),
    )


def _comparison(
    rigs: Sequence[PosedRig],
    times: Sequence[float],
    against: str | None,
    highest: float | None,
    unit: str,
    say: Callable[[str], None],
) -> Comparison | None:
    from elastomorph.cli.posed_rigs import reference
    from elastomorph.draw.pose_pictures import compare

    if against is None:
        return None
    name, at = reference(against, rigs[0], say)
    say("measuring distances")
    return compare(rigs, sorted(set(times)), name, at, highest=highest, unit=unit)


def _edge_loops(posed: PosedRig, say: Callable[[str], None]) -> tuple[Lines, ...]:
    from elastomorph.curves import extract_curves
    from elastomorph.draw.curves_picture import network_lines

    say("finding curves")
    mesh = posed.rig.neutral
    return network_lines(mesh, extract_curves(mesh))


def _counted(frames: Iterable[Image], count: int, say: Callable[[str], None]) -> Iterator[Image]:
    for number, frame in enumerate(frames, start=1):
        say(f"frame {number} of {count}")
        yield frame


def _write(output: str, image: Image) -> None:
    from elastomorph.draw.clips import WIDEST_WEBP
    from elastomorph.draw.pictures import write_picture

    _refuse(
        (
            Path(output).suffix.lower() == ".webp" and max(image.shape) > WIDEST_WEBP,
            f"{output}: WebP holds at most {WIDEST_WEBP:,} pixels a side, the picture has "
            f"{image.shape[1]:,} × {image.shape[0]:,}; write .png or smaller faces",
        )
    )
    write_picture(image, output)


def _tell(facts: dict[str, Any]) -> None:
    clip = (
        f", {facts['frames']} frames at {facts['fps']:g} fps, {facts['seconds']:.2f} s"
        if "frames" in facts
        else ""
    )
    typer.echo(f"{facts['written']}: {facts['width']} × {facts['height']}{clip}")
    if "distance" in facts:
        found = facts["distance"]
        shares = {kind: 100 * found[kind] / found["diameter"] for kind in ("largest", "mean")}
        typer.echo(
            f"distance from {found['from']}: largest {found['largest']:.4g} "
            f"({shares['largest']:.2g} % of D), mean {found['mean']:.4g} "
            f"({shares['mean']:.2g} % of D)"
        )
