r"""Point caches, MDD and PC2: every vertex of every frame, for programs that play no rig.

    MDD  big-endian:     int32 frames, int32 points, float32 times[frames] in seconds,
                         float32 positions[frames][points][3]
    PC2  little-endian:  "POINTCACHE2\0", int32 version 1, int32 points, float32 start frame,
                         float32 sample rate in frames, int32 samples,
                         float32 positions[samples][points][3]

Frames are written one by one as they come, so a cache may be larger than the memory.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterable, Iterator, Sized
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import opened, replacing, require_room

_MAGIC = b"POINTCACHE2\0"
_MDD_HEADER = struct.Struct(">ii")
_PC2_HEADER = struct.Struct("<iiffi")
_LARGEST = 2**31 - 1
_BLOCK = 1 << 16

Frames = Iterable[ArrayLike]


@dataclass(frozen=True, eq=False, repr=False)
class PointCache:
    """The content of a point cache.

    Attributes:
        frames: (T, V, 3) float32 in the byte order of this machine.
        times: (T,) float64, seconds in MDD, frame numbers in PC2.
        rate: MDD: frames in a second, 0 where the times do not tell. PC2: frames from one sample
            to the next.
        start: Number of the first frame.
    """

    frames: NDArray[np.float32]
    times: NDArray[np.float64]
    rate: float
    start: float

    def __repr__(self) -> str:
        count, points = self.frames.shape[:2]
        return f"PointCache({count:,} frames, {points:,} points)"


def write_mdd(
    path: str | Path,
    frames: Frames,
    *,
    count: int | None = None,
    rate: float = 30.0,
    start: float = 0.0,
) -> None:
    """Write an MDD point cache, whole or not at all.

    Frames are (V, 3), at ``(start + i) / rate`` seconds, and come one by one or as (T, V, 3); each
    may be overwritten by the next, as those of ``chain.from_iterable(rig.stream(weights))``. Their
    number is needed where ``frames`` has no length.
    """
    total = _counted(frames, count, rate, start)

    def header(points: int) -> Iterator[bytes]:
        yield _MDD_HEADER.pack(total, points)
        for first in range(0, total, _BLOCK):
            numbers = np.arange(first, min(first + _BLOCK, total), dtype=np.float64)
            yield ((start + numbers) / rate).astype(">f4").tobytes()

    _write(path, frames, total, ">f4", header)


def write_pc2(
    path: str | Path,
    frames: Frames,
    *,
    count: int | None = None,
    rate: float = 1.0,
    start: float = 0.0,
) -> None:
    """As `write_mdd`, PC2: ``rate`` is frames from one sample to the next."""
    total = _counted(frames, count, rate, start)

    def header(points: int) -> Iterator[bytes]:
        yield _MAGIC + _PC2_HEADER.pack(1, points, start, rate, total)

    _write(path, frames, total, "<f4", header)


def read_mdd(path: str | Path) -> PointCache:
    """The point cache in an MDD file."""
    with opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        head = file.read(_MDD_HEADER.size)
        if len(head) < _MDD_HEADER.size:
            raise FormatError(path, f"this is not MDD: it has only {size:,} bytes")
        total, points = _MDD_HEADER.unpack(head)
        _require_size(path, size, total, points, len(head) + 4 * max(total, 0))
        times = _numbers(path, file, (total,), ">f4").astype(np.float64)
        if not np.isfinite(times).all():
            raise FormatError(path, "its times are not all finite numbers")
        frames = _positions(path, file, total, points, ">f4")
    span = float(times[-1] - times[0])
    rate = (total - 1) / span if span > 0 else 0.0
    return PointCache(frames, times, rate, float(times[0]) * rate)


def read_pc2(path: str | Path) -> PointCache:
    """The point cache in a PC2 file."""
    with opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        length = len(_MAGIC) + _PC2_HEADER.size
        head = file.read(length)
        if not head.startswith(_MAGIC) or len(head) < length:
            raise FormatError(path, "this is not PC2: it does not begin with POINTCACHE2")
        version, points, start, rate, total = _PC2_HEADER.unpack(head[len(_MAGIC) :])
        if version != 1:
            raise FormatError(path, f"this is version {version} of PC2, expected 1")
        if not np.isfinite([start, rate]).all():
            raise FormatError(path, f"its start frame is {start} and its sample rate {rate}")
        _require_size(path, size, total, points, length)
        frames = _positions(path, file, total, points, "<f4")
    return PointCache(frames, start + rate * np.arange(total), rate, start)


def _counted(frames: Frames, count: int | None, rate: float, start: float) -> int:
    """How many frames there are, where these and the numbers of the header can be stored."""
    for what, number in (("rate", rate), ("start", start)):
        wanted = "a number above 0" if what == "rate" else "a number"
        try:
            as_stored = abs(float(number))
        except (TypeError, ValueError):
            as_stored = np.inf
        too_large = not as_stored < float(np.finfo(np.float32).max)
        if too_large or (what == "rate" and not number > 0):
            raise ParameterError(f"the {what} of a point cache must be {wanted}, found {number!r}")
    if count is None:
        if not isinstance(frames, Sized):
            raise ParameterError("say how many frames will come: count=…")
        count = len(frames)
    if not 1 <= count <= _LARGEST:
        raise ParameterError(f"a point cache has 1 to {_LARGEST:,} frames, not {count!r}")
    return count


def _write(
    path: str | Path,
    frames: Frames,
    total: int,
    kind: str,
    header: Callable[[int], Iterable[bytes]],
) -> None:
    with replacing(path) as file:
        shape = (0, 3)
        written = 0
        for frame in frames:
            positions = np.asarray(frame)
            if not written:
                shape = (len(positions) if positions.ndim else 0, 3)
            if positions.shape != shape or not 1 <= shape[0] <= _LARGEST:
                raise ParameterError(
                    f"frame {written:,} has the shape {positions.shape}, expected "
                    f"{shape if written else '(V, 3) with V ≥ 1'}"
                )
            if written == total:
                raise ParameterError(f"more frames came than the {total:,} announced")
            with np.errstate(over="ignore"):
                stored = positions.astype(kind)
            if not np.isfinite(stored).all():
                raise ParameterError(
                    f"frame {written:,} has coordinates that are not finite or too large for "
                    "float32"
                )
            if not written:
                size, what = 12 * total * shape[0], f"{total:,} frames of {shape[0]:,} points"
                require_room(path, size, what)
                file.writelines(header(shape[0]))
            file.write(stored.tobytes())
            written += 1
        if written != total:
            raise ParameterError(f"only {written:,} of the {total:,} frames announced came")


def _require_size(path: str | Path, size: int, total: int, points: int, before: int) -> None:
    if total < 1 or points < 1:
        raise FormatError(
            path, f"its header announces {total:,} frames of {points:,} points; it is damaged"
        )
    expected = before + 12 * total * points
    if size != expected:
        raise FormatError(
            path,
            f"its header announces {total:,} frames of {points:,} points, {expected:,} bytes, but "
            f"it has {size:,}; the file was cut off or its header is wrong",
        )


def _numbers(
    path: str | Path, file: BinaryIO, shape: tuple[int, ...], kind: str
) -> NDArray[np.float32]:
    """Numbers as they stand in the file, in the byte order of this machine."""
    raw = np.empty(4 * int(np.prod(shape, dtype=np.int64)), dtype=np.uint8)
    view = raw.data
    while view:
        got = file.readinto(view)  # type: ignore[attr-defined]  # BinaryIO does not list it
        if not got:
            raise FormatError(path, "it became shorter while it was read")
        view = view[got:]
    stored = raw.view(kind).reshape(shape)
    if not stored.dtype.isnative:
        stored.byteswap(inplace=True)
    return stored.view(np.float32)


def _positions(
    path: str | Path, file: BinaryIO, total: int, points: int, kind: str
) -> NDArray[np.float32]:
    frames = _numbers(path, file, (total, points, 3), kind)
    step = max(1, _BLOCK // points)
    for first in range(0, total, step):
        finite = np.isfinite(frames[first : first + step]).all(axis=(1, 2))
        if not finite.all():
            bad = first + int(np.argmin(finite))
            raise FormatError(path, f"frame {bad:,} has coordinates that are not finite")
    return frames
