"""A recipe: what the faces of a data set are, as tables of TOML.

Every key is read here, and what is not read is refused.

Columns that are drawn each by itself: time, identity, head, camera, light.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import numpy as np
import tomlkit
from numpy.typing import NDArray

from elastomorph.character.document import Document, Where, as_found, nearest, open_document, shown
from elastomorph.errors import ElastomorphError, ParameterError
from elastomorph.farm.pictures.settings import ARRAYS, LARGEST, SETTINGS
from elastomorph.farm.sampling.columns import LEVELS, TIME, Codes, Column
from elastomorph.farm.sampling.controls import FARTHEST, Controls, Exclusion, KeyedError, Span
from elastomorph.farm.sampling.keys import RecipeKey, key, read_keys, read_value, stated
from elastomorph.farm.sampling.lanes import codes_of, normal
from elastomorph.farm.sampling.mixtures import Dirichlet, Grid, Mixture, Sparse, Take, Uniform
from elastomorph.io.untrusted import shortened
from elastomorph.numbers import is_whole
from elastomorph.rig.timing import NAMES, by_name


@dataclass(frozen=True, eq=False)
class Single:
    """A column, and the code of each lane; None where each lane is its own code."""

    column: Column
    table: Codes | None = None


@dataclass(frozen=True, kw_only=True)
class Timing:
    """A common time of the paths of a face: its weights are then the ζ of `Rig.blend`."""

    range: Span = key(
        (0.0, 1.0), "span", "from where to where on the paths", "[0, 1]", least=-10, most=10
    )
    law: str = key(
        "linear", "text", f"how a uniform number becomes t: {', '.join(NAMES)}", '"minimum-jerk"'
    )

    def single(self) -> Single:
        """The column of times.

        Raises:
            KeyedError: There is no such law.
        """
        try:
            law = by_name(self.law)
        except ParameterError as error:
            raise KeyedError(("law",), str(error)) from None
        low, high = self.range
        times = low + (high - low) * law.at(np.arange(LEVELS + 1) / LEVELS)
        column = Column.within(TIME, float(times.min()), float(times.max()))
        return Single(column, codes_of(column, times))


@dataclass(frozen=True, kw_only=True)
class Identity:
    """Sliders that say who it is: no mixture moves them, each has its own number."""

    sliders: tuple[str, ...] = key(
        (), "texts", "names, patterns or groups", '["identity*"]', needed=True
    )
    range: Span = key(
        (-3.0, 3.0),
        "span",
        "their limits, where [limits] has none",
        "[-2, 2]",
        least=-FARTHEST,
        most=FARTHEST,
    )
    law: str = key(
        "normal", "text", "normal, cut off at the limits, or uniform", '"uniform"',
        choices=("normal", "uniform"),
    )  # fmt: skip
    mean: float = key(0.0, "number", "of the normal law", "0.5")
    deviation: float = key(1.0, "number", "of the normal law", "0.7", above=0, most=FARTHEST)

    def singles(self, controls: Controls) -> Iterator[tuple[int, Single]]:
        """The place and the law of each slider.

        Raises:
            KeyedError: The mean is out of their limits, or there is one of a law that has none.
        """
        if self.law == "uniform" and (self.mean, self.deviation) != (0.0, 1.0):
            raise KeyedError(
                ("law",), "'mean' and 'deviation' are of the normal law, not of the uniform one"
            )
        for place in sorted(controls.others):
            column = controls.columns[place]
            if self.law == "uniform":
                yield place, Single(column)
                continue
            try:
                values = normal(column.low, column.high, self.mean, self.deviation)
            except ParameterError as error:
                raise KeyedError(("mean",), f"of {column.name!r} {error}") from None
            yield place, Single(column, codes_of(column, values))


def scene_singles(scene: Mapping[str, Span]) -> list[Single]:
    """Head, camera, light and background: each uniform in its range."""
    return [Single(Column(name, *span)) for name, span in scene.items()]


VERSION = 1
"""The form of recipes that this package writes and reads."""

KINDS: Mapping[str, type[Mixture]] = {
    kind.kind: kind for kind in (Sparse, Uniform, Dirichlet, Grid, Take)
}
"""The kinds of mixture by name."""

SCENE = tuple(dict.fromkeys(name.partition(".")[0] for name in SETTINGS))
"""The tables whose keys are columns of pictures: head, camera, light, …"""


@dataclass(frozen=True, kw_only=True)
class Pictures:
    """Pictures of the faces with labels."""

    size: int = key(256, "whole", "height and width in pixels", "256", least=16, most=LARGEST)
    arrays: tuple[str, ...] = key(
        ARRAYS, "texts", "what is made of each; all by default", '["colour", "depth"]',
        choices=ARRAYS,
    )  # fmt: skip


@dataclass(frozen=True)
class Recipe:
    """What the faces of a data set are; made by `read_recipe` or `recipe_from`.

    Attributes:
        seed: 0 to 2⁶⁴ - 1: other seeds give other faces.
        mixtures: How sliders are drawn; each face is of one of them, by their shares.
        limits: Lowest and highest weight of sliders, patterns or groups; others have 0 and 1.
        exclusions: What sliders are not at the same time.
        timing: A common time of the paths, or None.
        identity: Sliders that say who it is, or None.
        scene: Lowest and highest of each column of head, camera, light and background.
        pictures: Pictures of the faces, or None.
        landmarks: Vertex of each named point.
        anatomy: Whether shapes of ARKit keep to what a face can do, see `sampling.anatomy`.
        tables: What was kept of the files that it names; None where they are to be read.
    """

    seed: int = 0
    mixtures: tuple[Mixture, ...] = (Sparse(),)
    limits: Mapping[str, Span] = field(default_factory=dict)
    exclusions: tuple[Exclusion, ...] = ()
    timing: Timing | None = None
    identity: Identity | None = None
    scene: Mapping[str, Span] = field(default_factory=dict)
    pictures: Pictures | None = None
    landmarks: Mapping[str, int] = field(default_factory=dict)
    anatomy: bool = False
    tables: Mapping[str, NDArray[Any]] | None = field(default=None, compare=False, repr=False)
    document: Document = field(default_factory=lambda: GivenRecipe({}), compare=False, repr=False)

    def pictured(self, size: int) -> Recipe:
        """The recipe with pictures of so many pixels; what it says of them stays."""
        scene = {name: self.scene.get(name, (its.low, its.high)) for name, its in SETTINGS.items()}
        pictures = replace(self.pictures or Pictures(), size=size)
        return replace(self, scene=scene, pictures=pictures)

    def kept(self, mixture: int) -> dict[str, NDArray[Any]] | None:
        """What was kept of the files of a mixture; None where they are to be read."""
        if self.tables is None:
            return None
        start = f"mixture-{mixture}-"
        return {
            name.removeprefix(start): table
            for name, table in self.tables.items()
            if name.startswith(start)
        }

    def text(self) -> str:
        """The recipe as TOML, with all defaults that do not follow from the rig."""
        content: dict[str, Any] = {"version": VERSION, "seed": self.seed}
        content |= {"anatomy": True} if self.anatomy else {}
        content |= {"limits": dict(self.limits)} if self.limits else {}
        content["mixture"] = [{"kind": each.kind, **stated(each)} for each in self.mixtures]
        content["exclude"] = [stated(each) for each in self.exclusions]
        for name in ("timing", "identity", "pictures"):
            own = getattr(self, name)
            content |= {name: stated(own)} if own is not None else {}
        for name, span in self.scene.items():
            table, _, column = name.partition(".")
            content.setdefault(table, {})[column] = span
        content |= {"landmarks": dict(self.landmarks)} if self.landmarks else {}
        return tomlkit.dumps({name: value for name, value in content.items() if value != []})

    @contextmanager
    def naming(self, *where: str | int) -> Iterator[None]:
        """Turn what does not suit the rig into a complaint about its file, line and key."""
        try:
            yield
        except KeyedError as error:
            place = (*where, *error.where)
            self.document.refuse(place, f"{shown(place)}: {error}")


class GivenRecipe(Document):
    """A recipe that is no file."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        super().__init__(Path("recipe.toml"), dict(content), "")

    def refuse(self, where: object, problem: str) -> NoReturn:
        """Refuse it; there is no line to name."""
        raise ParameterError(f"recipe: {shortened(problem)}")


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
        from elastomorph.capturing.landmarks import read_landmarks

        name = read_value(document, ("landmarks", "file"), _FILE, table.pop("file"))
        try:
            found.update(read_landmarks(document.path.parent / name).vertices)
        except ElastomorphError as error:
            document.refuse(("landmarks", "file"), str(error))
    for name, vertex in table.items():
        found[name] = read_value(document, ("landmarks", name), _VERTEX, vertex)
    return found
