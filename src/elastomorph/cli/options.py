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
    from elastomorph.rig import Rig
    from elastomorph.timing import Timing

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]
CurveFile = Annotated[
    Path | None,
    typer.Option("--curves", help="Artists' curves (JSON); what they leave is filled in."),
]
Mass = Annotated[float, typer.Option(help="m of the material, above 0.")]
Damping = Annotated[float, typer.Option(help="c of the material, above 0.")]
Rigidity = Annotated[float, typer.Option("--rigidity", help="k = EI of the material, above 0.")]
Closure = Annotated[
    str,
    typer.Option(help="Time law of a curve's mean: limit, compatible, rest, unforced, linear."),
]

OptionalRig = Annotated[
    Path | None,
    typer.Argument(
        metavar="[RIG]",
        help="A rig: .glb, .usd, .fbx, .npz, or a folder of meshes. Default: the built-in head.",
    ),
]
TimingText = Annotated[
    str | None,
    typer.Option(
        "--timing",
        help="How t runs over the clip: smoothstep, minimum-jerk, cosine, gompertz:3, blink, "
        "keys:0=0,0.3=0.8,1=1. Never part of the path.",
    ),
]
MethodText = Annotated[str, typer.Option(help="linear, cosine, ease:R, beam:R or beam:R:closure.")]


def material(mass: float, damping: float, rigidity: float) -> Material:
    """The material that the options describe."""
    from elastomorph.physics import Material

    return Material(mass, damping, rigidity)


def timing(text: str | None) -> Timing | None:
    """The timing that an option names, if it was given."""
    from elastomorph.timing import by_name

    return None if text is None else by_name(text)


def network(mesh: Mesh, file: Path | None, names: tuple[str, ...] = ()) -> CurveNetwork:
    """The curves of a mesh, artists' own first."""
    from elastomorph.curves import extract_curves
    from elastomorph.io.curve_file import read_curves

    keep = () if file is None else read_curves(file, len(mesh.vertices), names or None)
    return extract_curves(mesh, keep)


def named_numbers(texts: list[str], option: str) -> dict[str, float]:
    """Numbers by name from ``name=0.4`` texts.

    Raises:
        ParameterError: A text is not understood, or a name comes twice.
    """
    from elastomorph.errors import ParameterError

    found: dict[str, float] = {}
    for text in texts:
        name, equals, number = text.partition("=")
        try:
            value = float(number)
        except ValueError:
            value = float("nan")
        if not equals or value != value or name in found:
            raise ParameterError(f"{option} {text!r}: expected name=number, each name once")
        found[name] = value
    return found


def full_rig(path: Path | None, method: str, say: Callable[[str], None]) -> Rig:
    """A rig from a file or folder, or the built-in head with its shapes and expressions.

    The method makes the paths where there are only shapes; rig files have paths of their own.
    """
    from elastomorph.io import read_rig
    from elastomorph.paths import prepare
    from elastomorph.rig import Rig

    if path is None:
        from elastomorph.samples import expressions, head, shapes

        say("building the head")
        to = prepare(head(), method)
        return Rig(head(), {n: to(mesh) for n, mesh in {**shapes(), **expressions()}.items()})
    say(f"reading {path}")
    return read_rig(path, method=method) if path.is_dir() else read_rig(path)


def expression_rig(
    path: Path | None, names: str | None, method: str, say: Callable[[str], None]
) -> Rig:
    """A rig of the expressions named, or of the paper's five, composed where it has none."""
    from elastomorph.paper_expressions import EXPRESSIONS, compose_expressions
    from elastomorph.paths import prepare
    from elastomorph.rig import Rig

    rig = full_rig(path, method, say)
    if names is not None:
        return rig.only([name.strip() for name in names.split(",")])
    if all(name in rig.morphs for name in EXPRESSIONS):
        return rig.only(list(EXPRESSIONS))
    targets = {name: morph.target for name, morph in rig.morphs.items()}
    composed = compose_expressions(rig.neutral, targets)
    if not composed:
        return rig.only(list(rig.morphs)[: len(EXPRESSIONS)])
    to = prepare(rig.neutral, method)
    return Rig(rig.neutral, {name: to(mesh) for name, mesh in composed.items()})


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
