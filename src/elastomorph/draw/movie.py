"""Moving pictures: MP4 (H.264), encoded by ffmpeg while frames are drawn, and animated GIF."""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.pictures import SUFFIXES, Image, as_pillow, imported, write_picture
from elastomorph.errors import ElastomorphError, FileError, FormatError, ParameterError
from elastomorph.io.atomic import opened, replacing, replacing_path
from elastomorph.io.numbering import frame_pattern

_FINEST_RATE = 1001
"""Denominator of the broadcast rates: 23.976 is 24000/1001."""
_SAME_RATE = 1e-5


def find_encoder() -> str:
    """The ffmpeg program that imageio-ffmpeg brings along, or finds on this machine."""
    try:
        return str(imported("imageio_ffmpeg").get_ffmpeg_exe())
    except RuntimeError:
        raise ElastomorphError(
            "MP4 needs the program ffmpeg, and imageio-ffmpeg brings none for this machine: "
            "install ffmpeg, or write .webp, .gif or numbered pictures"
        ) from None


def movie_rate(fps: float) -> Fraction:
    """The frames a second that a movie has: 29.97 and the like are those of broadcast, n/1.001."""
    broadcast = Fraction(round(fps * 1.001) * 1000, _FINEST_RATE)
    if broadcast > 0 and abs(float(broadcast) - fps) < _SAME_RATE * fps:
        return broadcast
    return Fraction(fps).limit_denominator(_FINEST_RATE)


def write_movie(
    path: str | Path,
    frames: Iterable[Image],
    size: tuple[int, int],
    fps: float,
    sound: Sound | None = None,
) -> None:
    """Write an MP4 that browsers and editors play: H.264, yuv420p, the index at the front.

    Frames are (H, W, 3) uint8, sRGB, and converted and marked as BT.709, whose primaries are the
    same, so players show the colours that were drawn. Width and height are even. A sound is AAC.
    """
    with replacing_path(path) as temporary, tempfile.TemporaryFile() as complaints:
        process = subprocess.Popen(
            _command(find_encoder(), temporary, size, fps, sound),
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=complaints,
        )
        try:
            # a pipe that breaks means that ffmpeg gave up; it says why below
            with suppress(BrokenPipeError):
                _feed(process, frames, size)
            status = process.wait()
        finally:
            _end(process)
        if status:
            why = _last_line(complaints) or f"it ended with status {status}"
            raise FileError(path, f"ffmpeg could not encode the movie: {why}")


def _command(
    program: str, path: Path, size: tuple[int, int], fps: float, sound: Sound | None
) -> list[str]:
    pixels = f"-f rawvideo -pixel_format rgb24 -video_size {size[0]}x{size[1]}"
    given = f"{pixels} -framerate {movie_rate(fps)} -i pipe:0"
    heard = ["-an"] if sound is None else sound.words
    convert = (
        "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int,"
        "format=yuv420p,"
        "setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709:range=tv"
    )
    encode = "-c:v libx264 -preset medium -crf 15"
    whole = "-movflags +faststart -fflags +bitexact -f mp4"
    return [
        *(program, "-y", "-nostdin", "-hide_banner", "-loglevel", "error"),
        *(*given.split(), *heard, "-vf", convert),
        *(*encode.split(), *whole.split(), str(path)),
    ]


def _feed(process: subprocess.Popen[bytes], frames: Iterable[Image], size: tuple[int, int]) -> None:
    expected = (size[1], size[0], 3)
    if process.stdin is None:
        return
    with process.stdin as pipe:
        for frame in frames:
            if frame.shape != expected:
                raise ParameterError(f"a movie of {expected} pixels got a frame of {frame.shape}")
            pipe.write(np.ascontiguousarray(frame).data)


def _end(process: subprocess.Popen[bytes]) -> None:
    """Whatever happened, no encoder goes on in the background."""
    if process.poll() is None:
        process.kill()
        process.wait()


def _last_line(complaints: IO[bytes]) -> str:
    complaints.seek(0)
    lines = complaints.read().decode(errors="replace").strip().splitlines()
    return lines[-1].strip() if lines else ""


