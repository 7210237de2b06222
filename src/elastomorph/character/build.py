"""The rig that settings describe, kept in the same cache as rigs of folders."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from elastomorph.character.paths import PathMaker
from elastomorph.character.settings import Settings
from elastomorph.character.sources import Sources, find_sources
from elastomorph.io.registry import read
from elastomorph.io.rig_cache import RigCache, content_digests
from elastomorph.io.rig_folder import read_targets, rig_as_stored
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from elastomorph.rig.remade import bare_rig, extent_of

__all__ = ["rig_from_settings"]


def rig_from_settings(
    settings: Settings,
    *,
    cache: bool | str | Path | None = True,
    say: Callable[[str], None] = lambda _: None,
) -> Rig:
    """The rig of a character.

    Args:
        settings: As `elastomorph.character.read_settings` gives them.
        cache: Where the finished rig is kept, as for `elastomorph.io.rig_folder.read_rig_folder`.
            One that was not made from exactly these files and settings is not used.
        say: Told what is being done.

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
    contents: tuple[str, ...] = ()
    if place is not None:
        contents = _contents(sources)
        known = place.read(contents, sources.main)
        if known is not None:
            say(f"{len(known)} targets of {settings.path} read from {place.file}")
            return known
    rig = _remade(settings, sources, say) if sources.rig else _built(settings, sources, say)
    # A file that changed while it was read must not be remembered under its content before.
    if place is not None and _contents(sources) == contents:
        place.write(contents, rig)
    return rig


def _built(settings: Settings, sources: Sources, say: Callable[[str], None]) -> Rig:
    say(f"reading {sources.main.name}")
    neutral = read(sources.main)
    targets = read_targets(neutral, sources.targets, say)
    maker = PathMaker(settings, neutral, extent_of(bare_rig(neutral, targets)))
    morphs: dict[str, Morph] = {}
    for name, target in targets.items():
        say(f"the path to {name}, {len(morphs) + 1} of {len(targets)}")
        morphs[name] = maker.path(name, target)
    return Rig(
        neutral,
        morphs,
        correctives=settings.correctives,
        groups=settings.members(morphs),
    )


def _remade(settings: Settings, sources: Sources, say: Callable[[str], None]) -> Rig:
    """A rig file, its paths made anew where the settings state a method."""
    say(f"reading {sources.main}")
    rig = rig_as_stored(sources.main, mesh=settings.character.mesh or None)
    settings.require_names(rig.morphs)
    maker = PathMaker(settings, rig.neutral, extent_of(rig))
    morphs: dict[str, Morph] = {}
    for name, morph in rig.morphs.items():
        say(f"{name}, {len(morphs) + 1} of {len(rig.morphs)}")
        morphs[name] = maker.path(name, morph.target, own=morph)
    return Rig(
        rig.neutral,
        morphs,
        correctives=settings.correctives or rig.sliders.correctives,
        groups=settings.members(morphs) or rig.sliders.groups,
    )


def _what_paths_depend_on(settings: Settings) -> list[object]:
    """All of the settings but names, units, timing and export, which change no path."""
    plain = replace(settings.character, name="", unit=None)
    return [
        plain,
        settings.method,
        settings.methods,
        settings.regions,
        settings.inbetweens,
        settings.groups,
        settings.correctives,
    ]


def _contents(sources: Sources) -> tuple[str, ...]:
    """Name and digest of every file."""
    digests = content_digests(sources.all)
    return tuple(f"{file}:{own}" for file, own in zip(sources.all, digests, strict=True))
