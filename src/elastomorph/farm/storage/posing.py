"""Faces from codes of columns: products in which a face has the same bits in any company.

The last bits of a sum in a matrix product depend on how many rows the product has and on which of
them a face is. So all products have `TOGETHER` rows, and face i is always row i modulo that number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.blas_threads import in_own_threads
from elastomorph.farm.sampling.columns import Columns
from elastomorph.rig.rig import Rig
from elastomorph.rig.sliders import table_moments

TOGETHER = 32
"""Faces in one product."""

_BESIDE = 64  # Coordinates that stay still between two moved ones are cheaper multiplied than cut
_PRODUCTS = 4  # In a task of one thread: enough that starting it does not count

Rows = slice | NDArray[np.int64]


@dataclass(frozen=True)
class Run:
    """Consecutive coordinates that the fields move."""

    place: slice  # Of the 3V coordinates
    fields: NDArray[np.float32]  # (F, n) C-contiguous
    neutral: NDArray[np.float32]  # (n,)


@dataclass(frozen=True, eq=False)
class Poser:
    """The faces that rows of codes stand for.

    Args:
        rig: The rig.
        columns: What the codes mean; the first are the sliders of the rig.
    """

    rig: Rig
    columns: Columns

    def coefficients(self, codes: NDArray[np.uint16]) -> NDArray[np.float32]:
        """(S, F) what each field, Δ and bends of all morphs, is multiplied with in each face."""
        values = self.columns.decode(codes)
        sliders = values[:, : len(self.rig.names)]
        times = self.columns.times(values, len(self.rig.names))
        zeta, moments = table_moments(self.rig.sliders, sliders, times, normalize=False)
        blocks = [
            zeta[:, j, None] * morph.factors(moments[:, j])
            for j, morph in enumerate(self.rig.fields.morphs)
        ]
        return np.concatenate([np.zeros((len(codes), 0)), *blocks], axis=1).astype(np.float32)

    def positions(
        self,
        left: NDArray[np.float32],
        numbers: NDArray[np.int64],
        out: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]:
        """(S, V, 3) positions of the faces of these coefficients and (S,) numbers, on all cores."""
        shape = (len(left), *self.rig.neutral.vertices.shape)
        out = np.empty(shape, np.float32) if out is None else out
        flat = out.reshape(len(left), shape[1] * 3)

        def write(rows: Rows, run: Run, moved: NDArray[np.float32]) -> None:
            flat[rows, run.place] = np.add(moved, run.neutral, out=moved)

        for still in self.still:
            flat[:, still] = self._neutral[still]
        self.products(left, numbers, self._runs, write)
        return out

    def prepare(self) -> None:
        """Make once what all faces need."""
        _ = self._runs

    def runs(self, step: float = 1.0) -> list[Run]:
        """The coordinates that any field moves, in runs; fields in units of a step."""
        fields = self.rig.fields.matrix(np.float32)[1:]
        fields *= np.float32(1 / step)
        return [
            Run(run, np.ascontiguousarray(fields[:, run]), self._neutral[run])
            for run in self._moved
        ]

    def products(
        self,
        left: NDArray[np.float32],
        numbers: NDArray[np.int64],
        runs: list[Run],
        write: Callable[[Rows, Run, NDArray[np.float32]], object],
    ) -> None:
        """Hand on, of some faces and a run at a time, the (n, run) sums of fields.

        The sums are overwritten by the next; `write` is called by several threads.
        """
        widest = max((run.fields.shape[1] for run in runs), default=0)

        def work(some: list[tuple[Rows, Rows]]) -> None:
            buffer = np.empty(TOGETHER * widest, np.float32)
            whole = np.zeros((TOGETHER, left.shape[1]), np.float32)
            for rows, slots in some:
                whole[:] = 0
                whole[slots] = left[rows]
                for run in runs:
                    width = run.fields.shape[1]
                    sums = buffer[: TOGETHER * width].reshape(TOGETHER, width)
                    np.matmul(whole, run.fields, out=sums)
                    write(rows, run, sums[slots])

        parts = list(_products(numbers))
        in_own_threads(work, [parts[i : i + _PRODUCTS] for i in range(0, len(parts), _PRODUCTS)])

    @cached_property
    def _runs(self) -> list[Run]:
        return self.runs()

    @cached_property
    def still(self) -> list[slice]:
        """The runs of coordinates that nothing moves."""
        ends = [0, *(end for run in self._moved for end in (run.start, run.stop))]
        ends.append(self.rig.neutral.vertices.size)
        return [slice(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b]

    @cached_property
    def _moved(self) -> list[slice]:
        moves = np.zeros(self.rig.neutral.vertices.shape, bool)
        for morph in self.rig.fields.morphs:
            for span in morph.spans:
                moves[span.vertices] |= span.fields.any(axis=0)
        moved = np.flatnonzero(moves)
        cuts = np.flatnonzero(np.diff(moved) > _BESIDE) + 1
        return [slice(int(r[0]), int(r[-1]) + 1) for r in np.split(moved, cuts) if len(r)]

    @cached_property
    def _neutral(self) -> NDArray[np.float32]:
        return self.rig.neutral.vertices.astype(np.float32).reshape(-1)


def _products(numbers: NDArray[np.int64]) -> Iterator[tuple[Rows, Rows]]:
    """Rows of faces that are multiplied together, and their rows in the product."""
    slots = numbers % TOGETHER
    order = np.argsort(slots, kind="stable")
    firsts = np.searchsorted(slots[order], np.arange(TOGETHER))
    product = np.empty(len(numbers), np.int64)  # the how-manieth face of its slot each face is
    product[order] = np.arange(len(numbers)) - firsts[slots[order]]
    by_product = np.lexsort((np.arange(len(numbers)), product))
    ends = np.flatnonzero(np.diff(product[by_product])) + 1
    for rows in np.split(by_product, ends) if len(numbers) else []:
        yield _as_slice(rows), _as_slice(slots[rows])


def _as_slice(rows: NDArray[np.int64]) -> Rows:
    """A slice where the rows follow each other: several times faster than an array of them."""
    first, count = int(rows[0]), len(rows)
    if (np.diff(rows) == 1).all():
        return slice(first, first + count)
    return rows
