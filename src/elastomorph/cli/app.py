"""All verbs together, and how an error reaches the user."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from inspect import cleandoc
from itertools import pairwise
from typing import Any, NoReturn

import typer

from elastomorph.cli import completion
from elastomorph.cli.animate import animate
from elastomorph.cli.bench import bench
from elastomorph.cli.blend import blend
from elastomorph.cli.curves import curves
from elastomorph.cli.demo import demo
from elastomorph.cli.doctor import doctor
from elastomorph.cli.evaluate import evaluate
from elastomorph.cli.export import export
from elastomorph.cli.fit import fit
from elastomorph.cli.inbetweens import suggest
from elastomorph.cli.init import init
from elastomorph.cli.inspect import inspect
from elastomorph.cli.interpolate import interpolate
from elastomorph.cli.render import render
from elastomorph.cli.verb import keeping_inputs
from elastomorph.cli.view import view
from elastomorph.errors import ElastomorphError

__all__ = ["app", "main"]

app = typer.Typer(
    name="elastomorph",
    help="Nonlinear blendshapes that run anywhere linear ones do.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _add(verb: Callable[..., Any], verbs: typer.Typer) -> None:
    """Every verb keeps its inputs; examples stay on lines of their own; short help is uncut."""
    text = cleandoc(verb.__doc__ or "")
    verbs.command(
        help=re.sub(r"^(Examples?:)\s*", "\b\n\\1\n  ", text, flags=re.MULTILINE),
        short_help=re.split(r"[:;]|\.$", text.partition("\n")[0])[0] + ".",
    )(keeping_inputs(verb))


for each in (
    *(demo, init, inspect, doctor, curves, interpolate, evaluate, fit),
    *(blend, export, animate, render, view, bench),
):
    _add(each, app)
_inbetweens = typer.Typer(
    help="In-betweens: shapes a path passes through.", no_args_is_help=True, rich_markup_mode=None
)
_add(suggest, _inbetweens)
app.add_typer(_inbetweens, name="inbetweens")


@app.callback(invoke_without_command=True)
def _options(
    version: bool = typer.Option(False, "--version", help="Print the version and exit."),
) -> None:
    if version:
        from importlib.metadata import version as installed

        typer.echo(installed("elastomorph"))
        raise typer.Exit


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error is one sentence and a status that is not 0.

    Args:
        arguments: Words after the program's name; those of the process by default.
    """
    _require_streams()
    if arguments is None:
        signal.signal(signal.SIGTERM, _stop)
    words = sys.argv[1:] if arguments is None else arguments
    # Text may be empty where it is a caption; nothing else means anything then.
    if any(not word and before != "--unit" for before, word in pairwise(["", *words])):
        _fail("an argument is empty: name what is meant, or leave it out")
    try:
        try:
            if completion.asked():
                completion.answered(app)
            else:
                app(arguments)
        finally:
            sys.stdout.flush()
    except ElastomorphError as error:
        _fail(str(error))
    except KeyboardInterrupt:
        _fail("interrupted", 130, kind="")
    except BrokenPipeError:  # whoever read our output has seen enough
        _drop_output()
        sys.exit(141)
    except MemoryError:
        _fail("there is not enough memory for this; try fewer or smaller files at a time")
    except OSError as error:
        _drop_output()
        _fail(f"{error.filename or 'the output'}: {error.strerror or error}")


def _require_streams() -> None:
    """Open what was closed, as for a service, so that no file written takes its number."""
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_RDWR)
            mode = "r" if name == "stdin" else "w"
            setattr(sys, name, os.fdopen(nowhere, mode, encoding="utf-8", closefd=False))


def _stop(number: int, frame: object) -> None:
    """End as on an interrupt, so that nothing half done is left behind."""
    sys.exit(128 + number)


def _fail(problem: str, status: int = 1, kind: str = "error: ") -> NoReturn:
    sys.stderr.write(f"{kind}{problem}\n")
    sys.exit(status)


def _drop_output() -> None:
    """Keep Python from writing, at its very end, what could not be written before."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
