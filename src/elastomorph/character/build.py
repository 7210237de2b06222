"""The rig that settings describe: its files, and a path to each target by its own method."""

from __future__ import annotations

import glob
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.character.settings import Settings, is_pattern
from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import FileError, FormatError
from elastomorph.io.registry import MESH_FORMATS, known_suffixes, read
from elastomorph.io.rig_cache import RigCache, read_or_build
from elastomorph.io.rig_folder import find_neutral, find_rig_files, read_targets, rig_as_stored
from elastomorph.io.simplex import read_correctives
from elastomorph.io.vertex_lists import read_curves, read_region
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths import Method, prepare, through
from elastomorph.paths.region import blend_into_rest, laid_over, weights_inside
from elastomorph.rig import Rig
from elastomorph.rig.build import bare_rig, extent_of
from elastomorph.rig.laws import Corrective
from elastomorph.rig.pairs import pair_bends


def rig_from_settings(
    settings: Settings,
    *,
    cache: bool | str | Path | None = True,
    say: Callable[[str], None] = lambda _: None,
    stored: Rig | None = None,
) -> Rig:
    """The rig of a character.

    Args:
        settings: As `elastomorph.character.read_settings` gives them.
        cache: Where the finished rig is kept, as for `elastomorph.io.rig_folder.read_rig_folder`.
            One that was not made from exactly these files and settings is not used.
        say: Told what is being done.
        stored: What is in the rig file, where it was read already.

    Returns:
        The rig; its morphs in the order of the names of their files, or of the rig file.

    Raises:
        FileError: A file is missing, or two targets have one name.
        FormatError: A file is not what its format allows, or the settings name what is not there.
        TopologyError: A target has other vertices or polygons than the neutral.
        ResonanceError: A material is singular for its load.
    """
    sources = find_sources(settings)
    if sources.rig is None:
        settings.require_names(sources.targets)
    place = RigCache.of(cache, settings.path.parent, _what_paths_depend_on(settings))
    files = {file: str(file) for file in sources.all}

    def built() -> Rig:
        return _built(settings, sources, stored, say)

    return read_or_build(place, files, settings.path, built, say)


def _built(
    settings: Settings, sources: Sources, stored: Rig | None, say: Callable[[str], None]
) -> Rig:
    """Of meshes; or a rig file, its paths made anew where the settings state a method."""
    if sources.rig is None:
        say(f"reading {sources.main.name}")
        neutral = read(sources.main)
        rig = bare_rig(neutral, read_targets(neutral, sources.targets, say))
    else:
        say(f"reading {sources.rig}")
        own = settings.character.mesh or None
        rig = rig_as_stored(sources.rig, mesh=own, root=settings.root) if stored is None else stored
        settings.require_names(rig.morphs)
    maker = PathMaker(settings, rig.neutral, rig)
    targets = rig.targets
    morphs: dict[str, Morph] = {}
    for name, target in targets.items():
        what = name if sources.rig else f"the path to {name}"
        say(f"{what}, {len(morphs) + 1} of {len(targets)}")
        morphs[name] = maker.path(name, target, own=rig[name])
    given = dict(settings.correctives)
    if settings.character.correctives is not None:
        given = read_correctives(settings.file(settings.character.correctives), targets) | given
    groups = settings.members(morphs) or rig.sliders.groups
    return maker.rig(rig, morphs, _correctives(rig, given), groups, say)


def _correctives(rig: Rig, given: Mapping[str, Corrective]) -> dict[str, Corrective]:
    """Those of settings in place of those of a rig, but for pair bends, which stay.

    Unless what drives them is now a corrective itself, or settings drive them otherwise.
    """
    if not given:
        return dict(rig.sliders.correctives)
    pairs = rig.pair_bends().items()
    return {n: own for n, own in pairs if not given.keys() & {*own.drivers}} | dict(given)


