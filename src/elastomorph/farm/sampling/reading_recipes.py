"""From TOML to recipes: every key is read here, and what is not read is refused."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from elastomorph.character.document import Document, Where, as_found, nearest, open_document, shown
from elastomorph.errors import ElastomorphError, ParameterError
from elastomorph.farm.pictures.settings import SETTINGS
from elastomorph.farm.sampling.keys import RecipeKey, read_keys, read_value
from elastomorph.farm.sampling.mixtures import Mixture
from elastomorph.farm.sampling.recipe import KINDS, SCENE, VERSION, GivenRecipe, Pictures, Recipe
from elastomorph.farm.sampling.rules import FARTHEST, Exclusion, Span
from elastomorph.farm.sampling.singles import Identity, Timing
from elastomorph.numbers import is_whole

Described = TypeVar("Described")

_TABLES = (
    "version", "seed", "anatomy", "limits", "mixture", "exclude", "timing", "identity", *SCENE,
    "pictures", "landmarks",
)  # fmt: skip
_SEED = RecipeKey("whole", "other seeds, other faces", "7", least=0, most=2**64 - 1)
_ANATOMY = RecipeKey("flag", "shapes of ARKit do together what a face can do", "true")
_LIMITS = RecipeKey("span", "lowest and highest weight", "[0, 0.8]", least=-FARTHEST, most=FARTHEST)
_VERTEX = RecipeKey("whole", "a vertex of the rig", "2010", least=0, most=2**31 - 1)
_FILE = RecipeKey("file", "a file of landmarks", '"landmarks.json"')
_MOST_ENTRIES = 100


def read_recipe(path: str | Path) -> Recipe:
    """The recipe in a file.

    Args:
        path: A .toml file.

    Raises:
        FileError: It is missing or cannot be read.
        FormatError: It is no TOML, is of another version, or has a table, key or value that a
            recipe does not have. The message names the line, and the nearest known name.
    """
    return _read(open_document(path))


def recipe_from(content: Mapping[str, Any]) -> Recipe:
    """The recipe in tables of Python, as TOML would have them.

    Raises:
        ParameterError: As `read_recipe`, without lines.
    """
    return _read(GivenRecipe(_plain(content)))


def recipe_from_text(text: str) -> Recipe:
    """The recipe whose `Recipe.text` this is.

    Raises:
        ParameterError: It is none.
    """
    try:
        return recipe_from(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise ParameterError(f"recipe: not TOML: {error}") from None


def _read(document: Document) -> Recipe:
    version = document.content.get("version", VERSION)
    if not is_whole(version) or version != VERSION:
        document.refuse(
            ("version",),
            f"this is version {as_found(version)} of recipes, and this package knows {VERSION}; "
            "another elastomorph may read it",
        )
    document.require_known((), _TABLES)
    mixtures = tuple(_mixture(document, where) for where in _entries(document, "mixture"))
    recipe = Recipe(
        mixtures=mixtures or Recipe.mixtures,
        seed=read_value(document, ("seed",), _SEED, document.content.get("seed", 0)),
        anatomy=read_value(
            document, ("anatomy",), _ANATOMY, document.content.get("anatomy", False)
        ),
        limits={
            name: read_value(document, ("limits", name), _LIMITS, given)
            for name, given in document.table(("limits",)).items()
        },
        exclusions=tuple(
            read_keys(document, where, Exclusion) for where in _entries(document, "exclude")
        ),
        timing=_optional(document, "timing", Timing),
        identity=_optional(document, "identity", Identity),
        scene=_scene(document),
        pictures=_optional(document, "pictures", Pictures),
        landmarks=_landmarks(document),
        document=document,
    )
    if recipe.timing is not None:
        with recipe.naming("timing"):
            recipe.timing.single()
    return recipe


def _plain(value: Any) -> Any:
    """What Python holds, as TOML would: lists for tuples, numbers for those of NumPy."""
    if isinstance(value, Mapping):
        return {str(name): _plain(own) for name, own in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return value.item() if isinstance(value, np.generic) else value


def _entries(document: Document, name: str) -> list[Where]:
    found = document.entries(name)
    if len(found) > _MOST_ENTRIES:
        document.refuse(found[_MOST_ENTRIES], f"there are more than {_MOST_ENTRIES} [[{name}]]")
    return found


def _mixture(document: Document, where: Where) -> Mixture:
    kind = document.table(where).get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        found = "it has none" if kind is None else f"found {as_found(kind)}"
        document.refuse(
            (*where, "kind"),
            f"'{shown(where)}' needs a kind of mixture, {found}: {nearest(str(kind), KINDS)}",
        )
    return read_keys(document, where, KINDS[kind], "kind")


def _optional(document: Document, name: str, described: type[Described]) -> Described | None:
    return read_keys(document, (name,), described) if name in document.content else None


def _scene(document: Document) -> dict[str, Span]:
    """The range of each column of the tables that are there; of all where there are pictures."""
    found: dict[str, Span] = {}
    for table in SCENE:
        if table not in document.content and "pictures" not in document.content:
            continue
        own = {n.partition(".")[2]: n for n in SETTINGS if n.partition(".")[0] == table}
        document.require_known((table,), own)
        given = document.table((table,))
        for column, name in own.items():
            its = SETTINGS[name]
            allowed = RecipeKey(
                "span", its.meaning, f"[{its.low:g}, {its.high:g}]", least=its.least, most=its.most
            )
            found[name] = (
                read_value(document, (table, column), allowed, given[column])
                if column in given
                else (float(its.low), float(its.high))
            )
    return found


def _landmarks(document: Document) -> dict[str, int]:
    """Vertices by name, those of a file first."""
    table = dict(document.table(("landmarks",)))
    found: dict[str, int] = {}
    if isinstance(table.get("file"), str):
        from elastomorph.capturing.landmarks.landmarks import read_landmarks

        name = read_value(document, ("landmarks", "file"), _FILE, table.pop("file"))
        try:
            found.update(read_landmarks(document.path.parent / name).vertices)
        except ElastomorphError as error:
            document.refuse(("landmarks", "file"), str(error))
    for name, vertex in table.items():
        found[name] = read_value(document, ("landmarks", name), _VERTEX, vertex)
    return found
