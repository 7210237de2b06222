"""Correctives as Simplex, of Blur Studio, has them: its definition of a face, as JSON.

Shapes, progressions (shapes along one number), sliders and combos refer to each other by their
places in lists; versions 2 and 3 are alike in all that is read here::

    {"encodingVersion": 3,
     "shapes": [{"name": "Rest"}, {"name": "jawOpen"}, {"name": "pucker"}, {"name": "both"}],
     "progressions": [{"pairs": [[0, 0.0], [1, 1.0]]}, {"pairs": [[0, 0.0], [2, 1.0]]},
                      {"pairs": [[0, 0.0], [3, 1.0]]}],
     "sliders": [{"name": "jawOpen", "prog": 0}, {"name": "pucker", "prog": 1}],
     "combos": [{"name": "both", "prog": 2, "pairs": [[0, 1.0], [1, 1.0]], "solveType": "min"}]}
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from elastomorph.errors import FormatError, ParameterError, warn
from elastomorph.io.atomic import read_bytes
from elastomorph.numbers import first_few
from elastomorph.rig.laws import LAWS, Corrective

_READ = (2, 3)  # versions


def read_correctives(path: str | Path, names: Collection[str]) -> dict[str, Corrective]:
    """What drives the combination shapes of a rig that was made with Simplex.

    A combo for the ends of its sliders becomes a corrective of its law, ``min`` where it states
    none. The negative end of a slider is a target of its own. A combo that is switched off, is for
    sliders between their ends, or names a shape that the rig has not, is left out with a warning.

    The overrides of VRM 1.0 are no correctives: they weigh expressions, which move several targets
    each, and players apply them before they set targets. `elastomorph inspect` tells them.

    Args:
        path: The definition, a JSON file, as Simplex exports it beside its .smpx.
        names: Targets of the rig, named as the shapes of Simplex.

    Returns:
        Correctives by the names of their targets, for `elastomorph.Rig`.

    Raises:
        FileError: The file cannot be read.
        FormatError: It is no definition of version 2 or 3, or a VRM.
    """
    found: dict[str, Corrective] = {}
    left_out: list[str] = []
    text = read_bytes(path)
    if Path(path).suffix.lower() == ".vrm":
        raise FormatError(
            path,
            "players apply the overrides of its expressions before they set targets, which needs "
            "no correctives; leave it out ('elastomorph inspect' tells them)",
        )
    try:
        content = json.loads(text)
        if content["encodingVersion"] not in _READ:
            raise FormatError(
                path,
                f"expected version 2 or 3, found {content['encodingVersion']!r}; update Simplex",
            )
        ends = _ends(content)
        sliders = [ends[slider["prog"]] for slider in content["sliders"]]
        for combo in content["combos"]:
            shape = ends[combo["prog"]].get(1.0)
            drivers = [sliders[number].get(value) for number, value in combo["pairs"]]
            if not combo.get("enabled", True):
                left_out.append(f"{combo['name']} (switched off)")
            elif any(abs(value) != 1 for _, value in combo["pairs"]):
                left_out.append(f"{combo['name']} (between the ends of sliders)")
            elif shape not in names or not set(drivers).issubset(names):
                missing = next(own for own in (shape, *drivers) if own not in names)
                left_out.append(f"{combo['name']} (no target {missing!r})")
            else:
                law = combo.get("solveType")
                found[shape] = Corrective(tuple(drivers), law if law in LAWS else "min")
    except (LookupError, TypeError, AttributeError, ValueError, RecursionError) as error:
        problem = error if isinstance(error, ParameterError) else "expected a definition by Simplex"
        raise FormatError(path, f"{problem}; export it again") from error
    if left_out:
        warn(f"{path}: combos that are left out: {first_few(left_out, 8)}")
    return found


def _ends(content: Mapping[str, Any]) -> list[dict[float, str]]:
    """For each progression the names of its shapes by their values."""
    shapes = [shape["name"] for shape in content["shapes"]]
    return [
        {value: shapes[number] for number, value in own["pairs"]} for own in content["progressions"]
    ]
