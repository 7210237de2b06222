"""Performances by the suffix of a file: text in columns, arrays, a clip of a glTF file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import require_name
from elastomorph.io.gltf.clips import SCENES, chosen_clip, named_clip, read_weight_clips
from elastomorph.io.npz.members import open_npz, write_arrays
from elastomorph.io.performance.columns import (
    frame_rate,
    plain_performance,
    write_performance_csv,
)
from elastomorph.io.performance.livelink import is_livelink, livelink_performance
from elastomorph.io.performance.table import read_table, say_how_read
from elastomorph.io.rig_folder import rig_as_stored
from elastomorph.io.untrusted import naming_file
from elastomorph.rig.performance import HEAD_ANGLES, Performance, is_rotation

__all__ = ["read_performance", "write_performance"]

_MEMBERS = ("names", "times", "weights")


def read_performance(
    path: str | Path, timecode_rate: float | None = None, *, clip: str | None = None
) -> Performance:
    """The performance in a file: weights of a face over time.

    Args:
        path: A take of Live Link Face or plain columns with a time (.csv); arrays ``names`` (N,),
            ``times`` (T,) in seconds, ``weights`` (T, N) and, if it is known, ``rate`` (.npz); or
            an animation of weights (.glb, .gltf, .vrm), with how it turns the head.
        timecode_rate: Frames a second that timecodes count, such as 29.97, where it is known better
            than the file shows.
        clip: Which animation, in a file with several, as also ``take.glb#NAME`` says. By default
            the one named like the file, else the first that is not named like a slider, as those
            are that play one slider from 0 to 1.

    Returns:
        Weights under the names that the file has. ``HeadYaw``, ``HeadPitch`` and ``HeadRoll`` are
        among them where it says how the head turns, in radians, see `Performance.head`; so are the
        angles of the eyes, whose directions the shapes ``eyeLook…`` tell too.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It holds no performance, or nothing tells in which units its numbers are; the
            message names the line.
        ParameterError: No timecode counts at ``timecode_rate``, or there are none, or no animation
            is called ``clip``.
    """
    require_name(path)
    path, clip = named_clip(path, clip)
    suffix = Path(path).suffix.lower()
    if clip is not None and suffix not in SCENES:
        raise ParameterError(f"{path} holds one performance: leave the name of a clip out")
    table = read_table(path) if suffix not in (".npz", *SCENES) else None
    if table is not None and is_livelink(table):
        performance = livelink_performance(table, timecode_rate)
        say_how_read(table, ())
        return performance
    if timecode_rate is not None:
        raise ParameterError(
            f"{path} has times in seconds and no timecodes: leave the timecode rate out"
        )
    if table is not None:
        return plain_performance(table)
    return _in_arrays(path) if suffix == ".npz" else _in_clip(path, clip)


def write_performance(path: str | Path, performance: Performance) -> None:
    """Write a performance, which comes back from `read_performance` bit for bit.

    Timecodes and what was dropped are not kept, nor is the rate in a table; whole or not at all.

    Args:
        path: A .csv file, a table of times and weights; or .npz, the arrays ``names``, ``times``,
            ``weights`` and ``rate``. For animated rigs see ``elastomorph animate``.
        performance: The weights over time.

    Raises:
        FileError: The file cannot be written.
        FormatError: The suffix is neither.
        ParameterError: A name cannot stand in a table, or this is no performance.
    """
    require_name(path)
    if not isinstance(performance, Performance):
        raise ParameterError(f"expected a Performance, found {type(performance).__name__}")
    suffix = Path(path).suffix.lower()
    if suffix == ".csv":
        write_performance_csv(path, performance)
    elif suffix == ".npz":
        arrays = {name: np.asarray(getattr(performance, name)) for name in (*_MEMBERS, "rate")}
        write_arrays(path, arrays)
    else:
        raise FormatError(
            path, f"a performance goes into .csv or .npz, found {suffix or 'no suffix'}"
        )


def _in_arrays(path: str | Path) -> Performance:
    with open_npz(path) as members:
        missing = [name for name in _MEMBERS if name not in members.names]
        if missing:
            raise FormatError(
                path,
                f"there is no array '{missing[0]}': a performance has names (N,), times (T,) and "
                f"weights (T, N), found {members.listed()}",
            )
        names = members.texts("names")
        times = members.array("times", "fiu", (None,)).astype(np.float64)
        weights = members.array("weights", "fiu", (len(times), len(names))).astype(np.float64)
        rate = float(members.array("rate", "fiu", ())) if "rate" in members.names else None
    with naming_file(path):
        if rate is None:
            rises = bool(len(times)) and bool((np.diff(times) > 0).all())
            rate = frame_rate(times) if rises else 30.0  # where they do not, that is refused
        return Performance(names, times, weights, rate, source=str(path))


def _in_clip(path: str | Path, name: str | None) -> Performance:
    rig = rig_as_stored(path)
    clips = read_weight_clips(path, rig.sliders)
    if not clips:
        raise FormatError(
            path, "no animation in it moves a slider of its rig; name a file with a take"
        )
    clip = chosen_clip(path, clips, name, rig.sliders)
    moved = np.flatnonzero(clip.weights.any(axis=0))
    names = [rig.names[column] for column in moved]
    weights = clip.weights[:, moved]
    if clip.turn is not None and not any(map(is_rotation, names)):
        names += HEAD_ANGLES
        weights = np.hstack([weights, clip.turn.angles])
    with naming_file(path):
        return Performance(names, clip.times, weights, frame_rate(clip.times), source=str(path))
