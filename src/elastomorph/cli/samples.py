"""``elastomorph samples``: the files that the documentation speaks of."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastomorph.cli.output import Say
from elastomorph.cli.verb import Answer, verb


@verb
def samples(
    output: Annotated[
        Path, typer.Option("--output", "-o", help="A folder, made where it is missing.")
    ] = Path("samples"),
    *,
    say: Say,
) -> Answer:
    """Write files of the built-in head to try things with: those that the documentation names.

    Example: elastomorph samples -o try && cd try
    """
    from elastomorph.io.sample_files import write_samples

    say("writing samples")
    names = [str(path) for path in write_samples(output)]
    return Answer({"files": names}, lambda: typer.echo("\n".join(names)))
