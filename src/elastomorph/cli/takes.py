"""What verbs play on a rig: a take or poses from a file, which part of it, and its sound."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, fields
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.errors import ParameterError, warn
from elastomorph.numbers import as_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.cli.output import Say
    from elastomorph.draw.movie import Sound
    from elastomorph.draw.pictures import Image
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
