"""The weights that a runtime sets, from the description of a bent mesh and its sliders alone."""

from __future__ import annotations

import math
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


def driven_weight(
    corrective: Mapping[str, Any], version: float, sliders: Mapping[str, float]
) -> float:
    """The weight of a corrective from those of its drivers, by its law."""
    w = [float(sliders.get(name, 0.0)) for name in corrective["drivers"]]
    law = corrective.get("law", "product") if version > 2 else "product"
    if law == "product":
        return math.prod(w)
    if law == "hinge":
        gains = corrective["gains"]
        return max(0.0, math.fsum(k * x for k, x in zip(gains, w, strict=True)) - 1.0)
    if min(w) <= 0:
        return 0.0
    if law == "min":
        return min(w)
    if law == "softmin":
        p = corrective["sharpness"]
        powers = [-p * math.log(x) for x in w]
        most = max(powers)
        mean = math.fsum(math.exp(power - most) for power in powers) / len(w)
        return math.exp(-(most + math.log(mean)) / p)
    c = [min(x, 1.0) for x in w]
    return {
        "allMul": math.prod(c),
        "extMul": min(c) * max(c),
        "mulAvgExt": 2.0 / (1.0 / min(c) + 1.0 / max(c)),
        "mulAvgAll": math.prod(c) / (math.fsum(c) / len(c)),
    }[law]


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
    correctives = {own["name"]: own for own in stored.get("correctives", [])}
    for morph in stored["morphs"]:
        of = correctives.get(morph["name"], {"drivers": [morph["name"]]})
        t = driven_weight(of, stored["version"], sliders)
        fold = morph.get("fold") if stored["version"] > 1 else None
        if "target" in morph:  # a pair bend has none
            found[place(morph, names)] = t + (curve_value(fold, t) if fold else 0.0)
        for bend in morph.get("bends", []):
            found[place(bend, names)] = curve_value(bend["curve"], t)
    return np.array(found)


def place(entry: Mapping[str, Any], names: Sequence[str]) -> int:
    """The number of the target of a morph or a bend."""
    places = [i for i, name in enumerate(names) if name == entry["target"]]
    index = entry.get("index")
    return index if index in places else places[0]