def _what_paths_depend_on(settings: Settings) -> list[object]:
    """All of the settings but names, units, timing and export, which change no path."""
    plain = replace(settings.character, name="", unit=None)
    names = ("method", "methods", "regions", "inbetweens", "groups", "correctives")
    return [plain, *(getattr(settings, name) for name in names)]


@dataclass(frozen=True, eq=False)
class Part:
    """The vertices (N,) that paths are restricted to."""

    vertices: NDArray[np.int64]
    falloff: float = 3.0  # rings of edges inside its border over which paths blend into the rest
    rest: str = "linear"  # what the other vertices do, as for `elastomorph.interpolate`


class PathMaker:
    """Makes the paths of a character from one neutral, each method prepared once.

    Args:
        settings: The settings.
        neutral: The face at rest.
        rig: All targets, whose D counts, and which say what is one; else every target by itself
            and D of the neutral.
        part: Where paths follow the settings; everywhere by default.

    Raises:
        FileError: A file of curves or of a region cannot be read.
        FormatError: One is not what it should be, or does not fit the neutral.
    """

    def __init__(
        self,
        settings: Settings,
        neutral: Mesh,
        rig: Rig | None = None,
        part: Part | None = None,
    ) -> None:
        self._settings = settings
        self._neutral = neutral
        self._extent = None if rig is None else extent_of(rig)
        self._targets = None if rig is None else [own.target for own in rig.morphs.values()]
        self._part = part
        self._prepared: dict[tuple[Method, str], Callable[[Mesh], Morph]] = {}
        self._regions = {
            name: (self._vertices(name, region.vertices), region)
            for name, region in settings.regions.items()
        }

    def with_settings(self, settings: Settings) -> PathMaker:
        """The same maker with other methods: what was prepared for the neutral serves again."""
        other = copy(self)
        other._settings = settings
        return other

    def path(self, name: str, target: Mesh, own: Morph | None = None) -> Morph:
        """The path to one target, which settings know by its name.

        The path that it has already stays where settings state no method, unless it is bare.
        """
        morph = self._everywhere(name, target, own)
        if self._part is None:
            return morph
        weights = weights_inside(
            self._neutral, self.network, self._part.vertices, self._part.falloff
        )
        return blend_into_rest(lambda _: morph, weights, self._part.rest)(target)

    def rig(
        self,
        before: Rig,
        morphs: Mapping[str, Morph],
        correctives: Mapping[str, Corrective],
        groups: Mapping[str, Sequence[str]],
        say: Callable[[str], None] = lambda _: None,
    ) -> Rig:
        """The rig of paths, with a pair bend of those that turn and meet.

        Pair bends of the rig before stay where both paths are what they were.
        """
        made = {name for name, morph in morphs.items() if morph is not before[name]}
        kept, whole = before.pair_bends(made).keys() & correctives.keys(), dict(morphs)
        gone = before.pair_bends().keys() - kept
        whole |= {name: before[name] for name in before if name in kept}
        left = {name: own for name, own in correctives.items() if name not in gone}
        others = {name for pair in gone for name in before.sliders.drivers(pair)}
        among = [
            n for n, m in morphs.items() if self._turns(n, m.choice is not None or n in others)
        ]
        if made and among:
            # The path to both is made as most are, if those turn.
            path = partial(self.path, "" if self._turns("") else among[0])
            scale = self._extent or self._neutral.diameter
            pairs, driven = pair_bends(self._neutral, whole, left, path, scale, among, say, made)
            whole, left = whole | pairs, left | driven
        return Rig(self._neutral, whole, correctives=left, groups=groups)

    def _turns(self, name: str, otherwise: bool = True) -> bool:
        """Whether the method stated for a target turns what moves; otherwise where none is."""
        choice = self._settings.choice_for(name)
        between = name in self._settings.inbetweens
        return not between and (choice.method().turns if choice else otherwise)

    def _everywhere(self, name: str, target: Mesh, own: Morph | None) -> Morph:
        if between := self._settings.inbetweens.get(name):
            shapes = {t: read(self._settings.file(file)) for t, file in between.files.items()}
            return through(self._neutral, target, shapes, method=between.method)
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
            curves, character = None, self._settings.character
            limited = bool(region) or self._part is not None or character.curves is not None
            if (method.on_curves and limited) or not len(self._neutral.faces):
                curves = self.network
                if region:
                    curves = curves.restricted(self._regions[region][0])
                if self._part is not None:
                    curves = curves.restricted(self._part.vertices)
            extent = self._extent if "extent" in method.inputs() else None
            self._prepared[method, region] = prepare(
                self._neutral,
                method,
                curves=curves,
                extent=extent,
                weld=character.weld,
                targets=self._targets,
            )
        return self._prepared[method, region]

    def _vertices(self, name: str, written: str | tuple[int, ...]) -> NDArray[np.int64]:
        if isinstance(written, str):
            is_file = written.lower().endswith(".json")
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


