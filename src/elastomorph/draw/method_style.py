"""One colour and one kind of line for each method, the same in every graph."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["LineStyle", "styles_for"]


@dataclass(frozen=True)
class LineStyle:
    """How the line of a method is drawn.

    Attributes:
        colour: As #rrggbb, told apart by the colour-blind.
        dashes: Lengths of dashes and gaps in line widths; empty for a solid line.
        width: In points.
        layer: Lines of a higher layer cover those of a lower.
    """

    colour: str
    dashes: tuple[float, ...] = ()
    width: float = 1.6
    layer: int = 3


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
    """The style of each method.

    Args:
        labels: Labels of methods. Well-known ones look alike in all graphs; any others take
            further styles in their order.
    """
    others = [label for label in labels if label not in _KNOWN]
    return {
        label: _KNOWN[label] if label in _KNOWN else _OTHERS[others.index(label) % len(_OTHERS)]
        for label in labels
    }
