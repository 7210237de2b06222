"""Confidence as a mask: vertices of a recording that are not to be trusted do not count.

Poses that were found in photographs or wrapped to scans are surer in some places than in others,
and one stray vertex is the largest error of every method. A vertex counts in a frame where its
confidence is high enough there, and in the first and the last frame too, for its path leads from
the one to the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.evaluation.curve_errors import CurveVertices
from elastomorph.evaluation.words import SPACE
from elastomorph.model.sequence import MeshSequence
from elastomorph.numbers import as_number, as_numbers, first_few

LEAST = 0.5
"""The confidence from which on a vertex counts."""

_NAMED = 6
_MOVES = 0.005
"""Of D: what moves farther than this in some frame moves."""


@dataclass(frozen=True, eq=False)
class Confidence:
    """How far each vertex of a recorded motion is to be trusted, and from where on it counts.

    Attributes:
        values: (T, V) from 0 to 1.
        least: The confidence from which on a vertex counts.
    """

    values: NDArray[np.floating]
    least: float = LEAST

    @classmethod
    def of(
        cls,
        given: str | Path | Mapping[str, ArrayLike] | ArrayLike,
        truth: MeshSequence,
        least: float = LEAST,
    ) -> Confidence:
        """That of a motion: a file ``confidence.npz``, (V,) by the names of poses, or (T, V).

        A pose has the name of its frame, with or without suffix; further names are passed over.

        Raises:
            FileError: The file cannot be read.
            FormatError: It is no such file, or does not fit the motion.
            ParameterError: A frame has no confidence, or it is not (V,) numbers from 0 to 1.
        """
        from elastomorph.io.npz.confidence import read_confidence  # beside this package

        if isinstance(given, str | Path):
            try:
                values = _by_name(read_confidence(given), truth)
            except ParameterError as error:
                raise FormatError(given, str(error)) from None
        elif isinstance(given, Mapping):
            values = _by_name(given, truth)
        else:
            values = _checked(as_numbers(given, "the confidence"), truth)
        return cls(values, least)

    @cached_property
    def counted(self) -> NDArray[np.bool_]:
        """(T, V) which vertices count in which frames."""
        sure: NDArray[np.bool_] = self.values >= self.least
        found: NDArray[np.bool_] = sure & sure[0] & sure[-1]
        return found

    def part(self, start: int, stop: int) -> Confidence:
        """That of frames ``start`` to ``stop`` inclusive, as `MeshSequence.part` has them."""
        step = 1 if stop >= start else -1
        return Confidence(self.values[np.arange(start, stop + step, step)], self.least)

    def covered(self, along: CurveVertices) -> NDArray[np.float64]:
        """(T,) share of the vertices of curves that count in each frame."""
        return np.asarray(self.counted[:, along.indices].mean(axis=1, dtype=np.float64))


ConfidenceLike = Confidence | str | Path | Mapping[str, ArrayLike] | ArrayLike
"""A confidence, or what `Confidence.of` makes one of."""


def counted_of(confidence: Confidence | None) -> NDArray[np.bool_] | None:
    """(T, V) which vertices count; None where all do."""
    return None if confidence is None else confidence.counted


def require_least(least: float) -> float:
    """The confidence from which on vertices count, from 0 to 1, or a ParameterError."""
    own = as_number(least, "the least confidence", least=0)
    if own > 1:
        raise ParameterError(f"the least confidence must be a number from 0 to 1, found {own:g}")
    return own


def require_some(confidence: Confidence, along: CurveVertices) -> None:
    """Raise a ParameterError where no vertex of any curve counts in any frame."""
    if not confidence.counted[:, along.indices].any():
        raise ParameterError(
            f"no vertex of any curve has a confidence of {confidence.least:g} or more in a frame, "
            "the first and the last, so there is nothing to compare; lower the least confidence, "
            "or capture these poses again"
        )


def coverage_facts(
    confidence: Confidence, along: CurveVertices, truth: MeshSequence
) -> dict[str, Any]:
    """What tables and files say of a mask, as JSON: shares of the vertices of curves that count.

    ``covered`` is the share in all frames between the ends, ``covered_moving`` that of the vertices
    that move, ``covered_by_frame`` that in each frame, and ``counted`` how many vertices of each
    curve count in each frame.
    """
    counts = confidence.counted[:, along.indices].astype(np.int64)
    return {
        "least": confidence.least,
        "covered": mean_covered(confidence.covered(along)),
        "covered_moving": _moving_covered(confidence, along, truth),
        "covered_by_frame": confidence.covered(along).tolist(),
        "counted": np.add.reduceat(counts, along.starts, axis=1).T.tolist(),
    }


def mean_covered(shares: NDArray[np.float64]) -> float:
    """The mean of shares over the frames between the ends, or over the ends where nothing is."""
    return float((shares[1:-1] if len(shares) > 2 else shares).mean())


def coverage_words(confidence: Confidence, along: CurveVertices, truth: MeshSequence) -> str:
    """How much of the vertices a mask covers, in a sentence."""
    shares = confidence.covered(along)
    text = f"{share_words(mean_covered(shares))} of the vertices count"
    moving = _moving_covered(confidence, along, truth)
    if moving is not None:
        text += f", {share_words(moving)} of those that move"
    if len(shares) > 2:
        worst = 1 + int(shares[1:-1].argmin())
        text += f", in the frames between the ends; {share_words(shares[worst])} in frame "
        text += truth.names[worst]
    return (
        f"{text}. They are those with a confidence of {confidence.least:g} or more there, in the "
        "first and in the last frame"
    )


def _moving_covered(
    confidence: Confidence, along: CurveVertices, truth: MeshSequence
) -> float | None:
    """The share that counts of the vertices that move by half a per cent of D; None where none."""
    away = np.zeros(len(along.indices))
    for frame in truth.frames:
        offsets = frame[along.indices] - truth.frames[0, along.indices]
        away = np.maximum(away, np.sqrt(np.einsum("ni,ni->n", offsets, offsets)))
    moving = along.indices[away > _MOVES * truth.mesh.diameter]
    if not len(moving):
        return None
    return mean_covered(np.asarray(confidence.counted[:, moving].mean(axis=1, dtype=np.float64)))


def share_words(share: float) -> str:
    """Such as "97.3 %"; 100 and 0 only where they are meant."""
    percent = 100 * share
    if 0 < share < 1:
        percent = min(max(percent, 0.1), 99.9)
    return f"{percent:.1f}{SPACE}%"


def _by_name(given: Mapping[str, ArrayLike], truth: MeshSequence) -> NDArray[np.float64]:
    rows = []
    for frame in truth.names:
        name = next((own for own in (frame, Path(frame).stem) if own in given), None)
        if name is None:
            raise ParameterError(
                f"it has no confidence for the frame {frame}, but for "
                f"{first_few(given, _NAMED) or 'none'}; give that of these frames, or let all "
                "vertices count with a least confidence of 0"
            )
        rows.append(_shares(as_numbers(given[name], f"the confidence of {name!r}"), name, truth))
    return np.stack(rows)


def _checked(values: NDArray[np.float64], truth: MeshSequence) -> NDArray[np.float64]:
    shape = (len(truth), len(truth.mesh.vertices))
    if values.shape != shape:
        raise ParameterError(
            "the confidence of a motion needs one number for each vertex in each frame, the shape "
            f"{shape}, found {values.shape}"
        )
    for name, row in zip(truth.names, values, strict=True):
        _shares(row, name, truth)
    return values


def _shares(values: NDArray[np.float64], name: str, truth: MeshSequence) -> NDArray[np.float64]:
    from elastomorph.io.npz.confidence import require_shares

    require_shares(values, name)
    if len(values) != len(truth.mesh.vertices):
        raise ParameterError(
            f"the confidence of {name!r} has {len(values):,} numbers, but the motion has "
            f"{len(truth.mesh.vertices):,} vertices; it belongs to other poses"
        )
    return values
