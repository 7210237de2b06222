"""Options that several verbs share, and what they stand for."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import completion
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.character import Settings
    from elastomorph.character.schema import MethodChoice
    from elastomorph.cli.output import Say
    from elastomorph.curves import CurveNetwork
    from elastomorph.model.mesh import Mesh
    from elastomorph.rig import Rig
    from elastomorph.rig.timing import Timing

CurveFile = Annotated[
    Path | None,
    typer.Option("--curves", help="Artists' curves (JSON); what they leave is filled in."),
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
PosesFolder = Annotated[
    Path,
    typer.Option(
        "--output",
        "-o",
        help="Folder for a mesh of each pose, their confidence and what was measured.",
    ),
]
NeutralPose = Annotated[
    str | None,
    typer.Option(
        help="The pose that is the neutral. Default: the one with 'neutral' in its name, or the "
        "first."
    ),
]

RECORDED = "scan.####.obj, a folder, .npz of meshes or markers, .c3d, .mdd, .pc2, .glb"
"""What a recorded motion is read from, for the help of verbs that take one."""

ClipName = Annotated[
    str | None,
    typer.Option("--clip", help="Which animation of a .glb, .gltf or .vrm with several."),
]
ConfidenceFile = Annotated[
    Path | None,
    typer.Option(
        "--confidence",
        help="How far each vertex is to be trusted, to leave out the others: confidence.npz as "
        "'capture' and 'register' write it. One in the folder of the frames is found by itself.",
    ),
]
LeastConfidence = Annotated[
    float | None,
    typer.Option(
        "--least-confidence",
        help="From which confidence on a vertex counts; 0.5 by default, 0 lets all count.",
    ),
]


def settings_of(
    rig: Path | None, file: Path | None, choice: MethodChoice | str | None = None
) -> Settings | None:
    """The settings a verb runs with, or None where there are none.

    They are those that the user named, else those in the folder of the rig, or the rig is settings
    itself; ``choice`` is what the command line says of the method.
    """
    named = rig is not None and rig.suffix.lower() == ".toml" and not rig.is_dir()
    if file is None and not named and (rig is None or not rig.is_dir()):
        return None
    from elastomorph.character import find_settings, read_settings
    from elastomorph.character.schema import MethodChoice

    if named and file is not None:
        raise ParameterError(f"the rig {rig} is settings of its own; leave out --settings {file}")
    found = rig if named else file
    if found is None and rig is not None:
        found = find_settings(rig)
    if found is None:
        return None
    settings = read_settings(found)
    if settings.root is not None:
        from elastomorph.io.usd.library import ROOT_VARIABLE

        os.environ[ROOT_VARIABLE] = str(settings.root)
    if rig is not None and not named:
        settings = settings.with_rig(rig)
    if isinstance(choice, str):
        choice = MethodChoice.of(choice)
    return settings.with_choice(choice) if choice else settings


@dataclass(frozen=True)
class NamedRig:
    """A rig as the command line names it, not read yet.

    Attributes:
        place: The rig file, folder or settings; None for the built-in head.
        method: Makes all paths anew. Left out, settings say, else paths of the file stay as they
            are and the rest gets the default.
        settings: Those the user named, else those of the folder.
        mesh: Names of the meshes meant, in a file with several.
    """

    place: Path | None
    method: str | None
    settings: Settings | None
    mesh: Sequence[str]

    @classmethod
    def of(
        cls,
        rig: str | None,
        settings: Path | None = None,
        method: str | None = None,
        mesh: Sequence[str] | None = None,
    ) -> NamedRig:
        """What options say."""
        from elastomorph.io.registry import BUILT_IN

        if rig == BUILT_IN and settings is not None:
            raise ParameterError("the built-in head has no settings; leave out one of the two")
        place = None if rig is None or rig == BUILT_IN else Path(rig)
        return cls(place, method, settings_of(place, settings, method), mesh or ())

    @property
    def followed(self) -> Settings | None:
        """The settings that its paths follow; those of a folder without any say nothing yet."""
        from elastomorph.character.read import no_settings

        if self.settings is None:
            folder = self.place is not None and self.place.is_dir()
            return no_settings(self.place) if folder and self.place else None
        return self.settings.with_mesh(list(self.mesh)) if self.mesh else self.settings

    def stored(self, say: Say) -> Rig:
        """The rig without paths that no one has chosen, whatever settings say."""
        from elastomorph.io.rig_folder import rig_as_stored

        return rig_as_stored(**self._source(say))

    def full(self, say: Say, only: str | None = None, *, stored: Rig | None = None) -> Rig:
        """The rig with its paths, or the targets that ``only`` names, separated by commas.

        Where it was read already, as it is stored, it is not read again.
        """
        from elastomorph.io.rig_folder import read_rig
        from elastomorph.rig.build import with_paths

        if self.settings is not None:
            from elastomorph.character import rig_from_settings

            if self.mesh and self.settings.character.rig is None:
                raise ParameterError(f"--mesh is for rig files; {self.settings.path} names meshes")
            followed = self.followed or self.settings
            return _chosen(rig_from_settings(followed, say=say, stored=stored), only)
        if only is None and stored is not None:
            return with_paths(stored, self.method, say=say)
        if only is None:
            return read_rig(**self._source(say), method=self.method, say=say)
        # Some methods take a second a target: only those wanted are given their paths.
        rig = self.stored(say)
        names = _chosen(rig, only).names
        return with_paths(rig, self.method, names=names, say=say).only(names)

    def expressions(self, say: Say, names: str | None) -> Rig:
        """A rig of the expressions named, or of the paper's five, composed where it has none."""
        from elastomorph.rig import Rig
        from elastomorph.rig.build import bare_rig, with_paths
        from elastomorph.samples.paper_expressions import EXPRESSIONS, compose_expressions

        settings = self.settings
        if names is not None:
            return self.full(say, names)
        rig = self.stored(say) if settings is None else self.full(say)
        five = [name for name in EXPRESSIONS if name in rig.morphs]
        if len(five) < len(EXPRESSIONS):
            targets = rig.targets
            composed = compose_expressions(rig.neutral, targets)
            five = list(composed or rig.targets)[: len(EXPRESSIONS)]
            rig = bare_rig(rig.neutral, composed) if composed else rig
            if composed and settings is not None:
                from elastomorph.character import PathMaker

                maker = PathMaker(settings, rig.neutral, rig)
                return Rig(rig.neutral, {name: maker.path(name, composed[name]) for name in five})
        return with_paths(rig, None if settings else self.method, names=five, say=say).only(five)

    def _source(self, say: Say) -> dict[str, Any]:
        from elastomorph.io.registry import BUILT_IN

        say("building the head" if self.place is None else f"reading {self.place}")
        place = BUILT_IN if self.place is None else self.place
        return {"path": place} | ({"mesh": list(self.mesh)} if self.mesh else {})


