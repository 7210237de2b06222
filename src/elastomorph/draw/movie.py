"""MP4 movies (H.264), encoded by ffmpeg while frames are drawn."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import IO

import numpy as np

from elastomorph.draw.pictures import Image, imported
from elastomorph.errors import ElastomorphError, FileError, ParameterError
from elastomorph.io.atomic import replacing_path

_FINEST_RATE = 1001
"""Denominator of the broadcast rates: 23.976 is 24000/1001."""


def find_encoder() -> str:
    """The ffmpeg program that imageio-ffmpeg brings along, or finds on this machine."""
    try:
        return str(imported("imageio_ffmpeg").get_ffmpeg_exe())
    except RuntimeError:
        raise ElastomorphError(
            "MP4 needs the program ffmpeg, and imageio-ffmpeg brings none for this machine: "
            "install ffmpeg, or write .webp, .gif or numbered pictures"
        ) from None


def write_movie(
    path: str | Path, frames: Iterable[Image], size: tuple[int, int], fps: float
) -> None:
    """Write an MP4 that browsers and editors play: H.264, yuv420p, the index at the front.

    Frames are (H, W, 3) uint8, sRGB, and converted and marked as BT.709, whose primaries are the
    same, so players show the colours that were drawn. Width and height are even.
    """
    with replacing_path(path) as temporary, tempfile.TemporaryFile() as complaints:
        process = subprocess.Popen(
            _command(find_encoder(), temporary, size, fps),
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
            raise FileError(path, f"ffmpeg could not encode the movie: {_last_line(complaints)}")


def _command(program: str, path: Path, size: tuple[int, int], fps: float) -> list[str]:
    rate = str(Fraction(fps).limit_denominator(_FINEST_RATE))
    given = f"-f rawvideo -pixel_format rgb24 -video_size {size[0]}x{size[1]} -framerate {rate}"
    convert = (
        "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int,"
        "format=yuv420p,"
        "setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709:range=tv"
    )
    encode = "-c:v libx264 -preset medium -crf 15"
    whole = "-movflags +faststart -fflags +bitexact -f mp4"
    return [
        *(program, "-y", "-nostdin", "-hide_banner", "-loglevel", "error"),
        *(*given.split(), "-i", "pipe:0", "-an", "-vf", convert),
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
    return lines[-1].strip() if lines else "it gave no reason"
