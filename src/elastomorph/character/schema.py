"""Every table and key that a settings file may have, and what each holds.

The one list that reading, refusing, documentation and tests share. A table whose name ends in ``*``
stands for any number of tables, each with a name of the user's: ``[regions.mouth]``.
"""

from __future__ import annotations

from typing import NamedTuple

from elastomorph.paths import Method

__all__ = ["FREE", "Key", "tables"]


class Key(NamedTuple):
    """One key of a settings file.

    Attributes:
        kind: What its value must be: ``text``, ``number``, ``whole``, ``flag``, ``numbers`` or
            ``table``; ``file``, the name of one that exists; ``texts``, one text or a list of
            them; ``vertices``, a file, ranges, or a list of indices.
        example: A value as TOML.
    """

    kind: str
    example: str


_METHOD = Key("text", '"beam:3"')
_NUMBER = Key("number", "2.0")


def tables() -> dict[str, dict[str, Key]]:
    """The keys of each table; those of methods are the options that methods have."""
    every = Method.every_option()
    options = {name: Key(its.kind, its.example) for name, its in every.items()}
    return {
        "character": {
            "name": Key("text", '"Ada"'),
            "unit": Key("text", '"mm"'),
            "rig": Key("file", '"head.glb"'),
            "mesh": Key("texts", '"Head"'),
            "neutral": Key("file", '"neutral.obj"'),
            "targets": Key("texts", '"shapes/*.obj"'),
            "curves": Key("file", '"curves.json"'),
        },
        "method": {"default": _METHOD, **options},
        "methods.*": {"method": _METHOD, **options},
        "regions.*": {
            "vertices": Key("vertices", '"mouth.json"'),
            "falloff": Key("number", "5"),
            "method": _METHOD,
            **options,
        },
        "material": dict.fromkeys(every["material"].parts, _NUMBER),
        "inbetweens.*": {"method": Key("text", '"spline"')},
        "timing": {"default": Key("text", '"minimum-jerk"')},
        "export.glb": {
            "normals": Key("text", '"none"'),
            "tolerance": Key("number", "1e-4"),
            "keys_tolerance": Key("number", "1e-3"),
            "fps": Key("number", "60"),
            "sparse": Key("flag", "false"),
        },
        "export.usd": {
            "tolerance": Key("number", "1e-4"),
            "most_inbetweens": Key("whole", "5"),
            "fps": Key("number", "24"),
        },
    }


FREE: dict[str, str] = {
    "methods": "a target, or a pattern such as eyeBlink_*, and its method",
    "inbetweens.*": 'a time between 0 and 1 and a file: "0.3" = "jawOpen_30.obj"',
    "groups": "a group and the names or patterns of its sliders",
    "correctives": "a corrective and the sliders whose weights drive it",
}
"""Tables whose keys are names of the user's own, and what each line of them says."""
