"""A rig from USD: our own files as they were, any other as straight pieces between in-betweens."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from elastomorph.errors import ElastomorphWarning, FormatError, MissingExtraError
from elastomorph.io.atomic import opened
from elastomorph.io.checked import naming_file
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.usd.names import prim_names
from elastomorph.io.usd.paths import morph_of, values_needed
from elastomorph.io.usd.scene import FoundShape, Scene
from elastomorph.io.usd.writer import SUFFIXES
from elastomorph.morph import Morph
from elastomorph.rig import Rig

__all__ = ["read_usd", "read_usd_settings"]

_READER = IsolatedReader(
    "elastomorph.io.usd.worker",
    "USD",
    "write it again from the program it was made with, or as one file (usdcat --flatten)",
)


def read_usd(path: str | Path, *, mesh: str | None = None) -> Rig:
    """The rig in a USD file.

    A file of `write_usd` comes back with its curved paths. Of any other, each in-between becomes
    a bend whose curve is a hat, so that the path is exactly the one UsdSkel plays. Positions are
    those of the mesh in its own space; polygons of a left-handed mesh are turned around. USD reads
    the file in a process of its own, as it ends the whole program on some damaged files.

    Args:
        path: A .usd, .usda or .usdc file. References, payloads and sublayers are followed within
            its own folder only.
        mesh: Name or path of the mesh to read, where several have blend shapes.

    Raises:
        MissingExtraError: usd-core is not installed.
        FileError: The file is missing or cannot be read.
        FormatError: It is not USD or damaged, several meshes have blend shapes or none has, or
            it is composed of files outside its folder.
    """
    with _scene(path, mesh or "") as scene:
        return _rig(path, scene)


def read_usd_settings(path: str | Path, *, mesh: str | None = None) -> str | None:
    """The settings that `write_usd` kept in a file, as JSON; None where there are none.

    Args:
        path: As for `read_usd`.
        mesh: As for `read_usd`.

    Raises:
        MissingExtraError: As `read_usd`; so are the others.
        FileError: As `read_usd`.
        FormatError: As `read_usd`.
    """
    with _scene(path, mesh or "") as scene:
        return scene.settings


@contextmanager
def _scene(path: str | Path, mesh: str) -> Iterator[Scene]:
    """The content of a file."""
    if Path(path).suffix.lower() not in SUFFIXES:
        raise FormatError(path, f"expected a name that ends in {', '.join(SUFFIXES)}")
    with opened(path):  # a file that is not there is no matter of what is installed
        pass
    if find_spec("pxr") is None:
        raise MissingExtraError("usd-core", "usd")
    with extracted(_READER, path, mesh) as members:
        yield Scene(path, members)


def _rig(path: str | Path, scene: Scene) -> Rig:
    neutral = scene.mesh()
    count = len(neutral.vertices)
    found = [scene.shape(i, count) for i in range(scene.shape_count())]
    scene.budget.spend_fields(count, sum(map(values_needed, found)))
    names = _names(found)
    morphs: dict[str, Morph] = {}
    for name, shape in zip(names, found, strict=True):
        morphs[name] = morph_of(path, neutral, name, shape)
    correctives = _lists(scene.sliders.get("correctives"))
    groups = _lists(scene.sliders.get("groups"))
    entries = sum(map(len, (*correctives.values(), *groups.values())))
    scene.budget.spend_lookups(entries, len(names))
    known = set(names)
    lost = any({n, *own} - known for n, own in correctives.items())
    lost = lost or any(set(own) - known for own in groups.values())
    if lost:
        warnings.warn(
            f"{path}: blend shapes that correctives or groups name are gone; both are left out",
            ElastomorphWarning,
            stacklevel=3,
        )
        correctives, groups = {}, {}
    with naming_file(path):
        return Rig(neutral, morphs, correctives=correctives, groups=groups)


def _names(shapes: list[FoundShape]) -> list[str]:
    """Our own names where the prims still have the names made from them; all different."""
    names: dict[str, None] = {}
    again: dict[str, int] = {}
    for shape in shapes:
        name = shape.token
        if shape.name is not None:
            plain = prim_names([shape.name])[0]
            rest = shape.token.removeprefix(plain)
            if shape.token.startswith(plain) and (not rest or rest[0] == "_"):
                name = shape.name
        free = name
        while free in names:
            again[name] = again.get(name, 0) + 1
            free = f"{name}_{again[name]}"
        names[free] = None
    return list(names)


def _lists(content: Any) -> dict[str, list[str]]:
    if not isinstance(content, Mapping):
        return {}
    return {
        str(name): [str(n) for n in own] for name, own in content.items() if isinstance(own, list)
    }
