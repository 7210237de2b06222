"""Which targets are the left and the right of one expression, by their names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from elastomorph.errors import ParameterError

__all__ = ["SIDES", "parse_sides", "sided_pairs"]

SIDES: tuple[tuple[str, str], ...] = (
    ("_L", "_R"),
    ("_l", "_r"),
    (".L", ".R"),
    (".l", ".r"),
    ("Left", "Right"),
    ("_left", "_right"),
    ("_lf", "_rt"),
    ("L_", "R_"),
    ("l_", "r_"),
    ("left_", "right_"),
)
"""Endings and beginnings that tell sides; those that end in an underscore are beginnings."""


def parse_sides(text: str) -> tuple[tuple[str, str], ...]:
    """Sides from text such as ``_lft=_rgt,lf_=rt_``.

    Raises:
        ParameterError: A part is not two different words around one equals sign.
    """
    sides = []
    for part in text.split(","):
        left, _, right = (word.strip() for word in part.partition("="))
        if not left or not right or left == right or "=" in right:
            raise ParameterError(f"--pairs {part!r}: expected left=right, such as _lft=_rgt")
        sides.append((left, right))
    return tuple(sides)


def sided_pairs(
    names: Iterable[str], sides: Sequence[tuple[str, str]] = SIDES
) -> tuple[list[tuple[str, str]], list[str]]:
    """The pairs among names, and the names whose other side is missing.

    Args:
        names: Names of targets.
        sides: Left and right endings, or beginnings where both end in an underscore.

    Returns:
        Pairs (left, right), and names that say a side without an other one. A name that ends in
        a side only by chance, as "cleft" does, is not counted among them.
    """
    known = list(dict.fromkeys(names))
    every = set(known)
    pairs: dict[str, tuple[str, str]] = {}
    alone = []
    for name in known:
        others = [(other, is_left) for other, is_left in _others(name, sides)]
        partner = next(((o, left) for o, left in others if o in every), None)
        if partner is not None:
            pair = (name, partner[0]) if partner[1] else (partner[0], name)
            pairs[pair[0]] = pair
        elif others:
            alone.append(name)
    return list(pairs.values()), alone


def _others(name: str, sides: Sequence[tuple[str, str]]) -> list[tuple[str, bool]]:
    """What the other side may be called, and whether this one is the left."""
    found = []
    for pair in sides:
        beginning = all(word.endswith("_") for word in pair)
        for mine, other, is_left in ((*pair, True), (*pair[::-1], False)):
            if len(name) <= len(mine):
                continue
            if beginning and name.startswith(mine):
                found.append((other + name[len(mine) :], is_left))
            elif not beginning and name.endswith(mine):
                found.append((name[: -len(mine)] + other, is_left))
    return found