def _chosen(rig: Rig, only: str | None) -> Rig:
    return rig if only is None else rig.only([name.strip() for name in only.split(",")])


def curve_file(keep: Path | None, settings: Path | None) -> Path | None:
    """The curves that the command line names, or else settings."""
    if keep is not None or settings is None:
        return keep
    from elastomorph.character import read_settings

    found = read_settings(settings)
    name = found.character.curves
    return None if name is None else found.file(name)


def network(mesh: Mesh, file: Path | None, names: tuple[str, ...] = ()) -> CurveNetwork:
    """The curves of a mesh, artists' own first."""
    from elastomorph.curves import extract_curves
    from elastomorph.io.vertex_lists import read_curves

    keep = () if file is None else read_curves(file, len(mesh.vertices), names or None)
    return extract_curves(mesh, keep)


def timing(text: str | None) -> Timing | None:
    """The timing that an option names, if it was given."""
    from elastomorph.rig.timing import by_name

    return None if text is None else by_name(text)


def named_numbers(texts: list[str], option: str) -> dict[str, float]:
    """Numbers by name from ``name=0.4`` texts, each name once."""
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


def numbers(text: str, option: str) -> list[float]:
    """Finite numbers from ``0,0.5,1``."""
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = [math.nan]
    if not all(map(math.isfinite, found)):
        raise ParameterError(f"{option} {text!r}: expected numbers separated by commas, as 0,0.5,1")
    return found
