"""One way of making graphs: legible letters, a style for each method, files whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from elastomorph.draw.pictures import imported
from elastomorph.errors import ParameterError
from elastomorph.io.atomic import replacing

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
def new_figure(path: str | Path, width: float, height: float, title: str = "") -> Iterator[Any]:
    """A figure to draw in, of this size in inches, written when the block ends without an error.

    No window, no state shared with other figures.
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
        if title:
            figure.suptitle(title, fontweight="bold", fontsize=13)
        # The date would make two runs differ that drew the same.
        dated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(suffix, {})
        with replacing(path) as file:
            figure.savefig(file, format=suffix[1:], dpi=150, metadata=dated)


def dress(axes: Any, title: str, across: str, up: str, *, whole_time: bool = False) -> None:
    """Give axes a title and their names; from 0 upwards, and from t = 0 to 1 where that is all."""
    axes.set_title(title)
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_ylim(bottom=0)
    if whole_time:
        axes.set_xlim(0, 1)


def legend(figure: Any, axes: Any) -> None:
    """Name the lines of these axes beside the graph, long enough to tell dashes apart."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", handlelength=3.4)


@dataclass(frozen=True)
class LineStyle:
    """How the line of a method is drawn; colours are told apart by the colour-blind.

    Dashes are lengths of dashes and gaps in line widths, none for a solid line; the width is in
    points; lines of a higher layer cover those of a lower.
    """

    colour: str
    dashes: tuple[float, ...] = ()
    width: float = 1.6
    layer: int = 3

    def of(self, label: str, slim: float = 1.0) -> dict[str, Any]:
        """Options of ``Axes.plot`` for a line with this label, slimmer by a factor."""
        return {
            "label": label,
            "color": self.colour,
            "dashes": self.dashes,
            "linewidth": self.width * slim,
            "zorder": self.layer,
        }


# Straight paths are broad and pale, beams narrow and dashed on top: where the two coincide, as
# linear and R = 1 do and ease and beam of one order nearly do, both are seen. So are rotation and
# auto, which takes it where it turns.
_KNOWN = {
    "linear": LineStyle("#b0b0b0", (), 4.5, 2),
    "beam R=1": LineStyle("#000000", (3.0, 2.5), 1.5, 4),
    "ease R=2": LineStyle("#8fcdf2", (), 4.5, 2),
    "beam R=2": LineStyle("#0060a8", (3.0, 2.5), 1.5, 4),
    "ease R=3": LineStyle("#f6c567", (), 4.5, 2),
    "beam R=3": LineStyle("#c44e00", (3.0, 2.5), 1.5, 4),
    "cosine": LineStyle("#009e73", (), 1.6, 3),
    "plate R=2": LineStyle("#6a3d9a", (1.2, 1.4), 1.8, 5),
    "arc": LineStyle("#b8860b", (), 1.6, 4),
    "rotation": LineStyle("#e6a3c8", (), 4.5, 3),
    "auto": LineStyle("#8c1d5b", (3.0, 2.5), 1.5, 5),
    "through 1": LineStyle("#66b266", (), 1.8, 5),
    "through 2": LineStyle("#116622", (), 1.8, 5),
}
_OTHERS = (
    LineStyle("#cc5f9a", (6.0, 2.0, 1.2, 2.0), 1.6, 5),
    LineStyle("#3b528b", (1.2, 1.4), 1.8, 5),
    LineStyle("#7a1f2b", (8.0, 2.0), 1.5, 5),
    LineStyle("#4d4d4d", (6.0, 1.5, 1.2, 1.5, 1.2, 1.5), 1.5, 5),
    LineStyle("#8a6d00", (2.0, 1.0), 1.5, 5),
)


def styles_for(labels: Sequence[str]) -> dict[str, LineStyle]:
    """The style of each method; those not well known take further ones in their order."""
    others = [label for label in labels if label not in _KNOWN]
    return {
        label: _KNOWN[label] if label in _KNOWN else _OTHERS[others.index(label) % len(_OTHERS)]
        for label in labels
    }
