"""The weights that a runtime sets, from the description of a bent mesh and its sliders alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


def curve_value(curve: Mapping[str, Any], t: float) -> float:
    """Σ_n c_n (t - break)^n within [0, 1]; beyond, straight on along the tangent of the end."""
    breaks, pieces = curve["breaks"], curve["coefficients"]
    inside = min(max(t, 0.0), 1.0)
    k = max(i for i in range(len(pieces)) if breaks[i] <= inside or i == 0)
    s = inside - breaks[k]
    value = sum(c * s**n for n, c in enumerate(pieces[k]))
    if inside == t:
        return float(value)
    slope = sum(n * c * s ** (n - 1) for n, c in enumerate(pieces[k]) if n)
    return float(value + (t - inside) * slope)


def bent_weights(
    stored: Mapping[str, Any] | None, names: Sequence[str], sliders: Mapping[str, float]
) -> NDArray[np.float64]:
    """The weight of every target of a mesh.

    Args:
        stored: ``extras.elastomorph`` of the mesh, None if it has none.
        names: Its targets in order.
        sliders: Weights by name, 0 where there is none.
    """
    found = [float(sliders.get(name, 0.0)) for name in names]
    if stored is None:
        return np.array(found)
    drivers = {own["name"]: own["drivers"] for own in stored.get("correctives", [])}
    for morph in stored["morphs"]:
        of = drivers.get(morph["name"], [morph["name"]])
        t = float(np.prod([sliders.get(name, 0.0) for name in of]))
        fold = morph.get("fold") if stored["version"] > 1 else None
        found[place(morph, names)] = t + (curve_value(fold, t) if fold else 0.0)
        for bend in morph.get("bends", []):
            found[place(bend, names)] = curve_value(bend["curve"], t)
    return np.array(found)


def place(entry: Mapping[str, Any], names: Sequence[str]) -> int:
    """The number of the target of a morph or a bend."""
    places = [i for i, name in enumerate(names) if name == entry["target"]]
    index = entry.get("index")
    return index if index in places else places[0]
