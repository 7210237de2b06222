"""What ``elastomorph render`` draws: a picture, faces side by side, a clip; and when it may.

What ``--pose`` asks for: weights by name, a pose of a file, or all poses of a file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.options import named_numbers
from elastomorph.cli.output import Say
from elastomorph.cli.takes import TAKES, Film, TakeOptions, named_part
from elastomorph.errors import ParameterError, warn

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.draw.pictures import Image
    from elastomorph.draw.posed import PosedRig
    from elastomorph.rig import Rig


_SHOWN = 8


@dataclass(frozen=True)
class PoseWords:
    """Poses as the command line names them, their files read.

    Attributes:
        weights: Those given by name; they come on top.
        poses: Those of files: by their words, or by their names of a whole file.
        file: Where all of them come from, if a whole file was named.
    """

    weights: dict[str, float]
    poses: dict[str, dict[str, float]]
    file: str | None = None

    @classmethod
    def of(cls, texts: Sequence[str]) -> PoseWords:
        """Read ``smile=0.7,jawOpen=0.4``, ``poses.json#Smile`` and ``poses.json``."""
        from elastomorph.io.poses import POSE_SUFFIXES, read_poses

        inline: list[str] = []
        poses: dict[str, dict[str, float]] = {}
        for text in texts:
            file, name = named_part(text.strip())
            if not file.lower().endswith(POSE_SUFFIXES):
                inline += [part.strip() for part in text.split(",")]
                continue
            found = read_poses(file)
            if name is None:
                if len(texts) > 1:
                    raise ParameterError(
                        f"{file} is a sheet of all its poses: name one, as in "
                        f"{file}#{next(iter(found))}, or leave the other --pose out"
                    )
                return cls({}, found, file)
            _require(name, found, file)
            poses[text] = found[name]
        return cls(named_numbers(inline, "--pose"), poses)

    @property
    def sheet(self) -> bool:
        """Whether they are all poses of a file."""
        return self.file is not None

    def __bool__(self) -> bool:
        return bool(self.weights or self.poses)

    def on(self, rig: Rig) -> dict[str, dict[str, float]]:
        """The weights of the rig's sliders in each pose; in one without a name, if not a sheet."""
        from elastomorph.rig.performance import fitted_poses, unknown_sliders

        if self and not rig.names:
            raise ParameterError("this is a mesh without sliders, so there is nothing to --pose")
        fitted, unknown = fitted_poses(self.poses, rig.names)
        if unknown:
            sentence = unknown_sliders(unknown, rig.names)
            if not any(fitted.values()):
                raise ParameterError(f"{sentence}: these poses are for another rig")
            warn(f"{sentence}: left out")
        if self.sheet:
            return fitted
        together: dict[str, float] = {}
        for weights in (*fitted.values(), self.weights):
            together |= weights
        rig.sliders.row(together)
        return {"": together}


def _require(name: str, poses: dict[str, dict[str, float]], file: str) -> None:
    if name in poses:
        return
    near = get_close_matches(name, poses, n=1, cutoff=0.5)
    shown = ", ".join(list(poses)[:_SHOWN]) + (", …" if len(poses) > _SHOWN else "")
    hint = f"did you mean {near[0]!r}?" if near else f"there are {shown}"
    raise ParameterError(f"{file} has no pose {name!r}: {hint}")


_STILL, _FACE, FRAME = (720, 900), (240, 300), (480, 600)
TURN_FRAMES, SWING_FRAMES = 100, 50
RATE = 25.0