@dataclass(frozen=True)
class Sources:
    """The files of a character: a rig file, or the meshes of a neutral and its targets by name."""

    main: Path  # that the neutral comes from
    rig: Path | None
    targets: dict[str, Path]  # none where there is a rig file
    beside: tuple[Path, ...]  # every other file that paths depend on: curves, regions, in-betweens

    @property
    def all(self) -> tuple[Path, ...]:
        """Every file, in an order that depends on names alone."""
        return (self.main, *self.targets.values(), *self.beside)


def find_sources(settings: Settings) -> Sources:
    """The files of the character of settings."""
    character = settings.character
    lists = (character.curves, character.correctives)
    beside = [name for name in lists if name is not None]
    for region in settings.regions.values():
        if isinstance(region.vertices, str) and region.vertices.lower().endswith(".json"):
            beside.append(region.vertices)
    between = [name for own in settings.inbetweens.values() for name in own.files.values()]
    others = tuple(settings.file(name) for name in (*beside, *between))
    if character.rig is not None:
        rig = settings.file(character.rig)
        return Sources(rig, rig, {}, others)
    neutral = None if character.neutral is None else settings.file(character.neutral)
    on_the_way = {_whole(settings.file(name)) for name in between}
    if not character.targets:
        files = find_rig_files(character.folder, neutral)
        targets = {n: f for n, f in files.targets.items() if _whole(f) not in on_the_way}
        return Sources(files.neutral, None, targets, others)
    neutral = find_neutral(character.folder) if neutral is None else neutral
    left_out = on_the_way | {_whole(neutral)}
    return Sources(neutral, None, _targets(settings, left_out), others)


def _targets(settings: Settings, left_out: set[Path]) -> dict[str, Path]:
    suffixes = known_suffixes(MESH_FORMATS)
    found: dict[Path, Path] = {}
    for pattern in settings.character.targets:
        exact = settings.file(pattern)
        files = [exact] if exact.is_file() else []
        if not files and is_pattern(pattern):
            # Not Path.glob: it takes no absolute patterns, and hidden files for others.
            names = glob.glob(pattern, root_dir=settings.path.parent)  # noqa: PTH207
            files = [settings.file(name) for name in names]
            files = [f for f in files if f.suffix.lower() in suffixes and f.is_file()]
        if not files:
            raise FileError(
                settings.path,
                f"'character.targets': {pattern!r} stands for no mesh file "
                f"({', '.join(suffixes)}) in {settings.path.parent}",
            )
        found |= {whole: file for file in files if (whole := _whole(file)) not in left_out}
    targets: dict[str, Path] = {}
    for file in sorted(found.values(), key=lambda file: (file.name, file)):
        if file.stem in targets:
            raise FileError(
                settings.path,
                f"{targets[file.stem]} and {file} are both called '{file.stem}'; keep one file "
                "for each target",
            )
        targets[file.stem] = file
    if not targets:
        raise FileError(settings.path, "there are no targets beside the neutral and in-betweens")
    return targets


def _whole(file: Path) -> Path:
    try:
        return file.resolve()
    except (OSError, RuntimeError):
        return file.absolute()
