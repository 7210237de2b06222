"""What a data set is to hold, as a user asks for it, and as its attributes keep it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.keys import keys_of
from elastomorph.farm.sampling.recipe import Pictures, Recipe
from elastomorph.farm.sampling.sampler import FaceSampler, as_recipe
from elastomorph.farm.storage.contents import Encoding, Poser
from elastomorph.farm.storage.manifest import require_codec
from elastomorph.numbers import is_whole
from elastomorph.rig.rig import Rig

LEAST, MOST = 1, 2**20
"""Faces in a unit."""


@dataclass(frozen=True)
class Wanted:
    """What is stored beside the recipe and its codes, as `make_faces` describes it."""

    vertices: str | None = None
    tolerance: float | None = None
    normals: bool = False
    landmarks: Mapping[str, int] | str | None = None
    codec: str = "lz4"
    unit: int | None = None

    def __post_init__(self) -> None:
        require_codec(self.codec)
        unit = self.unit
        if unit is not None and (
            not is_whole(unit) or not LEAST <= unit <= MOST or unit & unit - 1
        ):
            raise ParameterError(
                f"a unit is a power of two from {LEAST} to {MOST:,} faces, found {unit!r}"
            )

    def contents(self, rig: Rig, sampler: FaceSampler) -> dict[str, Any]:
        """What is chosen of each content, as JSON.

        Raises:
            ParameterError: What cannot be meant for this rig.
        """
        chosen: dict[str, Any] = {}
        if self.vertices is not None:
            poser = Poser(rig, sampler.columns)
            chosen["vertices"] = Encoding.of(poser, self.vertices, self.tolerance).as_json()
        elif self.tolerance is not None:
            raise ParameterError("a tolerance is for stored vertices: name their type, as 'int16'")
        if self.normals and not len(rig.neutral.faces):
            raise ParameterError("the rig has no polygons, so its vertices have no normals")
        if self.normals:
            chosen["normals"] = {}
        given = self.landmarks if self.landmarks is not None else sampler.recipe.landmarks or None
        landmarks = {} if given is None else _landmarks(rig, given)
        if landmarks:
            chosen["landmarks"] = landmarks
        pictures = sampler.recipe.pictures
        if pictures is not None:
            chosen["pictures"] = {
                "size": pictures.size,
                "arrays": list(pictures.arrays),
                "landmarks": landmarks,
            }
        return chosen


def pictured(recipe: Any, render: int | None) -> Recipe:
    """A user's recipe, with pictures of so many pixels if they are asked for.

    Raises:
        FileError: The recipe cannot be read.
        ParameterError: It is none, or pictures of such a size cannot be drawn.
    """
    own = as_recipe(recipe)
    if render is None:
        return own
    sides = keys_of(Pictures)["size"]
    if not is_whole(render) or not sides.holds(render):
        raise ParameterError(
            f"pictures have {sides.least:g} to {sides.most:g} pixels a side, found {render!r}"
        )
    return own.pictured(int(render))


def _landmarks(rig: Rig, given: Mapping[str, int] | str) -> dict[str, int]:
    count = len(rig.neutral.vertices)
    if isinstance(given, str):
        from elastomorph.capturing.landmarks import known_landmarks

        known = known_landmarks(rig.neutral.name, rig.neutral, given)
        if not known:
            raise ParameterError(
                f"the points {given!r} of this rig are not known: give vertices by name, as "
                "'elastomorph landmarks' places them"
            )
        return known
    if not isinstance(given, Mapping) or not given:
        raise ParameterError(f"landmarks are vertices by name, found {given!r}")
    for name, vertex in given.items():
        if not is_whole(vertex) or not 0 <= vertex < count:
            raise ParameterError(
                f"the landmark {name!r} is the vertex {vertex!r}, expected 0 to {count - 1:,}"
            )
    return {str(name): int(vertex) for name, vertex in given.items()}