@dataclass(frozen=True)
class Shot:
    """What is drawn, and when: a picture, a strip, a sheet of poses, a clip or a film of a take."""

    take: Annotated[
        str | None, typer.Option("--take", help=f"Film {TAKES[0].lower()}{TAKES[1:]}")
    ] = None
    t: Annotated[
        float | None,
        typer.Option(
            "--time", "--t", "-t", help="Master time: each path is at its weight × t; 1 by default."
        ),
    ] = None
    strip: Annotated[
        str | None, typer.Option(help="Times side by side in one picture: 0,0.25,0.5,0.75,1.")
    ] = None
    turntable: Annotated[bool, typer.Option("--turntable", help="Turn the head round.")] = False
    degrees: Annotated[
        float | None, typer.Option(help="How far it turns; 360 by default, -360 the other way.")
    ] = None
    animate: Annotated[bool, typer.Option("--animate", help="Run t from 0 to --time and back.")] = (
        False
    )
    timing: options.TimingText = None
    frames: Annotated[
        int | None, typer.Option(help=f"Of a clip: {TURN_FRAMES} of a turn, else {SWING_FRAMES}.")
    ] = None
    fps: Annotated[
        float | None,
        typer.Option(
            help=f"Frames a second of a clip: of a take its own by default, else {RATE:g}."
        ),
    ] = None

    @property
    def moving(self) -> bool:
        """Whether it is a clip."""
        return self.turntable or self.animate or self.take is not None

    @property
    def count(self) -> int:
        """Frames of a clip that is no take."""
        usual = TURN_FRAMES if self.turntable else SWING_FRAMES
        return usual if self.frames is None else self.frames

    @property
    def rate(self) -> float:
        """Frames a second of a clip that is no take."""
        return RATE if self.fps is None else self.fps

    def sides(self, size: str | None, *, sheet: bool) -> tuple[int, int]:
        """Width and height of a picture, a frame, or a face of a strip."""
        from elastomorph.cli.render_words import picture_size

        several = sheet or self.strip is not None
        return picture_size(size, FRAME if self.moving else _FACE if several else _STILL)

    def times(self) -> list[float]:
        """The master time of each face."""
        from elastomorph.cli.options import numbers
        from elastomorph.draw.posed import swing
        from elastomorph.rig.timing import by_name

        end = 1.0 if self.t is None else self.t
        if self.animate:
            return list(map(float, swing(self.count, by_name(self.timing or "smoothstep"), end)))
        if self.moving:
            return [end] * self.count
        return [end] if self.strip is None else numbers(self.strip, "--strip")

    def film(
        self, output: str, of_take: TakeOptions, size: tuple[int, int], say: Say
    ) -> Film | None:
        """The film of the take, if one is asked for."""
        if self.take is None:
            of_take.require_none("a --take: say which, as in --take take.csv")
            return None
        say(f"reading {self.take}")
        whole = of_take.read(self.take, timing=self.timing, rate=self.fps)
        return of_take.film(output, whole, self.fps, size)

    def angles(self) -> NDArray[np.float64] | None:
        """The degrees of each frame, where the head turns."""
        from elastomorph.draw.camera import turn_angles

        degrees = 360.0 if self.degrees is None else self.degrees
        return turn_angles(self.count, degrees) if self.turntable else None

    def require_format(self, output: str, size: tuple[int, int], *, transparent: bool) -> None:
        """Refuse a file name that does not fit what is to be written, before anything is read."""
        from elastomorph.draw.movie import check_clip, is_clip
        from elastomorph.draw.pictures import SUFFIXES

        suffix, still = Path(output).suffix.lower(), not self.moving
        if self.moving and self.take is None:  # a take counts its own frames
            check_clip(output, size, self.count, self.rate)
        refuse(
            {
                f"{output} is for a clip: add --turntable, --animate or --take, or write a picture "
                "such as face.png": still and is_clip(output),
                f"{output}: a picture is written as {', '.join(SUFFIXES)}, "
                f"found {suffix or 'no suffix'}": still and suffix not in SUFFIXES,
                f"{output}: only PNG and WebP are transparent; name one, or another "
                "--background": transparent and suffix not in (".png", ".webp"),
            }
        )

    def draw(
        self,
        output: str,
        rigs: Sequence[PosedRig],
        size: tuple[int, int],
        how: dict[str, Any],
        say: Say,
    ) -> dict[str, Any]:
        """Draw and write; the size of what was written, of which pose, and when."""
        from elastomorph.draw.movie import write_clip
        from elastomorph.draw.posed import clip_frames, pose_picture, pose_strip

        say("drawing")
        times, weights = self.times(), rigs[0].weights
        if self.moving:
            count, rate, angles = self.count, self.rate, self.angles()
            with closing(clip_frames(rigs[0], times, angles, size=size, **how)) as frames:
                write_clip(output, _counted(frames, count, say), count=count, fps=rate)
            length = {"frames": count, "fps": rate, "seconds": count / rate}
            return {"width": size[0], "height": size[1], **length, "pose": weights}
        if self.strip is None:
            image = pose_picture(rigs[0], times[0], size=size, **how)
        else:
            title = ", ".join(f"{name} {weight:g}" for name, weight in weights.items())
            image = pose_strip(rigs, times, face=size, title=title, **how)
        return {**written_picture(image, output), "pose": weights, "times": times}


