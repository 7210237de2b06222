"""A performance on a rig as a file: an animated rig, a point cache, or a mesh file a frame.

Animated rigs (.glb, .usd) keep the weights as they were recorded. Point caches (.mdd, .pc2, .npz)
and numbered mesh files keep positions, and are written in fixed memory however long the take is.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import is_folder
from elastomorph.io.npz.mesh import write_npz_take
from elastomorph.io.numbering import frame_pattern
from elastomorph.io.registry import write
from elastomorph.io.sequences import write_face_files, write_mdd, write_pc2
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn, Match, Performance, play, slider_weights

Frames = Iterator[NDArray[np.floating]]

_RIGS = (".glb", ".usd", ".usda", ".usdc")
_CACHES = (".mdd", ".pc2", ".npz")
_MESHES = (".obj", ".ply")
_LEAST_DIGITS = 4


def holds_positions(path: str | Path) -> bool:
    """Whether a take written there is positions, one row a frame, and not an animated rig."""
    name = Path(path).name
    suffix = Path(path).suffix.lower()
    if _is_folder(path) or ("#" in name and suffix in _MESHES) or suffix in _CACHES:
        return True
    if suffix in _RIGS and "#" not in name:
        return False
    raise FormatError(
        path,
        f"a take goes into {', '.join(_RIGS + _CACHES)}, a folder/, or numbered files such as "
        "frame.####.obj",
    )


def write_take(
    path: str | Path,
    rig: Rig,
    performance: Performance,
    by: Match | None = None,
    *,
    clip: bool = False,
    watch: Callable[[Frames], Iterable[NDArray[np.floating]]] = lambda frames: frames,
    export: Mapping[str, Any] | None = None,
    turn: HeadTurn | None = None,
) -> None:
    """Write a performance on a rig. The first frame comes at 0 s and has the number 1.

    A single file is written whole or not at all. Of numbered files each is, so that an interrupted
    take leaves the frames it had. The head is turned as in each frame of the performance, or still.
    """
    suffix = Path(path).suffix.lower()
    seconds = performance.times - performance.times[0]
    if not holds_positions(path):
        weights = slider_weights(rig, performance, by, clip=clip)
        animation = (seconds, weights, Path(performance.source).stem or "take")
        options = {**(export or {}), "animation": animation}
        if suffix != ".glb":
            options["fps"] = performance.rate
        if turn is not None:
            options["turn"] = turn
        write(path, rig, **options)
        return
    in_files = _is_folder(path) or "#" in Path(path).name
    kind = np.float64 if in_files else np.float32
    played = play(rig, performance, by, clip=clip, dtype=kind)
    frames = watch(played if turn is None else _turned(played, turn))
    count = len(performance)
    if in_files:
        pattern = Path(path)
        if _is_folder(path):
            try:
                pattern.mkdir(exist_ok=True)
            except OSError as error:
                problem = f"the folder cannot be made: {error.strerror or error}"
                raise FileError(path, problem) from error
            pattern /= f"frame.{'#' * max(_LEAST_DIGITS, len(str(count)))}.obj"
        frame_pattern(pattern).require_only(range(1, count + 1))
        write_face_files(pattern, rig.neutral, (frame[None] for frame in frames), count=count)
    elif suffix == ".npz":
        write_npz_take(path, rig.neutral, frames, seconds)
    elif suffix == ".mdd":
        write_mdd(path, frames, count=count, rate=performance.rate)
    else:
        write_pc2(path, frames, count=count)  # it counts frames, not seconds


def _turned(frames: Frames, turn: HeadTurn) -> Frames:
    for number, positions in enumerate(frames):
        yield turn.of(positions.astype(np.float64), number).astype(positions.dtype)


def _is_folder(path: str | Path) -> bool:
    return str(path).endswith(("/", os.sep)) or is_folder(path)
