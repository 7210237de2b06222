"""All options of all methods in one list: for help, the command line and the documentation."""

from __future__ import annotations

from dataclasses import fields
from typing import NamedTuple

from elastomorph.paths.method import Method
from elastomorph.paths.options import options_of

__all__ = ["OptionRow", "option_rows", "option_table"]


class OptionRow(NamedTuple):
    """One option; in place of one that is a table, each of its parts.

    Attributes:
        name: Its name.
        kind: What a settings file holds for it, see `elastomorph.paths.options.Option`.
        means: What it is for.
        default: Its default as text; empty where it has none.
        methods: The names of the methods that have it.
    """

    name: str
    kind: str
    means: str
    default: str
    methods: tuple[str, ...]


def option_rows() -> list[OptionRow]:
    """The options of all methods, each once, in the order in which methods have them."""
    found: dict[str, OptionRow] = {}
    for method in Method.known:
        defaults = {own.name: own.default for own in fields(method)}
        for name, its in options_of(method).items():
            parts = {part: getattr(defaults[name], part) for part in its.parts}
            for own, default in (parts or {name: defaults[name]}).items():
                found[own] = OptionRow(
                    own,
                    "number" if its.parts else its.kind,
                    its.parts.get(own, its.means),
                    f"{default:g}" if isinstance(default, float) else str(default or ""),
                    Method.with_option(name),
                )
    return list(found.values())


def option_table() -> str:
    """The options of all methods as a table in Markdown."""
    lines = ["| option | what it says | default | of |", "|---|---|---|---|"]
    for row in option_rows():
        default = f"`{row.default}`" if row.default else ""
        methods = ", ".join(f"`{name}`" for name in row.methods)
        lines.append(f"| `{row.name}` | {row.means} | {default} | {methods} |")
    return "\n".join(lines) + "\n"
