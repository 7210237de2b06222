"""What every verb looks at before its own work: whether its outputs can and may be written."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import wraps
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

__all__ = ["OUTPUTS", "keeping_inputs"]

OUTPUTS = ("output", "picture", "sheet", "grid", "report", "repair_to")
"""The parameters of verbs that name what is written."""

_PICTURES = ("picture", "sheet", "grid")
_DRAWING = (("vtkmodules", "vtk", "demo"), ("PIL", "pillow", "demo"))
_GRAPHS = ("matplotlib", "matplotlib", "demo")

_Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Let an output take the place of an input.")
]


def keeping_inputs(verb: Callable[..., Any]) -> Callable[..., Any]:
    """A verb that refuses to write over what it reads, unless ``--overwrite`` says so.

    Args:
        verb: The function of the verb; one without outputs is given back as it is.
    """
    signature = inspect.signature(verb)
    if not any(name in OUTPUTS for name in signature.parameters):
        return verb

    @wraps(verb)
    def kept(*arguments: Any, overwrite: bool = False, **options: Any) -> Any:
        from elastomorph.io.atomic import inputs_kept

        given = signature.bind(*arguments, **options).arguments
        _require_packages(given, verb.__name__)
        if not overwrite:
            _require_apart(given)
        with nullcontext() if overwrite else inputs_kept():
            return verb(*arguments, **options)

    hints = get_type_hints(verb, include_extras=True) | {"overwrite": _Overwrite}
    parameters = [
        *(own.replace(annotation=hints[name]) for name, own in signature.parameters.items()),
        inspect.Parameter(
            "overwrite", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=_Overwrite
        ),
    ]
    kept.__annotations__ = hints
    kept.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return kept


def _require_packages(parameters: dict[str, Any], verb: str) -> None:
    """Refuse an output that nothing installed can write, before any work is done."""
    from elastomorph.errors import MissingExtraError
    from elastomorph.io.registry import RIG_FORMATS

    suffixes = {Path(word).suffix.lower() for word in _words(parameters.get("output"))}
    needed = [known.package for known in RIG_FORMATS if suffixes.intersection(known.suffixes)]
    if verb == "demo" or any(parameters.get(name) is not None for name in _PICTURES):
        needed += _DRAWING
    pages = parameters.get("output") is not None or parameters.get("report") is not None
    if verb == "demo" or (verb == "evaluate" and pages and parameters.get("pictures", True)):
        needed += [_GRAPHS]
    for package in needed:
        if package is not None and find_spec(package[0]) is None:
            raise MissingExtraError(*package[1:])


def _require_apart(parameters: dict[str, Any]) -> None:
    """Refuse an output that is an input by name, before any work is done."""
    from elastomorph.errors import FileError

    inputs = [
        file
        for name, value in parameters.items()
        if name not in OUTPUTS
        for word in _words(value)
        for file in _files(word)
    ]
    for name in OUTPUTS:
        for word in _words(parameters.get(name)):
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
    try:
        if "#" in output.name:
            parts = re.split("#+", output.name)
            pattern = r"\d+".join(re.escape(part) for part in parts)
            same_folder = output.parent.resolve() == file.resolve().parent
            return same_folder and re.fullmatch(pattern, file.resolve().name) is not None
        return output.exists() and output.samefile(file)
    except (OSError, ValueError, RuntimeError):
        return False
