"""A matplotlib figure with legible letters, written whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from elastomorph.draw.extras import imported
from elastomorph.errors import ParameterError
from elastomorph.io.atomic import replacing

__all__ = ["GRAPH_SUFFIXES", "new_figure"]

GRAPH_SUFFIXES = (".png", ".svg", ".pdf")
_SETTINGS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.5,
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e8",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "lines.dash_capstyle": "butt",
    "legend.frameon": False,
    "figure.constrained_layout.w_pad": 0.1,
    "figure.constrained_layout.h_pad": 0.1,
    "svg.fonttype": "none",  # words stay words: searched, copied, restyled
    "svg.hashsalt": "elastomorph",
}


@contextmanager
def new_figure(path: str | Path, width: float, height: float) -> Iterator[Any]:
    """A figure to draw in, written to ``path`` when the block ends without an error.

    No window, no state shared with other figures.

    Args:
        path: The suffix chooses the format, one of `GRAPH_SUFFIXES`.
        width: In inches.
        height: In inches.

    Raises:
        ParameterError: Another suffix.
        FileError: The file cannot be written.
        MissingExtraError: matplotlib is not installed.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in GRAPH_SUFFIXES:
        raise ParameterError(
            f"{path}: a graph is written as {', '.join(GRAPH_SUFFIXES)}, "
            f"found {suffix or 'no suffix'}"
        )
    with imported("matplotlib").rc_context(_SETTINGS):
        figure = imported("matplotlib.figure").Figure(figsize=(width, height), layout="constrained")
        yield figure
        # The date would make two runs differ that drew the same.
        dated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(suffix, {})
        with replacing(path) as file:
            figure.savefig(file, format=suffix[1:], dpi=150, metadata=dated)
