"""From TOML to settings: every key is read here, and what is not read is refused."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from elastomorph.character.document import Document, Where, nearest, open_document, parse_document
from elastomorph.character.schema import FREE, UNITS, Key, MethodChoice, tables
from elastomorph.character.settings import (
    Character,
    Inbetweens,
    Region,
    Settings,
    is_pattern,
)
from elastomorph.errors import FileError
from elastomorph.io.atomic import is_file, is_folder
from elastomorph.io.gltf.writer import require_glb_settings
from elastomorph.io.usd.writer import require_usd_settings
from elastomorph.io.vertex_lists import read_region
from elastomorph.paths import Method
from elastomorph.paths.through import law_for
from elastomorph.rig.laws import Corrective
from elastomorph.rig.timing import by_name

FILE_NAME = "elastomorph.toml"
_FILE = Key("file", '"jawOpen_30.obj"')
_NAMES = Key("texts", '["jawOpen", "mouthClose"]')


def find_settings(folder: str | Path) -> Path | None:
    """The settings file in a folder, if there is one."""
    file = Path(folder) / FILE_NAME
    return file if is_file(file) else None


def no_settings(folder: str | Path) -> Settings:
    """The settings of a folder that has none yet."""
    return settings_of(parse_document(Path(folder) / FILE_NAME, b""))


def read_settings(path: str | Path) -> Settings:
    """The settings of a character.

    Every value is checked, as are the names of files; the files themselves are read when the rig
    is built.

    Args:
        path: A TOML file, or a folder with an ``elastomorph.toml``.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is no TOML, has a table or key that is not known, a value of another type
            or out of its range, or names a file that does not exist. The message names the line
            and, for a mistyped name, the nearest known one.
    """
    file = Path(path)
    if is_folder(file):
        if find_settings(file) is None:
            raise FileError(
                file, f"this folder has no {FILE_NAME}; 'elastomorph init {file}' writes one"
            )
        file /= FILE_NAME
    return settings_of(open_document(file))


def settings_of(document: Document) -> Settings:
    """The settings that an open file holds, as `read_settings` reads them."""
    top = dict.fromkeys(name.partition(".")[0] for name in (*tables(), *FREE))
    document.require_known((), [name for name in top if name != "material"])
    for table in ("export", "methods", "regions", "inbetweens"):
        document.table((table,))
    document.require_known(("export",), ["glb", "usd"])
    timing = _checked(document, ("timing",), lambda default: by_name(default)).get("default")
    inbetweens = {name: _inbetweens(document, name) for name in document.table(("inbetweens",))}
    methods = {name: _method_of(document, name) for name in document.table(("methods",))}
    for name in inbetweens:
        if name in methods:
            document.refuse(
                ("methods", name),
                f"{name!r} has both a method and in-betweens: its path passes through the "
                "in-betweens; leave one of them out",
            )
    settings = Settings(
        path=document.path,
        character=_character(document),
        method=_choice(document, ("method",), tables()["method"], text="default"),
        methods=methods,
        regions={name: _region(document, name) for name in document.table(("regions",))},
        inbetweens=inbetweens,
        groups=_lists(document, "groups"),
        correctives=_correctives(document),
        timing=timing,
        glb=_checked(document, ("export", "glb"), require_glb_settings),
        usd=_checked(document, ("export", "usd"), require_usd_settings),
    )
    _warn_of_idle(document, settings)
    return settings


def _warn_of_idle(document: Document, settings: Settings) -> None:
    """Say so where no method has a use for what all targets, or a region by itself, are given.

    It is no error: ``--method`` on the command line stands on it too.
    """
    targets = [settings.method, *(own.over(settings.method) for own in settings.methods.values())]
    regions = [own.choice.over(below) for own in settings.regions.values() for below in targets]
    where: Where = ("method",)
    places = [(where, settings.method, [*targets, *regions])]
    for name, region in settings.regions.items():
        if region.choice.name is None:
            own = [region.choice.over(below) for below in targets]
            places.append((("regions", name), region.choice, own))
    for where, choice, used in places:
        for field in choice.stated:
            if not all(field in one.idle for one in used):
                continue
            inner = ("material", field) if field in tables()["material"] else (field,)
            document.warn(
                (*where, *inner),
                f"'{field}' has no effect: it is for {', '.join(used[0].idle[field])}, and here "
                f"the method is {used[0].method().name}",
            )


def _character(document: Document) -> Character:
    found = document.values(("character",), tables()["character"])
    both = " and ".join(repr(key) for key in ("neutral", "targets") if key in found)
    if both and "rig" in found:
        document.refuse(
            ("character", "rig"), f"a rig file brings its own shapes; leave out 'rig' or {both}"
        )
    for key, of in (("mesh", "meshes of a rig file"), ("root", "the folder of a rig in USD")):
        if key in found and "rig" not in found:
            document.refuse(("character", key), f"{key!r} names {of}: name 'rig' too")
    unit = found.get("unit")
    if unit is not None and unit not in UNITS:
        document.refuse(
            ("character", "unit"), f"unknown unit {unit!r}: there are {', '.join(UNITS)}"
        )
    folder = document.path.parent
    for pattern in found.get("targets", ()):
        if not is_pattern(pattern):
            document.require_file(("character", "targets"), pattern)
    name = folder.name or folder.resolve().name or "face"
    return Character(**{"folder": folder, "name": name, **found})


def _choice(
    document: Document, where: Where, keys: Mapping[str, Key], *, text: str = "method"
) -> MethodChoice:
    """The method that a table states; other keys of the table are left alone."""
    stated = document.values(where, keys)
    own = {key: stated[key] for key in Method.every_option() if key in stated}
    own.pop("material", None)
    own |= document.values((*where, "material"), tables()["material"])
    # One by one, so that the complaint names the line that is to blame.
    for key, value in own.items():
        inner = ("material", key) if key in tables()["material"] else (key,)
        with document.naming((*where, *inner)):
            MethodChoice.of(None, **{key: value})
    with document.naming((*where, text) if text in stated else where):
        return MethodChoice.of(stated.get(text), **own)


def _method_of(document: Document, name: str) -> MethodChoice:
    where = ("methods", name)
    given = document.content["methods"][name]
    if isinstance(given, str):
        with document.naming(where):
            return MethodChoice.of(given)
    if not isinstance(given, dict):
        key = Key("text", '"rotation" or { method = "beam:3", closure = "rest" }')
        document.value(where, key, given)
    return _choice(document, where, tables()["methods.*"])


def _region(document: Document, name: str) -> Region:
    where = ("regions", name)
    stated = document.values(where, tables()["regions.*"])
    if "vertices" not in stated:
        document.refuse(where, f"the region {name!r} has no 'vertices': name a file or ranges")
    vertices = stated["vertices"]
    if isinstance(vertices, str) and vertices.lower().endswith(".json"):
        document.require_file((*where, "vertices"), vertices)
    elif isinstance(vertices, str):
        with document.naming((*where, "vertices")):
            read_region(vertices)
    falloff = float(stated.get("falloff", 3.0))
    if falloff < 0:
        document.refuse((*where, "falloff"), f"falloff must be from 0, found {falloff:g}")
    choice = _choice(document, where, tables()["regions.*"])
    if not choice:
        document.refuse(
            where,
            f"the region {name!r} says nothing that is done there: give it a 'method' or a "
            "'material'",
        )
    return Region(vertices, falloff, choice)


def _inbetweens(document: Document, name: str) -> Inbetweens:
    where = ("inbetweens", name)
    files: dict[float, str] = {}
    method: str | None = None
    for key, value in _flat(document.table(where)):
        if key == "method":
            method = document.value((*where, key), tables()["inbetweens.*"]["method"], value)
            with document.naming((*where, key)):
                law_for(method, 0)
            continue
        # A bare 0.3 is, to TOML, the key 3 of the table 0.
        line = (*where, key) if key in document.table(where) else (*where, *key.split("."))
        try:
            time = float(key)
        except ValueError:
            document.refuse(
                line,
                f"{key!r} in [inbetweens.{name}] is neither a time between 0 and 1 nor 'method': "
                + nearest(key, ["method"]),
            )
        if not 0 < time < 1:
            document.refuse(
                line,
                f"the time of an in-between must be between 0 (the neutral) and 1 (the target), "
                f"found {key}",
            )
        if time in files:
            document.refuse(line, f"two in-betweens of {name!r} are at {time:g}")
        files[time] = document.value(line, _FILE, value)
    if not files:
        document.refuse(where, f"[inbetweens.{name}] names no shape; {FREE['inbetweens.*']}")
    return Inbetweens(files, law_for(method, len(files)))


def _flat(table: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Keys and values, a bare ``0.3`` put together again."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        if isinstance(value, dict) and key.isdecimal():
            found += [(f"{key}.{rest}", own) for rest, own in value.items()]
        else:
            found.append((key, value))
    return found


def _lists(document: Document, table: str) -> dict[str, tuple[str, ...]]:
    return {
        name: document.value((table, name), _NAMES, given)
        for name, given in document.table((table,)).items()
    }


def _correctives(document: Document) -> dict[str, Corrective]:
    found: dict[str, Corrective] = {}
    table = document.table(("correctives",))
    for name, given in table.items():
        where = ("correctives", name)
        if isinstance(given, dict):
            stated = document.values(where, tables()["correctives.*"])
        else:
            stated = {"drivers": document.value(where, _NAMES, given)}
        with document.naming(where):
            found[name] = Corrective.of(stated)
        for driver in found[name].drivers:
            if driver != name and driver in table:
                document.refuse(
                    where,
                    f"{name!r} is driven by {driver!r}, which is a corrective itself; name the "
                    "sliders that drive both",
                )
    return found


def _checked(document: Document, where: Where, require: Callable[..., object]) -> dict[str, Any]:
    found = document.values(where, tables()[".".join(map(str, where))])
    for key, value in found.items():
        with document.naming((*where, key)):
            require(**{key: value})
    return found
