"""A distance on the subject as it is given with a command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from elastomorph.capturing.landmarks.landmarks import Distance
from elastomorph.errors import CaptureError, ParameterError
from elastomorph.numbers import as_number

_FORM = "expected two points that were clicked and how far they are apart: a,b=8.9"


def distance_of(given: object) -> Distance:
    """A distance from ``("a", "b", 8.9)`` or the text ``a,b=8.9``.

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
    return given[0], given[1], as_number(given[2], "the length of a distance", above=0.0)


def require_known(
    distance: Distance,
    clicks: Mapping[str, Mapping[str, tuple[float, float]]],
    photographs: Sequence[Path],
    file: str,
) -> None:
    """Refuse points that no two photographs have and that are no camera.

    Args:
        distance: Between them.
        clicks: Photograph → point → pixel.
        photographs: Whose cameras are points too, by the names of their files.
        file: Of the landmarks, for the message.
    """
    cameras = {path.name for path in photographs}
    for name in (own for own in distance[:2] if own not in cameras):
        count = sum(name in places for places in clicks.values())
        if count < 2:
            raise CaptureError(
                f"{file}: {name}, from which a distance is known, is in {count} photographs of the "
                "neutral; it is needed in two or more"
            )
