"""What the tab key offers: methods, views, and the sliders of the rig that is named.

An answer comes at once or not at all: whatever needs a process of its own to be read, or cannot be
read, has none, and nothing is said.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

_WEIGHTS = ("0.25", "0.5", "0.75", "1")
_MOST_BYTES = 1 << 20
"""Larger files hold takes, not poses."""


def methods(incomplete: str) -> list[str]:
    """The methods, and some with an option behind the name."""
    from elastomorph.paths import Method

    return _beginning(Method.texts(), incomplete)


def views(incomplete: str) -> list[str]:
    """The views of a picture."""
    from elastomorph.draw.camera import VIEWS

    return _beginning(VIEWS, incomplete)


def goals(incomplete: str) -> list[str]:
    """What a capture may stop after."""
    from elastomorph.capturing.work import TO

    return _beginning(TO, incomplete)


def rigs_of_cameras(incomplete: str) -> list[str]:
    """How the cameras of a capture stand."""
    from elastomorph.capturing.work import RIGS

    return _beginning(RIGS, incomplete)


def sliders(context: typer.Context, incomplete: str) -> list[str]:
    """Names of sliders separated by commas; the last one is completed."""
    before, comma, last = incomplete.rpartition(",")
    taken = before.split(",")
    names = [name for name in _slider_names(context) if name not in taken]
    return [f"{before}{comma}{name}" for name in _beginning(names, last)]


Expressions = Annotated[
    str | None,
    typer.Option(
        help="Names separated by commas; the paper's five by default.",
        autocompletion=sliders,
    ),
]
"""The option that names expressions."""


def poses(context: typer.Context, incomplete: str) -> list[str]:
    """As `sliders`, each with ``=``, and the last one with some weights.

    A shell adds a space behind what it has no choice for, and a weight follows without one. Also
    files of poses, and the names in one.
    """
    with suppress(OSError):
        if of_files := _poses_of_files(incomplete):
            return of_files
    before, comma, last = incomplete.rpartition(",")
    taken = [text.partition("=")[0] for text in before.split(",")]
    stem, equals, _ = last.partition("=")
    names = [name for name in _slider_names(context) if name not in taken]
    found = _beginning([f"{name}=" for name in names], f"{stem}{equals}")
    if len(found) == 1:
        found = _beginning([f"{found[0]}{weight}" for weight in _WEIGHTS], last)
    return [f"{before}{comma}{text}" for text in found]


def _poses_of_files(incomplete: str) -> list[str]:
    """Files of poses that begin so, or with ``#`` the poses in one."""
    from elastomorph.io.poses import POSE_SUFFIXES, read_poses

    named, mark, _ = incomplete.partition("#")
    folder, slash, _ = named.rpartition("/")
    files = [named] if mark else []
    if named and not mark:
        there = (f"{folder}{slash}{each.name}" for each in Path(folder + slash or ".").iterdir())
        files = _beginning(there, named)
    found: dict[str, list[str]] = {}
    for file in sorted(files):
        if not file.lower().endswith(POSE_SUFFIXES) or Path(file).stat().st_size > _MOST_BYTES:
            continue
        with suppress(Exception), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found[file] = [f"{file}#{name}" for name in read_poses(file)]
    if mark or len(found) == 1:  # one file: it, and what can follow
        return _beginning([text for file in found for text in (file, *found[file])], incomplete)
    return list(found)


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
    from elastomorph.io.npz.members import open_npz

    if path is None:
        from elastomorph.samples import expressions, shapes

        return [*shapes(), *expressions()]
    suffix = path.suffix.lower()
    if suffix == ".toml" or (path.is_dir() and (path / "elastomorph.toml").is_file()):
        from elastomorph.character import read_settings
        from elastomorph.character.build import find_sources

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
