"""How a verb runs: its outputs are looked at, it works, and what it found is printed.

Methods compute, so their classes need NumPy, which help and mistyped words must not wait for: what
the command line says of them is made of their fields, and only for a verb that is asked.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer
from typer.core import TyperCommand
from typer.main import get_command

from elastomorph.cli.output import print_json, progress
from elastomorph.errors import ElastomorphError, FileError, MissingExtraError, ParameterError

_OUTPUTS = ("output", "picture", "sheet", "grid", "report", "repair_to", "record")
"""The parameters of verbs that name what is written."""
_DRAWN = {".png", ".jpg", ".jpeg", ".webp", ".gif", ".mp4"}
_FILES = {
    *_DRAWN,
    *(".obj", ".ply", ".npz", ".npy", ".mdd", ".pc2", ".glb", ".vrm"),
    *(".usd", ".usda", ".usdc", ".usdz"),
    *(".csv", ".json", ".toml", ".html", ".svg", ".pdf"),
}
"""Suffixes of what is a file and no folder, whatever verb writes it."""
_PICTURES = ("picture", "sheet", "grid")
_DRAWING = (("vtkmodules", "vtk", "demo"), ("PIL", "pillow", "demo"))
_COMPRESSION = ("meshopt", "meshopt", "gltf")
_GRAPHS = ("matplotlib", "matplotlib", "demo")
STATUS_OF_ERRORS = {"doctor": 2}
"""Exit status of a verb on an error, where it is not 1."""
_GONE = {
    "--dashboard": "start Dask yourself with the dashboard you want, and give --scheduler its "
    "address",
    "--prices": "--dry-run says bytes and time; multiply them by your prices",
}
"""What to use in place of options that there were once."""
_KINDS = {"number": float, "whole": int}

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]
_Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Let an output take the place of an input.")
]


@dataclass(frozen=True)
class Answer:
    """What a verb found: a JSON document for machines, and a function that prints it for people."""

    facts: Any
    tell: Callable[[], object]
    status: int = 0


def verb(function: Callable[..., Answer | None]) -> Callable[..., None]:
    """The verb that a function of the command line is.

    One with the parameter ``say`` is told where to say what it does, and answers: it has the option
    ``--json``. One that writes refuses to write over what it reads, unless ``--overwrite`` says so.
    A parameter that is a dataclass stands for options of its fields, which verbs may share.
    """
    signature = inspect.signature(function)
    hints = get_type_hints(function, include_extras=True)
    groups: dict[str, Any] = {
        name: hint for name, hint in hints.items() if name != "return" and is_dataclass(hint)
    }
    own = _flat(signature.parameters.values(), hints, groups)
    writes = any(each.name in _OUTPUTS for each in own)
    answers = "say" in signature.parameters

    @wraps(function)
    def run(*, overwrite: bool = False, **given: Any) -> None:
        if writes:
            _require_packages(given, function.__name__)
        if writes:
            _require_places(given)
        if writes and not overwrite:
            _require_apart(given)
        with _inputs_kept() if writes and not overwrite else nullcontext():
            as_json = given.pop("as_json") if answers else False
            for name, kind in groups.items():
                given[name] = kind(**{each.name: given.pop(each.name) for each in fields(kind)})
            if not answers:
                function(**given)
                return
            try:
                with progress(as_json) as say:
                    answer = function(**given, say=say)
            except KeyboardInterrupt as interrupt:  # typer would end without a word
                sys.stderr.write(f"{interrupt or 'interrupted'}\n")
                raise typer.Exit(130) from None
            except ElastomorphError as error:
                if function.__name__ not in STATUS_OF_ERRORS:
                    raise
                sys.stderr.write(f"error: {error}\n")
                raise typer.Exit(STATUS_OF_ERRORS[function.__name__]) from None
            if answer is not None:
                print_json(answer.facts) if as_json else answer.tell()
                if answer.status:
                    raise typer.Exit(answer.status)

    added = {"as_json": AsJson} if answers else {}
    added |= {"overwrite": _Overwrite} if writes else {}
    parameters = [
        *own,
        *(
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=kind)
            for name, kind in added.items()
        ),
    ]
    run.__annotations__ = {each.name: each.annotation for each in parameters}
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return run


def _flat(
    parameters: Iterable[inspect.Parameter], hints: dict[str, Any], groups: dict[str, Any]
) -> list[inspect.Parameter]:
    """The parameters of a verb, in place of a dataclass one for each of its fields."""
    found: list[inspect.Parameter] = []
    for each in parameters:
        kind, only = groups.get(each.name), inspect.Parameter.KEYWORD_ONLY
        if kind is not None:
            of = get_type_hints(kind, include_extras=True)
            found += [
                inspect.Parameter(own.name, only, default=own.default, annotation=of[own.name])
                for own in fields(kind)
            ]
        elif each.name != "say":
            found.append(each.replace(kind=only, annotation=hints[each.name]))
    return found


def _inputs_kept() -> Any:
    from elastomorph.io.atomic import inputs_kept

    return inputs_kept()


def _require_packages(parameters: dict[str, Any], name: str) -> None:
    """Refuse an output that nothing installed can write, before any work is done."""
    from elastomorph.io.registry import RIG_FORMATS

    suffixes = {Path(word).suffix.lower() for word in _words(parameters.get("output"))}
    needed = [known.package for known in RIG_FORMATS if suffixes.intersection(known.suffixes)]
    drawn = _DRAWN.intersection(suffixes) or any(parameters.get(own) for own in _PICTURES)
    if name == "demo" or drawn:
        needed += _DRAWING
    pages = parameters.get("output") is not None or parameters.get("report") is not None
    if name == "demo" or (name == "evaluate" and pages and parameters.get("pictures", True)):
        needed += [_GRAPHS]
    if parameters.get("compress"):
        needed.append(_COMPRESSION)
    for package in needed:
        if package is not None and find_spec(package[0]) is None:
            raise MissingExtraError(*package[1:])


def _require_places(parameters: dict[str, Any]) -> None:
    """Refuse a file that could not be written where it is to be, before any work is done."""
    from elastomorph.io.atomic import is_folder, require_writable

    for word in _words([parameters.get(name) for name in _OUTPUTS]):
        if Path(word).suffix.lower() in _FILES and not word.endswith("/") and not is_folder(word):
            require_writable(word)


def _require_apart(parameters: dict[str, Any]) -> None:
    """Refuse an output that is an input by name, before any work is done."""
    inputs = [
        file
        for name, value in parameters.items()
        if name not in _OUTPUTS
        for word in _words(value)
        for file in _files(word)
    ]
    for word in _words([parameters.get(name) for name in _OUTPUTS]):
        for file in inputs:
            if _writes(Path(word), file):
                raise FileError(
                    word,
                    f"this would be written over the input {file}; name another output, or "
                    "add --overwrite",
                )


def _words(value: Any) -> Iterator[str]:
    if isinstance(value, str | Path):
        yield str(value)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from _words(one)


def _files(word: str) -> Iterator[Path]:
    """The files that a word of the command line stands for: one, or those in a folder."""
    try:
        place = Path(word)
        if place.is_file():
            yield place
        elif word and place.is_dir():
            yield from (file for file in place.iterdir() if file.is_file())
    except (OSError, ValueError):
        return


def _writes(output: Path, file: Path) -> bool:
    """Whether an output, or a numbered one such as half.####.obj, is a file."""
    from elastomorph.io.atomic import same_file

    try:
        if "#" in output.name:
            pattern = r"\d+".join(map(re.escape, re.split("#+", output.name)))
            same_folder = output.parent.resolve() == file.resolve().parent
            return same_folder and re.fullmatch(pattern, file.resolve().name) is not None
        return same_file(output, file)
    except (OSError, ValueError, RuntimeError):
        return False


