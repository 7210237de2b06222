"""Moving pictures: MP4 (H.264), encoded by ffmpeg while frames are drawn, and animated GIF."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.pictures import Image, imported
from elastomorph.errors import ElastomorphError, FileError, ParameterError
from elastomorph.io.atomic import replacing, replacing_path

if TYPE_CHECKING:
    from elastomorph.draw.sound import Sound

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
