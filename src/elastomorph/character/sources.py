"""Which files a character is made of: patterns and defaults become paths."""

from __future__ import annotations

import glob
from dataclasses import dataclass
from pathlib import Path

from elastomorph.character.settings import Settings, is_pattern
from elastomorph.errors import FileError
from elastomorph.io.registry import MESH_FORMATS, known_suffixes
from elastomorph.io.rig_folder import find_neutral, find_rig_files


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
    beside = [character.curves] if character.curves is not None else []
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
