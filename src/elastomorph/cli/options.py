"""Options that several verbs share, and how they speak."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.errors import ElastomorphWarning

if TYPE_CHECKING:
    from collections.abc import Callable

    from elastomorph.curves import CurveNetwork
    from elastomorph.mesh import Mesh
    from elastomorph.physics import Material

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]
CurveFile = Annotated[
    Path | None,
    typer.Option("--curves", help="Artists' curves (JSON); what they leave is filled in."),
]
Mass = Annotated[float, typer.Option(help="m of the material, above 0.")]
Damping = Annotated[float, typer.Option(help="c of the material, above 0.")]
Rigidity = Annotated[float, typer.Option(help="k = EI of the material, above 0.")]
Closure = Annotated[
    str,
    typer.Option(help="Time law of a curve's mean: limit, compatible, rest, unforced, linear."),
]


def material(mass: float, damping: float, rigidity: float) -> Material:
    """The material that the options describe."""
    from elastomorph.physics import Material

    return Material(mass, damping, rigidity)


def network(mesh: Mesh, file: Path | None, names: tuple[str, ...] = ()) -> CurveNetwork:
    """The curves of a mesh, artists' own first."""
    from elastomorph.curves import extract_curves
    from elastomorph.io.curve_file import read_curves

    keep = () if file is None else read_curves(file, len(mesh.vertices), names or None)
    return extract_curves(mesh, keep)


def print_json(value: Any) -> None:
    """One JSON document on standard output."""
    typer.echo(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


@contextmanager
def progress(quiet: bool = False) -> Iterator[Callable[[str], None]]:
    """A line on the terminal that says what is going on; warnings as plain sentences."""
    from rich.console import Console

    console = Console(stderr=True)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ElastomorphWarning)
        if quiet or not console.is_terminal:
            yield lambda _: None
        else:
            with console.status("working …") as status:
                yield lambda text: status.update(f"{text} …")
    for message in dict.fromkeys(str(w.message) for w in caught):
        console.print(f"warning: {message}", markup=False, highlight=False, soft_wrap=True)
