"""The directive ``verbs``: what every verb of the command line says about itself, as it says it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from typer.core import TyperGroup
from typer.main import get_command
from typer.testing import CliRunner

from elastomorph.cli import app


class Verbs(SphinxDirective):
    """A section for each verb, with its ``--help`` word for word."""

    def run(self) -> list[nodes.Node]:
        """One section for the program and one for each verb, those in groups included."""
        self.env.note_reread()  # the texts are in the code, not in the page
        return [self._section(words) for words in [(), *_verbs(get_command(app))]]

    def _section(self, words: tuple[str, ...]) -> nodes.section:
        title = " ".join(("elastomorph", *words))
        section = nodes.section(ids=["-".join(("elastomorph", *words))], names=[title])
        section += nodes.title(text=title)
        text = _help(words)
        section += nodes.literal_block(text, text, language="text")
        return section


def _verbs(group: object, before: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    if not isinstance(group, TyperGroup):
        return
    for name, command in group.commands.items():
        if isinstance(command, TyperGroup):
            yield from _verbs(command, (*before, name))
        else:
            yield (*before, name)


def _help(words: tuple[str, ...]) -> str:
    with _width_of_a_page():
        done = CliRunner().invoke(app, [*words, "--help"], prog_name="elastomorph")
    if done.exit_code:
        raise RuntimeError(f"{' '.join(words)} --help ended with {done.exit_code}: {done.output}")
    return done.output.strip("\n")


@contextmanager
def _width_of_a_page() -> Iterator[None]:
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = "80"
    try:
        yield
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before


def setup(site: Sphinx) -> dict[str, bool]:
    """Add the directive.

    Args:
        site: What is being built.
    """
    site.add_directive("verbs", Verbs)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
