"""A rig from USD: our own files as they were, any other as straight pieces between in-betweens.

UsdSkel plays V₀ + Π(t), straight from in-between to in-between: with offsets Y_i at weights w_i,

    V(t) = V₀ + tΔ + Σ_i h_i(t) (Y_i - w_i Δ)        h_i(w_j) = δ_ij, linear between the weights

which is a path with one bend an in-between. Beyond 0 and 1 both go straight on.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, MissingExtraError, warn
from elastomorph.io.atomic import opened
from elastomorph.io.blend_shapes import different_names, hats
from elastomorph.io.choices import wanted_names
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.joined_rig import RigPart, joined_rig, placings
from elastomorph.io.npz.members import NpzMembers
from elastomorph.io.untrusted import MemoryBudget, naming_file
from elastomorph.io.usd.exact import checksum, path_from_json, prim_names
from elastomorph.io.usd.library import ROOT, STILL
from elastomorph.io.usd.scene import FoundMesh, FoundShape, found_meshes
from elastomorph.io.usd.writer import SUFFIXES
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig

__all__ = ["read_usd", "read_usd_settings"]

_SUFFIXES = (*SUFFIXES, ".usdz")
ADVICE = "write it again from the program it was made with, or as one file (usdcat --flatten)"
_READER = IsolatedReader("elastomorph.io.usd.worker", "USD", ADVICE)
_CLOSE = 1e-6  # UsdSkel passes over in-betweens nearer than this to 0 and 1


def read_usd(
    path: str | Path,
    *,
    mesh: str | Sequence[str] | None = None,
    still: bool = False,
    root: str | Path | None = None,
) -> Rig:
    """The rig in a USD file.

    A file of `write_usd`, or a layer of bends, comes back with its curved paths. Of any other, each
    in-between becomes a bend whose curve is a hat, so that the path is exactly the one UsdSkel
    plays. All meshes that are rendered become one, in the order of the stage; blend shapes of the
    same name in several of them are one morph, and a mesh without any is part of the neutral.
    Positions are those of the mesh with most blend shapes, turned upright, the others where they
    stand beside it, skinned ones where their joints hold them at rest, point by point; polygons of
    a left-handed mesh are turned around. USD reads the file in a process of its own, as it ends the
    whole program on some damaged files.

    Args:
        path: A .usd, .usda, .usdc or .usdz file. References, payloads and sublayers are followed
            within ``root``, or its package, only; the file under a layer of `elastomorph.bend`
            wherever it is.
        mesh: Name or path of the mesh to read, or of several; with or without blend shapes.
        still: Read meshes without any blend shapes too, as a rig without morphs.
        root: The folder in which all files must lie; the common parent of those named relative to
            each other by default, unless that is a home, a folder on top of the disk or the like.

    Raises:
        MissingExtraError: usd-core is not installed.
        FileError: The file is missing or cannot be read.
        FormatError: It is not USD or damaged, no mesh has blend shapes or there is none of a name,
            or it is composed of files outside the root.
        ParameterError: An empty list of names.
    """
    options = [STILL] * still + ([] if root is None else [f"{ROOT}{Path(root).absolute()}"])
    with members_of(path, [*options, *wanted_names(mesh)]) as members:
        found = found_meshes(path, members)
        return rig_of(path, found, parts_of(path, found, members.budget), members.budget)


def read_usd_settings(path: str | Path, *, mesh: str | Sequence[str] | None = None) -> str | None:
    """The settings that `write_usd` kept in a file, as JSON; None where there are none.

    Arguments and errors are those of `read_usd`.
    """
    with members_of(path, [STILL, *wanted_names(mesh)]) as members:
        found = [own.settings for own in found_meshes(path, members)]
        return next((text for text in found if text is not None), None)


@contextmanager
def members_of(
    path: str | Path, wanted: Sequence[str], reader: IsolatedReader = _READER
) -> Iterator[NpzMembers]:
    """The content of a file, as a worker found it."""
    if Path(path).suffix.lower() not in _SUFFIXES:
        raise FormatError(path, f"expected a name that ends in {', '.join(_SUFFIXES)}")
    with opened(path):  # a file that is not there is no matter of what is installed
        pass
    if find_spec("pxr") is None:
        raise MissingExtraError("usd-core", "usd")
    with extracted(reader, path, *wanted) as members:
        yield members


def rig_of(
    path: str | Path, found: list[FoundMesh], parts: list[RigPart], budget: MemoryBudget
) -> Rig:
    """The rig that the meshes of a file are together."""
    with naming_file(path):
        neutral, morphs = joined_rig(parts, str(path))
    correctives, groups = (
        {name: own for mesh in found for name, own in _lists(mesh.sliders.get(kind)).items()}
        for kind in ("correctives", "groups")
    )
    entries = sum(map(len, (*correctives.values(), *groups.values())))
    budget.spend_lookups(entries, len(morphs))
    known = set(morphs)
    named = [*({n, *own} for n, own in correctives.items()), *map(set, groups.values())]
    if any(own - known for own in named):
        warn(f"{path}: blend shapes that correctives or groups name are gone; both are left out")
        correctives, groups = {}, {}
    with naming_file(path):
        return Rig(neutral, morphs, correctives=correctives, groups=groups)


def parts_of(path: str | Path, found: list[FoundMesh], budget: MemoryBudget) -> list[RigPart]:
    """The meshes with their morphs, in the order of their blend shapes, each where it goes."""
    meshes = [one.mesh for one in found]
    shapes = [
        [one.shape(i, len(mesh.vertices)) for i in range(one.shape_count)]
        for one, mesh in zip(found, meshes, strict=True)
    ]
    vertices = sum(len(mesh.vertices) for mesh in meshes)
    # displacement fields that the morph of a shape will have, at most
    fields = sum(
        2 + max(len(shape.bends) // max(len(shape.points), 1), len(shape.weights))
        for own in shapes
        for shape in own
    )
    copies = 1 + (len(meshes) > 1) + any(one.held is not None for one in found)
    budget.spend_fields(vertices, fields, copies=copies)
    main = max(range(len(meshes)), key=lambda number: len(shapes[number]))
    with naming_file(path):
        places = placings(found[main].axes, found, main)
    parts = []
    for one, mesh, own, place in zip(found, meshes, shapes, places, strict=True):
        by_name = zip(_names(own), own, strict=True)
        morphs = {name: _morph(path, mesh, name, shape) for name, shape in by_name}
        part = RigPart(one.name, mesh, morphs, place)
        with naming_file(path):
            parts.append(part if one.held is None else _at_rest(part, one.held))
    return parts


def _at_rest(part: RigPart, held: NDArray[np.float64]) -> RigPart:
    """A mesh whose points have different joints, (N, 4, 3) each, where these hold them at rest."""

    def turned(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.einsum("...ni,nij->...nj", vectors, held[:, :3]))

    neutral = part.mesh.with_vertices(turned(part.mesh.vertices) + held[:, 3])
    morphs = {
        name: replace(
            morph,
            neutral=neutral,
            target=neutral.with_vertices(neutral.vertices + turned(morph.delta)),
            bends=turned(morph.bends),
        )
        for name, morph in part.morphs.items()
    }
    return replace(part, mesh=neutral, morphs=morphs)


def _names(shapes: Iterable[FoundShape]) -> list[str]:
    """Our own names where the prims still have the names made from them; all different.

    UsdSkel wants one weight a name: exporters number the names of further meshes (``jawOpen2``) and
    leave those of the prims, which then tell what moves together.
    """
    names = []
    for shape in shapes:
        name, plain = shape.name, prim_names([shape.name or ""])[0]
        rest = shape.token.removeprefix(plain)
        made_from_it = shape.token.startswith(plain) and rest[:1] in ("", "_")
        number = shape.token[len(shape.prim_name) :]
        numbered = shape.token.startswith(shape.prim_name) and number.isdecimal()
        token = shape.prim_name if numbered else shape.token
        names.append(token if name is None or not made_from_it else name)
    return different_names(names, first=1)


def _lists(content: Any) -> dict[str, list[str]]:
    if not isinstance(content, Mapping):
        return {}
    return {
        str(name): [str(n) for n in own] for name, own in content.items() if isinstance(own, list)
    }


def _morph(path: str | Path, neutral: Mesh, name: str, shape: FoundShape) -> Morph:
    """The morph of a blend shape."""
    delta = _spread(neutral, shape.points, shape.offsets[0])
    with naming_file(path):
        target = neutral.with_vertices(neutral.vertices + delta)
        if shape.path is not None:
            exact = _exact(neutral, target, shape)
            if exact is not None:
                return exact
            warn(
                f"{path}: the blend shape '{name}' was changed since elastomorph wrote it; its "
                "in-betweens are read instead of its curved path"
            )
        kept = _inner(path, name, shape)
        weights = shape.weights[kept]
        bends = np.zeros((len(kept), *delta.shape))
        for bend, weight, row in zip(bends, weights, kept, strict=True):
            bend[:] = _spread(neutral, shape.points, shape.offsets[1 + row]) - weight * delta
        method = "inbetweens" if kept else "linear"
        return Morph(neutral, target, bends, hats(weights), method=method, bare=not kept)


def _exact(neutral: Mesh, target: Mesh, shape: FoundShape) -> Morph | None:
    """The morph that elastomorph stored, unless the shapes are no longer those it belongs to."""
    stored = path_from_json(shape.path or "")
    order = np.argsort(shape.weights)
    shapes = shape.offsets[np.concatenate([[0], 1 + order])]
    floats = (shapes.astype(np.float32), shape.weights[order].astype(np.float32))
    if stored is None or stored.checksum != checksum([shape.points.astype(np.int32), *floats]):
        return None
    if len(shape.bends) != len(stored.curves) * len(shape.points):
        return None
    bends = np.zeros((len(stored.curves), *neutral.vertices.shape))
    bends[:, shape.points] = shape.bends.reshape(len(bends), len(shape.points), 3)
    return Morph(neutral, target, bends, stored.curves, **stored.more)


def _inner(path: str | Path, name: str, shape: FoundShape) -> list[int]:
    """The in-betweens at weights between 0 and 1, in the order of these."""
    kept: list[int] = []
    for row in np.argsort(shape.weights, kind="stable").tolist():
        weight = shape.weights[row]
        if not _CLOSE < weight < 1 - _CLOSE:
            warn(
                f"{path}: the blend shape '{name}' has an in-between at the weight {weight:g}, "
                "which is not between 0 and 1; it is left out"
            )
        elif kept and weight - shape.weights[kept[-1]] <= _CLOSE:
            if not np.array_equal(shape.offsets[1 + row], shape.offsets[1 + kept[-1]]):
                raise FormatError(
                    path,
                    f"the blend shape '{name}' has two different in-betweens at the weight "
                    f"{weight:g}; remove one of them",
                )
        else:
            kept.append(row)
    return kept


def _spread(
    neutral: Mesh, points: NDArray[np.int64], offsets: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(V, 3) from offsets of some points; a point named twice moves by both, as in UsdSkel."""
    field = np.zeros(neutral.vertices.shape)
    np.add.at(field, points, offsets)
    return field
