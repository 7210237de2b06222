"""The settings of one character, as a program uses them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from itertools import chain
from pathlib import Path
from typing import Any

from elastomorph.character.document import nearest
from elastomorph.character.schema import MethodChoice
from elastomorph.errors import FormatError
from elastomorph.rig.laws import Corrective


@dataclass(frozen=True)
class Character:
    """Which files a character is made of; names are relative to the settings file."""

    folder: Path  # where the neutral and the targets are looked for that are not named
    name: str
    unit: str | None = None  # of its files, one of `UNITS`
    rig: str | None = None  # a rig file, in place of neutral and targets
    mesh: tuple[str, ...] = ()  # names of the meshes of the rig file that are meant
    root: str | None = None  # the folder in which all files of a rig in USD lie
    neutral: str | None = None  # found by its name where it is left out
    targets: tuple[str, ...] = ()  # files and patterns; every other mesh where they are left out
    curves: str | None = None  # of artists
    correctives: str | None = None  # a file of Simplex that says what drives them
    weld: bool = True  # whether vertices at one place move as one


@dataclass(frozen=True)
class Region:
    """A part of the face with a method or material of its own."""

    vertices: str | tuple[int, ...]  # a file, ranges or indices
    falloff: float  # rings of edges inside its border over which it blends into the rest
    choice: MethodChoice  # on top of that of the target


@dataclass(frozen=True)
class Inbetweens:
    """The shapes that the path of one target passes through."""

    files: Mapping[float, str]  # by time
    method: str  # the law between them, one of `elastomorph.paths.through.LAWS`


@dataclass(frozen=True)
class Settings:
    """One settings file, checked. Immutable."""

    path: Path
    character: Character
    method: MethodChoice = field(default_factory=MethodChoice)  # the default of every target
    methods: Mapping[str, MethodChoice] = field(default_factory=dict)  # by target or pattern
    regions: Mapping[str, Region] = field(default_factory=dict)  # the later lie on top
    inbetweens: Mapping[str, Inbetweens] = field(default_factory=dict)  # by target
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # sliders or patterns
    correctives: Mapping[str, Corrective] = field(default_factory=dict)  # what drives each
    timing: str | None = None  # how t runs over exported clips; None for evenly
    glb: Mapping[str, Any] = field(default_factory=dict)  # options of `write_glb`
    usd: Mapping[str, Any] = field(default_factory=dict)  # options of `write_usd`
    # What the command line has put in the place of the file's own words.
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

    def members(self, names: Collection[str]) -> dict[str, tuple[str, ...]]:
        """The groups, with the sliders that their patterns stand for."""
        found = {}
        for group, written in self.groups.items():
            meant = [[own] if own in names else _matched(own, names) for own in written]
            found[group] = tuple(dict.fromkeys(chain(*meant)))
        return found

    def require_names(self, names: Collection[str]) -> None:
        """Check that every target that settings speak of is one; the message has the nearest."""
        for table, spoken in (
            ("methods", {name: (name,) for name in self.methods}),
            ("inbetweens", {name: (name,) for name in self.inbetweens}),
            ("groups", self.groups),
            ("correctives", {name: (name,) for name in self.correctives}),
            ("correctives", {name: own.drivers for name, own in self.correctives.items()}),
        ):
            for key, name in ((key, name) for key, own in spoken.items() for name in own):
                patterns = table in ("methods", "groups") and is_pattern(name)
                if name in names or (patterns and _matched(name, names)):
                    continue
                what = "stands for no target" if patterns else "is no target"
                raise FormatError(
                    self.path,
                    f"{name!r} in [{table}]{'' if key == name else f', {key!r},'} {what} of "
                    f"{self.character.name}: {nearest(name, names)}",
                )

    @property
    def root(self) -> Path | None:
        """The folder in which all files of a rig in USD lie, where the settings name it."""
        return None if self.character.root is None else self.file(self.character.root)

    def with_rig(self, rig: Path) -> Settings:
        """The same settings for another rig: a folder of meshes, or a rig file."""
        files: dict[str, Any] = {
            "rig": str(rig.resolve()),
            "mesh": (),
            "root": None,
            "neutral": None,
            "targets": (),
        }
        if rig.is_dir():
            if rig.resolve() == self.path.parent.resolve():
                return self
            files |= {"folder": rig, "rig": None}
        return self._with_files("rig", **files)

    def with_choice(self, choice: MethodChoice) -> Settings:
        """The same settings with a choice that counts for all targets and regions.

        In-betweens stay: they are shapes, not a method.
        """
        named = [] if choice.name is None else ["method"]
        return self.with_options(
            *named,
            *(name for name in choice.stated if name != "order"),
            method=choice.over(self.method),
            methods={name: own.without(choice) for name, own in self.methods.items()},
            regions={
                name: replace(own, choice=own.choice.without(choice))
                for name, own in self.regions.items()
            },
        )

    def with_curves(self, file: Path) -> Settings:
        """The same settings with another file of artists' curves."""
        return self._with_files("curves", curves=str(file.absolute()))

    def with_mesh(self, names: Sequence[str]) -> Settings:
        """The same settings with other meshes of the rig file."""
        return self._with_files("mesh", mesh=tuple(names))

    def with_options(self, *names: str, **fields: Any) -> Settings:
        """The same settings with other values of some fields, by options of these names."""
        return replace(self, **fields, overridden=tuple(dict.fromkeys((*self.overridden, *names))))

    def _with_files(self, name: str, **fields: Any) -> Settings:
        return self.with_options(name, character=replace(self.character, **fields))


def _matched(pattern: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if is_pattern(pattern) and fnmatchcase(name, pattern)]


def is_pattern(name: str) -> bool:
    """Whether a name stands for others."""
    return any(letter in name for letter in "*?[")
