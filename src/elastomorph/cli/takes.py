"""What verbs play on a rig: a take or poses from a file, which part of it, and its sound."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, fields
from difflib import get_close_matches
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.options import named_numbers
from elastomorph.cli.output import Say
from elastomorph.errors import ParameterError, warn
from elastomorph.numbers import as_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.cli.output import Say
    from elastomorph.draw.movie import Sound
    from elastomorph.draw.pictures import Image
    from elastomorph.draw.posed import PosedRig
    from elastomorph.rig import Rig
    from elastomorph.rig.performance import Match, Performance


TAKES = (
    "A take of Live Link Face or columns time,jawOpen,… (.csv), arrays (.npz), a clip "
    "(.glb, take.glb#NAME), or poses to go through (.json, .csv)."
)
_POSED = re.compile(r"(.+\.(?:json|csv|glb|gltf|vrm))#(.+)", re.IGNORECASE)
MOST_NAMED = 8
"""Weights or sliders of a kind; ``animate --list`` names them all."""
_TOLD = 0.1
"""Seconds by which a sound may end beside the take before that is told."""


def named_part(text: str | Path) -> tuple[str, str | None]:
    """The file and the name behind it in ``poses.json#Smile``."""
    found = _POSED.fullmatch(str(text))
    return (str(text), None) if found is None else (found[1], found[2])


@dataclass(frozen=True)
class TakeOptions:
    """How a take is read, which part of it is meant, and what is heard with it."""

    start: Annotated[
        float | None, typer.Option("--start", "--from", help="First second of the take.")
    ] = None
    stop: Annotated[
        float | None, typer.Option("--stop", "--to", help="Last second of the take.")
    ] = None
    timecode_rate: Annotated[
        float | None,
        typer.Option(help="What the timecodes count, such as 29.97, if they do not show it."),
    ] = None
    pose_times: Annotated[
        str | None,
        typer.Option(help="Of poses, the second of each: 0,0.5,2. Default: one a second."),
    ] = None
    audio: Annotated[
        Path | None,
        typer.Option(help="Sound of an .mp4: WAV, MP3 or a movie; it begins with the take."),
    ] = None
    audio_offset: Annotated[
        float | None,
        typer.Option(help="Seconds that the sound begins after the take; negative, before it."),
    ] = None
    clip: Annotated[bool, typer.Option("--clip", help="Keep weights within 0 and 1.")] = False
    still_head: Annotated[
        bool, typer.Option("--still-head", help="Leave the head still where the take turns it.")
    ] = False
    draft: Annotated[
        bool,
        typer.Option("--draft", help="One sample a pixel: jagged, two to three times as fast."),
    ] = False

    def require_none(self, why: str, names: Sequence[str] | None = None) -> None:
        """Refuse these options, or any."""
        for name in names or [each.name for each in fields(self)]:
            if getattr(self, name) not in (None, False):
                raise ParameterError(f"--{name.replace('_', '-')} is for {why}")

    def read(
        self, named: str | Path, *, timing: str | None = None, rate: float | None = None
    ) -> Performance:
        """The whole take that a word names, or the way through the poses in it."""
        from elastomorph.cli.options import numbers
        from elastomorph.io.performance import read_performance
        from elastomorph.io.poses import holds_poses, read_poses
        from elastomorph.rig.performance import through_poses
        from elastomorph.rig.timing import by_name

        file, part = named_part(named)
        if not holds_poses(file):
            why = f"poses; {file} is a take with its own times"
            self.require_none(why, ["pose_times"])
            if timing is not None:
                raise ParameterError(f"--timing is for {why}")
            return read_performance(file, self.timecode_rate, clip=part)
        if part is not None:
            raise ParameterError(f"{named} is one pose, which does not move; name {file} for all")
        times = self.pose_times
        return through_poses(
            read_poses(file),
            None if times is None else numbers(times, "--pose-times"),
            timing=by_name(timing or "smoothstep"),
            rate=30.0 if rate is None else rate,
            source=file,
        )

    def part(self, whole: Performance) -> Performance:
        """The frames that are meant."""
        start, stop = self._span()
        return whole if (start, stop) == (-inf, inf) else whole.part(start, stop)

    def _span(self) -> tuple[float, float]:
        """First and last second."""
        start = -inf if self.start is None else as_number(self.start, "--from")
        stop = inf if self.stop is None else as_number(self.stop, "--to")
        if start > stop:
            raise ParameterError(f"--from {start:g} comes after --to {stop:g}: exchange the two")
        return start, stop

    def _even(self, whole: Performance, rate: float) -> Performance:
        """Frames at an even rate from the first second that is meant on.

        Keys may be far apart: between two of them there is a take, too.
        """
        from elastomorph.rig.performance import Performance

        start, stop = self._span()
        first, last = max(start, float(whole.times[0])), min(stop, float(whole.times[-1]))
        if first > last:
            whole.part(start, stop)  # says that there is nothing
        inside = whole.times[(whole.times > first) & (whole.times < last)]
        times = [first, *inside, last] if first < last else [first]
        cut = Performance(whole.names, times, whole.at(times), whole.rate, source=whole.source)
        return cut.resampled(rate)

    def film(
        self, output: str, whole: Performance, fps: float | None, size: tuple[int, int]
    ) -> Film:
        """A film of what is meant of a take; refused before anything is drawn."""
        from elastomorph.draw.movie import check_clip, movie_rate

        if self.audio is None:
            self.require_none("a sound: add --audio take.wav", ["audio_offset"])
        elif not output.lower().endswith(".mp4"):
            raise ParameterError(f"{output} holds no sound: write .mp4, or leave --audio out")
        wanted = whole.rate if fps is None else fps
        rate = float(movie_rate(wanted)) if 0 < wanted < inf else wanted
        check_clip(output, size, 1, rate)
        take = self._even(whole, rate)
        check_clip(output, size, len(take), rate)
        offset = as_number(self.audio_offset or 0.0, "--audio-offset")
        start = float(take.times[0] - whole.times[0]) - offset
        sound = None
        if self.audio is not None:
            sound = laid_sound(self.audio, start, len(take) / rate, cut=self.stop is not None)
        return Film(output, take, rate, size, sound, draft=self.draft)


