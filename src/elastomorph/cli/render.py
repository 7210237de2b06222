"""``elastomorph render``: pictures, strips and clips of a rig, without a display."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import completion, options
from elastomorph.cli.output import Say
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.draw.pictures import Image
    from elastomorph.draw.posed import PosedRig

_STILL, _FACE, _FRAME = (720, 900), (240, 300), (480, 600)
_TURN_FRAMES, _SWING_FRAMES = 100, 50
_RATE = 25.0

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
        help="smile=0.7, repeated or separated by commas.",
        autocompletion=completion.poses,
    ),
]
Time = Annotated[
    float | None,
    typer.Option(
        "--time", "--t", "-t", help="Master time: each path is at its weight × t; 1 by default."
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
Turn = Annotated[bool, typer.Option("--turntable", help="Turn the head round.")]
Degrees = Annotated[
    float | None, typer.Option(help="How far it turns; 360 by default, -360 the other way.")
]
Animate = Annotated[bool, typer.Option("--animate", help="Run t from 0 to --time and back.")]
Frames = Annotated[
    int | None, typer.Option(help=f"Of a clip: {_TURN_FRAMES} of a turn, else {_SWING_FRAMES}.")
]
Rate = Annotated[
    float | None, typer.Option(help=f"Frames a second of a clip, {_RATE:g} by default.")
]
Strip = Annotated[
    str | None, typer.Option(help="Times side by side in one picture: 0,0.25,0.5,0.75,1.")
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
    t: Time = None,
    method: Methods = None,
    mesh: options.MeshNames = None,
    view: ViewText = "front",
    size: Size = None,
    turntable: Turn = False,
    degrees: Degrees = None,
    animate: Animate = False,
    timing: options.TimingText = None,
    frames: Frames = None,
    fps: Rate = None,
    strip: Strip = None,
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
    """Draw a face: a picture, in-betweens side by side, a turn of the head, a moving expression.

    Examples:
      elastomorph render rig.glb --pose smile=0.7,jawOpen=0.4 --t 0.5 -o face.png
      elastomorph render rig.glb --pose smile=1 --turntable -o turn.mp4
      elastomorph render rig.glb --pose smile=1 --animate --timing smoothstep -o smile.gif
      elastomorph render rig.glb -p smile=1 --strip 0,0.5,1 --method linear --method arc -o a.png
    """
    from elastomorph.cli import render_words as said
    from elastomorph.draw.sheet import Style

    parts = [part.strip() for text in pose or () for part in text.split(",")]
    weights = options.named_numbers(parts, "--pose")
    colour = said.background_of(background)
    shot = _Shot(output, t, strip, turntable, degrees, animate, timing, frames, fps)
    _require_sense(shot, weights, method or [], against, transparent=colour is None)
    if against is None and (highest is not None or unit):
        raise ParameterError(f"--{'unit' if highest is None else 'highest'} is for --against")
    sides, looked = shot.sides(size), said.view_of(view)
    shot.require_format(sides, transparent=colour is None)
    times, angles = shot.times(), shot.angles()
    rigs = said.posed_rigs(rig, method or (), weights, say, settings, mesh)
    compared = said.comparison(rigs, times, against, highest, unit, say)
    style = Style(wireframe, said.curves_of(rigs[0], say) if edge_loops else (), colour)
    how = {"view": looked, "style": style, "comparison": compared}
    say("drawing")
    drawn = shot.draw(rigs, times, angles, sides, how, say)
    facts: dict[str, Any] = {"written": output, **drawn, "pose": weights}
    if not shot.moving:
        facts["times"] = times
    if compared is not None:
        facts["distance"] = {"from": against, **compared.facts}
    return Answer(facts, lambda: _tell(facts))


@dataclass(frozen=True)
class _Shot:
    """What is drawn, and when: a picture, a strip or a clip."""

    output: str
    t: float | None
    strip: str | None
    turntable: bool
    degrees: float | None
    animate: bool
    timing: str | None
    frames: int | None
    fps: float | None

    @property
    def moving(self) -> bool:
        return self.turntable or self.animate

    @property
    def count(self) -> int:
        usual = _TURN_FRAMES if self.turntable else _SWING_FRAMES
        return usual if self.frames is None else self.frames

    @property
    def rate(self) -> float:
        return _RATE if self.fps is None else self.fps

    def sides(self, size: str | None) -> tuple[int, int]:
        """Width and height of a picture, a frame, or a face of a strip."""
        from elastomorph.cli.render_words import picture_size

        usual = _FRAME if self.moving else _STILL if self.strip is None else _FACE
        return picture_size(size, usual)

    def times(self) -> list[float]:
        """The master time of each face."""
        from elastomorph.cli.render_words import numbers
        from elastomorph.draw.posed import swing
        from elastomorph.rig.timing import by_name

        end = 1.0 if self.t is None else self.t
        if self.animate:
            return list(map(float, swing(self.count, by_name(self.timing or "smoothstep"), end)))
        if self.moving:
            return [end] * self.count
        return [end] if self.strip is None else numbers(self.strip, "--strip")

    def angles(self) -> NDArray[np.float64] | None:
        """The degrees of each frame, where the head turns."""
        from elastomorph.draw.framing import turn_angles

        degrees = 360.0 if self.degrees is None else self.degrees
        return turn_angles(self.count, degrees) if self.turntable else None

    def require_format(self, size: tuple[int, int], *, transparent: bool) -> None:
        """Refuse a file name that does not fit what is to be written, before anything is read."""
        from elastomorph.draw.clips import check_clip, is_clip
        from elastomorph.draw.pictures import SUFFIXES

        output, suffix, still = self.output, Path(self.output).suffix.lower(), not self.moving
        if self.moving:
            check_clip(output, size, self.count, self.rate)
        _refuse(
            {
                f"{output} is for a clip: add --turntable or --animate, or write a picture such "
                "as face.png": still and is_clip(output),
                f"{output}: a picture is written as {', '.join(SUFFIXES)}, "
                f"found {suffix or 'no suffix'}": still and suffix not in SUFFIXES,
                f"{output}: only PNG and WebP are transparent; name one, or another "
                "--background": transparent and suffix not in (".png", ".webp"),
            }
        )

    def draw(
        self,
        rigs: Sequence[PosedRig],
        times: Sequence[float],
        angles: NDArray[np.float64] | None,
        size: tuple[int, int],
        how: dict[str, Any],
        say: Say,
    ) -> dict[str, float]:
        """Draw and write; the size of what was written, and the length of a clip."""
        from elastomorph.draw.clips import WIDEST_WEBP, write_clip
        from elastomorph.draw.pictures import write_picture
        from elastomorph.draw.posed import clip_frames, pose_picture, pose_strip

        if self.moving:
            count, rate = self.count, self.rate
            with closing(clip_frames(rigs[0], times, angles, size=size, **how)) as frames:
                write_clip(self.output, _counted(frames, count, say), count=count, fps=rate)
            length = {"frames": count, "fps": rate, "seconds": count / rate}
            return {"width": size[0], "height": size[1], **length}
        if self.strip is None:
            image = pose_picture(rigs[0], times[0], size=size, **how)
        else:
            title = ", ".join(f"{name} {weight:g}" for name, weight in rigs[0].weights.items())
            image = pose_strip(rigs, times, face=size, title=title, **how)
        height, width = image.shape[:2]
        webp = Path(self.output).suffix.lower() == ".webp"
        _refuse(
            {
                f"{self.output}: WebP holds at most {WIDEST_WEBP:,} pixels a side, the picture "
                f"has {width:,} × {height:,}; write .png or smaller faces": webp
                and max(height, width) > WIDEST_WEBP
            }
        )
        write_picture(image, self.output)
        return {"width": width, "height": height}


def _require_sense(
    shot: _Shot,
    weights: dict[str, float],
    methods: Sequence[str],
    against: str | None,
    *,
    transparent: bool,
) -> None:
    """Refuse options that ask for nothing, or for two things at once."""
    moving, strip, still = shot.moving, shot.strip is not None, not weights
    _refuse(
        {
            "give --strip, or --turntable and --animate, not both": moving and strip,
            "--degrees says how far a --turntable goes": shot.degrees is not None
            and not shot.turntable,
            "--timing is for --animate": shot.timing is not None and not shot.animate,
            "--frames and --fps are for clips: add --turntable or --animate": not moving
            and (shot.frames is not None or shot.fps is not None),
            "--strip names its times: leave out --time, or --strip": strip and shot.t is not None,
            "several methods are the rows of a strip: add --strip 0,0.5,1": len(methods) > 1
            and not strip,
            "nothing would move: say what does, as in --pose smile=1": still
            and (shot.animate or strip),
            "captions and legends need paper: no transparent background with --strip or "
            "--against": transparent and (strip or against is not None),
            f"--{'method' if shot.t is None else 'time'} is for what a --pose moves: say what, as "
            "in --pose smile=1": still and (shot.t is not None or bool(methods)),
        }
    )


def _refuse(mistakes: dict[str, bool]) -> None:
    """Raise the first sentence that is true."""
    for sentence, made in mistakes.items():
        if made:
            raise ParameterError(sentence)


def _counted(frames: Iterable[Image], count: int, say: Say) -> Iterator[Image]:
    for number, frame in enumerate(frames, start=1):
        say(f"frame {number} of {count}")
        yield frame


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
