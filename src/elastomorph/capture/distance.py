"""A distance that is known on the subject, from which its true size follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capture.similarity import Similarity
from elastomorph.errors import CaptureError, ParameterError
from elastomorph.numbers import as_number

__all__ = ["Distance"]

_FORM = "expected two points that were clicked and how far they are apart: a,b=8.9"


@dataclass(frozen=True)
class Distance:
    """How far two clicked points are apart: landmarks, or marks of a ruler.

    Attributes:
        first: Name of a point.
        second: Name of the other.
        length: In the units that the poses are to have; above 0.
    """

    first: str
    second: str
    length: float

    @classmethod
    def of(cls, given: object) -> Distance:
        """From ``("a", "b", 8.9)`` or the text ``a,b=8.9``.

        Raises:
            ParameterError: It is neither.
        """
        if isinstance(given, str):
            names, _, number = given.rpartition("=")
            try:
                given = (*(name.strip() for name in names.split(",")), float(number))
            except ValueError:
                raise ParameterError(f"distance {given!r}: {_FORM}") from None
        if not (
            isinstance(given, tuple | list)
            and len(given) == 3
            and all(isinstance(name, str) and name for name in given[:2])
            and given[0] != given[1]
        ):
            raise ParameterError(f"distance {given!r}: {_FORM}")
        return cls(given[0], given[1], as_number(given[2], "the length of a distance", above=0.0))

    def require_clicked(
        self, clicks: Mapping[str, Mapping[str, tuple[float, float]]], file: str
    ) -> None:
        """Refuse points that no two photographs have.

        Args:
            clicks: Photograph → point → pixel.
            file: Of the landmarks, for the message.
        """
        for name in (self.first, self.second):
            count = sum(name in places for places in clicks.values())
            if count < 2:
                raise CaptureError(
                    f"{file}: {name}, from which a distance is known, is in {count} photographs of "
                    "the neutral; it is needed in two or more"
                )

    def applied(
        self, similarity: Similarity, points: Mapping[str, NDArray[np.float64]]
    ) -> Similarity:
        """A similarity that goes to the true size instead, about the middle of the points.

        Args:
            similarity: To any size.
            points: Point → (3,) before it.

        Raises:
            CaptureError: No two cameras that were found see one of the two.
        """
        for name in (self.first, self.second):
            if name not in points:
                raise CaptureError(
                    f"{name}, from which a distance is known, is clicked in fewer than two of the "
                    "photographs whose cameras were found; click it in others"
                )
        moved = {name: similarity(point) for name, point in points.items()}
        found = float(np.linalg.norm(moved[self.first] - moved[self.second]))
        if found <= 0:
            raise CaptureError(f"{self.first} and {self.second} are clicked at one place")
        factor = self.length / found
        middle = np.mean(list(moved.values()), axis=0)
        return similarity.then(Similarity(factor, np.eye(3), (1 - factor) * middle))