class Verb(TyperCommand):
    """A verb whose help names all methods where it says ``{methods}``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse words; an option that there was once is refused with what to use."""
        for word in args:
            if (instead := _GONE.get(name := word.partition("=")[0])) is not None:
                raise ParameterError(f"{name} is gone: {instead}")
        return list(super().parse_args(ctx, args))

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
        ctx.obj = {row.name: ctx.params.pop(row.name) for row in _option_rows()}
        return super().invoke(ctx)


def _patterns() -> str:
    from elastomorph.paths import Method

    patterns = [kind.pattern() for kind in Method.known]
    return f"{', '.join(patterns[:-1])} or {patterns[-1]}"


def _option_rows() -> list[Any]:
    from elastomorph.paths import Method
    from elastomorph.paths.options import option_rows

    return list(option_rows(Method.known))


def _options() -> list[Any]:
    """An option of the command line for each option of a method."""

    def no_verb(**_: object) -> None:
        pass

    parameters = []
    for row in _option_rows():
        default = f"; {row.default} by default" if row.default else ""
        means = f"{row.means[0].upper()}{row.means[1:]}{default}. For {', '.join(row.methods)}."
        kind: Any = Annotated[_KINDS.get(row.kind, str) | None, typer.Option(help=means)]
        parameter = inspect.Parameter(row.name, inspect.Parameter.KEYWORD_ONLY, default=None)
        parameters.append(parameter.replace(annotation=kind))
    no_verb.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    no_verb.__annotations__ = {each.name: each.annotation for each in parameters}
    app = typer.Typer(add_completion=False)
    app.command()(no_verb)
    return list(get_command(app).params)
