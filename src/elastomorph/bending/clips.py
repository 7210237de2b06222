"""The animations of a document with the weights of bends, so that its clips play bent.

A channel of weights gets a sampler of its own with all weights, for others may use the one it had
and its accessors too; what nothing uses after that makes room in `fill_gaps`. Where
KHR_animation_pointer moves one weight alone, the weights of its bends get channels of their own.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.bending.additions import Additions
from elastomorph.bending.keys import Columns, Keys, bent_keys
from elastomorph.errors import ParameterError
from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.clips import POINTER, MovedWeights, moved_weights
from elastomorph.io.gltf.container import GltfFile


class ClipEdit:
    """The animations of a document that weights of bends are added to.

    Args:
        file: The file.
        document: The document that is changed.
        additions: What is added to it.
        columns: How the weights of each mesh that got bends are extended.
        tolerance: How far a vertex may be from its path between keys, as a fraction of D.

    Attributes:
        clips: How many animations play bent.
        added_keys: How many keys were added to them.
        error: How far a vertex may be from its path between keys, as a fraction of D.
    """

    def __init__(
        self,
        file: GltfFile,
        document: dict[str, Any],
        additions: Additions,
        columns: Mapping[int, Columns],
        tolerance: float,
    ) -> None:
        self._file, self._document, self._additions = file, document, additions
        self._columns, self._tolerance = columns, tolerance
        self._inputs: dict[tuple[int, bytes], int] = {}
        self.clips = 0
        self.added_keys = 0
        self.error = 0.0

    def extend(self) -> None:
        """Extend every channel of weights."""
        for number in range(len(self._file.items("animations"))):
            self._file.item("animations", number, "the document")
            animation = self._document["animations"][number]
            of = f"animation {number}"
            made: dict[tuple[int, MovedWeights], list[int]] = {}
            for channel in list(self._file.list_in(animation, "channels", of)):
                if not isinstance(channel, dict):
                    self._file.refuse(f"a channel of {of} is no object")
                moved = self._moved(channel, of)
                if moved is not None and moved.mesh in self._columns:
                    self._extend(animation, channel, moved, made, of)
            self.clips += bool(made)

    def _moved(self, channel: dict[str, Any], of: str) -> MovedWeights | None:
        """The weights that a channel moves, None where it moves something else."""
        moved = moved_weights(self._file, channel, of)
        columns = None if moved is None else self._columns.get(moved.mesh)
        if moved is None or moved.weight is None or columns is None:
            return moved
        if moved.weight >= columns.count:
            self._file.refuse(
                f"{of} moves weight {moved.weight} of mesh {moved.mesh}, which has "
                f"{columns.count} morph targets; take out that channel, or export it again"
            )
        return moved

    def _extend(
        self,
        animation: dict[str, Any],
        channel: dict[str, Any],
        moved: MovedWeights,
        made: dict[tuple[int, MovedWeights], list[int]],
        of: str,
    ) -> None:
        samplers = self._file.list_in(animation, "samplers", of)
        number = channel.get("sampler")
        if type(number) is not int or number not in range(len(samplers)):
            self._file.refuse(f"a channel of {of} names a sampler that it does not have")
        columns = self._columns[moved.mesh]
        followers = list(range(columns.count, columns.count + len(columns.bends)))
        if moved.weight is not None:
            followers = [
                columns.count + k
                for k, (column, _, _) in enumerate(columns.bends)
                if column == moved.weight
            ]
            columns = _of_one(columns, moved.weight)
            if not columns.followers:
                return
        key = (number, moved)
        if key not in made:
            keys, times = self._keys(samplers[number], columns, of)
            parts = [keys.values]
            if moved.weight is not None:  # its own first, which moves as before unless it is folded
                parts = np.split(keys.values, keys.values.shape[-1], axis=-1)
                parts = parts if columns.folds else parts[1:]
            made[key] = self._samplers(samplers, samplers[number], keys.times, times, parts)
        if moved.weight is None:
            channel["sampler"] = made[key][0]
            return
        if columns.folds:
            channel["sampler"] = made[key][0]
        for follower, sampler in zip(followers, made[key][bool(columns.folds) :], strict=True):
            added = copy.deepcopy(channel) | {"sampler": sampler}
            place = added["target"]["extensions"][POINTER]
            place["pointer"] = f"{place['pointer'].rpartition('/')[0]}/{follower}"
            animation["channels"].append(added)

    def _keys(self, sampler: Any, columns: Columns, of: str) -> tuple[Keys, NDArray[np.float64]]:
        """The keys of all weights, and the times of those of the source."""
        file, what = self._file, f"the keys of {of}"
        if not isinstance(sampler, dict):
            file.refuse(f"a sampler of {of} is no object")
        times = read_floats(file, sampler.get("input"), 1, what)[:, 0]
        kind = sampler.get("interpolation", "LINEAR")
        rows = 3 if kind == "CUBICSPLINE" else 1
        count = len(times) * rows * columns.count
        values = read_floats(file, sampler.get("output"), 1, what, count=count)
        shape = (len(times), *([3] if rows == 3 else []), columns.count)
        try:
            keys = bent_keys(times, values.reshape(shape), kind, columns, self._tolerance)
        except ParameterError as problem:
            file.refuse(f"{of} cannot be bent: {problem}")
        self.error = max(self.error, keys.error)
        self.added_keys += len(keys.times) - len(times)
        return keys, times

    def _samplers(
        self,
        samplers: list[Any],
        source: dict[str, Any],
        keys: NDArray[np.float64],
        times: NDArray[np.float64],
        parts: list[NDArray[np.float64]],
    ) -> list[int]:
        """The numbers of new samplers like that of the source, of key times and of values each."""
        number = source["input"]
        if not np.array_equal(times, keys):
            number = self._input(number, keys.astype(np.float32))
        for values in parts:
            view = self._view(source["output"])
            output = self._additions.keys(values.astype(np.float32).reshape(-1), view)
            samplers.append({**source, "input": number, "output": output})
        return list(range(len(samplers) - len(parts), len(samplers)))

    def _input(self, number: int, times: NDArray[np.float32]) -> int:
        """The accessor of key times in place of those of another accessor."""
        key = (number, times.tobytes())
        if key not in self._inputs:
            self._inputs[key] = self._additions.keys(times, self._view(number), bounds=True)
        return self._inputs[key]

    def _view(self, accessor: int) -> Any:
        return self._file.item("accessors", accessor, "a sampler").get("bufferView")


def _of_one(columns: Columns, weight: int) -> Columns:
    """The columns of one slider alone."""
    bends = tuple((0, curve, size) for column, curve, size in columns.bends if column == weight)
    folds = {0: columns.folds[weight]} if weight in columns.folds else {}
    return Columns(1, bends, folds)
