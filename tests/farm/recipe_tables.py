"""The keys of recipes as rows of Markdown, as they stand in the documentation."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from elastomorph.farm.pictures.settings import SETTINGS
from elastomorph.farm.sampling.controls import Exclusion
from elastomorph.farm.sampling.keys import keys_of
from elastomorph.farm.sampling.mixtures import Mixture
from elastomorph.farm.sampling.recipe import KINDS, Identity, Pictures, Timing

HEADER = "| key | what it says | such as | default | must be |\n|---|---|---|---|---|"
SCENE_HEADER = "| key | what it says | default | must be from |\n|---|---|---|---|"


def rows(described: Any, *, without: Any = None) -> list[str]:
    """A row for each key of a class, but for those of another."""
    defaults = {own.name: own.default for own in fields(described)}
    left_out = keys_of(without) if without is not None else {}
    return [
        f"| `{name}` | {key.means} | `{key.example}` | {_shown(defaults[name], key.needed)} | "
        f"{', '.join(key.choices) if key.choices else key.bounds or '–'} |"
        for name, key in keys_of(described).items()
        if name not in left_out
    ]


def tables() -> dict[str, str]:
    """What is documented, and its table."""
    found = {"every kind": [HEADER, *rows(Mixture)]}
    found |= {name: [HEADER, *rows(kind, without=Mixture)] for name, kind in KINDS.items()}
    found |= {
        "exclude": [HEADER, *rows(Exclusion)],
        "timing": [HEADER, *rows(Timing)],
        "identity": [HEADER, *rows(Identity)],
        "pictures": [HEADER, *rows(Pictures)],
        "scene": [
            SCENE_HEADER,
            *(
                f"| `{name}` | {its.meaning} | `[{its.low:g}, {its.high:g}]` | "
                f"{its.least:g} to {its.most:g} |"
                for name, its in SETTINGS.items()
            ),
        ],
    }
    return {name: "\n".join(own) for name, own in found.items() if len(own) > 1}


def _shown(default: Any, needed: bool) -> str:
    if needed:
        return "needed"
    if default in (None, ()):
        return "–"
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, float):
        return f"{default:g}"
    if isinstance(default, tuple):
        numbers = all(isinstance(each, float) for each in default)
        return f"`[{', '.join(f'{each:g}' for each in default)}]`" if numbers else "all"
    return str(default)


if __name__ == "__main__":
    for name, table in tables().items():
        print(f"{name}\n{table}\n")
