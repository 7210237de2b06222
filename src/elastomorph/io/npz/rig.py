"""Rigs as NumPy archives (.npz): every path complete and bit for bit, only where it moves anything.

Beside the arrays of the neutral (`elastomorph.io.npz`, with ``neutral`` in place of ``vertices``)
an archive holds, for J morphs with K bends in all:

- ``rig_version`` and ``rig_members``, the names of all arrays but these two;
- ``morph_names``, ``methods``, ``bake_errors``, ``bend_counts`` (J,);
- ``choices`` (J,): why ``auto`` chose each path, as JSON, empty where the method was named;
- J + K *fields*, for each morph its target and then its bends: ``field_sizes`` (J + K,) numbers of
  vertices, and one after another ``field_vertices`` (N,) and ``field_values`` (N, 3). The values
  of a target are positions, not differences, which would round; those of a bend are its vectors.
  A vertex that is not listed stays at the neutral;
- C different curves: ``curve_shapes`` (C, 2) pieces and coefficients of each, ``curve_breaks``,
  ``curve_coefficients``, ``curve_of_bend`` (K,) and ``curve_of_limit_law`` (J,);
- where there are any, ``corrective_names``, ``corrective_counts``, ``corrective_drivers``, and the
  same for ``slider_group_names``, ``slider_group_counts``, ``slider_group_members``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.choices import choice_to_json
from elastomorph.io.npz.members import NpzMembers, open_npz, write_arrays
from elastomorph.io.npz.mesh import mesh_of, surface_arrays
from elastomorph.io.npz.rig_tables import (
    CurveTable,
    as_text,
    as_whole,
    list_arrays,
    read_choices,
    read_counts,
    read_curves,
    read_indices,
    read_lists,
)
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import Mesh, Source
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig

__all__ = ["read_rig_npz", "rig_arrays", "rig_of_members", "write_rig_npz"]

_VERSION = 1


def read_rig_npz(path: str | Path) -> Rig:
    """The rig in an archive.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is no archive, or its arrays are not those of a rig.
    """
    with open_npz(path) as members:
        return rig_of_members(path, members)


def write_rig_npz(path: str | Path, rig: Rig, *, settings: Mapping[str, Any] | None = None) -> None:
    """Write a rig with its neutral, paths, correctives and groups.

    Targets are kept as positions; the polygons and labels of all are those of the neutral.

    Args:
        path: The file; its folder must exist. A file that is there is replaced at once.
        rig: The rig.
        settings: How the rig was made, as JSON: given back by
            `elastomorph.io.settings_used.settings_used`.

    Raises:
        FileError: The file cannot be written.
    """
    arrays = rig_arrays(rig)
    if settings is not None:
        arrays["settings"] = np.array(json.dumps(settings, ensure_ascii=False, allow_nan=False))
    write_arrays(path, arrays)


def rig_arrays(rig: Rig) -> dict[str, NDArray[Any]]:
    """The arrays of a rig's archive."""
    curves = CurveTable()
    fields: list[tuple[NDArray[np.int32], NDArray[np.float64]]] = []
    curve_of_bend: list[int] = []
    curve_of_limit_law: list[int] = []
    nowhere = np.zeros_like(rig.neutral.vertices)
    for morph in rig.morphs.values():
        fields.append(_changed(rig.neutral.vertices, morph.target.vertices))
        fields.extend(_changed(nowhere, bend) for bend in morph.bends)
        curve_of_bend += [curves.number(curve) for curve in morph.bend_curves]
        curve_of_limit_law.append(curves.number(morph.limit_law))
    morphs = list(rig.morphs.values())
    arrays: dict[str, NDArray[Any]] = {
        "neutral": rig.neutral.vertices,
        **surface_arrays(rig.neutral),
        "morph_names": as_text(rig.morphs),
        "methods": as_text([morph.method for morph in morphs]),
        "bake_errors": np.array([morph.bake_error for morph in morphs], dtype=np.float64),
        "choices": as_text(
            [json.dumps(choice_to_json(m.choice)) if m.choice else "" for m in morphs]
        ),
        "bend_counts": as_whole([len(morph.bends) for morph in morphs]),
        "field_sizes": as_whole([len(vertices) for vertices, _ in fields]),
        "field_vertices": np.concatenate([np.empty(0, np.int32), *(v for v, _ in fields)]),
        "field_values": np.concatenate([np.empty((0, 3)), *(values for _, values in fields)]),
        "curve_of_bend": as_whole(curve_of_bend),
        "curve_of_limit_law": as_whole(curve_of_limit_law),
        **curves.arrays(),
        **list_arrays("corrective", "drivers", rig.sliders.correctives),
        **list_arrays("slider_group", "members", rig.sliders.groups),
    }
    return {"rig_version": np.array(_VERSION), "rig_members": as_text(arrays), **arrays}


