"""A settings file written from what a folder holds and its names suggest, to go on from.

In the file, prose stands behind ``# ``. Lines that begin with ``#`` and no space are settings to
switch on: without the ``#`` they are valid, one by one and all together.

What a folder holds of a character: the neutral, targets, scans, curves, regions, takes, rigs.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from textwrap import wrap
from typing import Any, TypeVar

import tomlkit
from jinja2 import Environment, PackageLoader, StrictUndefined

from elastomorph.character.read import FILE_NAME
from elastomorph.errors import ElastomorphError, FileError
from elastomorph.io.atomic import read_bytes, replacing
from elastomorph.io.npz.members import open_npz
from elastomorph.io.performance import read_performance
from elastomorph.io.registry import MESH_FORMATS, RIG_FORMATS, known_suffixes, read
from elastomorph.io.rig_folder import find_neutral, rig_as_stored
from elastomorph.io.vertex_lists import read_curves, read_region
from elastomorph.rig.naming import ARKIT, shape_of, wholes

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
        found = Survey(place, None, {}, rigs[0], vertices, tuple(rig.targets))
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


_WIDTH = 88
_MOST_NAMES = 60
_TURNING = re.compile(r"jawOpen|eyeBlink|eyeLook|blink|look")
_TURNING_WORDS = re.compile(
    r"jaw[._ -]?(open|drop|down)|mouth[._ -]?open|blink|lid[._ -]?clos", re.I
)
_PARTS = ("brow", "eye", "cheek", "nose", "jaw", "mouth", "tongue")


def write_settings(
    folder: str | Path,
    *,
    neutral: str | None = None,
    force: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> tuple[Path, Survey]:
    """Write the settings file of a folder, whole or not at all; the file, and what was found.

    ``neutral`` is the name of its file, where that does not tell; ``force`` replaces settings that
    are there.
    """
    file = Path(folder) / FILE_NAME
    if file.exists() and not force:
        raise FileError(file, "there are settings already; --force replaces them")
    found = survey(folder, neutral, say)
    text = settings_text(found)
    with replacing(file) as page:
        page.write(text.encode())
    return file, found


def settings_text(found: Survey) -> str:
    """The settings file for what was found in a folder."""
    between = {path.stem for own in found.inbetweens.values() for path in own.values()}
    ends = [name for name in found.shapes if name not in between]
    corrected = correctives(found.shapes)
    plain = [name for name in ends if name not in corrected]
    page = Environment(
        loader=PackageLoader("elastomorph.character"),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    page.filters |= {
        "key": _key,
        "list_of": _list,
        "plain": _plain,
        "prose": lambda text: "".join(f"# {line}\n" for line in wrap(text, _WIDTH)),
        "relative": lambda file: file.relative_to(found.folder).as_posix(),
        "text": _text,
    }
    more = ["…"] if len(found.shapes) > _MOST_NAMES else []
    return page.get_template(FILE_NAME).render(
        found=found,
        title=found.folder.name or found.folder.resolve().name or "face",
        targets=None if found.rig else _targets(found),
        shapes=", ".join([*found.shapes[:_MOST_NAMES], *more]),
        arkit=arkit_names(found.shapes),
        missing=missing_arkit(found.shapes),
        turning=[name for name in turning(plain) if name not in found.inbetweens],
        correctives=corrected,
        groups=slider_groups(ends),
    )


def _targets(found: Survey) -> str:
    """Patterns where they say exactly which files are meant, otherwise every file."""
    files = set(found.targets.values())
    patterns = sorted({(file.parent, file.suffix) for file in files})
    caught: set[Path] = set()
    for folder, suffix in patterns:
        caught |= {
            file
            for file in folder.iterdir()
            if file.suffix == suffix and not file.name.startswith(".") and file.is_file()
        }
    plain = all(letter not in str(folder.name) for folder, _ in patterns for letter in "*?[")
    if caught - {found.neutral} == files and plain:
        named = [folder / f"*{suffix}" for folder, suffix in patterns]
    else:
        named = list(found.targets.values())
    shown = [file.relative_to(found.folder).as_posix() for file in named]
    if len(shown) == 1:
        return _text(shown[0])
    lines = wrap(", ".join(_text(name) for name in shown), _WIDTH, break_on_hyphens=False)
    # A name with a space must not be broken across two lines.
    whole = all(" " not in name for name in shown)
    return "\n".join(["[", *(f"  {line}" for line in lines), "]"]) if whole else _list(shown)


def _list(names: Iterable[str]) -> str:
    return f"[{', '.join(_text(name) for name in names)}]"


def _text(value: str) -> str:
    """A TOML string."""
    return tomlkit.string(_unicode(value)).as_string()


def _key(name: str) -> str:
    return tomlkit.key(_unicode(name)).as_string()


def _unicode(value: str) -> str:
    try:
        value.encode()
    except UnicodeEncodeError:
        raise FileError(
            value.encode("ascii", "backslashreplace").decode(),
            "the name of this file is no Unicode text, as a settings file needs; rename it",
        ) from None
    return value


def _plain(text: str) -> str:
    """Text for a comment, in which control characters are not allowed."""
    return "".join(c if c.isprintable() else "?" for c in text)


def arkit_names(names: Sequence[str]) -> dict[str, str]:
    """The names that stand for one of ARKit's 52 shapes, and which."""
    found = {name: shape_of(name) for name in names}
    return {name: shape for name, shape in found.items() if shape in ARKIT}


def missing_arkit(names: Sequence[str]) -> list[str]:
    """The shapes of ARKit that no name stands for, nor two halves, in ARKit's order."""
    known = {shape_of(name) for name in names}
    known |= {whole.name for whole in wholes() if known.issuperset(whole.parts)}
    return [shape for shape in ARKIT if shape not in known]


def turning(names: Sequence[str]) -> list[str]:
    """Targets that turn by their names: jaws that open, lids that close, eyes that look."""
    return [
        name
        for name in names
        if _TURNING.match(shape_of(name) or "") or _TURNING_WORDS.search(name)
    ]


def correctives(names: Sequence[str]) -> dict[str, list[str]]:
    """Combination shapes by their names, as Maya's, and what drives them.

    ``jawOpen_mouthFunnel`` corrects the sum of two other targets.
    """
    found = {name: parts for name in names if (parts := _joined(name, {*names} - {name}))}
    return {
        name: drivers for name, drivers in found.items() if not any(own in found for own in drivers)
    }


def slider_groups(names: Sequence[str]) -> dict[str, list[str]]:
    """Sliders of one part of the face, or a pattern for just these, where there are two or more."""
    shapes = {name: shape_of(name) or name for name in names}
    found: dict[str, list[str]] = {}
    for part in _PARTS:
        own = [name for name, shape in shapes.items() if shape.startswith(part)]
        begin = own[0][: len(part)] if own else part
        if len(own) > 1:
            pattern = own == [name for name in names if name.startswith(begin)]
            found[part] = [f"{begin}*"] if pattern else own
    return found


def _joined(name: str, others: set[str]) -> list[str]:
    """The names that underscores join into this one; empty where it is not such."""
    words = name.split("_")
    parts: list[str] = []
    start = 0
    while start < len(words):
        # The longest first, so that mouthSmile_L is one name.
        for stop in range(len(words), start, -1):
            part = "_".join(words[start:stop])
            if part in others:
                parts.append(part)
                start = stop
                break
        else:
            return []
    return parts if len(parts) > 1 and len(set(parts)) == len(parts) else []
