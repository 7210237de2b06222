"""The path of each target as settings want it: its method, its regions, its in-betweens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.character.settings import Inbetweens, Settings
from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import FormatError
from elastomorph.io.curve_file import read_curves
from elastomorph.io.region_file import read_region
from elastomorph.io.registry import read
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths import Method, prepare, through
from elastomorph.paths.patchwork import laid_over
from elastomorph.paths.region import blend_into_rest, weights_inside

__all__ = ["Part", "PathMaker"]


@dataclass(frozen=True, eq=False)
class Part:
    """The part of a face that paths are restricted to.

    Attributes:
        vertices: (N,) vertex indices.
        falloff: Rings of edges inside its border over which paths blend into the rest.
        rest: What the other vertices do, as for `elastomorph.interpolate`.
    """

    vertices: NDArray[np.int64]
    falloff: float = 3.0
    rest: str = "linear"


class PathMaker:
    """Makes the paths of a character from one neutral, each method prepared once.

    Args:
        settings: The settings.
        neutral: The face at rest.
        extent: D of the rig, see `elastomorph.rig.remade.extent_of`; that of the neutral by
            default.
        part: Where paths follow the settings; everywhere by default.

    Raises:
        FileError: A file of curves or of a region cannot be read.
        FormatError: One is not what it should be, or does not fit the neutral.
    """

    def __init__(
        self,
        settings: Settings,
        neutral: Mesh,
        extent: float | None = None,
        part: Part | None = None,
    ) -> None:
        self._settings = settings
        self._neutral = neutral
        self._extent = extent
        self._part = part
        self._prepared: dict[tuple[Method, str], Callable[[Mesh], Morph]] = {}
        self._regions = {
            name: (self._vertices(name, region.vertices), region)
            for name, region in settings.regions.items()
        }

    def path(self, name: str, target: Mesh, own: Morph | None = None) -> Morph:
        """The path to one target.

        Args:
            name: Its name, by which settings know it.
            target: Its mesh.
            own: The path that it has already, which stays where settings state no method, unless
                it is bare.

        Raises:
            ElastomorphError: As `elastomorph.interpolate` and `elastomorph.through`.
        """
        morph = self._everywhere(name, target, own)
        if self._part is None:
            return morph
        weights = weights_inside(
            self._neutral, self.network, self._part.vertices, self._part.falloff
        )
        return blend_into_rest(lambda _: morph, weights, self._part.rest)(target)

    def _everywhere(self, name: str, target: Mesh, own: Morph | None) -> Morph:
        if name in self._settings.inbetweens:
            return self._through(target, self._settings.inbetweens[name])
        choice = self._settings.choice_for(name)
        stays = own is not None and not own.bare and not choice
        below = None if stays else choice.method()
        start = own if own is not None and stays else self._made(choice.method(), "")(target)
        morph = start
        for region, (_, settings) in self._regions.items():
            method = settings.choice.over(choice).method()
            if morph is start and below is not None and method == below:
                continue
            over = self._made(method, region)(target)
            label = f"{morph.method}, {region}: {over.method}"
            morph = laid_over(morph, over, self._weights[region], label)
        return morph

    @cached_property
    def network(self) -> CurveNetwork:
        """The curves that beams follow, the artists' own first."""
        file = self._settings.character.curves
        count = len(self._neutral.vertices)
        keep = () if file is None else read_curves(self._settings.file(file), count)
        return extract_curves(self._neutral, keep)

    @cached_property
    def _weights(self) -> dict[str, NDArray[np.float64]]:
        return {
            name: weights_inside(self._neutral, self.network, vertices, region.falloff)
            for name, (vertices, region) in self._regions.items()
        }

    def _made(self, method: Method, region: str) -> Callable[[Mesh], Morph]:
        """A method on the whole face, or on the curves inside a region."""
        if (method, region) not in self._prepared:
            curves = None
            if method.on_curves or not len(self._neutral.faces):
                curves = self.network
                if region:
                    curves = curves.restricted(self._regions[region][0])
                if self._part is not None:
                    curves = curves.restricted(self._part.vertices)
            extent = self._extent if "extent" in method.inputs() else None
            self._prepared[method, region] = prepare(
                self._neutral, method, curves=curves, extent=extent
            )
        return self._prepared[method, region]

    def _through(self, target: Mesh, between: Inbetweens) -> Morph:
        shapes = {time: read(self._settings.file(file)) for time, file in between.files.items()}
        return through(self._neutral, target, shapes, method=between.method)

    def _vertices(self, name: str, written: str | tuple[int, ...]) -> NDArray[np.int64]:
        is_file = isinstance(written, str) and written.lower().endswith(".json")
        if isinstance(written, str):
            vertices = read_region(self._settings.file(written) if is_file else written)
        else:
            vertices = np.array(written, dtype=np.int64)
        count = len(self._neutral.vertices)
        if not len(vertices) or vertices.max() >= count:
            what = f"names vertex {vertices.max():,}" if len(vertices) else "is empty"
            raise FormatError(
                self._settings.path,
                f"the region {name!r} {what}; {self._neutral.name} has the vertices 0 to "
                f"{count - 1:,}",
            )
        return vertices
