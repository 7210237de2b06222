"""Writes the vectors that every runtime must reproduce, as elastomorph computes them.

::

    python runtimes/conformance/make_vectors.py [FOLDER]

A vector is a small rig with poses: the ``extras`` of its mesh, its ``neutral`` (V, 3), its
``targets`` (T, V, 3) in the order of ``targetNames``, and for each pose its ``sliders``, the
``weights`` (T,) of the targets and the ``positions`` (V, 3) they give. The numbers that go in are
short binary fractions, so that they are the same on every machine.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.io.blend_shapes import curve_to_json
from elastomorph.io.gltf.morph_targets import MorphTargets
from elastomorph.io.gltf.rig_extras import rig_extras
from elastomorph.rig.laws import LAWS

FOLDER = Path(__file__).parent / "vectors"
VERTICES = 4
# Inside, at the ends, outside, and next to the ends.
VALUES = (-1.5, -0.25, 0.0, 1e-12, 0.125, 0.3, 0.5, 0.77, 1 - 1e-12, 1.0, 1.25, 3.0)

BEAM = em.BendCurve.polynomial([0, 1, -1])
CUBIC = em.BendCurve.power(3)
TENT = em.BendCurve([0, 0.25, 1], [[0, 4], [1, -4 / 3]])
PAIR = {"name": "pair", "drivers": ["a", "b"]}
STEPS = em.BendCurve([0, 0.25, 0.5, 0.75, 1], [[0], [0.75], [-0.5], [0]])


@dataclass(frozen=True)
class Bent:
    """The curves of a morph."""

    bends: Sequence[em.BendCurve] = ()
    fold: em.BendCurve | None = None
    whole: bool = True  # False of a pair bend, which has no target


@dataclass(frozen=True)
class Vector:
    """One file of the kit."""

    about: str
    morphs: Mapping[str, Bent]
    poses: Sequence[Mapping[str, float]]
    correctives: Mapping[str, Sequence[str] | em.Corrective] = field(default_factory=dict)
    groups: Mapping[str, Sequence[str]] = field(default_factory=dict)


def all_vectors() -> dict[str, dict[str, Any]]:
    """The content of all files by their names."""
    rng = np.random.default_rng(7)
    many = [_pieces(rng, pieces, terms) for pieces, terms in ((2, 4), (33, 4), (97, 2), (5, 8))]
    breaks = sorted({float(t) for own in many for t in own.breaks[:: 1 + len(own.breaks) // 9]})
    three = {"a": Bent([BEAM]), "b": Bent([CUBIC, TENT]), "c": Bent()}
    texts = ("__proto__", "constructor", "ジョー", 'a "b" \\ /', "", "😀\n")
    plain = Vector(
        "No description: each target is a slider.", {"a": Bent(), "b": Bent()}, _each("ab")
    )
    other = Vector(
        "What changes nothing: targets in another order, targets that are not described, keys that "
        "are not known, lists that are left out, a fold in version 1.",
        three,
        _each("abc"),
    )
    return {
        "plain": _content(plain, rng) | {"extras": {"targetNames": ["a", "b"]}},
        "other": _rewritten(_content(other, rng)),
        "degrees": _content(
            Vector(
                "Curves of degree 0 to 7.",
                {"s": Bent([STEPS]), "p": Bent([TENT, *map(em.BendCurve.power, range(2, 8))])},
                _each("sp"),
            ),
            rng,
        ),
        "pieces": _content(
            Vector(
                "Curves of many pieces that do not meet, also exactly at their breaks.",
                {str(i): Bent([curve]) for i, curve in enumerate(many)},
                _each("0123", (*breaks, *VALUES)),
            ),
            rng,
        ),
        "correctives": _content(
            Vector(
                "Products of drivers: with and without a slider of their own, one driver twice.",
                three
                | {"ab": Bent([TENT]), "own": Bent([BEAM, CUBIC]), "aa": Bent([TENT])}
                | {"cba": Bent([CUBIC])},
                [
                    *_each(["a", "b", "c", "own"]),
                    {"a": 0.5},
                    {"own": 0.5},
                    {"a": 0.75, "c": 0.5},
                    {"a": 0.75, "c": 0.5, "own": -0.25},
                    {"a": 1.5, "b": -0.5, "c": 0.5, "own": 1.0},
                    {"a": 0.75, "b": 0.5, "ab": 1.0},  # which has no slider
                ],
                {
                    "ab": ("a", "b"),
                    "own": ("a", "c", "own"),
                    "aa": ("a", "a"),
                    "cba": ("c", "b", "a"),
                },
                {"lower": ("a", "own"), "none": ()},
            ),
            rng,
        ),
        "folds": _content(
            Vector(
                "Version 2: the weight of a target is t + fold(t), also of a corrective.",
                {
                    "only": Bent([], CUBIC),
                    "bent": Bent([BEAM, TENT], many[0]),
                    "plain": Bent([BEAM]),
                    "both": Bent([TENT], BEAM),
                },
                [*_each(["only", "bent", "plain"]), {"only": 0.5}, {"bent": 0.75, "plain": 0.5}],
                {"both": ("bent", "plain")},
            ),
            rng,
        ),
        "everything": _content(_everything(np.random.default_rng(11)), rng),
        "names": _content(
            Vector(
                "Any text is a name. A slider that the mesh does not have does nothing.",
                {name: Bent([BEAM]) for name in texts},
                [
                    {name: (i + 1) / 8 for i, name in enumerate(texts)},
                    {"length": 1.0, "toString": 1.0, "ジョー": 0.5, "__proto__.bend1": 0.5},
                    {},
                ],
            ),
            rng,
        ),
        "indices": _numbered(
            _content(
                Vector(
                    "Version 3: targets that share a name are told by their numbers.",
                    three | {"folded": Bent([BEAM], TENT)},
                    _each(["a", "b", "c", "folded"]),
                ),
                rng,
            )
        ),
        "beside": _beside(
            _content(Vector("Curves in a file beside: those of a mesh.", three, _each("abc")), rng)
        ),
        "laws": _content(_laws(three), rng),
        "pairs": _content(_pairs(three), rng),
        "together": _numbered(
            _content(_together(three), rng), kept=("a.bend1", "folded", "a_b.bend2")
        ),
        "earlier": _earlier(
            _content(
                Vector(
                    "Version 2: laws are passed over, a corrective is the product of its drivers.",
                    three | {"ab": Bent([TENT]), "cba": Bent([BEAM], CUBIC)},
                    _each("abc"),
                    {"ab": ("a", "b"), "cba": ("c", "b", "a")},
                ),
                rng,
            )
        ),
    }


def _laws(three: Mapping[str, Bent]) -> Vector:
    """Every law: of two drivers and of three in another order, of one, of one twice, of its own."""
    numbers = {
        "hinge": lambda count: (1.25, 0.75, -0.5)[:count],
        "softmin": lambda count: (0.5, 4.0, 64.0)[count - 1 : count],
    }
    driven = {}
    for law in LAWS:
        name = f"{law} of its own"
        for drivers in (("a", "b"), ("c", "b", "a"), ("b",), ("a", "a"), ("b", name)):
            own = numbers.get(law, lambda _: ())(len(drivers))
            title = name if name in drivers else f"{law} {' '.join(drivers)}"
            driven[title] = em.Corrective(drivers, law, own)
    alone = [name for name in driven if name.endswith("own")]
    poses = [
        dict(zip("abc", row, strict=True)) | dict.fromkeys(alone, own)
        for row, own in (
            ((0.25, 0.75, 0.5), 0.5),
            ((0.75, 0.25, 0.5), 1.0),
            ((0.5, 0.5, 0.5), 0.5),  # ties
            ((0.5, 0.25, 0.25), 0.25),
            ((1.0, 1.0, 1.0), 1.0),
            ((0.5, 0.5, 0.0), 0.8),  # where the hinge of a and b begins, 1.25 a + 0.75 b = 1
            ((0.8, 0.0, 1.0), -1.0),
            ((0.5, 0.5 - 2**-30, 0.25), 1e-12),
            ((0.5, 0.5 + 2**-30, 0.25), 1e-300),
            ((0.0, 0.75, 1.0), 0.0),
            ((1e-12, 1.0, 1e-300), 1.0),
            ((-0.25, 0.75, 1.0), 0.5),
            ((-0.25, -0.75, -1.0), -0.5),
            ((1.25, 0.75, 1.5), 0.5),
            ((1.25, 3.0, 1.5), 1.25),
            ((1.0, 1.5, 0.0), 2.0),
            ((1.5, -0.5, 0.5), 1.25),
            ((-1.5, 2.0, -0.25), 0.75),
        )
    ]
    return Vector(
        "Version 3, laws of correctives: at ties and where they have kinks, below 0 and above 1.",
        {**three, **{name: Bent([CUBIC]) for name in driven}},
        [*poses, *_each([*"abc", *alone]), {}],
        driven,
    )


def _pairs(three: Mapping[str, Bent]) -> Vector:
    """Pair bends, which have no target, before and after their drivers."""
    pairs = {
        "b_c": em.Corrective(("b", "c"), "min"),
        "a_b": em.Corrective(("a", "b"), "min"),
        "c_a": em.Corrective(("c", "a"), "hinge", (1.5, 0.75)),
        "product": em.Corrective(("b", "a", "c")),
        "shape": em.Corrective(("a", "b"), "softmin", (8.0,)),
    }
    curves: dict[str, list[em.BendCurve]] = {
        "b_c": [BEAM],
        "a_b": [CUBIC, TENT, BEAM],
        "c_a": [TENT],
        "product": [CUBIC, BEAM],
    }
    bent = {name: Bent(own, whole=False) for name, own in curves.items()}
    grid = [(a, b) for a in (-0.25, 0.0, 0.3, 0.5, 1.0, 1.25) for b in (0.0, 0.5, 0.77, 1.0)]
    return Vector(
        "Version 3, pair bends: morphs that are driven by others, with bends and no target.",
        {"b_c": bent.pop("b_c"), **three, **bent, "shape": Bent()},
        [*({"a": a, "b": b, "c": 0.75} for a, b in grid), *_each("abc")],
        pairs,
    )


def _together(three: Mapping[str, Bent]) -> Vector:
    """Laws, pair bends and folds of a mesh whose targets share their names."""
    return Vector(
        "Version 3: laws, a pair bend, a fold, and targets that are told by their numbers.",
        three
        | {
            "folded": Bent([BEAM], TENT),
            "a_b": Bent([CUBIC, BEAM], whole=False),
            "lid": Bent([TENT], CUBIC),
        },
        [
            *_each(["a", "b", "c", "folded"]),
            *({"a": a / 4, "b": b / 4, "folded": a * b / 16} for a in range(6) for b in range(6)),
        ],
        {
            "a_b": em.Corrective(("b", "a"), "min"),
            "lid": em.Corrective(("a", "folded", "c"), "hinge", (0.75, 0.5, 0.25)),
        },
    )


def _each(names: Sequence[str], values: Sequence[float] = VALUES) -> list[dict[str, float]]:
    """A pose for each value, of all sliders alike."""
    return [dict.fromkeys(names, value) for value in values]


def _fractions(rng: np.random.Generator, *shape: int) -> NDArray[np.float64]:
    """Random numbers between -1 and 1 of six binary digits."""
    return rng.integers(-64, 65, shape) / 64


def _pieces(rng: np.random.Generator, pieces: int, terms: int) -> em.BendCurve:
    inner = np.sort(rng.choice(np.arange(1, 256), pieces - 1, replace=False)) / 256
    breaks = np.concatenate([[0.0], inner, [1.0]])
    coefficients = _fractions(rng, pieces, terms)
    coefficients[0, 0] = 0.0
    coefficients[-1, 0] -= np.polynomial.polynomial.polyval(1 - breaks[-2], coefficients[-1])
    return em.BendCurve(breaks, coefficients)


def _everything(rng: np.random.Generator) -> Vector:
    """Many morphs, each with or without a fold, bends and drivers."""

    def curve() -> em.BendCurve:
        return _pieces(rng, int(rng.integers(2, 8)), int(rng.integers(1, 6)))

    morphs = {
        f"m{i}": Bent(
            [curve() for _ in range(rng.integers(0, 4))], curve() if rng.random() < 0.5 else None
        )
        for i in range(16)
    }
    correctives = {}
    for i in range(10, 16):
        drivers = [f"m{d}" for d in rng.integers(0, 10, rng.integers(1, 4))]
        correctives[f"m{i}"] = [*drivers, *([f"m{i}"] if rng.random() < 0.5 else [])]
    poses = [{name: float(_fractions(rng, 1)[0] * 2) for name in morphs} for _ in range(6)]
    return Vector("All of it at once, at random.", morphs, poses, correctives)


def _content(vector: Vector, rng: np.random.Generator) -> dict[str, Any]:
    neutral = em.Mesh(_fractions(rng, VERTICES, 3), [[0, 1, 2], [0, 2, 3]])
    stored, whole = {}, {}
    for name, bent in vector.morphs.items():
        moved = _fractions(rng, VERTICES, 3) if bent.whole else 0.0
        target = neutral.with_vertices(neutral.vertices + moved)
        bends = _fractions(rng, len(bent.bends), VERTICES, 3)
        stored[name] = whole[name] = em.Morph(neutral, target, bends, tuple(bent.bends))
        if bent.fold is not None:
            every = np.concatenate([bends, stored[name].delta[None]])
            whole[name] = em.Morph(neutral, target, every, (*bent.bends, bent.fold))
    named = {"correctives": vector.correctives, "groups": vector.groups}
    rig, folded = em.Rig(neutral, stored, **named), em.Rig(neutral, whole, **named)
    targets = MorphTargets.of(rig, 0.0)
    described = rig_extras(rig, targets, range(len(targets.names)))
    for entry, bent in zip(described["morphs"], vector.morphs.values(), strict=True):
        if bent.fold is not None:
            described["version"] = max(2, described["version"])
            entry["fold"] = curve_to_json(bent.fold)
    shapes = [
        shape
        for bent, m in zip(vector.morphs.values(), stored.values(), strict=True)
        for shape in (*([m.delta] if bent.whole else []), *m.bends)
    ]
    return {
        "about": vector.about,
        "extras": {"targetNames": list(targets.names), "elastomorph": described},
        "neutral": neutral.vertices.tolist(),
        "targets": [shape.tolist() for shape in shapes],
        "poses": [_pose(vector, folded, sliders) for sliders in vector.poses],
    }


def _pose(vector: Vector, rig: em.Rig, sliders: Mapping[str, float]) -> dict[str, Any]:
    """What sliders do: the weight of each target, and where the vertices then are."""
    known = {name: value for name, value in sliders.items() if name in rig.sliders.names}
    driven = rig.sliders.drive(rig.sliders.row(known)[None])[0]
    weights: list[float] = []
    for t, bent in zip(driven.tolist(), vector.morphs.values(), strict=True):
        weights += [t + (bent.fold.at(t) if bent.fold else 0.0)] if bent.whole else []
        weights += [curve.at(t) for curve in bent.bends]
    return {
        "sliders": dict(sliders),
        "weights": [weight + 0.0 for weight in weights],
        "positions": rig.pose(known).tolist(),
    }


def _rewritten(vector: dict[str, Any]) -> dict[str, Any]:
    """The same, as another program might have written it."""
    extras = vector["extras"]
    described = extras["elastomorph"]
    described["version"] = 1.0
    described["later"] = {"curve": None}
    described["morphs"] = [
        {"name": m["name"], "target": m["target"], "bends": m["bends"], "fold": curve_to_json(TENT)}
        for m in reversed(described["morphs"])
        if m["bends"]
    ]
    del described["correctives"], described["groups"]
    order = list(range(len(extras["targetNames"])))[::-1]
    extras["targetNames"] = [extras["targetNames"][i] for i in order]
    vector["targets"] = [vector["targets"][i] for i in order]
    for pose in vector["poses"]:
        pose["weights"] = [pose["weights"][i] for i in order]
    return vector


def _beside(vector: dict[str, Any]) -> dict[str, Any]:
    """The same as one mesh of a file of curves, as ``bend --curves`` writes it."""
    own = {"mesh": 3, "names": ["Face", "head"], **vector["extras"]}
    other = {"mesh": 4, "names": ["Face", "1"], "targetNames": ["a"], "elastomorph": {"version": 1}}
    curves = {"version": 1, "meshes": [other, own]}
    return vector | {"curves": curves, "mesh": "head"}


def _earlier(vector: dict[str, Any]) -> dict[str, Any]:
    """The same with laws, which version 2 does not know."""
    first, last = vector["extras"]["elastomorph"]["correctives"]
    first |= {"law": "hinge", "gains": [2.0, 1.0]}
    last |= {"law": "min"}
    return vector


def _numbered(
    vector: dict[str, Any], kept: Collection[str] = ("a.bend1", "folded")
) -> dict[str, Any]:
    """The same, with names for its targets that several have, and numbers that tell them apart.

    Of two targets the numbers are another's, as where a program has put them in another order: they
    are known by their names.
    """
    extras = vector["extras"]
    described, names = extras["elastomorph"], extras["targetNames"]
    described["version"] = 3
    entries = [own for morph in described["morphs"] for own in (morph, *morph["bends"])]
    entries = [own for own in entries if "target" in own]
    for own in entries:
        own["index"] = names.index(own["target"])
    for own in entries:
        if own["target"] in kept:
            own["index"] = 1 - own["index"] if own["index"] < 2 else 99
        else:
            own["target"] = names[own["index"]] = "same" if own["index"] % 2 else "name"
    return vector


def refused() -> list[dict[str, Any]]:
    """Extras that must be refused, each for one reason."""
    curve = curve_to_json(BEAM)
    morph = {"name": "a", "target": "a", "bends": [{"target": "a.bend1", "curve": curve}]}
    names = ["a", "a.bend1", "b", "c"]

    def entry(why: str, targets: Sequence[str] = names, **described: Any) -> dict[str, Any]:
        stored = {"version": 1, "morphs": [morph], **described}
        return {"why": why, "extras": {"targetNames": list(targets), "elastomorph": stored}}

    def curved(why: str, breaks: Any, coefficients: Any) -> dict[str, Any]:
        bends = [{"target": "a.bend1", "curve": {"breaks": breaks, "coefficients": coefficients}}]
        return entry(why, morphs=[morph | {"bends": bends}])

    def driven(why: str, *correctives: Any) -> dict[str, Any]:
        return entry(why, correctives=list(correctives))

    def lawful(why: str, **more: Any) -> dict[str, Any]:
        own = {"name": "c", "drivers": ["a", "b"], **more}
        return entry(why, version=3, correctives=[own])

    def paired(why: str, version: int, *correctives: Any, **more: Any) -> dict[str, Any]:
        pair = {"name": "pair", "bends": [{"target": "c", "curve": curve}], **more}
        return entry(why, version=version, morphs=[morph, pair], correctives=list(correctives))

    return [
        entry("a version that is not known yet", version=4),
        entry("no version", version=None),
        entry("a version that is a text", version="1"),
        entry("a version of true", version=True),
        entry("version 0", version=0),
        entry("half a version", version=1.5),
        {"why": "no object", "extras": {"targetNames": names, "elastomorph": [1]}},
        entry("morphs that are no list", morphs={"a": morph}),
        entry("a morph that is no object", morphs=["a"]),
        entry("a morph target that does not exist", ["a", "b"]),
        entry("a target that is a number", morphs=[morph | {"target": 0}]),
        entry("a name that is a number", morphs=[morph | {"name": 1}]),
        entry("a morph target used twice", morphs=[morph, {"name": "b", "target": "a"}]),
        entry("a name given twice", morphs=[morph, {"name": "a", "target": "b"}]),
        entry(
            "a name of a morph that a target has which is not described",
            morphs=[
                morph | {"name": "b"},
            ],
        ),
        entry("two targets of one name", [*names, "c"]),
        *(
            entry(
                why, ["a", "a", "a.bend1"], version=version, morphs=[own, other | {"target": "a"}]
            )
            for why, version, own, other in (
                ("two targets of one name, and no number", 3, morph | {"index": 0}, {"name": "b"}),
                (
                    "two targets of one name, and numbers in version 2",
                    2,
                    morph | {"index": 0},
                    {"name": "b", "index": 1},
                ),
                ("a number that is a text", 3, morph | {"index": 0}, {"name": "b", "index": "1"}),
                ("half a number", 3, morph | {"index": 0}, {"name": "b", "index": 0.5}),
                ("a number used twice", 3, morph | {"index": 1}, {"name": "b", "index": 1}),
                (
                    "two targets of one name, and the number of another",
                    3,
                    morph | {"index": 0},
                    {"name": "b", "index": 2},
                ),
                ("a number from the end", 3, morph | {"index": 0}, {"name": "b", "index": -2}),
            )
        ),
        entry("bends that are no list", morphs=[morph | {"bends": {"curve": curve}}]),
        entry("a bend without a curve", morphs=[morph | {"bends": [{"target": "a.bend1"}]}]),
        entry("a fold that is no curve", version=2, morphs=[morph | {"fold": 0.5}]),
        curved("breaks that do not rise", [0, 0.5, 0.5, 1], [[0], [1], [0]]),
        curved("breaks that do not begin at 0", [0.1, 1], [[0, 1, -1]]),
        curved("breaks that do not end at 1", [0, 0.9], [[0, 1, -1]]),
        curved("one break", [0], []),
        curved("breaks that are no numbers", [0, "0.5", 1], [[0], [0]]),
        curved("more breaks than pieces", [0, 0.5, 1], [[0, 1, -1]]),
        curved("a piece without coefficients", [0, 1], [[]]),
        curved("pieces of different length", [0, 0.5, 1], [[0, 1], [0]]),
        curved("a coefficient that is null", [0, 1], [[0, None]]),
        curved("more than 256 coefficients a piece", [0, 1], [[0.0] * 257]),
        curved("a curve that is not 0 at 0", [0, 1], [[1, -1]]),
        curved("a curve that is not 0 at 1", [0, 1], [[0, 1]]),
        driven("a corrective that is no object", "a"),
        driven("a corrective that is no morph", {"name": "x", "drivers": ["a"]}),
        driven("no drivers", {"name": "c", "drivers": []}),
        driven("drivers that are one text", {"name": "c", "drivers": "ab"}),
        driven("a driver that does not exist", {"name": "c", "drivers": ["a", "x"]}),
        driven("a driver that is the target of a bend", {"name": "c", "drivers": ["a.bend1"]}),
        driven("a corrective twice", *({"name": "c", "drivers": [own]} for own in "ab")),
        driven(
            "a driver that is itself a corrective",
            {"name": "b", "drivers": ["a", "b"]},
            {"name": "c", "drivers": ["b"]},
        ),
        lawful("a law that is not known", law="mean"),
        lawful("a law in capitals", law="Min"),
        lawful("a law that is null", law=None),
        lawful("a law that is a number", law=1),
        lawful("a hinge without gains", law="hinge"),
        lawful("gains for fewer drivers", law="hinge", gains=[1]),
        lawful("gains for more drivers", law="hinge", gains=[1, 1, 1]),
        lawful("gains that are one number", law="hinge", gains=1),
        lawful("a gain that is null", law="hinge", gains=[1, None]),
        lawful("a gain that is a text", law="hinge", gains=[1, "1"]),
        lawful("gains that are null", law="hinge", gains=None),
        lawful("a softmin without sharpness", law="softmin"),
        lawful("a sharpness of 0", law="softmin", sharpness=0),
        lawful("a sharpness below 0", law="softmin", sharpness=-4),
        lawful("a sharpness that is a text", law="softmin", sharpness="4"),
        lawful("a sharpness that is a list", law="softmin", sharpness=[4]),
        lawful("a sharpness of true", law="softmin", sharpness=True),
        lawful("a sharpness that is null", law="softmin", sharpness=None),
        lawful("gains of a product", gains=[1, 1]),
        lawful("gains of min", law="min", gains=[1, 1]),
        lawful("a sharpness of hinge", law="hinge", gains=[1, 1], sharpness=4),
        lawful("a sharpness of min that is null", law="min", sharpness=None),
        lawful("a law without drivers", law="min", drivers=[]),
        *(
            paired(f"a pair bend in version {version}", version, PAIR | law)
            for version, law in ((1, {}), (2, {"law": "min"}))
        ),
        paired("a pair bend with a slider", 3),
        paired("a pair bend that is its own driver", 3, PAIR | {"drivers": ["a", "pair"]}),
        paired("a pair bend whose target is null", 3, PAIR | {"law": "min"}, target=None),
    ]


def main(folder: Path) -> None:
    """Write all files into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in {**all_vectors(), "refused": refused()}.items():
        # Some names as they are, some as escapes.
        text = json.dumps(content, ensure_ascii=False).replace("😀", "\\ud83d\\ude00")
        for key in ('"neutral":', '"targets":', '"poses":', '{"sliders":', '{"why":', '{"name":'):
            text = text.replace(f" {key}", f"\n{key}")
        (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
