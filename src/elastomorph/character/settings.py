"""The settings of one character, as a program uses them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from elastomorph.character.choice import MethodChoice
from elastomorph.character.document import nearest
from elastomorph.errors import FormatError


@dataclass(frozen=True)
class Character:
    """Which files a character is made of; names are relative to the settings file.

    Attributes:
        folder: Where the neutral and the targets are looked for that are not named.
        name: What it is called.
        unit: Unit of its files, one of `UNITS`; None where nothing is said.
        rig: A rig file, in place of neutral and targets.
        mesh: Names of the meshes of the rig file that are meant; see its reader for the rest.
        neutral: File of the neutral; found by its name where it is left out.
        targets: Files and patterns of the targets; every other mesh where they are left out.
        curves: File of artists' curves.
    """

    folder: Path
    name: str
    unit: str | None = None
    rig: str | None = None
    mesh: tuple[str, ...] = ()
    neutral: str | None = None
    targets: tuple[str, ...] = ()
    curves: str | None = None


@dataclass(frozen=True)
class Region:
    """A part of the face with a method or material of its own.

    Attributes:
        vertices: A file, ranges or indices.
        falloff: Rings of edges inside its border over which it blends into the rest.
        choice: Its method, on top of that of the target.
    """

    vertices: str | tuple[int, ...]
    falloff: float
    choice: MethodChoice


@dataclass(frozen=True)
class Inbetweens:
    """The shapes that the path of one target passes through.

    Attributes:
        files: The file at each time.
        method: The law between them, one of `elastomorph.paths.through.LAWS`.
    """

    files: Mapping[float, str]
    method: str


@dataclass(frozen=True)
class Settings:
    """One settings file, checked. Immutable.

    Attributes:
        path: The file.
        character: The files of the character.
        method: The default of every target.
        methods: Target or pattern, and what it has for a method.
        regions: Parts of the face with methods of their own; the later lie on top.
        inbetweens: Shapes on the way to a target, by its name.
        groups: Names of groups, and names or patterns of the sliders in each.
        correctives: Name of each corrective, and the sliders that drive it.
        timing: How t runs over exported clips; None for evenly.
        glb: Options of `elastomorph.io.gltf.write_glb`.
        usd: Options of `elastomorph.io.usd.write_usd`.
        overridden: What the command line has put in the place of the file's own words.
    """

    path: Path
    character: Character
    method: MethodChoice = field(default_factory=MethodChoice)
    methods: Mapping[str, MethodChoice] = field(default_factory=dict)
    regions: Mapping[str, Region] = field(default_factory=dict)
    inbetweens: Mapping[str, Inbetweens] = field(default_factory=dict)
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    correctives: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    timing: str | None = None
    glb: Mapping[str, Any] = field(default_factory=dict)
    usd: Mapping[str, Any] = field(default_factory=dict)
    overridden: tuple[str, ...] = ()

    def file(self, name: str) -> Path:
        """The path of a file that the settings name."""
        return self.path.parent / name

    def choice_for(self, target: str) -> MethodChoice:
        """What the settings state about the method of one target.

        An exact name wins over patterns; of these, the one with the most letters that stand for
        themselves, and then the later.
        """
        best: tuple[int, str] | None = None
        for name in self.methods:
            if name == target:
                best = (len(name) + 1, name)
                break
            if is_pattern(name) and fnmatchcase(target, name):
                letters = sum(letter not in "*?[]" for letter in name)
                if best is None or letters >= best[0]:
                    best = (letters, name)
        return self.method if best is None else self.methods[best[1]].over(self.method)

    def members(self, names: Iterable[str]) -> dict[str, tuple[str, ...]]:
        """The groups, with the sliders that their patterns stand for."""
        known = tuple(names)
        return {
            group: tuple(
                dict.fromkeys(
                    name
                    for own in written
                    for name in ([own] if own in known else known)
                    if name == own or (is_pattern(own) and fnmatchcase(name, own))
                )
            )
            for group, written in self.groups.items()
        }

    def require_names(self, names: Iterable[str]) -> None:
        """Check that every target the settings speak of is one.

        Args:
            names: The targets of the character.

        Raises:
            FormatError: One is none, or a pattern stands for none; the message has the nearest.
        """
        known = tuple(names)
        for table, spoken in (
            ("methods", [(name, name) for name in self.methods]),
            ("inbetweens", [(name, name) for name in self.inbetweens]),
            ("groups", [(group, name) for group, own in self.groups.items() for name in own]),
            ("correctives", [(own, own) for own in self.correctives]),
            (
                "correctives",
                [(own, name) for own, drivers in self.correctives.items() for name in drivers],
            ),
        ):
            for key, name in spoken:
                patterns = table in ("methods", "groups") and is_pattern(name)
                if name in known or (patterns and any(fnmatchcase(own, name) for own in known)):
                    continue
                what = "stands for no target" if patterns else "is no target"
                raise FormatError(
                    self.path,
                    f"{name!r} in [{table}]{'' if key == name else f', {key!r},'} {what} of "
                    f"{self.character.name}: {nearest(name, known)}",
                )

    def with_rig(self, rig: Path) -> Settings:
        """The same settings for another rig: a folder of meshes, or a rig file."""
        own = self.character
        if rig.is_dir():
            if rig.resolve() == self.path.parent.resolve():
                return self
            character = replace(own, folder=rig, rig=None, mesh=(), neutral=None, targets=())
        else:
            named = str(rig.resolve())
            character = replace(own, rig=named, mesh=(), neutral=None, targets=())
        return replace(self, character=character, overridden=self._noted("rig"))

    def with_choice(self, choice: MethodChoice) -> Settings:
        """The same settings with a choice that counts for all targets and regions.

        In-betweens stay: they are shapes, not a method.

        Args:
            choice: What the command line says of the method.
        """
        named = [] if choice.name is None else ["method"]
        return replace(
            self,
            method=choice.over(self.method),
            methods={name: own.without(choice) for name, own in self.methods.items()},
            regions={
                name: replace(own, choice=own.choice.without(choice))
                for name, own in self.regions.items()
            },
            overridden=self._noted(*named, *(name for name in choice.stated if name != "order")),
        )

    def with_curves(self, file: Path) -> Settings:
        """The same settings with another file of artists' curves."""
        character = replace(self.character, curves=str(file.absolute()))
        return replace(self, character=character, overridden=self._noted("curves"))

    def with_mesh(self, names: Sequence[str]) -> Settings:
        """The same settings with other meshes of the rig file."""
        character = replace(self.character, mesh=tuple(names))
        return replace(self, character=character, overridden=self._noted("mesh"))

    def with_options(self, *names: str, **fields: Any) -> Settings:
        """The same settings with other values of some fields.

        Args:
            *names: What the options of the command line are called.
            **fields: Fields of the settings.
        """
        return replace(self, **fields, overridden=self._noted(*names))

    def _noted(self, *names: str) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*self.overridden, *names)))


def is_pattern(name: str) -> bool:
    """Whether a name stands for others."""
    return any(letter in name for letter in "*?[")
