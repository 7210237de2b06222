"""What the tab key offers: methods, views, and the sliders of the rig that is named.

An answer comes at once or not at all: whatever needs a process of its own to be read, or cannot be
read, has none, and nothing is said.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

import typer

__all__ = ["methods", "poses", "sliders", "views"]

_OF_ORDER = ("ease", "beam", "plate")
_WEIGHTS = ("0.25", "0.5", "0.75", "1")


def methods(incomplete: str) -> list[str]:
    """The methods, those of an order with some."""
    from elastomorph.paths import METHODS

    names = [f"{name}:{order}" for name in _OF_ORDER for order in (2, 3)]
    return _beginning([*METHODS, *names], incomplete)


def views(incomplete: str) -> list[str]:
    """The views of a picture."""
    from elastomorph.draw.camera import VIEWS

    return _beginning(VIEWS, incomplete)


def sliders(context: typer.Context, incomplete: str) -> list[str]:
    """Names of sliders separated by commas; the last one is completed."""
    before, comma, last = incomplete.rpartition(",")
    taken = before.split(",")
    names = [name for name in _slider_names(context) if name not in taken]
    return [f"{before}{comma}{name}" for name in _beginning(names, last)]


def poses(context: typer.Context, incomplete: str) -> list[str]:
    """As `sliders`, each with ``=``, and the last one with some weights.

    A shell adds a space behind what it has no choice for, and a weight follows without one.
    """
    before, comma, last = incomplete.rpartition(",")
    taken = [text.partition("=")[0] for text in before.split(",")]
    stem, equals, _ = last.partition("=")
    names = [name for name in _slider_names(context) if name not in taken]
    found = _beginning([f"{name}=" for name in names], f"{stem}{equals}")
    if len(found) == 1:
        found = _beginning([f"{found[0]}{weight}" for weight in _WEIGHTS], last)
    return [f"{before}{comma}{text}" for text in found]


def _beginning(names: Iterable[str], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def _slider_names(context: typer.Context) -> list[str]:
    # Where the line ends in an option without its value, arguments are not assigned any more.
    loose = [word for word in context.args if not word.startswith("-")]
    rig = loose[0] if loose else context.params.get("rig")
    with suppress(Exception), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return _names_in(None if rig in (None, "built-in") else Path(str(rig)))
    return []


def _names_in(path: Path | None) -> list[str]:
    from elastomorph.io.npz_members import open_npz

    if path is None:
        from elastomorph.samples import expressions, shapes

        return [*shapes(), *expressions()]
    suffix = path.suffix.lower()
    if suffix == ".toml" or (path.is_dir() and (path / "elastomorph.toml").is_file()):
        from elastomorph.character import read_settings
        from elastomorph.character.sources import find_sources

        sources = find_sources(read_settings(path))
        return list(sources.targets) if sources.rig is None else _names_in(sources.rig)
    if path.is_dir():
        from elastomorph.io.rig_folder import find_rig_files

        return list(find_rig_files(path).targets)
    if suffix == ".npz":
        with open_npz(path) as members:
            return [str(name) for name in members.array("morph_names", "U", (None,))]
    if suffix in (".glb", ".gltf", ".vrm"):
        from elastomorph.io.rig_folder import rig_as_stored

        return list(rig_as_stored(path).morphs)
    return []
