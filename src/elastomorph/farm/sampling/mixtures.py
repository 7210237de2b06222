"""Kinds of mixture: from random lanes to codes of sliders, many faces at once.

Recorded takes are one: moments of them, between frames, and what lies between two.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.character.settings import is_pattern
from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.sampling.columns import LEVELS, Codes, Columns
from elastomorph.farm.sampling.controls import Controls, KeyedError, Places
from elastomorph.farm.sampling.keys import key
from elastomorph.farm.sampling.lanes import Lanes, below, gamma, sizes, whole_numbers
from elastomorph.io.npz.members import open_npz
from elastomorph.io.performance import read_performance
from elastomorph.io.untrusted import naming_file
from elastomorph.rig.performance import match

Rows = NDArray[np.int64]
Tables = Mapping[str, NDArray[Any]]

_MOST_IN_GRID = 2**31
_CHANCES = LEVELS + 1


class Drawing(ABC):
    """A mixture made ready for a rig.

    Attributes:
        lanes: How many lanes of a face it uses.
        count: How many faces it has, where they are numbered; None where they are drawn.
        tables: Arrays that it read from files, by name.
        said: What else there is to say of it on this rig, for people.
    """

    lanes: int
    count: int | None = None
    tables: Tables = {}  # noqa: RUF012  (a default that nobody changes)
    said: str = ""

    def __init__(self, controls: Controls, chosen: Places) -> None:
        self.chosen = chosen
        self.columns = Columns(tuple(controls.columns[int(place)] for place in chosen))
        self._rest = controls.columns.rest
        self._all = len(chosen) == len(self._rest)

    def codes(self, lanes: Lanes, rows: Rows | None) -> Codes:
        """(n, J) codes of all sliders from (n, lanes) bits; those that are not chosen at rest.

        With (n,) rows, the faces of these numbers where faces are numbered.
        """
        own = self.draw(lanes, rows)
        if self._all:
            return own
        codes = np.repeat(self._rest[None], len(own), axis=0)
        codes[:, self.chosen] = own
        return codes

    @abstractmethod
    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        """(n, chosen) codes of the sliders that it moves."""


@dataclass(frozen=True, kw_only=True)
class Mixture(ABC):
    """How the sliders of some of the faces are drawn; one class a kind."""

    kind: ClassVar[str]
    share: float = key(
        1.0, "number", "how many of all faces, beside the others", "0.6", above=0, most=1e9
    )
    sliders: tuple[str, ...] = key(
        (), "texts", "names, patterns or groups that it moves; all by default", '["jaw*", "lids"]'
    )

    def prepared(self, controls: Controls, tables: Tables | None = None) -> Drawing:
        """The mixture for the sliders of a rig, with the tables that were kept or from its files.

        Raises:
            KeyedError: It does not suit the rig.
            FileError: A file that it names cannot be read.
        """
        return self._drawing(controls, controls.chosen(self.sliders, ("sliders",)), tables)

    @abstractmethod
    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing: ...


@dataclass(frozen=True, kw_only=True)
class Sparse(Mixture):
    """Each slider on or off by itself."""

    kind = "sparse"
    active: float | None = key(
        None, "number", "how many are on, on average; by default 6, or half of fewer than 12", "6",
        above=0,
    )  # fmt: skip
    power: float = key(
        1.0, "number", "a slider that is on is at u^power of its range, u uniform", "2",
        above=0, most=100,
    )  # fmt: skip
    symmetric: float = key(
        0.7, "number", "share of its faces whose sides are alike", "0.5", least=0, most=1
    )

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        return _Sparse(self, controls, chosen)


class _Sparse(Drawing):
    def __init__(self, mixture: Sparse, controls: Controls, chosen: Places) -> None:
        super().__init__(controls, chosen)
        count = len(chosen)
        active = min(6, count / 2) if mixture.active is None else mixture.active
        chances = round(active / count * _CHANCES)
        if not 0 < chances <= _CHANCES:
            raise KeyedError(
                ("active",),
                f"of {count} sliders {active:g} cannot be on, on average; from "
                f"{count / _CHANCES:.2g} to {count} can",
            )
        self.lanes = 2 * count + 1
        self.last_on = chances - 1
        self.least_unlike = round(mixture.symmetric * _CHANCES)
        place = {int(column): i for i, column in enumerate(chosen)}
        pairs = [(place[a], place[b]) for a, b in controls.pairs if a in place and b in place]
        self.said = f"; {len(pairs)} pairs of sides"
        self.left, self.right = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        # A table for all sliders that rest at one code; one from 0 of a uniform size needs none.
        self.sizes = [
            (np.flatnonzero(self.columns.rest == rest), sizes(int(rest), mixture.power))
            for rest in np.unique(self.columns.rest)
            if mixture.power != 1 or rest
        ]

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        count = len(self.chosen)
        size = lanes[:, count : 2 * count] * (lanes[:, :count] <= self.last_on)
        if self.left.size:
            alike = lanes[:, 2 * count, None] < self.least_unlike
            size[:, self.right] = np.where(alike, size[:, self.left], size[:, self.right])
        for places, table in self.sizes:
            if len(places) == count:
                return table[size]
            size[:, places] = table[size[:, places]]
        return size


@dataclass(frozen=True, kw_only=True)
class Uniform(Mixture):
    """Each slider anywhere in its range."""

    kind = "uniform"

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        return _Uniform(controls, chosen)


class _Uniform(Drawing):
    def __init__(self, controls: Controls, chosen: Places) -> None:
        super().__init__(controls, chosen)
        self.lanes = len(chosen)

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        return lanes[:, : self.lanes]


@dataclass(frozen=True, kw_only=True)
class Dirichlet(Mixture):
    """Weights of one sum, drawn by Dirichlet's law."""

    kind = "dirichlet"
    concentration: float = key(
        1.0, "number", "1: all mixtures alike; less: few sliders each", "0.3", least=0.05, most=1000
    )
    sum: float = key(
        1.0, "number", "of the weights of a face, before limits", "1.5", above=0, most=1e6
    )

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        return _Dirichlet(self, controls, chosen)


