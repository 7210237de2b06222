"""Recorded takes as a mixture: moments of them, between frames, and what lies between two."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.character.settings import is_pattern
from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.sampling.columns import LEVELS, Codes, Columns
from elastomorph.farm.sampling.controls import Controls, KeyedError, Places
from elastomorph.farm.sampling.keys import key
from elastomorph.farm.sampling.lanes import Lanes, whole_numbers
from elastomorph.farm.sampling.mixtures import Drawing, Mixture, Rows, Tables
from elastomorph.io.npz.members import open_npz
from elastomorph.io.performance import read_performance
from elastomorph.io.untrusted import naming_file
from elastomorph.rig.performance.matching import match

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
