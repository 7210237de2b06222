"""A recipe: what the faces of a data set are, as tables of TOML."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from elastomorph.character.document import Document, nearest, open_document, shown
from elastomorph.errors import ParameterError
from elastomorph.farm.controls import KeyedError
from elastomorph.farm.keys import RecipeKey, read_keys, read_value, stated
from elastomorph.farm.mixtures import Mixture, Sparse
from elastomorph.farm.toml import toml_text

VERSION = 1
"""The form of recipes that this package writes and reads."""

KINDS: dict[str, type[Mixture]] = {kind.kind: kind for kind in (Sparse,)}

_SPAN = RecipeKey("span", "the lowest and highest weight of a slider, pattern or group", "[0, 0.8]")
_SEED = RecipeKey("whole", "another seed, other faces", "7", least=0, most=2**64 - 1)


@dataclass(frozen=True)
class Recipe:
    """What the faces of a data set are; made by `read_recipe` or `recipe_from`.

    Attributes:
        seed: 0 to 2⁶⁴ - 1: other seeds give other faces.
        mixtures: How sliders are drawn; each face is of one of them, by their shares.
        limits: Lowest and highest weight of sliders, patterns or groups; others have 0 and 1.
    """

    seed: int = 0
    mixtures: tuple[Mixture, ...] = (Sparse(),)
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    document: Document = field(default_factory=lambda: _Given({}), compare=False, repr=False)

    @contextmanager
    def naming(self, *where: str | int) -> Iterator[None]:
        """Turn what does not suit the rig into a complaint about its file, line and key."""
        try:
            yield
        except KeyedError as error:
            place = (*where, *error.where)
            self.document.refuse(place, f"{shown(place)}: {error}")

    def text(self) -> str:
        """The recipe as TOML, complete: read again it is the same, whatever defaults become."""
        content: dict[str, Any] = {"version": VERSION, "seed": self.seed}
        if self.limits:
            content["limits"] = {name: list(span) for name, span in self.limits.items()}
        content["mixture"] = [
            {"kind": mixture.kind, **stated(mixture)} for mixture in self.mixtures
        ]
        return toml_text(content)


class _Given(Document):
    """A recipe that is no file."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        super().__init__(Path("recipe.toml"), dict(content), "")

    def refuse(self, where: object, problem: str) -> NoReturn:
        raise ParameterError(f"recipe: {problem}")


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
    return _read(_Given(content))


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
    document.require_known((), ["version", "seed", "limits", "mixture"])
    version = document.content.get("version", VERSION)
    if version != VERSION or isinstance(version, bool):
        document.refuse(
            ("version",),
            f"this is version {version!r} of recipes, and this package knows {VERSION}; "
            "a newer elastomorph may read it",
        )
    seed = read_value(document, ("seed",), _SEED, document.content.get("seed", 0))
    limits = {
        name: read_value(document, ("limits", name), _SPAN, given)
        for name, given in document.table(("limits",)).items()
    }
    mixtures = tuple(_mixture(document, where) for where in document.entries("mixture"))
    return Recipe(seed, mixtures or (Sparse(),), limits, document)


def _mixture(document: Document, where: tuple[str | int, ...]) -> Mixture:
    kind = document.table(where).get("kind")
    if kind not in KINDS:
        document.refuse(
            (*where, "kind"),
            f"a mixture needs a kind that there is, found {kind!r}: {nearest(str(kind), KINDS)}",
        )
    return read_keys(document, where, KINDS[kind], "kind")