def rig_of_members(path: str | Path, members: NpzMembers, source: str | Path | None = None) -> Rig:
    """The rig in an open archive.

    Args:
        path: The archive, for messages and for its size.
        members: Its arrays.
        source: The file that the neutral is said to come from; the archive by default.

    Raises:
        FormatError: The arrays are not those of a rig.
    """
    if "rig_version" not in members.names:
        raise FormatError(
            path,
            "this archive holds no rig; expected one written by write_rig_npz, with the array "
            f"'rig_version' (found {members.listed()})",
        )
    version = int(members.array("rig_version", "iu", ()))
    if version != _VERSION:
        raise FormatError(
            path, f"this rig has version {version}, expected {_VERSION}; update elastomorph"
        )
    # Some arrays may be absent, but none that was written: damage to a name must not go unseen.
    lost = set(members.array("rig_members", "U", (None,)).tolist()) - members.names
    if lost:
        raise FormatError(path, f"the array '{min(lost)[:60]}' is missing; the file is damaged")
    neutral = mesh_of(path, members, members.array("neutral", "fiu", (None, 3)))
    if source is not None:
        neutral = _said_to_come_from(neutral, source)
    names = [str(name) for name in members.array("morph_names", "U", (None,))]
    if len(set(names)) < len(names):
        raise FormatError(path, "two morphs have the same name; the file is damaged")
    count = len(names)
    methods = members.array("methods", "U", (count,)).tolist()
    bake_errors = members.array("bake_errors", "f", (count,)).tolist()
    if not all(0 <= error < np.inf for error in bake_errors):
        raise FormatError(path, "a bake error is no number from 0; the file is damaged")
    choices = read_choices(path, members, count)
    bend_counts = read_counts(path, members, "bend_counts", count)
    curves = read_curves(path, members)
    curve_of_bend = read_indices(path, members, "curve_of_bend", sum(bend_counts), len(curves))
    limit_laws = read_indices(path, members, "curve_of_limit_law", count, len(curves))
    # Fields that move nothing take no room in a file, but a morph holds them in full.
    members.budget.spend_fields(len(neutral.vertices), count + sum(bend_counts))
    fields = _Fields(path, members, count + sum(bend_counts), len(neutral.vertices))
    correctives = read_lists(path, members, "corrective", "drivers")
    groups = read_lists(path, members, "slider_group", "members")
    entries = sum(map(len, (*correctives.values(), *groups.values())))
    members.budget.spend_lookups(entries, count)
    morphs: dict[str, Morph] = {}
    bend = 0
    with naming_file(path):
        for number, name in enumerate(names):
            first, field = bend, bend + number
            bend += bend_counts[number]
            positions = neutral.vertices.copy()
            fields.put(field, positions)
            bends = np.zeros((bend_counts[number], *neutral.vertices.shape))
            for place, values in enumerate(bends):
                fields.put(field + 1 + place, values)
            morphs[name] = Morph(
                neutral,
                neutral.with_vertices(positions),
                bends,
                tuple(curves[curve] for curve in curve_of_bend[first:bend]),
                method=methods[number],
                limit_law=curves[limit_laws[number]],
                bake_error=bake_errors[number],
                choice=choices[number],
            )
        return Rig(neutral, morphs, correctives=correctives, groups=groups)


class _Fields:
    """The targets and bends of an archive, each on the vertices it moves."""

    def __init__(self, path: str | Path, members: NpzMembers, count: int, vertices: int) -> None:
        sizes = read_counts(path, members, "field_sizes", count)
        total = sum(sizes)
        self._vertices = members.array("field_vertices", "iu", (total,)).astype(np.int64)
        self._values = members.array("field_values", "f", (total, 3))
        self._starts = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
        steps = np.diff(self._vertices)
        steps[self._starts[(self._starts > 0) & (self._starts < total)] - 1] = 1
        if total and (
            self._vertices.min() < 0 or self._vertices.max() >= vertices or (steps <= 0).any()
        ):
            raise FormatError(
                path,
                "the array 'field_vertices' must hold, for each field, vertices that rise and "
                f"exist (0 to {vertices - 1:,}); the file is damaged",
            )

    def put(self, field: int, positions: NDArray[np.float64]) -> None:
        """Write the values of a field into (V, 3) numbers."""
        own = slice(self._starts[field], self._starts[field + 1])
        positions[self._vertices[own]] = self._values[own]


def _changed(
    before: NDArray[np.float64], after: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """The vertices that differ in any bit, and where they are afterwards."""
    # A view as integers tells -0.0 from 0.0, which == does not.
    bits = np.ascontiguousarray(before).view(np.int64) != np.ascontiguousarray(after).view(np.int64)
    vertices = np.flatnonzero(bits.any(axis=1)).astype(np.int32)
    return vertices, after[vertices]


def _said_to_come_from(mesh: Mesh, source: str | Path) -> Mesh:
    return Mesh(
        mesh.vertices,
        mesh.faces,
        uv=mesh.uv,
        materials=mesh.materials,
        groups=mesh.groups,
        material_library=mesh.material_library,
        source=Source(str(source), encoding=mesh.source.encoding if mesh.source else "utf-8"),
    )
