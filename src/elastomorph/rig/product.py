"""Faces as one matrix product at the speed of memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.blas_threads import in_own_threads
from elastomorph.errors import MissingExtraError, ParameterError
from elastomorph.rig.fields import RigFields

__all__ = ["BACKENDS", "BLOCK", "FieldProduct", "checked_output"]

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
    """Products with the matrix of a rig's neutral and fields.

    Attributes:
        fields: The fields of the rig.
        matrix: (1 + F, 3V) float32 or float64, the neutral and all fields, one a row.
    """

    fields: RigFields
    matrix: NDArray[np.floating]

    def into(
        self,
        weights: NDArray[np.float64],
        times: NDArray[np.float64],
        out: NDArray[np.floating],
        backend: str = "numpy",
    ) -> None:
        """Write V₀ + Σ ζ_j (w^j(t_j) - V₀) of many faces into a buffer.

        Args:
            weights: (S, J) ζ of each morph.
            times: (S, J) time of each morph.
            out: (S, 3V) of the type of the matrix, C-contiguous.
            backend: ``numpy`` or ``torch`` (on the CPU).

        Raises:
            ParameterError: Another backend.
            MissingExtraError: PyTorch is not installed.
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


def checked_output(out: NDArray[np.floating], shape: tuple[int, ...]) -> NDArray[np.floating]:
    """The caller's buffer, if faces can be written straight into it.

    Raises:
        ParameterError: Another shape, type or layout, or it is read-only.
    """
    if not isinstance(out, np.ndarray) or out.dtype not in (np.float32, np.float64):
        found = out.dtype if isinstance(out, np.ndarray) else type(out).__name__
        raise ParameterError(f"out must be a float32 or float64 array, found {found}")
    if out.shape != shape:
        raise ParameterError(f"out must have shape {shape}, found {out.shape}")
    if not out.flags.c_contiguous or not out.flags.writeable:
        raise ParameterError("out must be C-contiguous and writable")
    return out