def written_picture(image: Image, output: str) -> dict[str, float]:
    """Write a picture where its format holds it; its size."""
    from elastomorph.draw.movie import WIDEST_WEBP
    from elastomorph.draw.pictures import write_picture

    height, width = image.shape[:2]
    webp = Path(output).suffix.lower() == ".webp"
    refuse(
        {
            f"{output}: WebP holds at most {WIDEST_WEBP:,} pixels a side, the picture "
            f"has {width:,} × {height:,}; write .png or smaller faces": webp
            and max(height, width) > WIDEST_WEBP
        }
    )
    write_picture(image, output)
    return {"width": width, "height": height}


def require_sense(
    shot: Shot, posed: PoseWords, methods: Sequence[str], against: str | None, *, transparent: bool
) -> None:
    """Refuse options that ask for nothing, or for two things at once."""
    moving, strip, still = shot.moving, shot.strip is not None, not posed
    turned, one = shot.turntable or shot.animate, "name one pose, as in poses.json#Smile"
    own = strip or turned or shot.t is not None or shot.frames is not None or against is not None
    refuse(
        {
            "a --take moves the face by itself: leave out --pose, --time, --strip, --frames, "
            "--turntable, --animate and --against": shot.take is not None and (own or bool(posed)),
            f"a sheet of poses is one picture: {one}, or leave out --time, --strip, --turntable, "
            "--animate and --against": posed.sheet and (own or moving),
            "give --strip, or --turntable and --animate, not both": moving and strip,
            "--degrees says how far a --turntable goes": shot.degrees is not None
            and not shot.turntable,
            "--timing is for --animate, and for poses that are a --take": shot.timing is not None
            and not (shot.animate or shot.take),
            "--frames and --fps are for clips: add --turntable, --animate or --take": not moving
            and (shot.frames is not None or shot.fps is not None),
            "--strip names its times: leave out --time, or --strip": strip and shot.t is not None,
            "several methods are the rows of a strip: add --strip 0,0.5,1": len(methods) > 1
            and not strip,
            "nothing would move: say what does, as in --pose smile=1": still
            and (shot.animate or strip),
            "captions and legends need paper: no transparent background with several faces or "
            "--against": transparent and (strip or posed.sheet or against is not None),
            f"--{'method' if shot.t is None else 'time'} is for what a --pose moves: say what, as "
            "in --pose smile=1": still
            and shot.take is None
            and (shot.t is not None or bool(methods)),
        }
    )


def refuse(mistakes: dict[str, bool]) -> None:
    """Raise the first sentence that is true."""
    for sentence, made in mistakes.items():
        if made:
            raise ParameterError(sentence)


def _counted(frames: Iterable[Image], count: int, say: Say) -> Iterator[Image]:
    for number, frame in enumerate(frames, start=1):
        say(f"frame {number} of {count}")
        yield frame
