"""Recorded motion, whatever it was recorded as: frames, markers, a point cache, an animated rig.

What a program plays is sampled: at the keys of the animation, and thirty times a second between
keys that are farther apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError, ParameterError, warn
from elastomorph.io.atomic import is_file, require_name, size_of
from elastomorph.io.gltf.clips import SCENES, chosen_clip, named_clip, read_weight_clips
from elastomorph.io.markers import holds_markers, read_marker_file
from elastomorph.io.npz.members import open_npz
from elastomorph.io.npz.mesh import read_npz_sequence
from elastomorph.io.point_cache import read_mdd, read_pc2
from elastomorph.io.registry import MESH_FORMATS, known_suffixes, read
from elastomorph.io.sequences.meshes import read_numbered
from elastomorph.io.untrusted import MemoryBudget, naming_file
from elastomorph.model.markers import Markers
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from elastomorph.numbers import first_few

__all__ = ["Recording", "read_recording", "read_sequence", "whole"]

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
