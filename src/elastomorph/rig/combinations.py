"""Every combination of blend weights on a grid: the paper's 6⁵ - 1 = 7775 faces (Sec. 5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError

__all__ = ["spread_rows", "weight_combinations"]

MOST = 10_000_000


def weight_combinations(expressions: int, levels: int = 6) -> NDArray[np.float64]:
    """All rows of weights from {0, 1/(L-1), …, 1} but the one of zeros.

    Args:
        expressions: J, number of expressions; the paper has 5.
        levels: L, number of values from 0 to 1; the paper has 6.

    Returns:
        (L^J - 1, J) float64, the last column changing fastest.

    Raises:
        ParameterError: J < 1, L < 2, or more than ten million rows.
    """
    if expressions < 1 or levels < 2:
        raise ParameterError(
            "combinations need at least 1 expression and 2 levels, found "
            f"{expressions} and {levels}"
        )
    if levels**expressions > MOST:
        raise ParameterError(
            f"{levels} levels of {expressions} expressions are {levels**expressions:,} faces, more "
            f"than {MOST:,}; name fewer expressions or fewer levels"
        )
    steps = np.indices((levels,) * expressions).reshape(expressions, -1).T[1:]
    return np.asarray(steps / (levels - 1.0))


def spread_rows(total: int, count: int) -> NDArray[np.int64]:
    """(min(count, total),) rows spread evenly over all, the first and the last among them."""
    return np.unique(np.linspace(0, total - 1, min(count, total)).round().astype(np.int64))
