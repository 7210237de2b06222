"""A rig from USD: our own files as they were, any other as straight pieces between in-betweens."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from elastomorph.errors import ElastomorphWarning, FormatError, MissingExtraError
from elastomorph.io.atomic import opened
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.joined_rig import RigPart, joined_rig
from elastomorph.io.mesh_choice import wanted_names
from elastomorph.io.placing import placings
from elastomorph.io.untrusted import naming_file
from elastomorph.io.usd.names import prim_names
from elastomorph.io.usd.paths import morph_of, values_needed
from elastomorph.io.usd.scene import FoundShape, Scene
from elastomorph.io.usd.writer import SUFFIXES
from elastomorph.rig import Rig

__all__ = ["read_usd", "read_usd_settings"]

_SUFFIXES = (*SUFFIXES, ".usdz")
_READER = IsolatedReader(
    "elastomorph.io.usd.worker",
    "USD",
    "write it again from the program it was made with, or as one file (usdcat --flatten)",
)


def read_usd(path: str | Path, *, mesh: str | Sequence[str] | None = None) -> Rig:
    """The rig in a USD file.

    A file of `write_usd` comes back with its curved paths. Of any other, each in-between becomes
    a bend whose curve is a hat, so that the path is exactly the one UsdSkel plays. All meshes that
    are rendered become one, in the order of the stage; blend shapes of the same name in several of
    them are one morph, and a mesh without any is part of the neutral. Positions are those of the
    mesh with most blend shapes in its own space, the others where they stand beside it, skinned
    ones as they were bound; polygons of a left-handed mesh are turned around. USD reads the file
    in a process of its own, as it ends the whole program on some damaged files.

    Args:
        path: A .usd, .usda, .usdc or .usdz file. References, payloads and sublayers are followed
            within its own folder, or package, only.
        mesh: Name or path of the mesh to read, or of several; with or without blend shapes.

    Raises:
        MissingExtraError: usd-core is not installed.
        FileError: The file is missing or cannot be read.
        FormatError: It is not USD or damaged, no mesh has blend shapes or there is none of a name,
            or it is composed of files outside its folder.
        ParameterError: An empty list of names.
    """
    with _scene(path, wanted_names(mesh)) as scene:
        return _rig(path, scene)


def read_usd_settings(path: str | Path, *, mesh: str | Sequence[str] | None = None) -> str | None:
    """The settings that `write_usd` kept in a file, as JSON; None where there are none.

    Args:
        path: As for `read_usd`.
        mesh: As for `read_usd`.

    Raises:
        MissingExtraError: As `read_usd`; so are the others.
        FileError: As `read_usd`.
        FormatError: As `read_usd`.
        ParameterError: As `read_usd`.
    """
    with _scene(path, wanted_names(mesh)) as scene:
        return scene.settings


@contextmanager
def _scene(path: str | Path, wanted: Sequence[str]) -> Iterator[Scene]:
    """The content of a file."""
    if Path(path).suffix.lower() not in _SUFFIXES:
        raise FormatError(path, f"expected a name that ends in {', '.join(_SUFFIXES)}")
    with opened(path):  # a file that is not there is no matter of what is installed
        pass
    if find_spec("pxr") is None:
        raise MissingExtraError("usd-core", "usd")
    with extracted(_READER, path, *wanted) as members:
        yield Scene(path, members)


def _rig(path: str | Path, scene: Scene) -> Rig:
    parts = _parts(path, scene)
    with naming_file(path):
        neutral, morphs = joined_rig(parts, str(path))
    correctives, groups = (
        {name: own for mesh in scene.meshes for name, own in _lists(mesh.sliders.get(kind)).items()}
        for kind in ("correctives", "groups")
    )
    entries = sum(map(len, (*correctives.values(), *groups.values())))
    scene.budget.spend_lookups(entries, len(morphs))
    known = set(morphs)
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


def _parts(path: str | Path, scene: Scene) -> list[RigPart]:
    """The meshes with their morphs, each where it goes."""
    meshes = [found.mesh() for found in scene.meshes]
    shapes = [
        [found.shape(i, len(mesh.vertices)) for i in range(found.shape_count())]
        for found, mesh in zip(scene.meshes, meshes, strict=True)
    ]
    vertices = sum(len(mesh.vertices) for mesh in meshes)
    fields = sum(values_needed(shape) for own in shapes for shape in own)
    scene.budget.spend_fields(vertices, fields, copies=1 if len(meshes) == 1 else 2)
    main = max(range(len(meshes)), key=lambda number: len(shapes[number]))
    with naming_file(path):
        places = placings(None, scene.meshes, main)
    return [
        RigPart(
            found.name,
            mesh,
            {
                name: morph_of(path, mesh, name, shape)
                for name, shape in zip(_names(own), own, strict=True)
            },
            place,
        )
        for found, mesh, own, place in zip(scene.meshes, meshes, shapes, places, strict=True)
    ]


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
