"""Every table and key that a settings file may have, and settings as such tables.

The one list that reading, refusing, documentation and tests share. A table whose name ends in ``*``
stands for any number of tables, each with a name of the user's: ``[regions.mouth]``.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from elastomorph.character.choice import MethodChoice
from elastomorph.paths import Method
from elastomorph.rig.timing import by_name

if TYPE_CHECKING:
    from elastomorph.character.settings import Settings

UNITS = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}
"""Metres in each unit that a character may be measured in."""


class Key(NamedTuple):
    """One key of a settings file, with a value as TOML."""

    # ``text``, ``number``, ``whole``, ``flag``, ``numbers`` or ``table``; ``file``, the name of one
    # that exists; ``texts``, one text or a list; ``vertices``, a file, ranges, or a list of indices
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
            "neutral": Key("file", '"neutral.obj"'),
            "targets": Key("texts", '"shapes/*.obj"'),
            "curves": Key("file", '"curves.json"'),
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
        "timing": {"default": Key("text", '"minimum-jerk"')},
        "export.glb": {
            "normals": Key("text", '"none"'),
            "tolerance": Key("number", "1e-4"),
            "keys_tolerance": Key("number", "1e-3"),
            "fps": Key("number", "60"),
            "sparse": Key("flag", "false"),
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
    "correctives": "a corrective and the sliders whose weights drive it",
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
            "elastomorph": _version(),
            "settings": settings.path.name,
            "command_line": list(settings.overridden),
        },
        "character": {
            "name": character.name,
            "unit": character.unit,
            "rig": _file(character.rig),
            "mesh": list(character.mesh),
            "neutral": _file(character.neutral),
            "targets": [_file(name) for name in character.targets],
            "curves": _file(character.curves),
        },
        "method": _complete(settings.method),
        "methods": {name: _stated(choice, "method") for name, choice in settings.methods.items()},
        "regions": {
            name: {
                "vertices": _file(region.vertices),
                "falloff": region.falloff,
                **_stated(region.choice, "method"),
            }
            for name, region in settings.regions.items()
        },
        "inbetweens": {
            name: {"method": own.method, **{repr(t): _file(file) for t, file in own.files.items()}}
            for name, own in settings.inbetweens.items()
        },
        "groups": {name: list(own) for name, own in settings.groups.items()},
        "correctives": {name: list(own) for name, own in settings.correctives.items()},
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
    return _stated(MethodChoice(method.name, {**own, **choice.stated}), "default")


def _stated(choice: MethodChoice, text: str) -> dict[str, Any]:
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


def _version() -> str:
    try:
        return version("elastomorph")
    except PackageNotFoundError:
        return ""


def export_options(settings: Settings, path: str | Path) -> dict[str, Any]:
    """Options of `elastomorph.io.write` for a rig, with the settings themselves to be kept."""
    kept = {"settings": settings_tables(settings)}
    suffix = Path(path).suffix.lower()
    if suffix == ".glb":
        timed = {} if settings.timing is None else {"timing": by_name(settings.timing)}
        return {**settings.glb, **timed, **kept}
    if suffix in (".usd", ".usda", ".usdc"):
        unit = settings.character.unit
        measured = {} if unit is None else {"meters_per_unit": UNITS[unit]}
        return {**settings.usd, **measured, **kept}
    return kept if suffix == ".npz" else {}
