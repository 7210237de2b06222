"""What the command line says of methods: made of their fields, and only for a verb that is asked.

Methods compute, so their classes need NumPy, which help and mistyped words must not wait for.
"""

from __future__ import annotations

import inspect
from typing import Annotated, Any

import typer
from typer.core import TyperCommand
from typer.main import get_command

__all__ = ["Verb", "VerbWithOptions"]

_KINDS = {"number": float, "whole": int}


class Verb(TyperCommand):
    """A verb whose help names all methods where it says ``{methods}``."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        for parameter in self.params:
            text = getattr(parameter, "help", None) or ""
            if "{methods}" in text:
                parameter.help = text.replace("{methods}", _patterns())  # type: ignore[attr-defined]
        super().format_help(ctx, formatter)


class VerbWithOptions(Verb):
    """A verb that has every option of every method; it finds them as ``context.obj``."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Its own parameters, and an option for each of a method."""
        own = super().get_params(ctx)
        behind = 1 + [parameter.name for parameter in own].index("method")
        return [*own[:behind], *_options(), *own[behind:]]

    def invoke(self, ctx: Any) -> Any:
        """Run the verb."""
        ctx.obj = {option.name: ctx.params.pop(option.name) for option in _options()}
        return super().invoke(ctx)


def _patterns() -> str:
    from elastomorph.paths import Method

    patterns = [kind.pattern() for kind in Method.known]
    return f"{', '.join(patterns[:-1])} or {patterns[-1]}"


def _options() -> list[Any]:
    """An option of the command line for each option of a method."""
    from elastomorph.paths import Method
    from elastomorph.paths.options import option_rows

    def verb(**_: object) -> None:
        pass

    parameters = []
    for row in option_rows(Method.known):
        default = f"; {row.default} by default" if row.default else ""
        means = f"{row.means[0].upper()}{row.means[1:]}{default}. For {', '.join(row.methods)}."
        kind: Any = Annotated[_KINDS.get(row.kind, str) | None, typer.Option(help=means)]
        parameter = inspect.Parameter(row.name, inspect.Parameter.KEYWORD_ONLY, default=None)
        parameters.append(parameter.replace(annotation=kind))
    verb.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    verb.__annotations__ = {each.name: each.annotation for each in parameters}
    app = typer.Typer(add_completion=False)
    app.command()(verb)
    return list(get_command(app).params)
