"""What must be true of anything a reader returns, and of any error it raises."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.errors import ElastomorphError, ElastomorphWarning
from elastomorph.io.sequences import PointCache, Recording
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance

__all__ = ["WrongError", "is_small", "judged", "require", "same", "sound"]

_LONGEST_MESSAGE = 1500


class WrongError(Exception):
    """A reader returned or raised what it must not."""


def require(holds: Any, problem: str) -> None:
    """Check what must be true.

    Raises:
        WrongError: It is not.
    """
    if not holds:
        raise WrongError(problem)


def judged(read: Callable[[Path], Any], path: Path, folder: Path) -> tuple[Any, str]:
    """What a reader makes of a file: the thing, or the message of its one error.

    Raises:
        WrongError: A warning of another library, or a message that is endless, cannot be printed
            or names no file of the folder.
        Exception: Whatever else the reader raised.
    """
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        try:
            thing, message = read(path), ""
        except ElastomorphError as error:
            thing, message = None, str(error)
    for warning in warned:
        require(
            issubclass(warning.category, ElastomorphWarning),
            f"a warning of another library: {warning.category.__name__}: {warning.message}",
        )
    if message:
        require(str(folder) in message, f"the message names no file of the folder: {message}")
        require(len(message) < _LONGEST_MESSAGE + len(str(path)), f"too long: {message[:300]} …")
        require(_printable(message), f"the message cannot be printed: {message!a}")
        require("/elastomorph-" not in message, f"the message names a temporary file: {message}")
    return thing, message


def sound(thing: Any) -> None:
    """Check what must be true of a thing that was read.

    Raises:
        WrongError: It is not.
    """
    if isinstance(thing, Mesh):
        _sound_mesh(thing)
    elif isinstance(thing, Rig):
        _sound_rig(thing)
    elif isinstance(thing, MeshSequence):
        _sound_sequence(thing)
    elif isinstance(thing, Recording):
        _sound_sequence(thing.motion)
        require(len(thing.names) == len(thing.motion.mesh.vertices), "a name for each marker")
        _text(thing.names)
    elif isinstance(thing, Performance):
        _finite(thing.times, thing.weights, thing.dropped_times)
        require(thing.weights.shape == (len(thing.times), len(thing.names)), "weights of a table")
        require((np.diff(thing.times) > 0).all(), "times that rise")
        require(0 < thing.rate < np.inf, "a rate")
        _text(thing.names)
    elif isinstance(thing, PointCache):
        require(thing.frames.ndim == 3 and thing.frames.shape[2] == 3, "(T, V, 3) frames")
        require(thing.times.shape == thing.frames.shape[:1], "a time for each frame")
        _finite(thing.frames, thing.times, thing.rate, thing.start)
    else:
        raise WrongError(f"nothing is known about {type(thing).__name__}")


def is_small(thing: Any) -> bool:
    """Whether it can be written again in no time."""
    if isinstance(thing, Rig):
        return len(thing.neutral.vertices) * (1 + len(thing.morphs)) < 5000
    if isinstance(thing, Mesh):
        return len(thing.vertices) < 5000
    return True


def same(one: Any, other: Any, *, tolerance: float = 0.0) -> bool:
    """Whether two things have the same numbers, names and polygons."""
    if isinstance(one, Mesh):
        return one.faces == other.faces and _near(one.vertices, other.vertices, tolerance)
    if isinstance(one, Rig):
        return (
            list(one.morphs) == list(other.morphs)
            and same(one.neutral, other.neutral, tolerance=tolerance)
            and all(
                _near(mine.target.vertices, theirs.target.vertices, tolerance)
                and (tolerance > 0 or _near(mine.bends, theirs.bends, tolerance))
                for mine, theirs in zip(one.morphs.values(), other.morphs.values(), strict=True)
            )
        )
    if isinstance(one, MeshSequence):
        return (
            same(one.mesh, other.mesh)
            and one.names == other.names
            and _near(one.frames, other.frames, tolerance)
            and _near(one.times, other.times, 1e-12)
        )
    if isinstance(one, Performance):
        return (
            one.names == other.names
            and _near(one.times, other.times, 0.0)
            and _near(one.weights, other.weights, 0.0)
        )
    if isinstance(one, PointCache):
        return _near(one.frames, other.frames, 0.0)
    raise WrongError(f"nothing is known about {type(one).__name__}")


def _sound_mesh(mesh: Mesh) -> None:
    vertices, faces = mesh.vertices, mesh.faces
    require(vertices.ndim == 2 and vertices.shape[1] == 3 and len(vertices), "(V, 3) vertices")
    _finite(vertices)
    _within(faces.indices, 0, len(vertices))
    require(faces.offsets[0] == 0 and faces.offsets[-1] == faces.indices.size, "offsets")
    require((np.diff(faces.offsets) >= 3).all(), "polygons of three vertices or more")
    if mesh.uv is not None:
        _finite(mesh.uv.coordinates)
        require(mesh.uv.corners.shape == faces.indices.shape, "a texture coordinate a corner")
        _within(mesh.uv.corners, -1, len(mesh.uv.coordinates))
    for labels in (mesh.materials, mesh.groups):
        if labels is not None:
            require(labels.of_face.shape == (len(faces),), "a label for each polygon")
            _within(labels.of_face, -1, len(labels.names))
            _text(labels.names)
    if mesh.source is not None and mesh.source.face_lines is not None:
        require(mesh.source.face_lines.shape == (len(faces),), "a line for each polygon")
    _text([mesh.material_library or ""])


def _sound_rig(rig: Rig) -> None:
    _sound_mesh(rig.neutral)
    _text(rig.morphs)
    for morph in rig.morphs.values():
        require(morph.target.vertices.shape == rig.neutral.vertices.shape, "vertices of a target")
        _finite(morph.target.vertices, morph.bends, morph.bake_error)
        require(len(morph.bends) == len(morph.bend_curves), "a curve for each bend")
        require(morph.bake_error >= 0, "a bake error from 0")
        for curve in (*morph.bend_curves, morph.limit_law):
            _finite(curve.breaks, curve.coefficients)
        _text([morph.method])
    _text([*rig.sliders.groups, *rig.sliders.correctives])
    if len(rig.names) and len(rig.neutral.vertices) < 10_000:
        with np.errstate(all="ignore"):  # positions near the largest number may add up beyond it
            rig.pose({rig.names[0]: 0.5})


def _sound_sequence(motion: MeshSequence) -> None:
    _sound_mesh(motion.mesh)
    require(motion.frames.shape == (len(motion), *motion.mesh.vertices.shape), "(T, V, 3) frames")
    _finite(motion.frames, motion.times)
    require(len(motion) >= 2 and (np.diff(motion.times) > 0).all(), "times that rise")
    require(motion.times[0] == 0 and motion.times[-1] == 1, "times from 0 to 1")
    require(len(motion.names) == len(motion), "a name for each frame")
    _text([*motion.names, *motion.missing])


def _finite(*arrays: Any) -> None:
    for array in arrays:
        require(np.isfinite(array).all(), "numbers that are finite")


def _within(indices: Any, lowest: int, stop: int) -> None:
    if indices.size:
        require(indices.min() >= lowest and indices.max() < stop, "indices in range")


def _text(names: Any) -> None:
    for name in names:
        require(isinstance(name, str) and _printable(name), f"a name that can be written: {name!a}")


def _printable(text: str) -> bool:
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True


def _near(one: Any, other: Any, tolerance: float) -> bool:
    if one.shape != other.shape:
        return False
    if not tolerance:
        return bool(np.array_equal(one, other))
    largest = max(float(np.abs(one).max(initial=0.0)), 1e-30)
    return bool(np.abs(one - other).max(initial=0.0) <= tolerance * largest)