_COLOURS = 255
_UNCHANGED = 255
_SAMPLED_FRAMES = 16
_SAMPLED_PIXELS = 400_000
_DITHER = 5.0
"""Levels between the highest and the lowest of the pattern: about the step between colours."""


def write_gif(path: str | Path, frames: Iterable[Image], durations: list[int]) -> None:
    """Write (H, W, 3) uint8 pictures as a GIF that plays again and again, each for tens of ms.

    One palette serves all frames, the pattern of the dither stands still and the most frequent
    colour is exact. (The palettes that ffmpeg finds tint the whites of eyes.)
    """
    drawn = list(frames)  # all must wait for the palette
    if not drawn:
        raise ParameterError("a GIF needs at least 1 frame, found 0")
    coming = _changes(drawn, _palette(drawn[:: -(-len(drawn) // _SAMPLED_FRAMES)]))
    with replacing(path) as file:
        next(coming).save(
            file,
            format="GIF",
            save_all=True,
            append_images=coming,
            duration=durations,
            loop=0,
            disposal=1,
            transparency=_UNCHANGED,
            optimize=False,
        )


def _palette(frames: list[Image]) -> NDArray[np.uint8]:
    """(255, 3) colours: the most frequent of the first frame, then those of the other pixels."""
    pixels = np.stack(frames).reshape(-1, 3)
    colours, counts = np.unique(frames[0].reshape(-1, 3), axis=0, return_counts=True)
    background = colours[None, counts.argmax()]
    others = pixels[(pixels != background).any(axis=1)]
    sheet = np.concatenate([background, others[:: 1 + len(others) // _SAMPLED_PIXELS]])
    pillow = imported("PIL.Image")
    found = pillow.fromarray(sheet[None]).quantize(
        _COLOURS - 1, method=pillow.Quantize.MEDIANCUT, kmeans=2
    )
    chosen = np.array(found.getpalette(), dtype=np.uint8).reshape(-1, 3)
    return np.resize(np.concatenate([background, chosen]), (_COLOURS, 3))


def _changes(frames: list[Image], palette: NDArray[np.uint8]) -> Iterator[Any]:
    """Pillow's pictures of the first frame, and of what differs in each from the one before."""
    from scipy.spatial import cKDTree

    # the nearest colour to each cell of 4 × 4 × 4 levels
    cells = np.stack(np.meshgrid(*[np.arange(64) * 4 + 1.5] * 3, indexing="ij"), axis=-1)
    nearest = np.asarray(cKDTree(palette.astype(float)).query(cells)[1]).astype(np.uint8)
    pattern = dither_pattern(*frames[0].shape[:2])[..., None]
    before = None
    for frame in frames:
        noisy = np.clip(np.rint(frame + pattern), 0, 255).astype(np.uint8) >> 2
        indices = nearest[tuple(np.moveaxis(noisy, -1, 0))]
        indices[(frame == palette[0]).all(axis=2)] = 0
        new = indices if before is None else np.where(indices == before, _UNCHANGED, indices)
        picture = imported("PIL.Image").fromarray(new.astype(np.uint8))
        picture.putpalette(palette.tobytes())
        before = indices
        yield picture


def dither_pattern(height: int, width: int) -> NDArray[np.float64]:
    """Bayer's 8 × 8 pattern over a picture: (height, width) levels with mean 0."""
    bayer = np.zeros((1, 1))
    for _ in range(3):
        bayer = np.block([[4 * bayer, 4 * bayer + 2], [4 * bayer + 3, 4 * bayer + 1]])
    levels = (bayer + 0.5) / bayer.size - 0.5
    repeats = (-(-height // len(levels)), -(-width // len(levels)))
    return _DITHER * np.tile(levels, repeats)[:height, :width]


# The sound of a movie: of a sound file or another movie, laid to the picture sample by sample.

SAMPLES = 48_000
"""A second."""


@dataclass(frozen=True)
class Sound:
    """What is heard with a movie.

    Attributes:
        path: WAV, MP3, or whatever else ffmpeg hears something in, such as a movie.
        start: The second of it that is heard with the first frame; below 0, it begins later.
        seconds: How long the movie is: what is missing at the end is silent.
    """

    path: Path
    start: float
    seconds: float

    @property
    def words(self) -> list[str]:
        """What tells ffmpeg to read it, as its second input, and to lay it to the picture."""
        # Counted in samples from the beginning of the file, whatever its own time stamps are.
        steps = [f"aresample={SAMPLES}:async=1:first_pts=0"]
        first = round(self.start * SAMPLES)
        if first > 0:
            steps += [f"atrim=start_sample={first}", "asetpts=PTS-STARTPTS"]
        elif first < 0:
            steps.append(f"adelay=delays={-first}S:all=1")
        steps += ["apad", f"atrim=end_sample={round(self.seconds * SAMPLES)}"]
        heard = ["-map", "0:v:0", "-map", "1:a:0", "-af", ",".join(steps)]
        coded = ["-c:a", "aac", "-b:a", "192k", "-flags:a", "+bitexact"]
        return [*_input(self.path), *heard, *coded]


def sound_length(path: str | Path) -> float:
    """Seconds of sound in a file, counted by decoding it.

    Raises:
        FileError: It is missing or cannot be read.
        FormatError: There is no sound in it.
    """
    with opened(path):
        pass
    command = [find_encoder(), "-nostdin", "-hide_banner", "-loglevel", "error"]
    command += [*_input(Path(path)), "-map", "0:a:0", "-af", f"aresample={SAMPLES}:async=1"]
    told = subprocess.run(
        [*command, "-f", "null", "-progress", "pipe:1", "-"], capture_output=True, text=True
    )
    lengths = re.findall(r"^out_time_us=(\d+)$", told.stdout, re.MULTILINE)
    seconds = int(lengths[-1]) / 1e6 if lengths else 0.0
    if seconds <= 0:
        raise FormatError(
            path, "there is no sound in it that can be read; expected WAV, MP3 or a movie with it"
        )
    return seconds


def _input(path: Path) -> list[str]:
    """A file of this machine and nothing else: a playlist in it opens no address."""
    return ["-protocol_whitelist", "file,pipe", "-i", f"file:{path}"]


# Clips as files: a movie, a moving picture, or numbered pictures, frame by frame.
#
# A movie and numbered pictures are written while frames are drawn, in memory that does not grow
# with their number. Moving pictures (GIF, WebP) are kept until the last frame is there, so they
# have a limit.

CLIP_SUFFIXES = (".mp4", ".gif", ".webp")
FASTEST = 240.0
FASTEST_GIF = 50.0
"""Browsers show frames of a GIF that are shorter than 0.02 s for 0.1 s instead."""
ROOM = 400_000_000
"""Pixels of all frames together in a GIF or WebP: 1.2 GB as they wait for the last one."""
WIDEST_WEBP = 16383
_MOST = 10_000_000


def is_clip(path: str | Path) -> bool:
    """Whether a path can only be a clip: a movie, a GIF or a pattern of numbers."""
    name = Path(path)
    return "#" in name.name or name.suffix.lower() in (".mp4", ".gif")


def check_clip(path: str | Path, size: tuple[int, int], count: int, fps: float) -> None:
    """Refuse what `write_clip` cannot write, before the first frame (width, height) is drawn."""
    name, suffix = Path(path).name, Path(path).suffix.lower()
    if not 1 <= count <= _MOST:
        raise ParameterError(f"a clip has at least 1 frame, and at most {_MOST:,}, found {count:,}")
    if not 0 < fps <= FASTEST:
        raise ParameterError(f"a clip needs above 0 and at most {FASTEST:g} fps, found {fps:g}")
    if not Path(path).parent.is_dir():
        raise FileError(path, f"the folder {Path(path).parent} does not exist; make it first")
    if "#" in name:
        _require_free_numbers(path, count)
        return
    if suffix not in CLIP_SUFFIXES:
        raise ParameterError(
            f"{path}: a clip is written as {', '.join(CLIP_SUFFIXES)} or as numbered pictures "
            f"such as frame.####.png, found {suffix or 'no suffix'}"
        )
    width, height = size
    if suffix == ".mp4":
        if width % 2 or height % 2:
            raise ParameterError(
                f"{path}: an MP4 has an even width and height, found {width} × {height}; "
                f"take {width + width % 2}x{height + height % 2}"
            )

        find_encoder()
        return
    if suffix == ".gif" and fps > FASTEST_GIF:
        raise ParameterError(
            f"{path}: a GIF shows at most {FASTEST_GIF:g} frames a second, found {fps:g}; "
            "write .webp or .mp4 instead"
        )
    if count * width * height > ROOM:
        raise ParameterError(
            f"{path}: {count:,} frames of {width} × {height} do not fit into memory together; "
            "write .mp4 or numbered pictures, or fewer or smaller frames"
        )


def write_clip(
    path: str | Path,
    frames: Iterable[Image],
    *,
    count: int,
    fps: float,
    sound: Sound | None = None,
) -> None:
    """Write frames one after another; the file is whole or not there, numbered ones each.

    Args:
        path: ``.mp4`` (H.264), ``.gif`` and ``.webp`` (which play again and again), or
            ``frame.####.png``, .jpg or .webp, from number 1 on.
        frames: (H, W, 3) uint8 pictures of one size; for WebP and PNG also (H, W, 4).
        count: How many there are.
        fps: Frames a second.
        sound: What is heard with an MP4.
    """
    coming = iter(frames)
    try:
        first = next(coming)
    except StopIteration:
        raise ParameterError("a clip needs at least 1 frame, found 0") from None
    check_clip(path, (first.shape[1], first.shape[0]), count, fps)
    alike = _alike(chain([first], coming), first, count)
    suffix = Path(path).suffix.lower()
    if "#" in Path(path).name:
        pattern = frame_pattern(path)
        for number, frame in enumerate(alike, start=1):
            write_picture(frame, pattern.file(number))
    elif suffix == ".mp4":
        write_movie(path, alike, (first.shape[1], first.shape[0]), fps, sound)
    elif suffix == ".gif":
        write_gif(path, alike, frame_durations(count, fps, 10))
    else:
        _write_webp(path, alike, frame_durations(count, fps, 1))


def frame_durations(count: int, fps: float, step: int) -> list[int]:
    """Milliseconds of each frame, in whole steps of the format, such that no error adds up."""
    ends = np.rint(np.arange(count + 1) * (1000.0 / fps / step)).astype(int)
    return [max(step, int(each) * step) for each in np.diff(ends)]


def _write_webp(path: str | Path, frames: Iterator[Image], durations: list[int]) -> None:
    pictures = [as_pillow(frame) for frame in frames]
    with replacing(path) as file:
        pictures[0].save(
            file,
            format="WEBP",
            save_all=True,
            append_images=pictures[1:],
            duration=durations,
            loop=0,
            quality=88,
            method=4,
            # every frame whole: pieces of older frames that nearly fit would stay as patches
            kmin=0,
            kmax=1,
        )


def _alike(frames: Iterable[Image], first: Image, count: int) -> Iterator[Image]:
    """The frames, each checked against the first, and all of them counted."""
    number = 0
    for number, frame in enumerate(frames, start=1):
        if frame.shape != first.shape or number > count:
            raise ParameterError(
                f"expected {count} frames of shape {first.shape}, frame {number} has {frame.shape}"
            )
        yield frame
    if number != count:
        raise ParameterError(f"expected {count} frames, found {number}")


def _require_free_numbers(path: str | Path, count: int) -> None:
    if Path(path).suffix.lower() not in SUFFIXES:
        raise ParameterError(
            f"{path}: numbered pictures are {', '.join(SUFFIXES)}, "
            f"found {Path(path).suffix or 'no suffix'}"
        )
    frame_pattern(path).require_only(range(1, count + 1))
