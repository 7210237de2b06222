"""Limits of sliders."""

from __future__ import annotations

from collections.abc import Mapping

from elastomorph.farm.columns import Column, Columns
from elastomorph.farm.controls import KeyedError, places_of
from elastomorph.rig.sliders import Sliders


def slider_columns(sliders: Sliders, limits: Mapping[str, tuple[float, float]]) -> Columns:
    """A column for each slider, within its limits.

    What a slider's own name says goes before what its group or a pattern says.

    Raises:
        KeyedError: The rig has none of that name, or two groups or patterns differ.
    """
    names = sliders.names
    spans: dict[int, tuple[float, float]] = {}
    by: dict[int, str] = {}
    for name in sorted(limits, key=names.__contains__):
        where, span = ("limits", name), limits[name]
        for place in places_of(sliders, [name], where):
            if name not in names and spans.setdefault(place, span) != span:
                raise KeyedError(
                    where,
                    f"{by[place]!r} and {name!r} give {names[place]!r} different limits; give it "
                    "limits of its own",
                )
            spans[place], by[place] = span, name
    return Columns(
        tuple(Column.within(name, *spans.get(i, (0.0, 1.0))) for i, name in enumerate(names))
    )
