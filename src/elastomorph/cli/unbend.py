"""``elastomorph unbend``: the original of a bent character."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastomorph.cli.output import Say, print_facts
from elastomorph.cli.verb import Answer, verb


@verb
def unbend(
    character: Annotated[
        Path, typer.Argument(metavar="CHARACTER", help="A file that 'elastomorph bend' wrote.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="The original, of the same format.")
    ],
    *,
    say: Say,
) -> Answer:
    """Take the bends out of a character again, which gives the original back.

    Example: elastomorph unbend character.bent.glb -o character.glb
    """
    from elastomorph.bending import unbend as unbent

    say(f"reading {character}")
    unbent(character, output)
    facts = {"written": str(output), "bytes": output.stat().st_size}
    return Answer(facts, lambda: print_facts(facts, 7))
