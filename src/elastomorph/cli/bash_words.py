"""Bash breaks words at ``=`` and ``:``: before it is answered they are put together again.

It hands over ``jawOpen``, ``=`` and ``0.5,sm`` where ``jawOpen=0.5,sm`` is typed, and what it is
answered takes the place of the last piece alone.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO

__all__ = ["answered", "asked", "joined"]

_BREAKS = frozenset("=:")


def asked() -> bool:
    """Whether bash asks what the tab key should offer, with its words one a line."""
    return (
        os.environ.get("_ELASTOMORPH_COMPLETE") == "complete_bash"
        and "\n" in os.environ.get("COMP_WORDS", "")
        and os.environ.get("COMP_CWORD", "").isdigit()
    )


def answered(program: Callable[[], object]) -> None:
    """Answer bash, as if its words had not been broken.

    Args:
        program: Prints what is offered for the words in the environment, a line each.
    """
    pieces = os.environ["COMP_WORDS"].split("\n")[: int(os.environ["COMP_CWORD"]) + 1]
    words, there = joined(pieces)
    os.environ |= {"COMP_WORDS": "\n".join(words), "COMP_CWORD": str(len(words) - 1)}
    offered = StringIO()
    try:
        with redirect_stdout(offered):
            program()
    finally:
        for line in offered.getvalue().splitlines():
            sys.stdout.write(line.removeprefix(there) + "\n")


def joined(pieces: list[str]) -> tuple[list[str], str]:
    """The words that pieces were broken from, and what stands before the last piece in its word.

    A value behind ``--option=`` is completed by itself, so the option is not part of what stands
    before.
    """
    words: list[str] = []
    there = ""
    for piece in pieces:
        breaks = bool(piece) and _BREAKS.issuperset(piece)
        if words and (breaks or words[-1][-1:] in _BREAKS) and not piece.startswith("-"):
            there = words[-1] + (piece if breaks else "")
            words[-1] += piece
        else:
            words.append(piece)
            there = ""
    if there.startswith("--"):
        there = there.partition("=")[2]
    return words, there
