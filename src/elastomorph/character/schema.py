"""Every table and key that a settings file may have, and settings as such tables.

The one list that reading, refusing, documentation and tests share. A table whose name ends in ``*``
stands for any number of tables, each with a name of the user's: ``[regions.mouth]``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from elastomorph.errors import ParameterError
from elastomorph.io.rig_cache import installed_version
from elastomorph.paths import Method
from elastomorph.paths.options import options_of
from elastomorph.physics import Material
from elastomorph.rig.timing import by_name

if TYPE_CHECKING:
    from elastomorph.character.settings import Settings


UNITS = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}
"""Metres in each unit that a character may be measured in."""


class Key(NamedTuple):
    """One key of a settings file, with a value as TOML."""

    # ``text``, ``number``, ``whole``, ``flag``, ``numbers`` or ``table``; ``file``, the name of one
    # that exists; ``texts``, one text or a list; ``vertices``, a file, ranges or indices;
    # ``span``, a number or two
    kind: str
    example: str


_METHOD = Key("text", '"beam:3"')
_NUMBER = Key("number", "2.0")


def tables() -> dict[str, dict[str, Key]]:
    """The keys of each table; those of methods are the options that methods have."""
    every = Method.every_option()
    options = {name: Key(its.kind, its.example) for name, its in every.items()}
    return {
        "character": {
            "name": Key("text", '"Ada"'),
            "unit": Key("text", '"mm"'),
            "rig": Key("file", '"head.glb"'),
            "mesh": Key("texts", '"Head"'),
            "root": Key("text", '"../.."'),
            "neutral": Key("file", '"neutral.obj"'),
            "targets": Key("texts", '"shapes/*.obj"'),
            "curves": Key("file", '"curves.json"'),
            "correctives": Key("file", '"simplex.json"'),
            "weld": Key("flag", "false"),
        },
        "method": {"default": _METHOD, **options},
        "methods.*": {"method": _METHOD, **options},
        "regions.*": {
            "vertices": Key("vertices", '"mouth.json"'),
            "falloff": Key("number", "5"),
            "method": _METHOD,
            **options,
        },
        "material": dict.fromkeys(every["material"].parts, _NUMBER),
        "inbetweens.*": {"method": Key("text", '"spline"')},
        "correctives.*": {
            "drivers": Key("texts", '["eyeBlinkLeft", "eyeSquintLeft"]'),
            "law": Key("text", '"min"'),
            "gains": Key("numbers", "[1.0, 0.4]"),
            "sharpness": Key("number", "4"),
        },
        "timing": {"default": Key("text", '"minimum-jerk"')},
        "export.glb": {
            "normals": Key("text", '"none"'),
            "tolerance": Key("number", "1e-4"),
            "keys_tolerance": Key("number", "1e-3"),
            "fps": Key("number", "60"),
            "sparse": Key("flag", "false"),
            "clips": Key("flag", "true"),
            "compress": Key("flag", "true"),
        },
        "export.usd": {
            "tolerance": Key("number", "1e-4"),
            "most_inbetweens": Key("whole", "5"),
            "fps": Key("number", "24"),
        },
    }


FREE: dict[str, str] = {
    "methods": "a target, or a pattern such as eyeBlink_*, and its method",
    "inbetweens.*": 'a time between 0 and 1 and a file: "0.3" = "jawOpen_30.obj"',
    "groups": "a group and the names or patterns of its sliders",
    "correctives": "a corrective and the sliders that drive it, or a table with their law",
}
"""Tables whose keys are names of the user's own, and what each line of them says."""


def settings_tables(settings: Settings) -> dict[str, Any]:
    """The settings as tables of JSON, with what the command line has changed.

    The tables are those of a settings file, complete where it leaves the default method open;
    ``made_with`` says which program, which file and which options of the command line. File
    names are as the settings have them, so that nothing of the machine gets into outputs.
    """
    character = settings.character
    found: dict[str, Any] = {
        "made_with": {
            "elastomorph": installed_version("elastomorph"),
            "settings": settings.path.name,
            "command_line": list(settings.overridden),
        },
        "character": {
            "name": character.name,
            "unit": character.unit,
            "rig": _file(character.rig),
            "mesh": list(character.mesh),
            "root": _file(character.root),
            "neutral": _file(character.neutral),
            "targets": [_file(name) for name in character.targets],
            "curves": _file(character.curves),
            "correctives": _file(character.correctives),
            "weld": character.weld,
        },
        "method": _complete(settings.method),
        "methods": {name: stated_as(choice) for name, choice in settings.methods.items()},
        "regions": {
            name: {
                "vertices": _file(region.vertices),
                "falloff": region.falloff,
                **stated_as(region.choice),
            }
            for name, region in settings.regions.items()
        },
        "inbetweens": {
            name: {"method": own.method, **{repr(t): _file(file) for t, file in own.files.items()}}
            for name, own in settings.inbetweens.items()
        },
        "groups": {name: list(own) for name, own in settings.groups.items()},
        "correctives": {name: own.entry() for name, own in settings.correctives.items()},
        "timing": {"default": settings.timing},
        "export": {"glb": dict(settings.glb), "usd": dict(settings.usd)},
    }
    return _without_nothing(found)


def _file(name: str | tuple[int, ...] | None) -> str | list[int] | None:
    """A file as the settings name it, without the folders of this machine; or vertices."""
    if isinstance(name, tuple):
        return list(name)
    return Path(name).name if name is not None and Path(name).is_absolute() else name


