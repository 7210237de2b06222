"""The displacement fields of a rig, Δ and bends of each morph, and faces as one product of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import DTypeLike, NDArray

from elastomorph.blas_threads import in_own_threads, one_blas_thread
from elastomorph.errors import MissingExtraError, ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph

# Vertices that stay still between two moved ones are cheaper to add as zeros than to skip, up to
# about this many.
_GAP = 512


@dataclass(frozen=True, eq=False)
class Span:
    """Fields on a run of consecutive vertices."""

    start: int  # The first vertex
    fields: NDArray[np.float64]  # (1 + K, N, 3) float64, C-contiguous, Δ first

    @property
    def vertices(self) -> slice:
        """The run."""
        return slice(self.start, self.start + self.fields.shape[1])


@dataclass(frozen=True, eq=False)
class MorphFields:
    """Δ and bends of one morph on the vertices they move."""

    count: int  # 1 + K, number of fields
    spans: tuple[Span, ...]  # The fields, on runs of vertices that hold all moved ones
    bend_curves: tuple[BendCurve, ...]  # K scalar curves

    @classmethod
    def of(cls, morph: Morph) -> MorphFields:
        """The fields of a morph."""
        moves = morph.delta.any(axis=1)
        for bend in morph.bends:
            moves |= bend.any(axis=1)
        moved = np.flatnonzero(moves)
        cuts = np.flatnonzero(np.diff(moved) > _GAP) + 1
        spans = [
            Span(int(run[0]), np.concatenate([morph.delta[None, part], morph.bends[:, part]]))
            for run in np.split(moved, cuts)
            if run.size
            for part in [slice(int(run[0]), int(run[-1]) + 1)]
        ]
        return cls(1 + len(morph.bends), tuple(spans), morph.bend_curves)

    @property
    def moved(self) -> NDArray[np.int32]:
        """(N,) vertices on the spans, rising."""
        runs = [np.arange(s.vertices.start, s.vertices.stop, dtype=np.int32) for s in self.spans]
        return np.concatenate([np.zeros(0, dtype=np.int32), *runs])

    @property
    def fields(self) -> NDArray[np.float64]:
        """(1 + K, N, 3) the fields on these vertices."""
        return np.concatenate(
            [np.zeros((self.count, 0, 3)), *(s.fields for s in self.spans)], axis=1
        )

    def factors_at(self, time: float) -> list[float]:
        """1 + K numbers that the fields are multiplied with at one time."""
        return [time, *(curve.at(time) for curve in self.bend_curves)]

    def factors(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T, 1 + K) what each field is multiplied with at each time: t, b_1(t), …, b_K(t)."""
        return np.stack([times, *(curve(times) for curve in self.bend_curves)], axis=-1)

    def slopes(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T, 1 + K) the derivatives of the factors with respect to time."""
        ones = np.ones_like(times)
        return np.stack([ones, *(curve.slope(times) for curve in self.bend_curves)], axis=-1)

    def add_to(self, positions: NDArray[np.float64], factors: Iterable[float]) -> None:
        """Add the fields to (V, 3) C-contiguous positions, in place, each times its factor."""
        from scipy.linalg.blas import daxpy

        flat, numbers = positions.reshape(-1), list(factors)
        for offset, rows in self._rows:
            for row, factor in zip(rows, numbers, strict=True):
                if factor:
                    # In place and without a temporary: several times faster than NumPy's +=.
                    daxpy(row, flat, row.size, factor, 0, 1, offset)

    @cached_property
    def _rows(self) -> list[tuple[int, list[NDArray[np.float64]]]]:
        """Of each span, its first coordinate and its fields flat."""
        return [(3 * s.start, [field.reshape(-1) for field in s.fields]) for s in self.spans]


@dataclass(frozen=True, eq=False)
class RigFields:
    """The fields of all morphs of a rig, as one matrix for products."""

    neutral: NDArray[np.float64]  # (V, 3) float64
    morphs: tuple[MorphFields, ...]  # The fields of each morph, in the order of the rig

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """(J + 1,) row of the matrix where the fields of each morph start; row 0 is the neutral."""
        counts = [morph.count for morph in self.morphs]
        return np.concatenate([[1], 1 + np.cumsum(counts, dtype=np.int64)])

    def matrix(self, dtype: DTypeLike) -> NDArray[np.floating]:
        """(1 + F, 3V) the neutral and all fields, one a row."""
        rows = np.zeros((int(self.starts[-1]), *self.neutral.shape), dtype=dtype)
        rows[0] = self.neutral
        for start, morph in zip(self.starts, self.morphs, strict=False):
            for span in morph.spans:
                rows[start : start + morph.count, span.vertices] = span.fields
        return rows.reshape(len(rows), -1)

    def posed(self, zeta: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(V, 3) positions V₀ + Σ ζ_j (w^j(t_j) - V₀); only what moves is computed."""
        positions = self.neutral.copy()
        moments = zip(self.morphs, zeta.tolist(), times.tolist(), strict=True)
        with one_blas_thread():
            for fields, weight, time in moments:
                if weight:
                    fields.add_to(positions, [weight * f for f in fields.factors_at(time)])
        return positions

    def moving(
        self, times: NDArray[np.float64], speeds: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(V, 3) velocities while the times of the morphs change at these speeds."""
        moving = np.zeros_like(self.neutral)
        with one_blas_thread():
            for fields, time, speed in zip(self.morphs, times, speeds, strict=True):
                if speed:
                    fields.add_to(moving, (speed * fields.slopes(np.array(time))).tolist())
        return moving

    def product(self, dtype: np.dtype[np.floating]) -> FieldProduct:
        """Products with the matrix of this type, which is kept."""
        if dtype not in self._products:
            self._products[dtype] = FieldProduct(self, self.matrix(dtype))
        return self._products[dtype]

    @cached_property
    def _products(self) -> dict[np.dtype[np.floating], FieldProduct]:
        return {}


BLOCK = 64 * 2**20

BACKENDS = ("numpy", "torch")

# Output written in pieces of about this size stays in the cache until it is complete: on the
# machines measured twice as fast as one product over everything.
_PIECE = 2 * 2**20

# The last bits of a product depend on how many rows it has. So all pieces of a rig have the same
# number of rows, a multiple of those that a kernel of BLAS takes at once, and a face has the same
# bits whatever the threads and whatever is beside it.
_STEP = 16

# Pieces in a task of one thread: enough that starting it does not count, few enough that threads
# end together.
_TOGETHER = 8


@dataclass(frozen=True, eq=False)
class FieldProduct:
    """Products with the matrix of a rig's neutral and fields."""

    fields: RigFields  # The fields of the rig
    # (1 + F, 3V) float32 or float64, the neutral and all fields, one a row.
    matrix: NDArray[np.floating]

    def into(
        self,
        weights: NDArray[np.float64],
        times: NDArray[np.float64],
        out: NDArray[np.floating],
        backend: str = "numpy",
    ) -> None:
        """Write V₀ + Σ ζ_j (w^j(t_j) - V₀) of S faces into (S, 3V) of the type of the matrix.

        Weights ζ and times are (S, J), one of each morph; the torch backend runs on the CPU.
        """
        if backend not in BACKENDS:
            raise ParameterError(f"backend must be one of {', '.join(BACKENDS)}, found {backend!r}")
        coefficients, rows = self._factors(weights, times)
        size = out.itemsize * max(out.shape[1], 1)
        piece = _STEP * max(1, round(_PIECE / size / _STEP))
        parts = [slice(start, start + piece) for start in range(0, len(out), piece)]
        if backend == "torch":
            multiply = _torch_multiply()  # with its own threads
            for part in parts:
                multiply(coefficients[part], rows, out=out[part])
            return

        def write(some: list[slice]) -> None:
            for part in some:
                _multiply_piece(coefficients[part], rows, out[part], piece)

        in_own_threads(write, [parts[i : i + _TOGETHER] for i in range(0, len(parts), _TOGETHER)])

    def _factors(
        self, weights: NDArray[np.float64], times: NDArray[np.float64]
    ) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
        """(S, N) and (N, 3V) whose product the faces are, with N as small as it can be.

        A morph at one time in all faces is one field, Δ and bends folded together; fields that no
        face uses are left out.
        """
        columns, rows = [np.ones((len(weights), 1))], [self.matrix[:1]]
        for j, morph in enumerate(self.fields.morphs):
            zeta, t = weights[:, j, None], times[:, j]
            own = self.matrix[self.fields.starts[j] : self.fields.starts[j + 1]]
            if not zeta.any():
                continue
            if (t == t[0]).all():
                factors = np.array([morph.factors_at(float(t[0]))], dtype=own.dtype)
                columns.append(zeta)
                rows.append(factors @ own)
            else:
                block = zeta * morph.factors(t)
                used = block.any(axis=0)
                columns.append(block[:, used])
                rows.append(own[used])
        return np.concatenate(columns, axis=1).astype(self.matrix.dtype), np.concatenate(rows)


def _multiply_piece(
    left: NDArray[np.floating], right: NDArray[np.floating], out: NDArray[np.floating], piece: int
) -> None:
    """Multiply as if `left` had the rows of a whole piece."""
    if len(left) == piece:
        np.matmul(left, right, out=out)
        return
    whole = np.zeros((piece, left.shape[1]), dtype=left.dtype)
    whole[: len(left)] = left
    out[:] = (whole @ right)[: len(left)]


def _torch_multiply() -> Callable[..., object]:
    """``torch.mm`` that takes NumPy arrays."""
    try:
        import torch
    except ImportError:
        raise MissingExtraError("torch", "torch") from None

    def multiply(
        left: NDArray[np.floating], right: NDArray[np.floating], out: NDArray[np.floating]
    ) -> None:
        torch.mm(torch.from_numpy(left), torch.from_numpy(right), out=torch.from_numpy(out))

    return multiply


def block_length(block: int | None, size: int) -> int:
    """Faces in a block: as asked for, or as many as fit `BLOCK`, each of so many bytes."""
    length = max(1, BLOCK // size) if block is None else block
    if not isinstance(length, int) or length < 1:
        raise ParameterError(f"a block must hold at least one face, found {block!r}")
    return length


def checked_output(out: NDArray[np.floating], shape: tuple[int, ...]) -> NDArray[np.floating]:
    """The caller's buffer, if faces can be written straight into it."""
    if not isinstance(out, np.ndarray) or out.dtype not in (np.float32, np.float64):
        found = out.dtype if isinstance(out, np.ndarray) else type(out).__name__
        raise ParameterError(f"out must be a float32 or float64 array, found {found}")
    if out.shape != shape:
        raise ParameterError(f"out must have shape {shape}, found {out.shape}")
    if not out.flags.c_contiguous or not out.flags.writeable:
        raise ParameterError("out must be C-contiguous and writable")
    return out
