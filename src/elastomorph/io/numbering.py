"""Which files are the frames of a motion, and which number each has."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import gcd
from pathlib import Path
from typing import NamedTuple

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import is_file, is_folder
from elastomorph.io.npz.confidence import NAME as CONFIDENCE

_MOST_MISSING = 100_000
_DIGITS = re.compile(r"([0-9]+)")


@dataclass(frozen=True)
class FramePattern:
    """A file name with a run of # in place of the frame number, as in ``scan.####.obj``.

    A number written by us is filled up to ``width`` digits with zeros.
    """

    pattern: str | Path
    folder: Path
    before: str
    width: int
    after: str

    def file(self, number: int) -> Path:
        """The file of one frame."""
        return self.folder / f"{self.before}{number:0{self.width}d}{self.after}"

    def existing(self) -> dict[Path, int]:
        """The files that match, whatever the number of their digits, and their frame numbers."""
        name = re.compile(re.escape(self.before) + "([0-9]+)" + re.escape(self.after))
        return {
            self.folder / found.string: int(found[1])
            for found in map(name.fullmatch, _names_in(self.folder))
            if found
        }

    def require_only(self, numbers: Collection[int]) -> None:
        """Refuse to write frames beside those of another motion, with which they would mix."""
        there = self.existing() if self.folder.is_dir() else {}
        others = [file for file, n in there.items() if n not in numbers or file != self.file(n)]
        if others:
            raise FileError(
                self.pattern,
                f"{min(others).name} is already there and not among the {len(numbers):,} frames to "
                f"write ({len(others):,} such files); delete them or choose another name",
            )


class FrameFiles(NamedTuple):
    """The files of a motion, their rising frame numbers, and names of frames that are left out."""

    files: tuple[Path, ...]
    numbers: tuple[int, ...]
    missing: tuple[str, ...]


def frame_pattern(pattern: str | Path) -> FramePattern:
    """The pattern that a path with a run of # stands for."""
    path = Path(pattern)
    runs = re.findall("#+", path.name)
    if len(runs) != 1:
        raise FileError(
            pattern,
            f"expected one run of # for the frame number, found {len(runs)}; write for example "
            "'scan.####.obj'",
        )
    before, _, after = path.name.partition(runs[0])
    return FramePattern(pattern, path.parent, before, len(runs[0]), after)


def find_frames(pattern: str | Path, suffixes: Sequence[str]) -> FrameFiles:
    """The frames that a pattern, a wildcard or a folder stands for.

    In a wildcard or a folder the frame number is the run of digits in which the names differ, or
    else the last run of digits. Frames that were taken at equal steps (10, 20, 30) leave nothing
    out.
    """
    path = Path(pattern)
    if is_folder(path):
        numbers = _numbered(pattern, _meshes_in(path, suffixes))
    elif is_file(path):
        raise FileError(
            pattern,
            "this is one file; name all frames, for example 'scan.####.obj', 'scan.*.obj' or their "
            "folder",
        )
    elif "#" in path.name:
        numbers = frame_pattern(path).existing()
    elif any(wildcard in path.name for wildcard in "*?["):
        names = fnmatch.filter(_names_in(path.parent), path.name)
        numbers = _numbered(pattern, [path.parent / name for name in names])
    else:
        numbers = {}
    if len(numbers) < 2:
        raise FileError(pattern, _too_few(path, list(numbers)))
    files = sorted(numbers, key=lambda file: (numbers[file], file.name))
    for one, other in pairwise(files):
        if numbers[one] == numbers[other]:
            raise FileError(
                pattern,
                f"{one.name} and {other.name} both have the frame number {numbers[one]}; keep the "
                "frames of one take together and name only those",
            )
    rising = [numbers[file] for file in files]
    return FrameFiles(tuple(files), tuple(rising), _missing(pattern, files, rising))


def _meshes_in(folder: Path, suffixes: Sequence[str]) -> list[Path]:
    names = [name for name in _names_in(folder) if name != CONFIDENCE]
    files = [folder / name for name in names if Path(name).suffix.lower() in suffixes]
    found = sorted({file.suffix.lower() for file in files})
    if len(found) > 1:
        raise FormatError(
            folder,
            f"this folder has mesh files of several formats ({', '.join(found)}); name the ones "
            f"you mean, for example '{folder / ('*' + found[0])}'",
        )
    return files


def _numbered(pattern: str | Path, files: list[Path]) -> dict[Path, int]:
    parts = {file: _DIGITS.split(file.stem) for file in files}
    without = [file.name for file in files if len(parts[file]) < 3]
    if without:
        more = f", and {len(without) - 1} more have none" if len(without) > 1 else ""
        raise FileError(
            pattern,
            f"{without[0]} has no frame number in its name{more}; number the frames or name only "
            "those that are numbered",
        )
    column = -2
    if len({tuple(own[::2]) for own in parts.values()}) == 1:
        runs = list(zip(*(own[1::2] for own in parts.values()), strict=True))
        differing = [i for i, run in enumerate(runs) if len(set(map(int, run))) > 1]
        column = 2 * differing[-1] + 1 if differing else -2
    return {file: int(own[column]) for file, own in parts.items()}


def _missing(pattern: str | Path, files: list[Path], numbers: list[int]) -> tuple[str, ...]:
    step = gcd(*(number - numbers[0] for number in numbers))
    span = (numbers[-1] - numbers[0]) // step + 1
    if span - len(numbers) > _MOST_MISSING:
        raise FileError(
            pattern,
            f"the frame numbers go from {numbers[0]} to {numbers[-1]}, but there are only "
            f"{len(numbers)} files; check whether files of another take are among them",
        )
    present = set(numbers)
    absent = [n for n in range(numbers[0], numbers[-1], step) if n not in present]
    return tuple(_renumbered(files[0].name, numbers[0], number) for number in absent)


def _renumbered(name: str, own: int, number: int) -> str:
    """The name of another frame: the last run of digits that is this frame's number, replaced."""
    for run in reversed(list(_DIGITS.finditer(name))):
        if int(run[0]) == own:
            return f"{name[: run.start()]}{number:0{len(run[0])}d}{name[run.end() :]}"
    return str(number)


def _names_in(folder: Path) -> list[str]:
    """Names of the files in a folder, without hidden ones, such as a writer's temporary files."""
    try:
        return sorted(
            entry.name
            for entry in folder.iterdir()
            if not entry.name.startswith(".") and not entry.is_dir()
        )
    except FileNotFoundError:
        raise FileError(folder, "this folder does not exist") from None
    except (OSError, ValueError) as error:
        raise FileError(folder, f"this folder cannot be listed: {error}") from error


def _too_few(path: Path, found: list[Path]) -> str:
    if found:
        return f"a motion needs at least 2 frames, found only {found[0].name}"
    folder = path if is_folder(path) else path.parent
    if not is_folder(folder):
        return f"no frames found: the folder {folder} does not exist"
    there = _names_in(folder)
    shown = f"{len(there):,} files: {', '.join(there[:5])}" if there else "no files"
    what = "mesh files" if is_folder(path) else f"files called '{path.name}'"
    return f"no {what} in {folder}, which holds {shown}{', …' if len(there) > 5 else ''}"