def require_driven(found: Match, take: Performance) -> None:
    """Refuse a take that moves nothing of a rig."""
    if not found.drives and not found.sliders:
        raise ParameterError(
            f"the rig has no sliders, so {take.source} moves nothing; export it with its blend "
            "shapes"
        )
    if not found.drives:
        raise ParameterError(
            f"no weight of {take.source} drives a slider of the rig ({len(found.sliders)} "
            "sliders); see 'elastomorph animate --list' for the names of both"
        )


@dataclass(frozen=True)
class Film:
    """A film of a take: where it goes, how many frames a second, how large, with which sound.

    Attributes:
        output: .mp4, .gif, .webp or numbered pictures.
        take: What is shown, frame by frame, at the times of the whole take.
        fps: Frames a second; frame n shows the take n / fps after its first.
        size: Width and height in pixels.
        sound: What is heard, if anything.
        draft: Whether it is for a glance only.
    """

    output: str
    take: Performance
    fps: float
    size: tuple[int, int]
    sound: Sound | None = None
    draft: bool = False

    def write(
        self, rig: Rig, weights: NDArray[np.float64], how: dict[str, Any], say: Say
    ) -> dict[str, float]:
        """Draw (T, J) weights of the rig's sliders frame by frame; size and length."""
        from elastomorph.draw.film import film_frames
        from elastomorph.draw.movie import write_clip

        count = len(weights)

        def counted(frames: Iterator[Image]) -> Iterator[Image]:
            for number, frame in enumerate(frames, start=1):
                say(f"frame {number} of {count}")
                yield frame

        with closing(film_frames(rig, weights, size=self.size, draft=self.draft, **how)) as frames:
            write_clip(self.output, counted(frames), count=count, fps=self.fps, sound=self.sound)
        width, height = self.size
        length = {"frames": count, "fps": self.fps, "seconds": count / self.fps}
        return {"width": width, "height": height, **length}


def laid_sound(audio: Path, start: float, seconds: float, *, cut: bool) -> Sound:
    """A sound that is heard from a second of its own on, and a sentence where it does not fit."""
    from elastomorph.draw.movie import Sound, sound_length

    heard = sound_length(audio)
    left = heard - start - seconds
    if start >= heard or -start >= seconds:
        raise ParameterError(
            f"{audio} is {heard:.2f} s long and would not be heard in the {seconds:.2f} s that are "
            "shown; choose another --audio-offset"
        )
    if left < -_TOLD:
        _tell(f"{audio} is shorter than the take: its last {-left:.2f} s are silent")
    elif left > _TOLD and not cut:
        _tell(f"{audio} is longer than the take: its last {left:.2f} s are not heard")
    return Sound(audio, start, seconds)


def _tell(sentence: str) -> None:
    warn(sentence)


def frames_line(count: int, rate: float) -> str:
    """Such as "1 frame at 29.97 fps"."""
    return f"{count:,} frame{'s' * (count != 1)} at {rate:.5g} fps"


def film_line(facts: dict[str, Any]) -> str:
    """What was written, in a line."""
    length = (
        f", {frames_line(facts['frames'], facts['fps'])}, {facts['seconds']:.2f} s"
        if "frames" in facts
        else ""
    )
    return f"{facts['written']}: {facts['width']} × {facts['height']}{length}"


# What ``elastomorph render`` draws: a picture, faces side by side, a clip; and when it may.
#
# What ``--pose`` asks for: weights by name, a pose of a file, or all poses of a file.

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
