"""All verbs together, and how an error reaches the user."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from inspect import cleandoc
from itertools import pairwise
from pathlib import Path
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from elastomorph.errors import ElastomorphError

VERBS = {
    "demo": "Show on a face what each target needs, how every method does, and the paper's "
    "pictures.",
    "init": "Look at a folder and write elastomorph.toml.",
    "capture": "Make poses of one topology from photographs.",
    "inspect": "Say what a file holds and how it was made.",
    "doctor": "Examine the files of a rig.",
    "curves": "Find curves along edge loops.",
    "interpolate": "Interpolate between two known shapes, by any method.",
    "evaluate": "Judge methods by recorded frames.",
    "learn": "Learn the path of a recorded movement.",
    "blend": "Blend expressions.",
    "bend": "Bend the paths of a character in its own file.",
    "hold": "Add correctives where several shapes add up: lids and lips that pass, folds.",
    "unbend": "Take the bends out of a character again.",
    "export": "Write a rig for other programs.",
    "animate": "Play a recorded performance on a rig.",
    "track": "Solve a rig to a take of markers, or of meshes of another topology.",
    "farm": "Make a data set of faces.",
    "render": "Draw a face.",
    "view": "Look at a rig, or compare several, in the browser.",
    "live": "Show the face of a phone on a rig, as it moves, in the browser.",
    "landmarks": "Place the points of a face in photographs and on meshes, in the browser.",
    "register": "Register scans of any topology.",
    "bench": "Time the paper's experiment.",
    "samples": "Write files of the built-in head to try things with.",
}
"""Each verb, a function in the file of its name, and what it is for: the start of its own words."""

HEADINGS = {
    "Characters": "init doctor inspect bend hold unbend export animate track",
    "Heads and poses": "interpolate blend samples",
    "Capture": "capture landmarks register",
    "Measure": "evaluate inbetweens learn curves bench",
    "Look": "demo view render live",
    "Data sets": "farm",
}
"""Verbs as `--help` lists them."""

_INBETWEENS = {"suggest": "Find the recorded frames that pay most as in-betweens."}


class _Verbs(TyperGroup):
    """Imports a verb when it is called, so that no verb waits for the options of all others."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, command, rest = super().resolve_command(ctx, args)
        if name is not None and not isinstance(command, TyperGroup):
            command = _command(name)
        return name, command, rest

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write verbs under headings, each with what it is for."""
        own = {"Commands": " ".join(self.list_commands(ctx))}
        for heading, verbs in (own if ctx.parent else HEADINGS).items():
            found = [(name, self.get_command(ctx, name)) for name in verbs.split()]
            with formatter.section(heading):
                wide = formatter.width - 6 - max(len(name) for name, _ in found)
                formatter.write_dl(
                    [(name, verb.get_short_help_str(wide)) for name, verb in found if verb]
                )


def loaded(name: str) -> Callable[..., Any]:
    """The function of a verb."""
    file = "inbetweens" if name in _INBETWEENS else name
    return getattr(import_module(f"elastomorph.cli.{file}"), name)  # type: ignore[no-any-return]


def _command(name: str) -> Any:
    """A verb with its options; examples stay on lines of their own."""
    from elastomorph.cli.verb import Verb, VerbWithOptions

    verb = loaded(name)
    words = re.sub(
        r"^(Examples?:)\s*", "\b\n\\1\n  ", cleandoc(verb.__doc__ or ""), flags=re.MULTILINE
    )
    alone = typer.Typer(add_completion=False, rich_markup_mode=None)
    kind = VerbWithOptions if name == "interpolate" else Verb
    alone.command(name, cls=kind, help=words)(verb)
    return typer.main.get_command(alone)


def _group(verbs: dict[str, str], **options: Any) -> typer.Typer:
    group = typer.Typer(
        cls=_Verbs,
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        **options,
    )
    for name, text in verbs.items():
        group.command(name, short_help=text)(lambda: None)  # its place is taken by `_command`
    return group


app = _group(
    VERBS, name="elastomorph", help="Nonlinear blendshapes that run anywhere linear ones do."
)
app.add_typer(
    _group(_INBETWEENS, help="In-betweens: shapes a path passes through."), name="inbetweens"
)


@app.callback(invoke_without_command=True)
def _options(
    context: typer.Context,
    version: bool = typer.Option(False, "--version", help="Print the version and exit."),
    root: Path | None = typer.Option(  # noqa: B008
        None, exists=True, file_okay=False, help="Folder in which all files of a USD stage lie."
    ),
) -> None:
    before = os.environ.copy()  # settings may name that folder too, see `options.settings_of`
    context.call_on_close(lambda: _restore(before))
    if root is not None:
        from elastomorph.io.usd.library import ROOT_VARIABLE

        os.environ[ROOT_VARIABLE] = str(root.absolute())
    if version:
        from importlib.metadata import version as installed

        typer.echo(installed("elastomorph"))
        raise typer.Exit


def _restore(environment: dict[str, str]) -> None:
    """Take back what a call has set, for programs that call `main` more than once."""
    for name in {*os.environ} - {*environment}:
        del os.environ[name]
    os.environ.update(environment)


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error is one sentence and a status that is not 0.

    Args:
        arguments: Words after the program's name; those of the process by default.
    """
    _require_streams()
    if arguments is None:
        signal.signal(signal.SIGTERM, _stop)
        # A terminal that is closed; nohup has it ignored, and Windows has none.
        closed = getattr(signal, "SIGHUP", None)
        if closed is not None and signal.getsignal(closed) is signal.SIG_DFL:
            signal.signal(closed, _stop)
    words = sys.argv[1:] if arguments is None else arguments
    # Text may be empty where it is a caption; nothing else means anything then.
    if any(not word and before != "--unit" for before, word in pairwise(["", *words])):
        _fail("an argument is empty: name what is meant, or leave it out")
    try:
        try:
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
