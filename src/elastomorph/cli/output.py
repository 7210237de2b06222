"""What verbs print: the steps of a long run, facts line by line, tables, and their own call."""

from __future__ import annotations

import json
import re
import shlex
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from elastomorph.errors import ElastomorphWarning

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

Say = Callable[[str], None]
"""Told what is being done."""

_COUNTED = re.compile(r"\b\d+ of \d+$")
_GAP = 4.0
"""Seconds between two counted steps."""
_MINUTE = 60.0


@contextmanager
def _warned(console: Console) -> Iterator[None]:
    """Warnings follow at the end, each once, as plain sentences."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ElastomorphWarning)
        yield
    for message in dict.fromkeys(str(warning.message) for warning in caught):
        console.print(f"warning: {message}", markup=False, highlight=False, soft_wrap=True)


@contextmanager
def progress(quiet: bool = False) -> Iterator[Say]:
    """A line on the terminal that says what is going on; then warnings.

    Where there is no terminal, in a pipe or a log, a line a minute.
    """
    from rich.console import Console

    console = Console(stderr=True)
    with _warned(console):
        if quiet:
            yield lambda _: None
        elif not console.is_terminal:
            yield _now_and_then(console)
        else:
            with console.status("working …") as status:
                yield lambda text: status.update(f"{text} …")


def _now_and_then(console: Console) -> Say:
    start = told = time.monotonic()

    def say(text: str) -> None:
        nonlocal told
        now = time.monotonic()
        if now >= told + _MINUTE:
            told = now
            line = f"{(now - start) / 60:4.0f} min  {text}"
            console.print(line, markup=False, highlight=False, soft_wrap=True)

    return say


@contextmanager
def steps(quiet: bool = False) -> Iterator[Say]:
    """Prints each step with the seconds since the start, on standard error; then warnings.

    Of steps that count, as in "3 of 57", only one every few seconds is printed.
    """
    from rich.console import Console

    console = Console(stderr=True)
    start = time.perf_counter()
    counted_at = -_GAP

    def say(step: str) -> None:
        nonlocal counted_at
        now = time.perf_counter() - start
        if quiet:
            return
        if _COUNTED.search(step):
            if now < counted_at + _GAP:
                return
            counted_at = now
        console.print(f"{now:6.1f} s  {step}", markup=False, highlight=False, soft_wrap=True)

    with _warned(console):
        yield say


def print_json(value: Any) -> None:
    """One JSON document on standard output."""
    typer.echo(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


def print_facts(facts: Mapping[str, Any], width: int) -> None:
    """A line for each fact, its name to the left in this width; lists with commas."""
    for name, value in facts.items():
        text = f"{value:,}" if isinstance(value, int) else value
        typer.echo(f"{name:>{width}}  {', '.join(text) if isinstance(text, list | dict) else text}")


def plain_table(words: Sequence[str], columns: Sequence[str], **options: Any) -> Table:
    """An empty table with these columns: those of words to the left, of numbers to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, pad_edge=False, **options)
    for column in columns:
        table.add_column(column, justify="left" if column in words else "right", no_wrap=True)
    return table


def times_smaller(before: float, after: float) -> str:
    """How many times smaller an error became, for a table."""
    if before > 1000 * after:  # what is left is rounding, or nothing
        return "> 1000" if before > 0 else ""
    return f"{before / after:.2f}" if after > 0 else ""


def given_parameters(context: typer.Context) -> list[Any]:
    """What was given on the command line, without what has its default."""
    sources = {own: context.get_parameter_source(own.name or "") for own in context.command.params}
    return [own for own, source in sources.items() if source and source.name == "COMMANDLINE"]


def command_line(context: typer.Context) -> str:
    """The command that is running, as it was given, with files by their names alone.

    A report is passed on; the folders of the machine it was made on are nobody's business.
    """
    words = ["elastomorph", context.info_name or ""]
    arguments: list[str] = []
    for parameter in given_parameters(context):
        value = context.params.get(parameter.name or "")
        # The telling name of an option is the longest: ``--output``, not ``-o``.
        if parameter.param_type_name == "argument":
            several = value if isinstance(value, list | tuple) else [value]
            arguments += map(_without_folder, several)
        elif isinstance(value, bool):
            names = parameter.opts if value else parameter.secondary_opts or parameter.opts
            words.append(max(names, key=len))
        else:
            for each in value if isinstance(value, list | tuple) else [value]:
                words += [max(parameter.opts, key=len), _without_folder(each)]
    return shlex.join([*words[:2], *arguments, *words[2:]])


def _without_folder(value: object) -> str:
    text = str(value)
    return Path(text.replace("\\", "/")).name or text if re.search(r"[/\\]", text) else text
