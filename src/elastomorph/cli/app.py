"""All verbs together, and how an error reaches the user."""

from __future__ import annotations

import sys

import typer

from elastomorph.cli import (
    animate,
    bench,
    blend,
    curves,
    demo,
    evaluate,
    export,
    fit,
    inbetweens,
    inspect,
    interpolate,
)
from elastomorph.errors import ElastomorphError

__all__ = ["app", "main"]

app = typer.Typer(
    name="elastomorph",
    help="Nonlinear blendshapes that run anywhere linear ones do.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for verb in (
    demo,
    inspect,
    curves,
    interpolate,
    evaluate,
    inbetweens,
    fit,
    blend,
    export,
    animate,
    bench,
):
    verb.add_to(app)


@app.callback(invoke_without_command=True)
def _options(
    version: bool = typer.Option(False, "--version", help="Print the version and exit."),
) -> None:
    if version:
        from importlib.metadata import version as installed

        typer.echo(installed("elastomorph"))
        raise typer.Exit


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error of ours is one sentence and exit status 1.

    Args:
        arguments: Words after the program's name; those of the process by default.
    """
    try:
        app(arguments)
    except ElastomorphError as error:
        sys.stderr.write(f"error: {error}\n")
        sys.exit(1)
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        sys.exit(130)
