"""Moving pictures: MP4 (H.264), encoded by ffmpeg while frames are drawn, and animated GIF."""

from __future__ import annotations

import subprocess
import tempfile
import zlib
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


COLOURS = 255
_UNCHANGED = 255
_SAMPLED_FRAMES = 16
_SAMPLED_PIXELS = 400_000
_DITHER = 5.0
"""Levels between the highest and the lowest of the pattern: about the step between colours."""


def write_gif(path: str | Path, frames: Iterable[Image], durations: list[int]) -> None:
    """Write (H, W, 3) uint8 pictures as a GIF that plays again and again, each for tens of ms."""
    packed, shape = _packed(frames)
    if not packed:
        raise ParameterError("a GIF needs at least 1 frame, found 0")
    chosen = np.unique(np.linspace(0, len(packed) - 1, _SAMPLED_FRAMES).astype(int))
    samples = np.stack([_unpacked(packed[number], shape) for number in chosen])
    background = _most_frequent(samples[0].reshape(-1, 3))
    palette = _palette(samples.reshape(-1, 3), background)
    nearest = _nearest_table(palette)
    pattern = dither_pattern(shape[0], shape[1])
    indexed = (_indexed(_unpacked(each, shape), palette, nearest, pattern) for each in packed)
    coming = _changes(indexed, palette)
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


def dither_pattern(height: int, width: int) -> NDArray[np.float64]:
    """Bayer's 8 × 8 pattern over a picture: (height, width) levels with mean 0."""
    bayer = np.zeros((1, 1))
    for _ in range(3):
        bayer = np.block([[4 * bayer, 4 * bayer + 2], [4 * bayer + 3, 4 * bayer + 1]])
    levels = (bayer + 0.5) / bayer.size - 0.5
    repeats = (-(-height // len(levels)), -(-width // len(levels)))
    return _DITHER * np.tile(levels, repeats)[:height, :width]


def _packed(frames: Iterable[Image]) -> tuple[list[bytes], tuple[int, ...]]:
    """The frames compressed without loss, for all must wait for the palette; and their shape."""
    packed: list[bytes] = []
    shape: tuple[int, ...] = (0, 0, 3)
    for frame in frames:
        shape = frame.shape
        packed.append(zlib.compress(frame.tobytes(), 1))
    return packed, shape


def _unpacked(packed: bytes, shape: tuple[int, ...]) -> Image:
    return np.frombuffer(zlib.decompress(packed), dtype=np.uint8).reshape(shape)


def _most_frequent(pixels: Image) -> NDArray[np.uint8]:
    colours, counts = np.unique(pixels, axis=0, return_counts=True)
    return np.asarray(colours[counts.argmax()])


def _palette(pixels: Image, background: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(255, 3) colours: the background, then 254 of the other pixels."""
    others = pixels[(pixels != background).any(axis=1)]
    others = others[:: max(1, len(others) // _SAMPLED_PIXELS)]
    if not len(others):
        others = background[None]
    pillow = imported("PIL.Image")
    sheet = pillow.fromarray(np.ascontiguousarray(others[None]))
    found = sheet.quantize(COLOURS - 1, method=pillow.Quantize.MEDIANCUT, kmeans=2)
    chosen = np.array(found.getpalette(), dtype=np.uint8).reshape(-1, 3)[: COLOURS - 1]
    unused = np.broadcast_to(background, (COLOURS - 1 - len(chosen), 3))
    return np.concatenate([background[None], chosen, unused])


def _nearest_table(palette: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(64, 64, 64) nearest colour of the palette to each cell of 4 × 4 × 4 levels."""
    from scipy.spatial import cKDTree

    middle = np.arange(64) * 4 + 1.5
    cells = np.stack(np.meshgrid(middle, middle, middle, indexing="ij"), axis=-1)
    return np.asarray(cKDTree(palette.astype(float)).query(cells)[1]).astype(np.uint8)


def _indexed(
    frame: Image,
    palette: NDArray[np.uint8],
    nearest: NDArray[np.uint8],
    pattern: NDArray[np.float64],
) -> NDArray[np.uint8]:
    """(H, W) the colour of each pixel."""
    noisy = np.clip(np.rint(frame + pattern[..., None]), 0, 255).astype(np.uint8) >> 2
    indices: NDArray[np.uint8] = nearest[noisy[..., 0], noisy[..., 1], noisy[..., 2]]
    indices[(frame == palette[0]).all(axis=2)] = 0
    return indices


def _changes(indexed: Iterable[NDArray[np.uint8]], palette: NDArray[np.uint8]) -> Iterator[Any]:
    """Pillow's pictures of the first frame, and of what differs in each from the one before."""
    before: NDArray[np.uint8] | None = None
    for indices in indexed:
        new = indices if before is None else np.where(indices == before, _UNCHANGED, indices)
        picture = imported("PIL.Image").fromarray(new.astype(np.uint8), mode="P")
        picture.putpalette(palette.tobytes())
        before = indices
        yield picture