class _Dirichlet(Drawing):
    def __init__(self, mixture: Dirichlet, controls: Controls, chosen: Places) -> None:
        super().__init__(controls, chosen)
        most = sum(max(column.high, 0.0) for column in self.columns)
        least = sum(max(column.low, 0.0) for column in self.columns)
        if mixture.sum < least * (1 - 1e-9):
            raise KeyedError(
                ("sum",),
                f"weights whose limits add up to at least {least:g} cannot sum to {mixture.sum:g}",
            )
        if mixture.sum > most * (1 + 1e-9):
            raise KeyedError(
                ("sum",), f"weights whose limits add up to {most:g} cannot sum to {mixture.sum:g}"
            )
        self.lanes = len(chosen)
        self.sum = mixture.sum
        # Numbers of gamma laws over their sum are of Dirichlet's.
        self.quantiles = gamma(mixture.concentration)

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        parts = self.quantiles[lanes[:, : self.lanes]]
        return self.columns.encode(parts * (self.sum / parts.sum(axis=1, keepdims=True)))


@dataclass(frozen=True, kw_only=True)
class Grid(Mixture):
    """All combinations of levels, but the one of the lowest; alone in a recipe, in their order."""

    kind = "grid"
    levels: int = key(
        6, "whole", "values of each slider, evenly over its range", "6", least=2, most=_CHANCES
    )
    normalize: bool = key(False, "flag", "divide the weights of a face by their sum", "true")

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        return _Grid(self, controls, chosen)


