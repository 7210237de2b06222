"""A data set of faces as a PyTorch data set.

PyTorch is optional: importing this module without it raises `MissingExtraError`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MissingExtraError, ParameterError
from elastomorph.farm.storage.contents import TOGETHER
from elastomorph.numbers import is_whole

if TYPE_CHECKING:
    from elastomorph.farm.reading.faces import FaceSet

try:
    import torch
except ImportError:
    raise MissingExtraError("torch", "torch") from None

_WINDOW = 8  # Blocks of faces that are shuffled among each other: as many as are kept decoded


class FaceDataset(torch.utils.data.Dataset):
    """Faces as dicts of tensors by the names of arrays: float32, and whole numbers as stored.

    ``dataset[7]`` is one face, ``dataset[[7, 3]]`` a batch of two. For a ``DataLoader`` of your
    own it reads whole batches (``__getitems__``); those of `batches` are faster, as they do not put
    batches together from faces. Workers open the data set themselves, whatever starts them.

    Args:
        faces: The data set.
        names: Of arrays, as `FaceSet.array` takes them.
    """

    def __init__(self, faces: FaceSet, names: Sequence[str]) -> None:
        for name in names:
            faces.array(name)
        self.faces = faces
        self.names = tuple(names)

    def __len__(self) -> int:
        return len(self.faces)

    def __getitem__(self, index: Any) -> dict[str, torch.Tensor]:
        return {name: _tensor(self.faces.array(name)[index]) for name in self.names}

    def __getitems__(self, numbers: Sequence[int]) -> list[dict[str, torch.Tensor]]:
        batch = self[list(numbers)]
        return [{name: rows[i] for name, rows in batch.items()} for i in range(len(numbers))]

    def batches(
        self,
        size: int = 256,
        *,
        faces: slice = slice(None),
        shuffle: bool = True,
        seed: int = 0,
        workers: int = 0,
        **options: Any,
    ) -> torch.utils.data.DataLoader:
        """A loader of batches, dicts of tensors with a first axis of `size`; the last may be less.

        Shuffled faces are in another order each time it is gone through. They are mixed within
        windows of some hundred thousand faces, so that what is read is read once and recipes are
        multiplied out as fast as without shuffling.

        Args:
            size: Faces in a batch.
            faces: Which faces, as a slice without a step: some to train with, others to test.
            shuffle: Whether in random order.
            seed: Of the order.
            workers: Processes that read; 0: this one.
            options: More for ``torch.utils.data.DataLoader``.

        Raises:
            ParameterError: Something that cannot be meant.
        """
        if not is_whole(size) or size < 1:
            raise ParameterError(f"a batch has one face or more, found {size!r}")
        if not isinstance(faces, slice) or faces.step not in (None, 1):
            raise ParameterError(f"faces are chosen by a slice without a step, found {faces!r}")
        rows = range(len(self))[faces]
        order = _Shuffled(self, rows, size, seed) if shuffle else _InOrder(rows, size)
        return torch.utils.data.DataLoader(
            self, batch_size=None, sampler=order, num_workers=workers, **options
        )

    def block_and_grain(self) -> tuple[int, int]:
        """Faces that are read together best, and that must not be torn apart."""
        arrays = [self.faces.data.array(own) for own in self._read()]
        chunks = [int(array.chunks[0]) for array in arrays]
        return max([TOGETHER, *chunks]), max((c for c in chunks if c < TOGETHER), default=1)

    def _read(self) -> set[str]:
        stored = self.faces.labels
        return {name if name in stored else "weights" for name in self.names}


class _InOrder(torch.utils.data.Sampler):
    """Slices, one batch after the other."""

    def __init__(self, rows: range, size: int) -> None:
        self._rows, self._size = rows, size

    def __len__(self) -> int:
        return -(-len(self._rows) // self._size)

    def __iter__(self) -> Iterator[Any]:
        for start in range(self._rows.start, self._rows.stop, self._size):
            yield slice(start, min(start + self._size, self._rows.stop))


class _Shuffled(_InOrder):
    """Arrays of numbers, in another order each time.

    Face i is row i modulo `TOGETHER` of a product. Blocks are drawn; within a window of them, the
    faces of each such row are shuffled among themselves, so that products are full.
    """

    def __init__(self, data: FaceDataset, rows: range, size: int, seed: int) -> None:
        super().__init__(rows, size)
        self._block, self._grain = data.block_and_grain()
        self._seed, self._times = seed, 0

    def __iter__(self) -> Iterator[NDArray[np.int64]]:
        random = np.random.default_rng([self._seed, self._times])
        self._times += 1
        left = np.zeros(0, np.int64)
        for numbers in self._windows(random):
            left = np.concatenate([left, numbers])
            whole = len(left) // self._size * self._size
            yield from np.split(left[:whole], whole // self._size) if whole else []
            left = left[whole:]
        if len(left):
            yield left

    def _windows(self, random: np.random.Generator) -> Iterator[NDArray[np.int64]]:
        rows = self._rows
        blocks = random.permutation(
            np.arange(rows.start // self._block, -(-rows.stop // self._block))
        )
        within = np.arange(0, self._block, self._grain)
        for start in range(0, len(blocks), _WINDOW):
            grains = np.add.outer(blocks[start : start + _WINDOW] * self._block, within)
            mixed = random.permuted(grains.reshape(-1, TOGETHER // self._grain), axis=0)
            outside = (mixed + self._grain <= rows.start) | (mixed >= rows.stop)
            last = np.argsort(outside, axis=0, kind="stable")  # they would tear products apart
            mixed = np.take_along_axis(mixed, last, axis=0)
            numbers = np.add.outer(mixed, np.arange(self._grain)).reshape(-1)
            yield numbers[(numbers >= rows.start) & (numbers < rows.stop)]


def _tensor(values: NDArray[Any]) -> torch.Tensor:
    if values.dtype.kind == "f":
        values = values.astype(np.float32, copy=False)
    elif values.dtype == np.uint16:
        values = values.astype(np.int32)  # PyTorch can do little with uint16
    tensor = torch.from_numpy(np.ascontiguousarray(values))
    # A worker's tensors go through shared memory. Left to the thread that sends them, the copy is
    # torn off where a loader is left early, and the worker aborts.
    return tensor if torch.utils.data.get_worker_info() is None else tensor.share_memory_()
