"""The words of a call, so that whoever reads its report can make it again."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import typer

__all__ = ["call_words"]

_FOLDERS = re.compile(r"[/\\]")


def call_words(context: typer.Context) -> str:
    """The command that is running, as it was given, with files by their names alone.

    A report is passed on; the folders of the machine it was made on are nobody's business.
    """
    words = ["elastomorph", context.info_name or ""]
    arguments: list[str] = []
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if source is None or source.name != "COMMANDLINE":
            continue
        value = context.params.get(parameter.name or "")
        if parameter.param_type_name == "argument":
            arguments.append(_name(value))
        elif isinstance(value, bool):
            names = parameter.opts if value else parameter.secondary_opts or parameter.opts
            words.append(_longest(names))
        else:
            for each in value if isinstance(value, list | tuple) else [value]:
                words += [_longest(parameter.opts), _name(each)]
    return shlex.join([*words[:2], *arguments, *words[2:]])


def _longest(names: list[str]) -> str:
    """The telling name of an option: ``--output``, not ``-o``."""
    return max(names, key=len)


def _name(value: object) -> str:
    text = str(value)
    if not _FOLDERS.search(text):
        return text
    return Path(text.replace("\\", "/")).name or text
