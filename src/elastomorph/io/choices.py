"""Why `auto` chose a path, as JSON: kept beside every path that is stored."""

from __future__ import annotations

import math
from typing import Any

from elastomorph.errors import ParameterError
from elastomorph.model.morph import Choice

__all__ = ["choice_from_json", "choice_to_json"]


def choice_to_json(choice: Choice | None) -> dict[str, Any] | None:
    """A choice as JSON, with what follows from it for those who only read; None of none."""
    if choice is None:
        return None
    return {
        "distance": float(choice.distance),
        "allowed": float(choice.allowed),
        "exact": choice.exact,
        "straight": choice.straight,
    }


def choice_from_json(content: Any) -> Choice | None:
    """The choice in a file; None where nothing is said."""
    if content is None:
        return None
    try:
        distance, allowed = float(content["distance"]), float(content["allowed"])
        exact = content["exact"]
    except (TypeError, LookupError, ValueError, OverflowError):
        exact = None
    if not isinstance(exact, bool) or not all(
        math.isfinite(number) and number >= 0 for number in (distance, allowed)
    ):
        raise ParameterError("the choice of a path is damaged")
    return Choice(distance, allowed, exact)
