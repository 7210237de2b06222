"""The section a rigger reads first: which way each target needs, and what that costs."""

from __future__ import annotations

from collections.abc import Sequence

from elastomorph.evaluation.target_paths import TargetPath, TargetPaths
from elastomorph.paths.auto import INBETWEEN_PAYS
from elastomorph.report.about import SPACE, significant
from elastomorph.report.compared import counted
from elastomorph.report.document import Section
from elastomorph.report.error_table import scrolling
from elastomorph.report.markup import Markup, element, joined

__all__ = ["targets_section"]

_TITLES = (
    "Target",
    "What it needs",
    "Off straight, % of D",
    "More morph targets",
    "Bytes they add",
    "Stored within, % of D",
)


def targets_section(paths: TargetPaths, unit: str = "") -> Section:
    """Every target of a rig: what it needs, those that need more than a straight line first.

    Args:
        paths: What ``auto`` chose for each.
        unit: Unit of the coordinates, or an empty string.
    """
    allowed = max((target.choice.allowed for target in paths.targets), default=0.0)
    bent = [target for target in paths.targets if not target.choice.straight]
    straight = [target for target in paths.targets if target.choice.straight]
    content: list[object] = [
        element("p", paths.summary, class_="headline"),
        element(
            "p",
            "This is what the method auto does. It compares the straight line with the path of "
            "least distortion, on which parts that turn are turned (rotation): where the two part "
            f"by no more than {_plain(allowed)} halfway, the straight line is enough and costs "
            f"nothing. Beyond {_plain(INBETWEEN_PAYS)}, or where polygons turn over on the way, "
            "only a scanned or sculpted in-between can say which way is right. D is the size of "
            f"what the targets move, {significant(paths.extent)}{SPACE}{unit or 'units'}. Bytes "
            "are those of a file that stores an index and an offset for each moved vertex.",
        ),
    ]
    if bent:
        content.append(_table(bent, "Targets that need more than a straight line"))
    if straight:
        words = f"{counted(len(straight), 'target')} for which the straight line is enough"
        content.append(element("details", element("summary", words), _table(straight, words)))
    return Section("targets", "What each target needs", joined(content))


def _plain(fraction: float) -> str:
    return f"{100 * fraction:g}{SPACE}% of D"


def _table(targets: Sequence[TargetPath], caption: str) -> Markup:
    heads = [
        element("th", title, scope="col", class_="name" if not number else None)
        for number, title in enumerate(_TITLES)
    ]
    table = element(
        "table",
        element("caption", caption, class_="unseen"),
        element("thead", element("tr", *heads)),
        element("tbody", *(_row(target) for target in targets)),
        class_="targets",
    )
    return scrolling(table, caption)


def _row(target: TargetPath) -> Markup:
    choice = target.choice
    bound = "" if choice.exact else f"≤{SPACE}"
    words: list[object] = [target.words]
    if target.inbetween_pays:
        words = [element("b", target.words)]
    if target.flips:
        words.append(f" ({counted(target.flips, 'polygon')} turned over)")
    cells = [
        element("td", *words),
        element("td", f"{bound}{100 * choice.distance:.3f}"),
        element("td", str(target.bends) if target.bends else "none"),
        element("td", f"{target.bytes:,}" if target.bends else "none"),
        element("td", f"{100 * target.bake_error:.4f}" if target.bake_error else "exact"),
    ]
    return element("tr", element("th", target.name, scope="row", class_="name"), *cells)
