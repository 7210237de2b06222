"""Options that several verbs share, and how they speak."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import completion
from elastomorph.errors import ElastomorphWarning

if TYPE_CHECKING:
    from collections.abc import Callable

    from elastomorph.character import Settings
    from elastomorph.character.choice import MethodChoice
    from elastomorph.curves import CurveNetwork
    from elastomorph.model.mesh import Mesh
    from elastomorph.physics import Material
    from elastomorph.rig import Rig
    from elastomorph.rig.timing import Timing

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
    str | None,
    typer.Argument(
        metavar="[RIG]",
        help="A rig: .glb, .vrm, .usd, .fbx, .npz, a folder of meshes, settings (.toml); "
        "'built-in', the default, for ours.",
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
        help="Paths made anew by {methods}. Default: those of the file, auto where it has none.",
        autocompletion=completion.methods,
    ),
]
RigName = Annotated[
    str,
    typer.Argument(
        help="A rig: .glb, .vrm, .usd, .fbx, .npz, a folder, settings (.toml); 'built-in' for ours."
    ),
]
MeshNames = Annotated[
    list[str] | None,
    typer.Option(
        "--mesh", help="The mesh meant, in a .glb, .fbx or .usd with several; may be repeated."
    ),
]
SettingsFile = Annotated[
    Path | None,
    typer.Option(
        "--settings",
        help="Settings of a character (TOML). Default: elastomorph.toml in the folder of the rig.",
    ),
]


def material(
    mass: float | None,
    damping: float | None,
    rigidity: float | None,
    settings: Settings | None = None,
) -> Material:
    """The material that the options describe, and where they do not, settings or the program."""
    from elastomorph.character.choice import MethodChoice

    said = MethodChoice.of(mass=mass, damping=damping, rigidity=rigidity)
    return (said if settings is None else said.over(settings.method)).material


def method_choice(text: str | None, said: Mapping[str, Any]) -> MethodChoice:
    """What the command line says of a method.

    Args:
        text: Such as ``beam:3``.
        said: Options of methods, as `VerbWithOptions` finds them; None where nothing is said.

    Raises:
        ParameterError: The text or an option is not understood, or both say the same.
    """
    from elastomorph.character.choice import MethodChoice
    from elastomorph.errors import ParameterError

    given = dict(said)
    if given.get("load") is not None:
        try:
            given["load"] = tuple(float(p) for p in given["load"].split(","))
        except ValueError:
            raise ParameterError(
                f"--load must be numbers such as 0.2,0.8, found {given['load']!r}"
            ) from None
    return MethodChoice.of(text, **given)


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
    from elastomorph.character import find_settings, read_settings
    from elastomorph.character.choice import MethodChoice
    from elastomorph.errors import ParameterError

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


def named_rig(rig: str | None, settings: Path | None = None) -> Path | None:
    """The rig that a user named; None for the built-in head, or where nothing was named.

    Raises:
        ParameterError: Settings for the built-in head.
    """
    from elastomorph.errors import ParameterError
    from elastomorph.io.registry import BUILT_IN

    if rig == BUILT_IN and settings is not None:
        raise ParameterError("the built-in head has no settings; leave out one of the two")
    return None if rig in (None, BUILT_IN) else Path(rig)


def curve_file(keep: Path | None, settings: Path | None) -> Path | None:
    """The curves that the command line names, or else settings."""
    if keep is not None or settings is None:
        return keep
    from elastomorph.character import read_settings

    found = read_settings(settings)
    name = found.character.curves
    return None if name is None else found.file(name)


def timing(text: str | None) -> Timing | None:
    """The timing that an option names, if it was given."""
    from elastomorph.rig.timing import by_name

    return None if text is None else by_name(text)


def network(mesh: Mesh, file: Path | None, names: tuple[str, ...] = ()) -> CurveNetwork:
    """The curves of a mesh, artists' own first."""
    from elastomorph.curves import extract_curves
    from elastomorph.io.vertex_lists import read_curves

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
    mesh: Sequence[str] | None = None,
) -> Rig:
    """A rig from settings, a file or a folder, or the built-in head with its expressions.

    Args:
        path: The rig file, folder or settings; None for the built-in head.
        method: Makes all paths anew. Left out, settings say, else paths of the file stay as they
            are and the rest gets the default.
        say: Told what is being done.
        settings: As `settings_of` gives them, if that was asked; else those of the folder.
        only: Names of the targets wanted, separated by commas; all by default.
        mesh: Names of the meshes meant, in a file with several.
    """
    from elastomorph.errors import ParameterError
    from elastomorph.io.registry import BUILT_IN
    from elastomorph.io.rig_folder import read_rig, rig_as_stored
    from elastomorph.rig.build import with_paths

    settings = settings_of(path, None, method) if settings is None else settings
    if settings is not None:
        from elastomorph.character import rig_from_settings

        if mesh:
            if settings.character.rig is None:
                raise ParameterError(f"--mesh is for rig files; {settings.path} names meshes")
            settings = settings.with_mesh(mesh)
        return _chosen(rig_from_settings(settings, say=say), only)
    place = BUILT_IN if path is None else path
    say("building the head" if path is None else f"reading {path}")
    beside: dict[str, Any] = {"mesh": list(mesh)} if mesh else {}
    if only is None:
        return read_rig(place, method=method, say=say, **beside)
    # Some methods take a second a target: only those wanted are given their paths.
    rig = rig_as_stored(place, **beside)
    names = _chosen(rig, only).names
    return with_paths(rig, method, names=names, say=say).only(names)


def _chosen(rig: Rig, only: str | None) -> Rig:
    return rig if only is None else rig.only([name.strip() for name in only.split(",")])


def expression_rig(
    path: Path | None,
    names: str | None,
    method: str | None,
    say: Callable[[str], None],
    settings: Settings | None = None,
    mesh: Sequence[str] | None = None,
) -> Rig:
    """A rig of the expressions named, or of the paper's five, composed where it has none.

    Arguments as for `full_rig`.
    """
    from elastomorph.io.registry import BUILT_IN
    from elastomorph.io.rig_folder import rig_as_stored
    from elastomorph.rig import Rig
    from elastomorph.rig.build import bare_rig, extent_of, with_paths
    from elastomorph.samples.paper_expressions import EXPRESSIONS, compose_expressions

    settings = settings_of(path, None, method) if settings is None else settings
    if names is not None:
        return full_rig(path, method, say, settings, names, mesh)
    if settings is not None:
        rig = full_rig(path, method, say, settings, mesh=mesh)
    else:
        say("building the head" if path is None else f"reading {path}")
        beside: dict[str, Any] = {"mesh": list(mesh)} if mesh else {}
        rig = rig_as_stored(BUILT_IN if path is None else path, **beside)
    five = [name for name in EXPRESSIONS if name in rig.morphs]
    if len(five) < len(EXPRESSIONS):
        targets = {name: morph.target for name, morph in rig.morphs.items()}
        composed = compose_expressions(rig.neutral, targets)
        five = list(composed or rig.morphs)[: len(EXPRESSIONS)]
        rig = bare_rig(rig.neutral, composed) if composed else rig
        if composed and settings is not None:
            from elastomorph.character import PathMaker

            maker = PathMaker(settings, rig.neutral, extent_of(rig))
            return Rig(rig.neutral, {name: maker.path(name, composed[name]) for name in five})
    return with_paths(rig, None if settings else method, names=five, say=say).only(five)


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
