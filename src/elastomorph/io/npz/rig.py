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
  same for ``slider_group_names``, ``slider_group_counts``, ``slider_group_members``;
- in version 2, which is written where a corrective is no product, ``corrective_laws``, as JSON.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.choices import choice_from_json, choice_to_json
from elastomorph.io.npz.members import NpzMembers, open_npz, write_arrays
from elastomorph.io.npz.mesh import mesh_of, surface_arrays
from elastomorph.io.untrusted import naming_file
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Choice, Morph
from elastomorph.rig import Rig
from elastomorph.rig.laws import Corrective

_VERSION = 1
_LAWS = 2
_MOST_TERMS = 256


def read_rig_npz(path: str | Path) -> Rig:
    """The rig in an archive."""
    with open_npz(path) as members:
        return rig_of_members(members)


def write_rig_npz(path: str | Path, rig: Rig, *, settings: Mapping[str, Any] | None = None) -> None:
    """Write a rig with its neutral, paths, correctives and groups.

    Targets are kept as positions; the polygons and labels of all are those of the neutral.

    Args:
        path: The file; its folder must exist. A file that is there is replaced at once.
        rig: The rig.
        settings: How the rig was made, as JSON: given back by
            `elastomorph.io.registry.settings_used`.

    Raises:
        FileError: The file cannot be written.
    """
    arrays = rig_arrays(rig)
    if settings is not None:
        arrays["settings"] = np.array(json.dumps(settings, ensure_ascii=False, allow_nan=False))
    write_arrays(path, arrays)


def rig_arrays(rig: Rig) -> dict[str, NDArray[Any]]:
    """The arrays of a rig's archive."""
    morphs = list(rig.morphs.values())
    curves: dict[object, BendCurve] = {}
    number: dict[object, int] = {}

    def numbered(curve: BendCurve) -> int:
        """The number of a curve in the table; most morphs of a rig share theirs."""
        key = (curve.breaks.tobytes(), curve.coefficients.tobytes(), curve.coefficients.shape)
        curves.setdefault(key, curve)
        return number.setdefault(key, len(number))

    nowhere = np.zeros_like(rig.neutral.vertices)
    fields: list[tuple[NDArray[np.int32], NDArray[np.float64]]] = []
    of_bend: list[int] = []
    of_limit_law: list[int] = []
    for morph in morphs:
        fields.append(_changed(rig.neutral.vertices, morph.target.vertices))
        fields += [_changed(nowhere, bend) for bend in morph.bends]
        of_bend += map(numbered, morph.bend_curves)
        of_limit_law.append(numbered(morph.limit_law))
    choices = [json.dumps(choice_to_json(m.choice)) if m.choice else "" for m in morphs]
    shapes = [curve.coefficients.shape for curve in curves.values()]
    correctives = rig.sliders.correctives
    arrays: dict[str, NDArray[Any]] = {
        "neutral": rig.neutral.vertices,
        **surface_arrays(rig.neutral),
        "morph_names": np.array(list(rig.morphs), dtype=np.str_),
        "methods": np.array([morph.method for morph in morphs], dtype=np.str_),
        "bake_errors": np.array([morph.bake_error for morph in morphs], dtype=np.float64),
        "choices": np.array(choices, dtype=np.str_),
        "bend_counts": np.array([len(morph.bends) for morph in morphs], dtype=np.int64),
        "field_sizes": np.array([len(vertices) for vertices, _ in fields], dtype=np.int64),
        "field_vertices": np.concatenate([np.empty(0, np.int32), *(v for v, _ in fields)]),
        "field_values": np.concatenate([np.empty((0, 3)), *(values for _, values in fields)]),
        "curve_of_bend": np.array(of_bend, dtype=np.int64),
        "curve_of_limit_law": np.array(of_limit_law, dtype=np.int64),
        "curve_shapes": np.array(shapes, dtype=np.int64).reshape(-1, 2),
        "curve_breaks": np.concatenate([np.empty(0), *(c.breaks for c in curves.values())]),
        "curve_coefficients": np.concatenate(
            [np.empty(0), *(curve.coefficients.ravel() for curve in curves.values())]
        ),
        **_list_arrays("corrective", "drivers", {n: own.drivers for n, own in correctives.items()}),
        **_list_arrays("slider_group", "members", rig.sliders.groups),
    }
    laws = [own.entry() for own in correctives.values()]
    version = _LAWS if any("law" in entry for entry in laws) else _VERSION
    if version == _LAWS:
        arrays["corrective_laws"] = np.array([json.dumps(entry) for entry in laws], dtype=np.str_)
    names = np.array(list(arrays), dtype=np.str_)
    return {"rig_version": np.array(version), "rig_members": names, **arrays}