def _complete(choice: MethodChoice) -> dict[str, Any]:
    """What is stated, and the defaults of all else that the method has a use for."""
    method = choice.method()
    own = choice.values()
    if choice.stated.get("load") is not None:
        own.pop("order", None)
    return stated_as(MethodChoice(method.name, {**own, **choice.stated}), "default")


def stated_as(choice: MethodChoice, text: str = "method") -> dict[str, Any]:
    """What a choice states, as a table whose method has the key ``text``."""
    given = {
        key: list(own) if isinstance(own, tuple) else own for key, own in choice.stated.items()
    }
    material = {name: given.pop(name) for name in tables()["material"] if name in given}
    order = given.pop("order", None) if choice.name is not None else None
    name = choice.name if order is None else f"{choice.name}:{order}"
    return {text: name, **given, "material": material}


def _without_nothing(tables: dict[str, Any]) -> dict[str, Any]:
    """Without keys that say nothing and tables left empty by that: not all formats keep them."""
    found: dict[str, Any] = {}
    for name, value in tables.items():
        kept = _without_nothing(value) if isinstance(value, dict) else value
        if kept is not None and kept != {} and kept != []:
            found[name] = kept
    return found


def export_options(settings: Settings, path: str | Path) -> dict[str, Any]:
    """Options of `elastomorph.io.write` for a rig, with the settings themselves to be kept."""
    kept = {"settings": settings_tables(settings)}
    suffix = Path(path).suffix.lower()
    if suffix == ".glb":
        timed = {} if settings.timing is None else {"timing": by_name(settings.timing)}
        return {**settings.glb, **timed, **kept}
    if suffix in (".usd", ".usda", ".usdc", ".usdz"):
        unit = settings.character.unit
        measured = {} if unit is None else {"meters_per_unit": UNITS[unit]}
        return {**settings.usd, **measured, **kept}
    return kept if suffix == ".npz" else {}


@dataclass(frozen=True)
class MethodChoice:
    """The part of a method that one place of the settings states."""

    name: str | None = None
    # Of its options, as a settings file holds them, and of the constants of its material (``mass``,
    # ``damping``, ``rigidity``).
    stated: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.name is not None:
            Method.named(self.name)
        for name, value in _fields(self.stated).items():
            Method.every_option()[name].check(value, name)

    @classmethod
    def of(cls, text: str | None = None, **stated: Any) -> MethodChoice:
        """A choice from a text such as ``beam:3`` and from options; None leaves one open."""
        given = {name: value for name, value in stated.items() if value is not None}
        alike = [f"'{name}'" for name in given if _with_name(name)]
        if len(alike) > 1:
            raise ParameterError(f"{' and '.join(alike)} state the same; leave one of them out")
        if text is None:
            return cls(None, given)
        kind, found = Method.read(text)
        for name in given:
            instead = name not in found and _with_name(name) and any(map(_with_name, found))
            if name in found or instead:
                raise ParameterError(
                    f"{text!r} and '{name}' state the same; leave one of them out"
                    + (" (a load takes the place of the order)" if instead else "")
                )
        kind(**found)
        return cls(kind.name, found | given)

    def __bool__(self) -> bool:
        """Whether anything is stated."""
        return self.name is not None or bool(self.stated)

    @property
    def idle(self) -> dict[str, tuple[str, ...]]:
        """What is stated that its method has no use for, and the methods that have."""
        method = self.method()
        return {
            name: Method.with_option(own)
            for name in self.stated
            if not method.has(own := _option_of(name))
        }

    def over(self, general: MethodChoice) -> MethodChoice:
        """This choice where it states something, a more general one where it does not."""
        kept = general.without(self)
        name = kept.name if self.name is None else self.name
        return MethodChoice(name, {**kept.stated, **self.stated})

    def without(self, said: MethodChoice) -> MethodChoice:
        """What is left of this choice where another one has the say."""
        anew = said.name is not None or any(map(_with_name, said.stated))
        kept = {
            name: value
            for name, value in self.stated.items()
            if name not in said.stated and not (anew and _with_name(name))
        }
        return MethodChoice(None if said.name is not None else self.name, kept)

    def method(self) -> Method:
        """The method, with the program's defaults for what is not stated; without what is idle."""
        kind = type(Method()) if self.name is None else Method.named(self.name)
        given = _fields(self.stated)
        return kind(**{name: value for name, value in given.items() if kind.has(name)})

    def values(self) -> dict[str, Any]:
        """The options of the method, defaults too, as a settings file holds them."""
        method = self.method()
        found: dict[str, Any] = {}
        for name, its in options_of(method).items():
            value = getattr(method, name)
            if value is not None:
                found |= {part: getattr(value, part) for part in its.parts} or {name: value}
        return found

    @property
    def material(self) -> Material:
        """The material, with the program's defaults for what is not stated."""
        found: Material = _fields(self.stated).get("material", Material())
        return found


def _option_of(name: str) -> str:
    """The option that a name stands for: its own, or that of the table it is a part of."""
    every = Method.every_option()
    return next((own for own, its in every.items() if name in its.parts), name)


def _with_name(name: str) -> bool:
    its = Method.every_option().get(name)
    return its is not None and its.with_name


def _fields(stated: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of methods, made of what is stated."""
    found: dict[str, Any] = {}
    for name, its in Method.every_option().items():
        parts = {part: stated[part] for part in its.parts if part in stated}
        if parts:
            found[name] = its.made(parts)
        elif name in stated:
            found[name] = its.made(stated[name])
    return found
