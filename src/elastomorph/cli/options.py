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
    from elastomorph.settings import Settings
    from elastomorph.settings.choice import MethodChoice
    from elastomorph.timing import Timing

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON for machines.")]
CurveFile = Annotated[
    Path | None,
    typer.Option("--curves", help="Artists' curves (JSON); what they leave is filled in."),
]
Mass = Annotated[float | None, typer.Option(help="m of the material, above 0; 1 by default.")]
Damping = Annotated[float | None, typer.Option(help="c of the material, above 0; 1 by default.")]
Rigidity = Annotated[
    float | None,
    typer.Option("--rigidity", help="k = EI of the material, above 0; 1 by default."),
]
Closure = Annotated[
    str,
    typer.Option(help="Time law of a curve's mean: limit, compatible, rest, unforced, linear."),
]

OptionalRig = Annotated[
    Path | None,
    typer.Argument(
        metavar="[RIG]",
        help="A rig: .glb, .usd, .fbx, .npz, a folder of meshes, settings (.toml). Default: ours.",
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
MethodText = Annotated[
    str | None,
    typer.Option(
        help="linear, cosine, ease:R, beam:R[:closure], plate:R, arc, rotation; beam:2 by default."
    ),
]
SettingsFile = Annotated[
    Path | None,
    typer.Option(
        "--settings",
        help="Settings of a character (TOML). Default: elastomorph.toml in the folder of the rig.",
    ),
]

DEFAULT_METHOD = "beam:2"
"""Of targets where neither the command line nor settings say more."""


def material(
    mass: float | None,
    damping: float | None,
    rigidity: float | None,
    settings: Settings | None = None,
) -> Material:
    """The material that the options describe, and where they do not, settings or the program."""
    from elastomorph.settings.choice import MethodChoice

    said = MethodChoice(mass=mass, damping=damping, rigidity=rigidity)
    return (said if settings is None else said.over(settings.method)).method().material


def settings_of(
    rig: Path | None, file: Path | None, choice: MethodChoice | str | None = None
) -> Settings | None:
    """The settings a verb runs with, or None where there are none.

    Args:
        rig: The rig that the user named: a folder of meshes, a rig file, or settings.
        file: The settings that the user named; those in the folder of the rig by default.
        choice: What the command line says of the method.
    """
    named = rig is not None and rig.suffix.lower() == ".toml" and not rig.is_dir()
    if file is None and not named and (rig is None or not rig.is_dir()):
        return None
    from elastomorph.errors import ParameterError
    from elastomorph.settings import find_settings, read_settings
    from elastomorph.settings.choice import MethodChoice

    if named and file is not None:
        raise ParameterError(f"the rig {rig} is settings of its own; leave out --settings {file}")
    found = rig if named else file
    if found is None and rig is not None:
        found = find_settings(rig)
    if found is None:
        return None
    settings = read_settings(found)
    if rig is not None and not named:
        settings = settings.with_rig(rig)
    if isinstance(choice, str):
        choice = MethodChoice.of(choice)
    return settings.with_choice(choice) if choice else settings


def named_rig(rig: str, settings: Path | None) -> Path | None:
    """The rig that a user named; None for the built-in head.

    Raises:
        ParameterError: Settings for the built-in head.
    """
    from elastomorph.errors import ParameterError

    if rig == "built-in" and settings is not None:
        raise ParameterError("the built-in head has no settings; leave out one of the two")
    return None if rig == "built-in" else Path(rig)


def curve_file(keep: Path | None, settings: Path | None) -> Path | None:
    """The curves that the command line names, or else settings."""
    if keep is not None or settings is None:
        return keep
    from elastomorph.settings import read_settings

    found = read_settings(settings)
    name = found.character.curves
    return None if name is None else found.file(name)


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


def full_rig(
    path: Path | None,
    method: str | None,
    say: Callable[[str], None],
    settings: Settings | None = None,
    only: str | None = None,
) -> Rig:
    """A rig from settings, a file or a folder, or the built-in head with its expressions.

    The method makes the paths where there are only shapes; rig files have paths of their own.

    Args:
        path: The rig file, folder or settings; None for the built-in head.
        method: The method; that of settings, or else `DEFAULT_METHOD`, where it is left out.
        say: Told what is being done.
        settings: As `settings_of` gives them, if that was asked; else those of the folder.
        only: Names of the targets wanted, separated by commas; all by default.
    """
    from elastomorph.io import read_rig
    from elastomorph.paths import prepare
    from elastomorph.rig import Rig

    settings = settings_of(path, None, method) if settings is None else settings
    if settings is not None:
        from elastomorph.settings import rig_from_settings

        return _chosen(rig_from_settings(settings, say=say), only)
    method = DEFAULT_METHOD if method is None else method
    if path is not None:
        say(f"reading {path}")
        if only is None or not path.is_dir():
            return _chosen(read_rig(path, method=method) if path.is_dir() else read_rig(path), only)
        straight = read_rig(path, method="linear")
    else:
        from elastomorph.samples import expressions, head, shapes

        say("building the head")
        to = prepare(head(), "linear")
        straight = Rig(head(), {n: to(m) for n, m in {**shapes(), **expressions()}.items()})
    # Some methods take a second a target: only those wanted are given their paths.
    wanted = _chosen(straight, only)
    to = prepare(wanted.neutral, method)
    return Rig(wanted.neutral, {name: to(m.target) for name, m in wanted.morphs.items()})


def _chosen(rig: Rig, only: str | None) -> Rig:
    return rig if only is None else rig.only([name.strip() for name in only.split(",")])


def expression_rig(
    path: Path | None,
    names: str | None,
    method: str | None,
    say: Callable[[str], None],
    settings: Settings | None = None,
) -> Rig:
    """A rig of the expressions named, or of the paper's five, composed where it has none.

    Arguments as for `full_rig`.
    """
    from elastomorph.paper_expressions import EXPRESSIONS, compose_expressions
    from elastomorph.paths import prepare
    from elastomorph.rig import Rig

    settings = settings_of(path, None, method) if settings is None else settings
    rig = full_rig(path, method, say, settings, names)
    if names is not None:
        return rig
    if all(name in rig.morphs for name in EXPRESSIONS):
        return rig.only(list(EXPRESSIONS))
    targets = {name: morph.target for name, morph in rig.morphs.items()}
    composed = compose_expressions(rig.neutral, targets)
    if not composed:
        return rig.only(list(rig.morphs)[: len(EXPRESSIONS)])
    if settings is not None:
        from elastomorph.settings import PathMaker

        maker = PathMaker(settings, rig.neutral)
        return Rig(rig.neutral, {name: maker.path(name, mesh) for name, mesh in composed.items()})
    to = prepare(rig.neutral, DEFAULT_METHOD if method is None else method)
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