def rig_of_members(members: NpzMembers, source: str | Path | None = None) -> Rig:
    """The rig in an open archive."""
    path = members.path
    _require_version(members)
    neutral = mesh_of(members, members.array("neutral", "fiu", (None, 3)), source)
    vertices = len(neutral.vertices)
    names = members.texts("morph_names")
    if len(set(names)) < len(names):
        raise FormatError(path, "two morphs have the same name; the file is damaged")
    count = len(names)
    methods = members.texts("methods", count)
    bake_errors = members.array("bake_errors", "f", (count,)).tolist()
    if not all(0 <= error < np.inf for error in bake_errors):
        raise FormatError(path, "a bake error is no number from 0; the file is damaged")
    choices = _choices(members, count)
    bend_counts = members.whole("bend_counts", (count,)).tolist()
    bends = sum(bend_counts)
    curves = _curves(members)
    of_bend = members.whole("curve_of_bend", (bends,), 0, len(curves) - 1).tolist()
    limit_laws = members.whole("curve_of_limit_law", (count,), 0, len(curves) - 1).tolist()
    # Fields that move nothing take no room in a file, but a morph holds them in full.
    members.budget.spend_fields(vertices, count + bends)
    put = _fields(members, count + bends, vertices)
    drivers = _lists(members, "corrective", "drivers")
    groups = _lists(members, "slider_group", "members")
    entries = sum(map(len, (*drivers.values(), *groups.values())))
    members.budget.spend_lookups(entries, count)
    morphs: dict[str, Morph] = {}
    bend = 0
    with naming_file(path):
        for number, name in enumerate(names):
            first, field = bend, bend + number
            bend += bend_counts[number]
            positions = neutral.vertices.copy()
            put(field, positions)
            own = np.zeros((bend_counts[number], vertices, 3))
            for place, values in enumerate(own, start=field + 1):
                put(place, values)
            morphs[name] = Morph(
                neutral,
                neutral.with_vertices(positions),
                own,
                tuple(curves[curve] for curve in of_bend[first:bend]),
                method=methods[number],
                limit_law=curves[limit_laws[number]],
                bake_error=bake_errors[number],
                choice=choices[number],
            )
        correctives = _correctives(members, drivers)
        return Rig(neutral, morphs, correctives=correctives, groups=groups)


def _correctives(
    members: NpzMembers, drivers: Mapping[str, Sequence[str]]
) -> dict[str, Corrective]:
    if "corrective_laws" not in members.names:
        return {name: Corrective.of(own) for name, own in drivers.items()}
    found = {}
    for (name, own), text in zip(
        drivers.items(), members.texts("corrective_laws", len(drivers)), strict=True
    ):
        try:
            entry = dict(json.loads(text))
        except (ValueError, TypeError, RecursionError):
            raise FormatError(members.path, "the law of a corrective is damaged") from None
        found[name] = Corrective.of({**entry, "drivers": own})
    return found


def _require_version(members: NpzMembers) -> None:
    if "rig_version" not in members.names:
        raise FormatError(
            members.path,
            "this archive holds no rig; expected one written by write_rig_npz, with the array "
            f"'rig_version' (found {members.listed()})",
        )
    if (version := int(members.array("rig_version", "iu", ()))) not in (_VERSION, _LAWS):
        raise FormatError(
            members.path, f"this rig has version {version}, expected 1 or 2; update elastomorph"
        )
    # Some arrays may be absent, but none that was written: damage to a name must not go unseen.
    lost = set(members.texts("rig_members")) - members.names
    if lost:
        raise FormatError(
            members.path, f"the array '{min(lost)[:60]}' is missing; the file is damaged"
        )


