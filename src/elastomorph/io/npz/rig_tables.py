"""What archives of rigs hold beside fields: bend curves, lists of names, counts and limits."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.choices import choice_from_json
from elastomorph.io.npz.members import NpzMembers
from elastomorph.io.untrusted import naming_file
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Choice

__all__ = [
    "CurveTable",
    "as_text",
    "as_whole",
    "list_arrays",
    "read_choices",
    "read_counts",
    "read_curves",
    "read_indices",
    "read_lists",
]

_MOST_TERMS = 256


class CurveTable:
    """Different bend curves, each once: most morphs of a rig share theirs."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[bytes, bytes, tuple[int, ...]], int] = {}
        self._curves: list[BendCurve] = []

    def number(self, curve: BendCurve) -> int:
        """The number of a curve, which is taken up where it is new."""
        key = (curve.breaks.tobytes(), curve.coefficients.tobytes(), curve.coefficients.shape)
        if key not in self._numbers:
            self._numbers[key] = len(self._curves)
            self._curves.append(curve)
        return self._numbers[key]

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The table as arrays."""
        nothing = np.empty(0)
        shapes = [curve.coefficients.shape for curve in self._curves]
        return {
            "curve_shapes": np.array(shapes, dtype=np.int64).reshape(-1, 2),
            "curve_breaks": np.concatenate([nothing, *(c.breaks for c in self._curves)]),
            "curve_coefficients": np.concatenate(
                [nothing, *(c.coefficients.ravel() for c in self._curves)]
            ),
        }


def read_curves(path: str | Path, members: NpzMembers) -> list[BendCurve]:
    """The curves of a table.

    Raises:
        FormatError: They are not those of a `CurveTable`.
    """
    shapes = members.array("curve_shapes", "iu", (None, 2)).tolist()
    if any(pieces < 1 or terms < 1 for pieces, terms in shapes):
        raise FormatError(path, "a bend curve has no pieces or no coefficients")
    if any(terms > _MOST_TERMS for _, terms in shapes):
        raise FormatError(path, f"a bend curve has more than {_MOST_TERMS} coefficients a piece")
    members.budget.spend_objects(len(shapes))
    breaks = members.array("curve_breaks", "f", (sum(pieces + 1 for pieces, _ in shapes),))
    flat = members.array("curve_coefficients", "f", (sum(p * n for p, n in shapes),))
    curves = []
    a = b = 0
    with naming_file(path):
        for pieces, terms in shapes:
            rows = flat[b : b + pieces * terms].reshape(pieces, terms)
            curves.append(BendCurve(breaks[a : a + pieces + 1], rows))
            a, b = a + pieces + 1, b + pieces * terms
    return curves


def read_counts(path: str | Path, members: NpzMembers, name: str, count: int) -> list[int]:
    """Whole numbers from 0.

    Raises:
        FormatError: There is no such array of ``count`` whole numbers, or one is negative.
    """
    counts: list[int] = members.array(name, "iu", (count,)).tolist()
    if any(number < 0 for number in counts):
        raise FormatError(path, f"the array '{name}' holds a number below 0; the file is damaged")
    return counts


def read_indices(
    path: str | Path, members: NpzMembers, name: str, count: int, length: int
) -> list[int]:
    """Whole numbers from 0 to below ``length``.

    Raises:
        FormatError: There is no such array of ``count`` whole numbers, or one is out of range.
    """
    indices = read_counts(path, members, name, count)
    if any(index >= length for index in indices):
        raise FormatError(
            path, f"the array '{name}' names a curve that does not exist; the file is damaged"
        )
    return indices


def read_choices(path: str | Path, members: NpzMembers, count: int) -> list[Choice | None]:
    """Why each path was chosen; nothing of all in archives written before that was kept.

    Raises:
        FormatError: One is damaged.
    """
    if "choices" not in members.names:
        return [None] * count
    try:
        texts = members.array("choices", "U", (count,)).tolist()
        return [choice_from_json(json.loads(text)) if text else None for text in texts]
    except (ValueError, RecursionError):
        raise FormatError(path, "the array 'choices' is damaged") from None


def list_arrays(
    kind: str, what: str, lists: Mapping[str, Sequence[str]]
) -> dict[str, NDArray[Any]]:
    """The arrays of named lists of names; none where there are no lists."""
    if not lists:
        return {}
    return {
        f"{kind}_names": as_text(lists),
        f"{kind}_counts": as_whole([len(entries) for entries in lists.values()]),
        f"{kind}_{what}": as_text([entry for entries in lists.values() for entry in entries]),
    }


def read_lists(path: str | Path, members: NpzMembers, kind: str, what: str) -> dict[str, list[str]]:
    """The named lists of names; none where the archive has no such arrays.

    Raises:
        FormatError: The arrays do not fit each other.
    """
    if f"{kind}_names" not in members.names:
        return {}
    names = members.array(f"{kind}_names", "U", (None,)).tolist()
    counts = read_counts(path, members, f"{kind}_counts", len(names))
    entries = members.array(f"{kind}_{what}", "U", (sum(counts),)).tolist()
    ends = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).tolist()
    return {
        name: entries[start:stop] for name, (start, stop) in zip(names, pairwise(ends), strict=True)
    }


def as_text(names: Mapping[str, Any] | Sequence[str]) -> NDArray[Any]:
    """Names as an array."""
    return np.array(list(names), dtype=np.str_)


def as_whole(numbers: list[int]) -> NDArray[np.int64]:
    """Whole numbers as an array."""
    return np.array(numbers, dtype=np.int64)
