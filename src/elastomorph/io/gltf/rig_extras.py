"""How the morph targets of a file make up the morphs of a rig, as plain JSON.

::

    {"version": 1,
     "morphs": [{"name": "jawOpen", "target": "jawOpen", "method": "rotation", "bake_error": 0.0,
                 "choice": {"distance": 0.011, "allowed": 0.0005, "exact": true, …},
                 "limit_law": {"breaks": [0, 1], "coefficients": [[0, -1, 1]]},
                 "bends": [{"target": "jawOpen.bend1",
                            "curve": {"breaks": …, "coefficients": …}}]}],
     "correctives": [{"name": "mouthClose", "drivers": ["jawOpen", "mouthClose"]}],
     "groups": [{"name": "jaw", "members": ["jawOpen"]}],
     "surface": {…}}

Where a surface is stored as several meshes, each of them describes the targets that it has, and its
``part`` says which vertices of the surface are its own. The first has the rest under ``whole``: the
surface, groups, and the names of all targets in order.

Targets are named as in ``targetNames``. A weight t of a morph is the weight t of its target and
the weight b_k(t) of the target of each bend. ``choice`` says why ``auto`` took the path, and is
null where the method was named. The curves are piecewise polynomials: between breaks
i and i + 1 the value is Σ_n coefficients[i][n] (t - breaks[i])^n.

Version 2 knows one key more, and is written only where it is used: ``"fold": {curve}`` of a morph
is a bend that is a multiple of Δ and so needs no target of its own. The weight of the target itself
is then t + fold(t).

Version 3 knows ``"index": 4`` beside a ``target`` that shares its name with others of its mesh: the
number of the one that is meant; and laws of correctives, ``{"name": …, "drivers": […], "law":
"min"}`` with ``gains`` or a ``sharpness``, see `elastomorph.Corrective`. A morph that is driven
entirely by others may then have bends and no ``target``: a pair bend.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from elastomorph.errors import ParameterError
from elastomorph.io.blend_shapes import curve_from_json, curve_to_json, different_names
from elastomorph.io.choices import choice_from_json, choice_to_json
from elastomorph.io.gltf.container import GltfFile, object_of
from elastomorph.io.gltf.morph_targets import MorphTargets
from elastomorph.io.untrusted import MemoryBudget
from elastomorph.model.bend_curve import BendCurve
from elastomorph.rig import Rig
from elastomorph.rig.laws import Corrective
from elastomorph.rig.sliders import Sliders

WITHOUT_FOLDS, FOLDS, INDICES, LAWS = 1, 2, 3, 3
"""Versions."""


@dataclass(frozen=True, eq=False)
class StoredMorph:
    """A morph as the file describes it."""

    name: str  # Its name
    target: str | None  # Name of the morph target with Δ; a pair bend has none
    bends: tuple[tuple[str, BendCurve], ...]  # Name of the morph target of each bend, and its curve
    more: Mapping[str, Any]  # Further arguments of `Morph`
    fold: BendCurve | None = None  # What is added to the weight of the target itself

    @classmethod
    def straight(cls, name: str) -> StoredMorph:
        """A morph target of which nothing more is known: a straight path of its name."""
        return cls(name, name, (), {"method": "linear", "bare": True})


@dataclass(frozen=True, eq=False)
class StoredRig:
    """A rig as the file describes it."""

    morphs: tuple[StoredMorph, ...]  # Its morphs in order
    correctives: dict[str, Corrective]  # How others drive a shape, by its name
    groups: dict[str, list[str]]  # Name and members of each group
    described: bool = True  # False where the file says nothing that fits


def described_meshes(file: GltfFile) -> dict[int, Any]:
    """``extras.elastomorph`` by the number of the mesh.

    Programs such as three.js' exporter put it into the extras of the node that shows the mesh.
    """
    holders: list[tuple[Any, Any]] = [*enumerate(file.items("meshes"))]
    holders += [(object_of(node).get("mesh"), node) for node in file.items("nodes")]
    found: dict[int, Any] = {}
    for number, holder in holders:
        extras = object_of(object_of(holder).get("extras"))
        if "elastomorph" in extras and type(number) is int:
            found.setdefault(number, extras["elastomorph"])
    return found


def numbered(entry: Mapping[str, Any], given: Sequence[str]) -> int:
    """The number of the target of a morph or a bend, among targets as the file names them."""
    names = different_names(given)
    return names.index(_Targets(names, given).named(entry))


def rig_extras(rig: Rig, targets: MorphTargets, held: Collection[int]) -> dict[str, Any]:
    """The description of a rig by a mesh that holds its targets of these numbers."""
    sliders = rig.sliders
    known = {n for n, kept in zip(rig.morphs, targets.morphs, strict=True) if kept.first in held}
    correctives = corrective_entries({n: c for n, c in sliders.correctives.items() if n in known})
    morphs = [
        {
            "name": name,
            **({"target": targets.names[kept.first]} if kept.whole else {}),
            "method": morph.method,
            "bake_error": float(morph.bake_error + kept.dropped_error),
            "choice": choice_to_json(morph.choice),
            "limit_law": curve_to_json(morph.limit_law),
            "bends": [
                {"target": targets.names[number], "curve": curve_to_json(morph.bend_curves[k])}
                for number, k in enumerate(kept.bends, start=kept.first + kept.whole)
                if number in held
            ],
            **({} if kept.fold is None else {"fold": curve_to_json(kept.fold)}),
        }
        for (name, morph), kept in zip(rig.morphs.items(), targets.morphs, strict=True)
        if name in known
    ]
    return {
        "version": least_version(morphs, correctives),
        "morphs": morphs,
        "correctives": correctives,
        "groups": [{"name": n, "members": [*own]} for n, own in sliders.groups.items()],
    }


def corrective_entries(correctives: Mapping[str, Corrective]) -> list[dict[str, Any]]:
    """The list of correctives of a mesh."""
    return [{"name": name, **own.entry()} for name, own in correctives.items()]


def least_version(
    morphs: Sequence[Mapping[str, Any]], correctives: Sequence[Mapping[str, Any]]
) -> int:
    """The least version that says what these lists of a mesh say."""
    every = [one for morph in morphs for one in (morph, *morph.get("bends", []))]
    if any("index" in one or "target" not in one for one in every):
        return INDICES
    if any("law" in own for own in correctives):
        return LAWS
    return FOLDS if any("fold" in morph for morph in morphs) else WITHOUT_FOLDS


def stored_rig(
    stored: Any, targets: Sequence[str], budget: MemoryBudget, given: Sequence[str] = ()
) -> StoredRig:
    """The description of a rig in ``extras.elastomorph`` of a mesh, or a ValueError.

    Morph targets that it does not name are morphs of their own, at its end. Targets have names that
    differ; those that the file has given them may not.
    """
    version = _version(stored)
    names_of = _Targets(targets, given if version >= INDICES else ())
    morphs = [_morph(entry, version, names_of) for entry in _list(stored, "morphs")]
    used = [
        target
        for m in morphs
        for target in (m.target, *(bend for bend, _ in m.bends))
        if target is not None
    ]
    missing = set(used).difference(targets)
    if missing:
        raise ParameterError(f"it names the morph target {min(missing)!r}, which does not exist")
    morphs += [StoredMorph.straight(name) for name in targets if name not in set(used)]
    names = [morph.name for morph in morphs]
    if len(set(used)) != len(used) or len(set(names)) != len(names):
        raise ParameterError("it uses a morph target or a name twice")
    correctives = _correctives(stored, version)
    found = StoredRig(tuple(morphs), correctives, _lists(stored, "groups", "members"))
    lists = (*(own.drivers for own in correctives.values()), *found.groups.values())
    budget.spend_lookups(2 * sum(map(len, lists)), len(names))  # here, and by the rig
    groups = {name: tuple(own) for name, own in found.groups.items()}
    sliders = Sliders(tuple(names), correctives, groups)
    for morph in morphs:
        if morph.target is None and morph.name in sliders.drivers(morph.name):
            raise ParameterError(f"{morph.name!r} has a slider and no morph target")
    return found


def joined_rigs(parts: Sequence[StoredRig], whole: Mapping[str, Any]) -> StoredRig:
    """What the meshes of one surface say together, or a ValueError."""
    names = (name if isinstance(name, str) else "" for name in _list(dict(whole), "targets"))
    order = {name: number for number, name in enumerate(names)}
    last = len(order)

    def place(target: str) -> int:
        return order.get(target, last)

    morphs: dict[str, StoredMorph] = {}
    for morph in (own for part in parts for own in part.morphs):
        known = morphs.get(morph.name, morph)
        if (known.target, known.fold is None) != (morph.target, morph.fold is None):
            raise ParameterError(f"two meshes say different things of {morph.name!r}")
        bends = {**dict(known.bends), **dict(morph.bends)}.items()
        in_order = tuple(sorted(bends, key=lambda bend: place(bend[0])))
        said = known if known.bends else morph
        morphs[morph.name] = replace(said, bends=in_order)
    found = sorted(
        morphs.values(), key=lambda morph: min(map(place, _names_of(morph)), default=last)
    )
    correctives = {name: own for part in parts for name, own in part.correctives.items()}
    groups = _lists(dict(whole), "groups", "members")
    sliders = {morph.name for morph in found}
    if not sliders.issuperset(member for own in groups.values() for member in own):
        raise ParameterError("a group has a member that does not exist")
    return StoredRig(tuple(found), correctives, groups)


def _names_of(morph: StoredMorph) -> list[str]:
    """Of the target that a morph is sorted by: Δ, or the bends of one that has none."""
    return [name for name, _ in morph.bends] if morph.target is None else [morph.target]


def _correctives(stored: dict[str, Any], version: int) -> dict[str, Corrective]:
    lists = _lists(stored, "correctives", "drivers")
    if version < LAWS:
        return {name: Corrective.of(own) for name, own in lists.items()}
    return {_text(entry, "name"): Corrective.of(entry) for entry in _list(stored, "correctives")}


def _version(stored: Any) -> int:
    # Some programs write every number with a point.
    version: Any = stored.get("version") if isinstance(stored, dict) else None
    if type(version) not in (int, float) or version < 1 or version % 1 != 0:
        raise ParameterError("it has no version")
    if version > INDICES:
        raise ParameterError(
            f"it has version {version:.0f}, this program reads up to {INDICES}; update elastomorph"
        )
    return int(version)


@dataclass(frozen=True)
class _Targets:
    """The morph targets of a mesh, and the names that its file has given them."""

    names: Sequence[str]
    given: Sequence[str]

    def named(self, entry: Mapping[str, Any]) -> str:
        """The name of the target of a morph or a bend."""
        name, index = _text(entry, "target"), entry.get("index", -1)
        told = type(index) in (int, float) and index in range(len(self.given))
        return self.names[int(index)] if told and self.given[int(index)] == name else name


def _morph(entry: Any, version: int, targets: _Targets) -> StoredMorph:
    if not isinstance(entry, dict):
        raise ParameterError("a morph is no object")
    bends = []
    for bend in _list(entry, "bends"):
        if not isinstance(bend, dict):
            raise ParameterError("a bend is no object")
        bends.append((targets.named(bend), curve_from_json(bend.get("curve"))))
    error = entry.get("bake_error", 0.0)
    if not isinstance(error, int | float) or isinstance(error, bool) or not 0 <= error < 1e300:
        raise ParameterError("the bake error of a morph is no number from 0")
    more = {
        "method": _text(entry, "method"),
        "bake_error": float(error),
        "choice": choice_from_json(entry.get("choice")),
    }
    if "limit_law" in entry:
        more["limit_law"] = curve_from_json(entry["limit_law"])
    fold = curve_from_json(entry["fold"]) if version >= FOLDS and "fold" in entry else None
    without = version >= LAWS and "target" not in entry
    target = None if without else targets.named(entry)
    return StoredMorph(_text(entry, "name"), target, tuple(bends), more, fold)


def _text(entry: Mapping[str, Any], key: str) -> str:
    value = entry.get(key, "")
    if not isinstance(value, str):
        raise ParameterError(f"'{key}' of a morph is no text")
    return value


def _list(entry: dict[str, Any], key: str) -> list[Any]:
    # An empty list may have been left out: many programs write no empty lists.
    value = entry.get(key, [])
    if not isinstance(value, list):
        raise ParameterError(f"'{key}' is no list")
    return value


def _lists(stored: dict[str, Any], key: str, inner: str) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for entry in _list(stored, key):
        members: Sequence[Any] = _list(entry, inner) if isinstance(entry, dict) else [None]
        if not all(isinstance(member, str) for member in members):
            raise ParameterError(f"'{key}' are no lists of names")
        name = _text(entry, "name")
        if name in found:
            raise ParameterError(f"'{key}' has the name {name!r} twice")
        found[name] = list(members)
    return found
