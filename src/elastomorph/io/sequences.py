r"""Recorded motion, whatever it is in: numbered meshes, archives, markers, caches, animated rigs.

What a program plays is sampled: at the keys of the animation, and thirty times a second between
keys that are farther apart. Markers, which are named points in motion, are those of a .c3d or an
.npz, or the vertices of any other recording; an archive of them has (T, N, 3) positions, and
perhaps (N,) ``names``, ``times`` and ``vertices``.

Point caches, MDD and PC2: every vertex of every frame, for programs that play no rig.

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
from collections.abc import Callable, Iterable, Iterator, Sequence, Sized
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FileError, FormatError, ParameterError, warn
from elastomorph.io.atomic import (
    is_file,
    opened,
    replacing,
    replacing_path,
    require_name,
    require_room,
    require_writable,
    size_of,
)
from elastomorph.io.c3d import read_c3d
from elastomorph.io.gltf.clips import SCENES, chosen_clip, named_clip, read_weight_clips
from elastomorph.io.npz.members import NpzMembers, open_npz
from elastomorph.io.npz.mesh import read_npz_sequence, write_npz_sequence, write_npz_take
from elastomorph.io.numbering import find_frames, frame_pattern
from elastomorph.io.registry import MESH_FORMATS, known_suffixes, read, write, writer_of
from elastomorph.io.untrusted import MemoryBudget, naming_file
from elastomorph.model.markers import Markers
from elastomorph.model.mesh import LARGEST, Mesh, require_same_topology
from elastomorph.model.sequence import MeshSequence
from elastomorph.numbers import first_few

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


_CACHE_WRITERS = {".mdd": write_mdd, ".pc2": write_pc2}

_FINEST_GRID = 10_000
_LEAST_BYTES = 12
"""Of a vertex in any mesh file: three float32 of binary PLY."""


def read_numbered(pattern: str | Path) -> MeshSequence:
    """The frames in numbered mesh files or a folder of them, in the order of their numbers."""
    found = find_frames(pattern, known_suffixes(MESH_FORMATS))
    first = read(found.files[0])
    budget = MemoryBudget(pattern, sum(map(size_of, found.files)))
    budget.spend_fields(len(first.vertices), len(found.files))
    frames = np.empty((len(found.files), *first.vertices.shape))
    frames[0] = first.vertices
    for i, file in enumerate(found.files[1:], start=1):
        mesh = read(file)
        require_same_topology(first, mesh)
        frames[i] = mesh.vertices
    frames.flags.writeable = False  # a motion takes such frames as they are
    numbers = [float(number - found.numbers[0]) for number in found.numbers]
    with naming_file(pattern):
        return MeshSequence(
            first, frames, numbers, [file.name for file in found.files], found.missing
        )


def write_sequence(pattern: str | Path, sequence: MeshSequence) -> None:
    """Write a recorded motion, all frames or none.

    All frames are written under temporary names and only then renamed. Frames are numbered from 1
    by their times, so that a motion with a gap is read back with that gap.

    Args:
        pattern: ``scan.####.obj``, with as many # as numbers should have digits, or one ``.npz``
            archive, which keeps times and names as they are. The folder must exist.
        sequence: The motion.

    Raises:
        FileError: A file cannot be written, or files of another motion match the pattern and
            would mix with this one.
        FormatError: The suffix is unknown.
        ParameterError: The times lie on no even grid of frames; only an archive can hold them.
    """
    if not isinstance(sequence, MeshSequence):
        raise ParameterError(f"expected a MeshSequence, found {type(sequence).__name__}")
    require_name(pattern)
    path = Path(pattern)
    if path.suffix.lower() == ".npz" and "#" not in path.name:
        write_npz_sequence(pattern, sequence)
        return
    frames = frame_pattern(pattern)
    numbers = _frame_numbers(sequence.times)
    require_frames(pattern, sequence.mesh, len(numbers))
    frames.require_only(numbers)
    _write_numbered(map(frames.file, numbers), sequence.mesh, sequence.frames)


def write_frames(
    path: str | Path,
    mesh: Mesh,
    frames: Iterable[NDArray[np.float64]],
    *,
    names: Sequence[str],
) -> None:
    """Write (V, 3) frames at even steps, one a name, all or none, in the memory of one frame.

    Numbered mesh files such as ``half.####.obj``, ``.npz`` as float64 with the names, or a point
    cache, ``.mdd`` or ``.pc2``.
    """
    count, suffix = len(names), Path(path).suffix.lower()
    if "#" not in Path(path).name and suffix in _CACHE_WRITERS:
        _CACHE_WRITERS[suffix](path, frames, count=count)
    elif "#" not in Path(path).name and suffix == ".npz":
        write_npz_take(path, mesh, frames, np.linspace(0, 1, count), names=names, kind="<f8")
    else:
        pattern = frame_pattern(path)
        numbers = range(1, count + 1)
        pattern.require_only(numbers)
        _write_numbered(map(pattern.file, numbers), mesh, frames)


def require_frames(path: str | Path, mesh: Mesh, count: int) -> None:
    """Refuse what `write_frames` could not write, before the first frame is computed."""
    if "#" in Path(path).name or Path(path).suffix.lower() not in (*_CACHE_WRITERS, ".npz"):
        writer_of(frame_pattern(path).file(1), MESH_FORMATS)
    vertices = len(mesh.vertices)
    require_writable(path)
    require_room(
        path, _LEAST_BYTES * vertices * count, f"{count:,} frames of {vertices:,} vertices"
    )


def _write_numbered(
    files: Iterable[Path], mesh: Mesh, frames: Iterable[NDArray[np.float64]]
) -> None:
    with ExitStack() as renames:
        for file, positions in zip(files, frames, strict=True):
            temporary = renames.enter_context(replacing_path(file))
            write(temporary, mesh.with_vertices(positions))


def write_face_files(
    pattern: str | Path,
    mesh: Mesh,
    blocks: Iterable[NDArray[np.floating]],
    *,
    first: int = 1,
    count: int = 0,
) -> int:
    """Write (s, V, 3) blocks of faces, each face into a file of its own, whole or not at all.

    The pattern is as ``face.####.obj``, its folder must exist; returns the number of files. Where
    it is known how many will come, a disk that does not hold them is refused.
    """
    frames = frame_pattern(pattern)
    write = writer_of(pattern, MESH_FORMATS)
    require_frames(pattern, mesh, count)
    number = first
    for block in blocks:
        for positions in block:
            write(frames.file(number), mesh.with_vertices(positions))
            number += 1
    return number - first


def _frame_numbers(times: NDArray[np.float64]) -> list[int]:
    """Whole numbers from 1 with the distances of the times, as small as possible."""
    gaps = np.diff(times)
    for steps in range(len(times) - 1, max(_FINEST_GRID + 1, len(times))):
        if gaps.min() * steps < 0.5:
            continue
        numbers = np.rint(times * steps)
        if np.abs(times * steps - numbers).max() < 1e-6:
            return [int(number) + 1 for number in numbers]
    raise ParameterError(
        f"the {len(times)} times lie on no even grid of up to {_FINEST_GRID:,} frames, as numbered "
        "files need; write an .npz archive, which keeps them"
    )


_SLOW = 1.0  # Seconds a frame
_POSITIONS = ("positions", "markers", "stab")


def holds_markers(path: str | Path) -> bool:
    """Whether a file is one of markers rather than of a mesh in motion."""
    suffix = Path(path).suffix.lower()
    if suffix != ".npz" or not is_file(path):
        return suffix == ".c3d"
    with open_npz(path) as members:
        return any(p in members.names for p in _POSITIONS)


def read_marker_file(path: str | Path) -> Markers:
    """The markers of a file that holds some, where the head was and with gaps."""
    taken = read_c3d(path) if Path(path).suffix.lower() == ".c3d" else _read_archive(path)
    if not taken.frames.size:
        raise FormatError(
            path,
            f"it has no positions of markers: {len(taken):,} frames of {len(taken.names)} markers",
        )
    for name, place in zip(taken.names, np.moveaxis(taken.frames, 1, 0), strict=True):
        if (np.abs(place) > LARGEST).any():
            raise FormatError(
                path,
                f"the marker {name:.40} has positions beyond {LARGEST:g}; the file is damaged, or "
                "has other numbers than NaN where a marker is missing",
            )
    return taken


def _read_archive(path: str | Path) -> Markers:
    with open_npz(path) as members:
        called = next((p for p in _POSITIONS if p in members.names), None)
        if called is None:
            raise FormatError(
                path, f"expected (T, N, 3) positions of markers called {' or '.join(_POSITIONS)}"
            )
        frames = members.array(called, "fiu", (None, None, 3)).astype(np.float64)
        count = frames.shape[1]
        named = "names" in members.names
        names = members.texts("names", count) if named else [str(i) for i in range(count)]
        times = _times(members, len(frames))
        vertices = None
        if "vertices" in members.names:
            vertices = tuple(members.whole("vertices", (count,)).tolist())
    return Markers(tuple(names), frames, times, vertices)


def _times(members: NpzMembers, count: int) -> NDArray[np.float64] | None:
    """Seconds of the frames, where they are said."""
    if "times" not in members.names:
        return None
    times = members.array("times", "fiu", (count,)).astype(np.float64)
    if not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise FormatError(members.path, "its times must be finite numbers that rise")
    step = float(np.median(np.diff(times))) if count > 1 else 0.0
    if step >= _SLOW:
        warn(
            f"{members.path}: its times are taken as seconds, so that a frame lasts {step:.4g} s; "
            "milliseconds and numbers of frames must be made seconds"
        )
    return times


def read_markers(path: str | Path, *, clip: str | None = None) -> Markers:
    """Named points in motion, as they were recorded.

    Args:
        path: ``.c3d``; ``.npz`` with ``markers`` (T, M, 3), NaN where one is missing, and perhaps
            ``names`` (M,), ``times`` (T,) in seconds and ``vertices`` (M,) of the rig; or any
            motion that `read_sequence` reads, such as ``take.####.obj`` or an ``.npz`` with
            ``frames`` (T, V, 3), whose vertices are the points. Points without names are called by
            their numbers, ``0``, ``1`` and so on. Frames that the numbers of files leave out have
            no points.
        clip: As for `read_sequence`.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is not what its format allows, or of another format.
        MissingExtraError: It is .c3d and ezc3d is not installed.
        TopologyError: One mesh has other vertices or polygons than the first.
    """
    require_name(path)
    if clip is None and holds_markers(path):
        return read_marker_file(path)
    recording = read_recording(path, clip=clip)
    motion, seconds = recording.motion, recording.seconds
    frames = motion.frames
    if motion.missing and seconds is None:
        count = len(motion) + len(motion.missing)
        frames = np.full((count, *frames.shape[1:]), np.nan)
        frames[np.rint(motion.times * (count - 1)).astype(int)] = motion.frames
    times = None if seconds is None else motion.times * seconds
    return Markers(tuple(map(str, range(frames.shape[1]))), frames, times)


Floats = NDArray[np.float64]

_CACHES = {".mdd": read_mdd, ".pc2": read_pc2}
_NOT_PLAYED = (".fbx", ".abc", ".usd", ".usda", ".usdc", ".usdz")
_RATE = 30.0  # Frames a second between keys
_CLOSE = 1e-3  # Keys a thousandth of a frame too far apart count as one frame apart
_FEW = 6


@dataclass(frozen=True, eq=False)
class Recording:
    """A motion as it was recorded.

    Attributes:
        motion: Its frames. A marker that is missing is put on the straight line between the frames
            that see it, and held before the first and after the last of them.
        names: Of markers, (V,); otherwise none.
        seen: (T, V) whether a marker was seen in a frame; None where all were, or there are none.
        seconds: How long it takes, where the file says it.
    """

    motion: MeshSequence
    names: tuple[str, ...] = ()
    seen: NDArray[np.bool_] | None = None
    seconds: float | None = None


def read_sequence(pattern: str | Path, *, clip: str | None = None) -> MeshSequence:
    """A recorded motion.

    Of numbered files, times follow the frame numbers: without frame 3, frame 4 still comes at its
    own time. Frames that the numbering leaves out are named in ``missing``.

    Args:
        pattern: ``scan.####.obj`` (a run of # stands for a number of any width), a wildcard such
            as ``scan.*.obj``, or a folder with mesh files of one suffix. Or one file: a ``.npz``
            archive of frames or of markers, markers as ``.c3d``, a point cache (``.mdd``,
            ``.pc2``) with the mesh it moves beside it under the same name, or a ``.glb``,
            ``.gltf`` or ``.vrm`` whose animation moves morph targets.
        clip: Name of the animation, in a file with several; as for `read_performance`.

    Raises:
        FileError: There are no such files, or fewer than two, or their numbers are not clear.
        FormatError: A file is not what its format allows, nothing moves in it, or markers are
            missing in some frames.
        TopologyError: A frame has other vertices or polygons than the first one.
    """
    return whole(pattern, read_recording(pattern, clip=clip))


def whole(path: str | Path, recording: Recording) -> MeshSequence:
    """The motion of a recording without gaps; of others a FormatError."""
    if recording.seen is None:
        return recording.motion
    frame, marker = np.argwhere(~recording.seen)[0]
    raise FormatError(
        path,
        f"the marker {recording.names[marker]} is missing in frame {frame}, and "
        f"{(~recording.seen).mean():.1%} of all are: evaluate, inbetweens and learn leave them out "
        "where they read the file themselves; here, fill the gaps first",
    )


def read_recording(path: str | Path, *, clip: str | None = None) -> Recording:
    """As `read_sequence`, with the names of markers and which of them were seen."""
    require_name(path)
    path, clip = named_clip(path, clip)
    suffix = Path(path).suffix.lower()
    if clip is not None and not (suffix in SCENES and is_file(path)):
        raise ParameterError(f"{path}: only {', '.join(SCENES)} have animations to choose one of")
    if not is_file(path):
        return Recording(read_numbered(path))
    if holds_markers(path):
        return _of_markers(path)
    if suffix == ".npz":
        return _of_archive(path)
    if suffix in _CACHES:
        return _of_cache(path)
    if suffix in SCENES:
        return _of_clip(path, clip)
    if suffix in _NOT_PLAYED:
        raise FormatError(
            path,
            f"animations in {suffix} are not read; write the motion as .glb, as a point cache "
            "(.mdd, .pc2) with its mesh beside it, or as numbered meshes",
        )
    if suffix not in known_suffixes(MESH_FORMATS):
        raise FormatError(
            path,
            "recorded motion is numbered meshes such as take.####.obj, .npz, .c3d, "
            f"{', '.join([*_CACHES, *SCENES])}",
        )
    return Recording(read_numbered(path))


def _of_markers(path: str | Path) -> Recording:
    """Markers, gaps closed. What the head does is part of the motion, unless it was removed."""
    taken = read_marker_file(path)
    if len(taken.frames) < 2:
        raise FormatError(path, f"a take needs at least 2 frames, found {len(taken.frames)}")
    seen: NDArray[np.bool_] = np.asarray(np.isfinite(taken.frames).all(axis=2))
    ever: NDArray[np.bool_] = np.asarray(seen.any(axis=0))
    if not ever.any():
        raise FormatError(path, "no marker is seen in any frame: there are no finite numbers")
    if not ever.all():
        never = [taken.names[i] for i in np.flatnonzero(~ever)]
        warn(f"{path}: never seen, and left out: {first_few(never, _FEW)}")
    names = tuple(taken.names[i] for i in np.flatnonzero(ever))
    seen = seen[:, ever]
    frames = _closed(taken, seen, ever)
    with naming_file(path):
        motion = MeshSequence(Mesh(frames[0]), frames, taken.times)
    return Recording(motion, names, None if seen.all() else seen)


def _closed(taken: Markers, seen: NDArray[np.bool_], ever: NDArray[np.bool_]) -> Floats:
    """(T, N, 3) positions without gaps."""
    frames = taken.frames[:, ever]
    times = np.arange(len(frames), dtype=np.float64) if taken.times is None else taken.times
    for marker in np.flatnonzero(~seen.all(axis=0)):
        there = seen[:, marker]
        for axis in range(3):
            known = frames[there, marker, axis]
            frames[~there, marker, axis] = np.interp(times[~there], times[there], known)
    frames.flags.writeable = False  # a motion takes such frames as they are
    return frames


def _of_archive(path: str | Path) -> Recording:
    """The frames of an archive; times from 0 to 1, as motions are kept with, are no seconds."""
    motion, seconds = read_npz_sequence(path), None
    with open_npz(path) as members:
        if "times" in members.names:
            times = members.array("times", "fiu", (len(motion),))
            ends = float(times[0]), float(times[-1])
            seconds = None if ends == (0.0, 1.0) else ends[1] - ends[0]
    return Recording(motion, seconds=seconds)


def _of_cache(path: str | Path) -> Recording:
    """A point cache on the mesh of its name beside it."""
    file = Path(path)
    suffixes = known_suffixes(MESH_FORMATS)
    beside = [file.with_suffix(s) for s in suffixes if is_file(file.with_suffix(s))]
    if len(beside) != 1:
        found = " and ".join(own.name for own in beside) or "none"
        raise FileError(
            path,
            f"a point cache has no polygons: put the mesh that it moves beside it, one of "
            f"{', '.join(file.stem + s for s in suffixes)} (found {found})",
        )
    mesh, cache = read(beside[0]), _CACHES[file.suffix.lower()](path)
    count, points = cache.frames.shape[:2]
    if points != len(mesh.vertices):
        raise FormatError(
            path,
            f"it moves {points:,} points, but {beside[0].name} has {len(mesh.vertices):,} vertices",
        )
    if count < 2:
        raise FormatError(path, f"a motion needs at least 2 frames, found {count}")
    frames = cache.frames.astype(np.float64)
    frames.flags.writeable = False
    # Frames of a .pc2 have numbers instead of times.
    seconds = float(np.ptp(cache.times)) if file.suffix.lower() == ".mdd" else None
    with naming_file(path):
        return Recording(MeshSequence(mesh, frames, cache.times), seconds=seconds)


def _of_clip(path: str | Path, name: str | None) -> Recording:
    """An animation of morph targets, as our own rig plays it."""
    from elastomorph.io.gltf import read_glb

    rig = read_glb(path)
    found = [clip for clip in read_weight_clips(path, rig.sliders) if clip.weights.any()]
    if not found:
        raise FormatError(
            path,
            "no animation in it moves morph targets, so nothing of the face moves; joints are not "
            "played: write that motion as a point cache or numbered meshes",
        )
    clip = chosen_clip(path, found, name, rig.sliders)
    if len(clip.times) < 2:
        raise FormatError(path, f"the animation {clip.name!r} has only one key, so nothing moves")
    steps = np.maximum(np.ceil(np.diff(clip.times) * _RATE - _CLOSE), 1)
    MemoryBudget(path, size_of(path)).spend_fields(len(rig.neutral.vertices), int(steps.sum()) + 1)
    keys = np.concatenate([[0.0], np.cumsum(steps)])
    times = np.interp(np.arange(keys[-1] + 1), keys, clip.times)
    weights = np.stack([np.interp(times, clip.times, own) for own in clip.weights.T], axis=1)
    frames = np.empty((len(times), *rig.neutral.vertices.shape))
    start = 0
    for faces in rig.stream(weights, dtype=np.float64):
        frames[start : start + len(faces)] = faces
        start += len(faces)
    frames.flags.writeable = False
    with naming_file(path):
        return Recording(MeshSequence(rig.neutral, frames, times), seconds=float(np.ptp(times)))