def _fields(
    members: NpzMembers, count: int, vertex_count: int
) -> Callable[[int, NDArray[np.float64]], None]:
    """Writes the values of a field, by its number, into (V, 3) numbers."""
    sizes = members.whole("field_sizes", (count,)).tolist()
    total = sum(sizes)
    vertices = members.array("field_vertices", "iu", (total,)).astype(np.int64)
    values = members.array("field_values", "f", (total, 3))
    starts = _starts(sizes)
    steps = np.diff(vertices)
    steps[starts[(starts > 0) & (starts < total)] - 1] = 1
    if total and (vertices.min() < 0 or vertices.max() >= vertex_count or (steps <= 0).any()):
        raise FormatError(
            members.path,
            "the array 'field_vertices' must hold, for each field, vertices that rise and "
            f"exist (0 to {vertex_count - 1:,}); the file is damaged",
        )

    def put(field: int, positions: NDArray[np.float64]) -> None:
        own = slice(starts[field], starts[field + 1])
        positions[vertices[own]] = values[own]

    return put


def _changed(
    before: NDArray[np.float64], after: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """The vertices that differ in any bit, and where they are afterwards."""
    # A view as integers tells -0.0 from 0.0, which == does not.
    bits = np.ascontiguousarray(before).view(np.int64) != np.ascontiguousarray(after).view(np.int64)
    vertices = np.flatnonzero(bits.any(axis=1)).astype(np.int32)
    return vertices, after[vertices]


def _curves(members: NpzMembers) -> list[BendCurve]:
    """The different bend curves of an archive."""
    shapes = members.array("curve_shapes", "iu", (None, 2)).tolist()
    if any(pieces < 1 or terms < 1 for pieces, terms in shapes):
        raise FormatError(members.path, "a bend curve has no pieces or no coefficients")
    if any(terms > _MOST_TERMS for _, terms in shapes):
        raise FormatError(
            members.path, f"a bend curve has more than {_MOST_TERMS} coefficients a piece"
        )
    members.budget.spend_objects(len(shapes))
    breaks = members.array("curve_breaks", "f", (sum(pieces + 1 for pieces, _ in shapes),))
    flat = members.array("curve_coefficients", "f", (sum(p * n for p, n in shapes),))
    curves = []
    a = b = 0
    with naming_file(members.path):
        for pieces, terms in shapes:
            rows = flat[b : b + pieces * terms].reshape(pieces, terms)
            curves.append(BendCurve(breaks[a : a + pieces + 1], rows))
            a, b = a + pieces + 1, b + pieces * terms
    return curves


def _choices(members: NpzMembers, count: int) -> list[Choice | None]:
    """Why each path was chosen; nothing of all in archives written before that was kept."""
    if "choices" not in members.names:
        return [None] * count
    try:
        texts = members.texts("choices", count)
        return [choice_from_json(json.loads(text)) if text else None for text in texts]
    except (ValueError, RecursionError):
        raise FormatError(members.path, "the array 'choices' is damaged") from None


def _list_arrays(
    kind: str, what: str, lists: Mapping[str, Sequence[str]]
) -> dict[str, NDArray[Any]]:
    """The arrays of named lists of names; none where there are no lists."""
    if not lists:
        return {}
    entries = [entry for own in lists.values() for entry in own]
    return {
        f"{kind}_names": np.array(list(lists), dtype=np.str_),
        f"{kind}_counts": np.array([len(own) for own in lists.values()], dtype=np.int64),
        f"{kind}_{what}": np.array(entries, dtype=np.str_),
    }


def _lists(members: NpzMembers, kind: str, what: str) -> dict[str, list[str]]:
    """The named lists of names; none where the archive has no such arrays."""
    if f"{kind}_names" not in members.names:
        return {}
    names = members.texts(f"{kind}_names")
    counts = members.whole(f"{kind}_counts", (len(names),)).tolist()
    entries = members.texts(f"{kind}_{what}", sum(counts))
    ends = pairwise(_starts(counts).tolist())
    return {name: entries[start:stop] for name, (start, stop) in zip(names, ends, strict=True)}


def _starts(sizes: list[int]) -> NDArray[np.int64]:
    """Where each of some runs begins, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
