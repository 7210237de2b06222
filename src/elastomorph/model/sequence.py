"""A recorded motion: one mesh, many frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import LARGEST, Mesh, require_mesh
from elastomorph.numbers import as_numbers


@dataclass(frozen=True, eq=False, repr=False)
class MeshSequence:
    """Frames of one mesh in motion: what interpolation is compared with.

    Attributes:
        mesh: The first frame, with the polygons all frames share.
        frames: (T, V, 3) float64, read-only.
        times: (T,) float64, rising from 0 (the first frame) to 1 (the last).
        names: One name a frame: its file, or its number.
        missing: Names of frames that the numbering of the files leaves out.

    Raises:
        MeshError: The frames are not finite (T, V, 3) coordinates with T ≥ 2.
        ParameterError: The times do not rise, or are not T finite numbers.
    """

    mesh: Mesh
    frames: NDArray[np.float64]
    times: NDArray[np.float64]
    names: tuple[str, ...]
    missing: tuple[str, ...] = field(default=())

    def __init__(
        self,
        mesh: Mesh,
        frames: ArrayLike,
        times: ArrayLike | None = None,
        names: Sequence[str] = (),
        missing: Sequence[str] = (),
    ) -> None:
        require_mesh(mesh, "the mesh of a motion")
        try:
            given = as_numbers(frames, "frames")
        except ParameterError as error:
            raise MeshError(str(error)) from None
        # Of long recordings there is no room for two: what nobody can write to is not copied.
        fixed = given.base is None and not given.flags.writeable
        own = given if fixed else np.array(given)
        if own.ndim != 3 or own.shape[1:] != mesh.vertices.shape or len(own) < 2:
            raise MeshError(
                f"frames must have shape (T, {len(mesh.vertices):,}, 3) with T ≥ 2, "
                f"found {own.shape}"
            )
        usable = np.array([(np.abs(frame) <= LARGEST).all() for frame in own])
        if not usable.all():
            raise MeshError(
                f"frame {int(np.argmin(usable))} has coordinates that are not finite numbers of "
                f"at most {LARGEST:g}"
            )
        when = np.linspace(0.0, 1.0, len(own)) if times is None else as_numbers(times, "times")
        if when.shape != (len(own),) or not np.isfinite(when).all() or (np.diff(when) <= 0).any():
            raise ParameterError(f"times must be {len(own)} finite numbers that rise")
        when = (when - when[0]) / (when[-1] - when[0])
        when[-1] = 1.0
        if names and len(names) != len(own):
            raise ParameterError(f"expected {len(own)} frame names, found {len(names)}")
        for array in (own, when):
            array.flags.writeable = False
        own_names = tuple(names) or tuple(str(i) for i in range(len(own)))
        vars(self).update(mesh=mesh.with_vertices(own[0]), frames=own, times=when)
        vars(self).update(names=own_names, missing=tuple(missing))

    @property
    def neutral(self) -> Mesh:
        """The first frame."""
        return self.mesh

    @property
    def target(self) -> Mesh:
        """The last frame."""
        return self.mesh.with_vertices(self.frames[-1])

    def part(self, start: int, stop: int) -> MeshSequence:
        """Frames ``start`` to ``stop`` inclusive, with times from 0 to 1; ``start`` may be larger.

        A part that runs backwards plays the motion in reverse.
        """
        step = 1 if stop >= start else -1
        pick = np.arange(start, stop + step, step)
        return MeshSequence(
            self.mesh,
            self.frames[pick],
            np.abs(self.times[pick] - self.times[start]),
            [self.names[i] for i in pick],
        )

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, index: int) -> Mesh:
        return self.mesh.with_vertices(self.frames[index])

    def __iter__(self) -> Iterator[Mesh]:
        return (self.mesh.with_vertices(frame) for frame in self.frames)

    def __repr__(self) -> str:
        return f"MeshSequence({len(self)} frames, {len(self.mesh.vertices):,} vertices)"


def require_motion(value: object, what: str = "a motion") -> None:
    """Raise ParameterError where something is no recorded motion."""
    if not isinstance(value, MeshSequence):
        raise ParameterError(
            f"{what} must be a MeshSequence, as em.read_sequence('scan.####.obj') reads it or "
            f"em.MeshSequence(mesh, frames) makes it, found {type(value).__name__}"
        )
