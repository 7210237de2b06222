"""What a folder holds of a character: the neutral, targets, scans, curves, regions, takes, rigs."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from elastomorph.errors import ElastomorphError, FileError
from elastomorph.io.atomic import read_bytes
from elastomorph.io.npz.members import open_npz
from elastomorph.io.performance import read_performance
from elastomorph.io.registry import MESH_FORMATS, RIG_FORMATS, known_suffixes, read
from elastomorph.io.rig_folder import find_neutral, rig_as_stored
from elastomorph.io.vertex_lists import read_curves, read_region

_FRAME = re.compile(r"(?P<before>.*[._-])(?P<number>[0-9]{3,})")
_BETWEEN = re.compile(r"(?P<target>.*?)[._-]?(?:(?P<share>0\.[0-9]+)|(?P<percent>[0-9]{1,2}))%?")
_LEAST_FRAMES = 3

Shape = TypeVar("Shape")


@dataclass(frozen=True)
class Survey:
    """The files of one folder, told apart by name and content."""

    folder: Path
    neutral: Path | None  # None where there is only a rig file
    targets: dict[str, Path]
    rig: Path | None  # that the character is made of, where there are no meshes
    vertices: int  # how many the neutral has
    shapes: tuple[str, ...]  # names of the targets, or of the morphs of the rig file
    # Targets that look like shapes on the way to another one: file by time.
    inbetweens: dict[str, dict[float, Path]] = field(default_factory=dict)
    # Patterns of numbered frames and archives of motion, and how many frames.
    sequences: dict[str, int] = field(default_factory=dict)
    curves: tuple[Path, ...] = ()  # that fit the neutral, as the next
    regions: tuple[Path, ...] = ()
    takes: tuple[Path, ...] = ()  # recorded performances
    other_rigs: tuple[Path, ...] = ()


def survey(
    folder: str | Path,
    neutral: str | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Survey:
    """Look at a folder, and where it has no targets at the folders in it."""
    place = Path(folder)
    files = _files_in(place)
    meshes, rigs, sequences = _told_apart(files)
    meshes, frames = _without_frames(place, meshes)
    sequences |= frames
    if not meshes and neutral is None:
        if not rigs:
            raise FileError(
                place,
                "there is neither a mesh nor a rig in this folder "
                f"({', '.join(known_suffixes(MESH_FORMATS) + known_suffixes(RIG_FORMATS)[:-1])})",
            )
        say(f"reading {rigs[0].name}")
        rig = rig_as_stored(rigs[0])
        vertices = len(rig.neutral.vertices)
        found = Survey(place, None, {}, rigs[0], vertices, tuple(rig.morphs))
        others = tuple(rigs[1:])
    else:
        rest = _neutral(place, neutral)
        targets = [file for file in meshes if file != rest]
        if not targets:
            for inner in sorted(file for file in place.iterdir() if file.is_dir()):
                if not inner.name.startswith("."):
                    targets += _told_apart(_files_in(inner))[0]
            targets, frames = _without_frames(place, targets)
            sequences |= frames
        say(f"reading {rest.name}")
        vertices = len(read(rest).vertices)
        by_name = _by_name(place, targets)
        found = Survey(place, rest, by_name, None, vertices, tuple(by_name))
        others = tuple(rigs)
    say("looking at curves, regions and takes")
    curves, regions = _lists(files, found.vertices)
    csv = [file for file in files if file.suffix.lower() == ".csv"]
    return replace(
        found,
        inbetweens=ways_by_name(found.targets),
        sequences=dict(sorted(sequences.items())),
        curves=curves,
        regions=regions,
        takes=tuple(file for file in csv if _fits(partial(read_performance, file))),
        other_rigs=others,
    )


def _files_in(place: Path) -> list[Path]:
    if not place.is_dir():
        what = "this is a file" if place.exists() else "there is no such folder"
        raise FileError(place, f"{what}; name the folder of a character")
    try:
        return sorted(
            file for file in place.iterdir() if file.is_file() and not file.name.startswith(".")
        )
    except OSError as error:
        raise FileError(place, f"this folder cannot be listed: {error.strerror}") from error


def _neutral(place: Path, name: str | None) -> Path:
    if name is None:
        return find_neutral(place)
    if not (place / name).is_file():
        raise FileError(place / name, "there is no such file to be the neutral; check its name")
    return place / name


def _told_apart(files: Iterable[Path]) -> tuple[list[Path], list[Path], dict[str, int]]:
    """Meshes, rig files, and archives of motion with their number of frames."""
    meshes: list[Path] = []
    rigs: list[Path] = []
    motions: dict[str, int] = {}
    for file in files:
        suffix = file.suffix.lower()
        if suffix == ".npz":
            members, frames = _members(file)
            if "rig_version" in members:
                rigs.append(file)
            elif "vertices" in members:
                meshes.append(file)
            elif "frames" in members:
                motions[file.name] = frames
        elif suffix in known_suffixes(MESH_FORMATS):
            meshes.append(file)
        elif suffix in known_suffixes(RIG_FORMATS):
            rigs.append(file)
    return meshes, rigs, motions


def _members(file: Path) -> tuple[frozenset[str], int]:
    """Names of the arrays of an archive, and how many frames of motion it has."""
    names: frozenset[str] = frozenset()
    with suppress(ElastomorphError), open_npz(file) as members:
        names = members.names
        if not names & {"rig_version", "vertices"} and "frames" in names:
            return names, len(members.array("frames", "fiu", (None, None, 3)))
    return names, 0


def _without_frames(place: Path, meshes: list[Path]) -> tuple[list[Path], dict[str, int]]:
    """Meshes that are no numbered frames, and the patterns of those that are."""
    groups: dict[str, list[Path]] = {}
    for file in meshes:
        if found := _FRAME.fullmatch(file.stem):
            pattern = file.with_name(f"{found['before']}{'#' * len(found['number'])}{file.suffix}")
            groups.setdefault(pattern.relative_to(place).as_posix(), []).append(file)
    frames = {name: own for name, own in groups.items() if len(own) >= _LEAST_FRAMES}
    taken = {file for own in frames.values() for file in own}
    counts = {name: len(own) for name, own in frames.items()}
    return [file for file in meshes if file not in taken], counts


def _by_name(place: Path, files: list[Path]) -> dict[str, Path]:
    targets: dict[str, Path] = {}
    for file in sorted(files, key=lambda file: (file.name, file)):
        if file.stem in targets:
            raise FileError(
                place,
                f"{targets[file.stem].relative_to(place)} and {file.relative_to(place)} are both "
                f"called '{file.stem}'; keep one file for each target",
            )
        targets[file.stem] = file
    if not targets:
        raise FileError(place, "there are no targets beside the neutral")
    return targets


def ways_by_name(targets: Mapping[str, Shape]) -> dict[str, dict[float, Shape]]:
    """What is on the way to a target by its name and when: jawOpen_30 or jawOpen_0.3 to jawOpen."""
    found: dict[str, dict[float, Shape]] = {}
    for name, shape in targets.items():
        parts = _BETWEEN.fullmatch(name)
        if parts is None or parts["target"] not in targets:
            continue
        time = float(parts["share"]) if parts["share"] else int(parts["percent"]) / 100
        if 0 < time < 1 and time not in found.get(parts["target"], {}):
            found.setdefault(parts["target"], {})[time] = shape
    return {name: dict(sorted(own.items())) for name, own in found.items()}


def _lists(files: list[Path], vertices: int) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Curve files and region files among all .json files."""
    curves, regions = [], []
    for file in files:
        if file.suffix.lower() != ".json":
            continue
        if _fits(partial(read_curves, file, vertices)):
            curves.append(file)
        elif _is_region(file, vertices):
            regions.append(file)
    return tuple(curves), tuple(regions)


def _is_region(file: Path, vertices: int) -> bool:
    try:
        content: Any = json.loads(read_bytes(file))
        named = isinstance(content, list) or "vertices" in content
        region: Sequence[int] = read_region(file).tolist() if named else ()
    except (ElastomorphError, ValueError, TypeError, RecursionError):
        return False
    return len(region) > 0 and max(region) < vertices


def _fits(reading: Callable[[], object]) -> bool:
    try:
        reading()
    except ElastomorphError:
        return False
    return True