class _Grid(Drawing):
    lanes = 2

    def __init__(self, mixture: Grid, controls: Controls, chosen: Places) -> None:
        # What has one value only has no levels: each face would be there several times.
        chosen = np.array([i for i in chosen if controls.columns[int(i)].varies], dtype=np.intp)
        if not chosen.size:
            raise KeyedError(("sliders",), "their limits leave each of these sliders one value")
        super().__init__(controls, chosen)
        self.base = mixture.levels
        if self.base ** len(chosen) > _MOST_IN_GRID:
            raise KeyedError(
                ("sliders",) if mixture.sliders else (),
                f"{self.base} levels of {len(chosen)} sliders are more than {_MOST_IN_GRID:,} "
                "faces; name fewer sliders or fewer levels",
            )
        if mixture.normalize and any(column.low < 0 for column in self.columns):
            raise KeyedError(("normalize",), "weights below 0 cannot be divided by their sum")
        self.count: int = self.base ** len(chosen) - 1
        self.normalize = mixture.normalize
        self.places = self.base ** np.arange(len(chosen) - 1, -1, -1)
        steps = np.arange(self.base)
        self.steps = np.rint(steps * LEVELS / (self.base - 1)).astype(np.uint16)

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        numbers = below(lanes, self.count) if rows is None else rows
        codes: Codes = self.steps[(numbers[:, None] + 1) // self.places % self.base]
        if self.normalize:
            values = self.columns.decode(codes)
            codes = self.columns.encode(values / values.sum(axis=1, keepdims=True))
        return codes


Floats = NDArray[np.float64]

_MOST_CODES = 1 << 27


class _Recorded(NamedTuple):
    """What is recorded in a file: (T,) seconds and (T, N) weights of N names."""

    names: tuple[str, ...]
    times: Floats
    weights: Floats


@dataclass(frozen=True, kw_only=True)
class Take(Mixture):
    """Moments of recorded takes, each as likely as any other."""

    kind = "take"
    files: tuple[str, ...] = key(
        (), "texts", "recordings (.csv, .npz, .glb), or patterns", '["takes/*.csv"]', needed=True
    )
    mixed: float = key(
        0.0, "number", "share of its faces that lie between two moments", "0.3", least=0, most=1
    )

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        if tables is None:
            tables = _read(self.files, controls, chosen)
        return _Take(self, controls, chosen, tables)


class _Take(Drawing):
    lanes = 6

    def __init__(self, take: Take, controls: Controls, chosen: Places, tables: Tables) -> None:
        super().__init__(controls, chosen)
        self.tables = tables
        self.clock, self.frames = _checked(tables, len(chosen))
        self.least_alone = round(take.mixed * (LEVELS + 1))

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        moment = self._at(lanes[:, :2])
        mixed = np.flatnonzero(lanes[:, 4] < self.least_alone)
        if mixed.size:
            way = lanes[mixed, 5, None] / LEVELS
            moment[mixed] += way * (self._at(lanes[mixed, 2:4]) - moment[mixed])
        codes: Codes = np.rint(moment).astype(np.uint16)
        return codes

    def _at(self, lanes: Lanes) -> Floats:
        """(n, chosen) codes, as they go straight from frame to frame, at random moments."""
        moment = whole_numbers(lanes) * (self.clock[-1] / 2.0**32)
        # Where a take begins the one before ends: of equal times the last is found.
        before = np.searchsorted(self.clock, moment, side="right") - 1
        gap = self.clock[before + 1] - self.clock[before]
        way = ((moment - self.clock[before]) / gap)[:, None]
        first = self.frames[before].astype(np.float64)
        return np.asarray(first + way * (self.frames[before + 1] - first))


def _read(files: tuple[str, ...], controls: Controls, chosen: Places) -> Tables:
    """The frames of all takes as codes, and a clock that goes on from each to the next."""
    clocks: list[Floats] = []
    frames: list[Codes] = []
    end, size = 0.0, 0
    columns = tuple(controls.columns[int(place)] for place in chosen)
    for path in _found(files, controls.folder):
        for recorded in _recorded(path):
            with naming_file(path):
                by = match(recorded.names, controls.sliders.names)
            driven = [i for i, column in enumerate(columns) if column.name in by.drives]
            if not driven:
                raise KeyedError(
                    ("files",),
                    f"no weight of {path.name} drives a slider that this mixture moves; "
                    "'elastomorph animate --list' shows the names of both",
                )
            if len(recorded.times) < 2:
                raise KeyedError(("files",), f"{path.name} has one frame; a take has two or more")
            size += len(recorded.times) * len(columns)
            if size > _MOST_CODES:
                raise KeyedError(
                    ("files",),
                    f"the takes up to {path.name} have more than {_MOST_CODES:,} weights; name "
                    "fewer takes or fewer sliders",
                )
            weights = by.drive(recorded.weights)[:, chosen]
            frames.append(Columns(columns).encode(weights))
            clocks.append(end + recorded.times - recorded.times[0])
            end = float(clocks[-1][-1])
    return {"clock": np.concatenate(clocks), "frames": np.concatenate(frames)}


def _checked(tables: Tables, count: int) -> tuple[Floats, Codes]:
    """The tables, as a data set has kept them."""
    clock, frames = tables.get("clock"), tables.get("frames")
    if (
        clock is None
        or frames is None
        or clock.dtype != np.float64
        or frames.dtype != np.uint16
        or clock.ndim != 1
        or len(clock) < 2
        or frames.shape != (len(clock), count)
        or not np.isfinite(clock).all()
        or not (np.diff(clock) >= 0).all()
        or not clock[-2] < clock[-1]
    ):
        raise ParameterError("the takes kept with the faces are damaged, or of another rig")
    return clock, frames


def _found(words: tuple[str, ...], folder: Path) -> list[Path]:
    """The files that names and patterns mean, each once."""
    found: dict[Path, None] = {}
    for word in words:
        place = folder / word
        if is_pattern(word):
            root = Path(place.anchor)
            paths = sorted(root.glob(str(place.relative_to(root))))
            if not paths:
                raise KeyedError(("files",), f"no file is called like {word!r} in {folder}")
        else:
            paths = [place]
        found.update(dict.fromkeys(paths))
    return list(found)


def _recorded(path: Path) -> Iterator[_Recorded]:
    """What is recorded in a file: one take, or as many as a .glb has animations."""
    suffix = path.suffix.lower()
    if suffix in (".glb", ".gltf"):
        yield from _clips(path)
    elif suffix == ".npz":
        yield _arrays(path)
    else:
        performance = read_performance(path)
        yield _Recorded(performance.names, performance.times, performance.weights)


def _clips(path: Path) -> Iterator[_Recorded]:
    from elastomorph.io.gltf import read_glb
    from elastomorph.io.gltf.clips import read_weight_clips

    rig = read_glb(path)
    found = read_weight_clips(path, rig.sliders)
    clips = [clip for clip in found if len(clip.times) > 1 and clip.weights.any()]
    if not clips:
        raise FormatError(path, "no animation in it moves morph targets, so there is no take in it")
    for clip in clips:
        yield _Recorded(rig.names, clip.times, clip.weights)


def _arrays(path: Path) -> _Recorded:
    """An archive with 'names' (N), 'times' (T) in seconds and 'weights' (T, N)."""
    with open_npz(path) as members:
        names = tuple(members.texts("names"))
        times = members.array("times", "f", (None,)).astype(np.float64)
        weights = members.array("weights", "f", (len(times), len(names))).astype(np.float64)
    rising = np.isfinite(times).all() and (np.diff(times) > 0).all()
    if not rising or not np.isfinite(weights).all():
        raise FormatError(path, "times must rise, and times and weights be finite numbers")
    return _Recorded(names, times, weights)
