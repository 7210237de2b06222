"""A recipe: what the faces of a data set are, as tables of TOML."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn

import tomlkit
from numpy.typing import NDArray

from elastomorph.character.document import Document, shown
from elastomorph.errors import ParameterError
from elastomorph.farm.pictures.settings import ARRAYS, LARGEST, SETTINGS
from elastomorph.farm.sampling.controls import KeyedError
from elastomorph.farm.sampling.keys import key, stated
from elastomorph.farm.sampling.mixtures import Dirichlet, Grid, Mixture, Sparse, Uniform
from elastomorph.farm.sampling.rules import Exclusion, Span
from elastomorph.farm.sampling.singles import Identity, Timing
from elastomorph.farm.sampling.takes import Take

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
        raise ParameterError(f"recipe: {problem}")
