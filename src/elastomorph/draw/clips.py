"""Clips as files: a movie, a moving picture, or numbered pictures, frame by frame.

A movie and numbered pictures are written while frames are drawn, in memory that does not grow
with their number. Moving pictures (GIF, WebP) are kept until the last frame is there, so they
have a limit.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from elastomorph.draw.pictures import SUFFIXES, Image, as_pillow, write_picture
from elastomorph.errors import FileError, ParameterError
from elastomorph.io.atomic import replacing
from elastomorph.io.numbering import frame_pattern

if TYPE_CHECKING:
    from elastomorph.draw.sound import Sound

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
        from elastomorph.draw.movie import find_encoder

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
        from elastomorph.draw.movie import write_movie

        write_movie(path, alike, (first.shape[1], first.shape[0]), fps, sound)
    elif suffix == ".gif":
        from elastomorph.draw.movie import write_gif

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
