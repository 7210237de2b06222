"""Every table and key that a settings file may have, what each holds and what it is for.

The one list that reading, refusing, documentation and tests share. A table whose name ends in ``*``
stands for any number of tables, each with a name of the user's: ``[regions.mouth]``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["FREE", "TABLES", "Key", "Kind"]

Kind = Literal["text", "number", "whole", "flag", "file", "numbers", "texts", "vertices", "table"]


@dataclass(frozen=True)
class Key:
    """One key of a settings file.

    Attributes:
        kind: What its value must be. A ``file`` is the name of one that exists; ``texts`` is one
            text or a list of them; ``vertices`` a file, ranges, or a list of indices.
        means: What it is for, in a few words.
        example: A value as TOML.
    """

    kind: Kind
    means: str
    example: str


_METHOD: dict[str, Key] = {
    "closure": Key("text", "time law of the mean of a curve", '"compatible"'),
    "load": Key("numbers", "p₁, p₂, … of a polynomial load, in place of an order", "[0.2, 0.8]"),
    "basis": Key("text", "modes of open curves: cosine or fourier", '"fourier"'),
    "stiffness": Key("text", "uniform, or length: short curves are stiffer", '"length"'),
    "harmonics": Key("whole", "modes above this number follow the limit law", "8"),
    "tolerance": Key("number", "how closely bends of arc and rotation hold, of D", "1e-5"),
    "straight_within": Key("number", "how close to straight a turn goes straight, of D", "1e-3"),
    "material": Key("table", "mass, damping, rigidity of beam and plate", "{ damping = 2.0 }"),
}
_NAMED = {"method": Key("text", "auto, linear, rotation, beam:R[:closure], …", '"beam:3"')}

TABLES: dict[str, dict[str, Key]] = {
    "character": {
        "name": Key("text", "what the character is called", '"Ada"'),
        "unit": Key("text", "unit of the files: mm, cm, m or in", '"mm"'),
        "rig": Key("file", "a rig file, in place of neutral and targets", '"head.glb"'),
        "mesh": Key("texts", "the meshes of the rig file that are meant", '"Head"'),
        "neutral": Key("file", "the face at rest", '"neutral.obj"'),
        "targets": Key("texts", "files of the targets; * and ? stand for others", '"shapes/*.obj"'),
        "curves": Key("file", "artists' curves that beams follow", '"curves.json"'),
    },
    "method": {
        "default": Key("text", "method of every target no other line names", '"beam:3"'),
        **_METHOD,
    },
    "methods.*": {**_NAMED, **_METHOD},
    "regions.*": {
        "vertices": Key("vertices", "the vertices: a file, ranges or a list", '"mouth.json"'),
        "falloff": Key("number", "rings of edges over which it blends into the rest", "5"),
        **_NAMED,
        **_METHOD,
    },
    "material": {
        "mass": Key("number", "m, above 0", "2.0"),
        "damping": Key("number", "c, above 0", "2.0"),
        "rigidity": Key("number", "k = EI, above 0", "0.01"),
    },
    "inbetweens.*": {
        "method": Key("text", "smooth, spline, or piecewise from shape to shape", '"spline"'),
    },
    "timing": {
        "default": Key("text", "how t runs over an exported clip", '"minimum-jerk"'),
    },
    "export.glb": {
        "normals": Key("text", "delta: targets turn the normals; none", '"none"'),
        "tolerance": Key("number", "bends that move less, of D, are left out", "1e-4"),
        "keys_tolerance": Key("number", "distance of animations from the path, of D", "1e-3"),
        "fps": Key("number", "frames a second of the animations", "60"),
        "sparse": Key("flag", "store only the vertices that move", "false"),
    },
    "export.usd": {
        "tolerance": Key("number", "distance from the path that needs no in-between, of D", "1e-4"),
        "most_inbetweens": Key("whole", "largest number of in-betweens of a shape", "5"),
        "fps": Key("number", "time codes a second", "24"),
    },
}
"""The keys of each table."""

FREE: dict[str, str] = {
    "methods": "a target, or a pattern such as eyeBlink_*, and its method",
    "inbetweens.*": 'a time between 0 and 1 and a file: "0.3" = "jawOpen_30.obj"',
    "groups": "a group and the names or patterns of its sliders",
    "correctives": "a corrective and the sliders whose weights drive it",
}
"""Tables whose keys are names of the user's own, and what each line of them says."""
