"""What it takes to make a report again: settings, versions, and what was compared."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.evaluation.words import percent
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method
from elastomorph.paths.options import options_of
from elastomorph.physics import CLOSURES
from elastomorph.physics.equation import HIGHEST_ORDER
from elastomorph.report.document import Section
from elastomorph.report.facts import About

_PACKAGES = {
    "elastomorph": "elastomorph",
    "numpy": "NumPy",
    "scipy": "SciPy",
    "matplotlib": "matplotlib",
    "vtk": "VTK",
    "pillow": "Pillow",
}
_POWERS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_SAID = (
    *("order", "load", "material", "closure", "harmonics", "basis", "stiffness"),
    *("tolerance", "straight_within"),
)
"""Options that have words of their own."""


def recipe(
    truth: MeshSequence, evaluation: Evaluation, about: About, *, several: bool = False
) -> Section:
    """The last section of a report."""
    software = ", ".join([f"Python {platform.python_version()}", *_versions()])
    content = {
        "call": about.call,
        "software": [
            ("Versions", software),
            ("Platform", f"{platform.system()} {platform.machine()}"),
        ],
        "now": datetime.now(UTC),
        "curves": about.curves,
        "digest": _frames_digest(truth),
        "stored": not several,
        "methods": [_described(result, about, several) for result in evaluation.results],
    }
    return Section("recipe", "To reproduce it", content, appendix=True)


def _versions() -> list[str]:
    found = []
    for package, name in _PACKAGES.items():
        try:
            found.append(f"{name} {version(package)}")
        except PackageNotFoundError:
            continue
    return found


def _frames_digest(truth: MeshSequence) -> str:
    """SHA-256 of ``truth.frames`` as (T, V, 3) little-endian float64."""
    frames = np.ascontiguousarray(truth.frames, dtype="<f8")
    return hashlib.sha256(frames.tobytes()).hexdigest()


def _described(result: MethodResult, about: About, several: bool) -> dict[str, object]:
    """A method with all its settings and what its path takes to store."""
    morph = result.morph
    method = about.methods.get(result.label) or _named(morph)
    path, settings = _method_words(method)
    if several and isinstance(method, Morph):
        settings = "at the best frames of each"
    return {
        "label": result.label,
        "path": path,
        "settings": settings,
        "bends": len(morph.bends),
        "stored": percent(morph.bake_error) if morph.bake_error else "exact",
    }


def _named(morph: Morph) -> Method | Morph:
    """The method whose label a path carries: a label leaves no setting unsaid but the tolerance."""
    if morph.choice is not None:
        return Method("auto", straight_within=morph.choice.allowed)
    for kind in Method.known:
        for order in range(1, HIGHEST_ORDER + 1):
            for closure in CLOSURES:
                stated: dict[str, Any] = {"order": order, "closure": closure}
                method = kind(**{key: stated[key] for key in stated if kind.has(key)})
                if method.label == morph.method:
                    return method
    return morph


def _method_words(method: Method | Morph) -> tuple[str, str]:
    """What a method does, and all its settings."""
    if isinstance(method, Morph):
        inner = [
            f"{time:.4g}"
            for time in sorted({float(b) for curve in method.bend_curves for b in curve.breaks})
            if 0 < time < 1
        ]
        if method.method.startswith("through") and inner:
            return "through frames of this recording", f"at t = {', '.join(inner)}"
        return f"a finished path, made by {method.method}", ""
    settings = []
    if method.has("load"):
        settings.append(f"p(t) = {_polynomial(method.external_load.coefficients)}")
    if method.has("material"):
        material = method.material
        settings += [
            f"m = {material.mass:g}",
            f"c = {material.damping:g}",
            f"k = {material.rigidity:g}",
            f"closure {method.closure}",
            "all modes" if method.harmonics is None else f"{method.harmonics} modes",
        ]
    if method.has("basis"):
        settings += [f"basis {method.basis} on open curves", f"stiffness {method.stiffness}"]
    if method.has("tolerance"):
        settings.append(f"tolerance {percent(method.tolerance)}")
    if method.has("straight_within"):
        settings.append(f"straight within {percent(method.straight_within)}")
    others = (name for name in options_of(method) if name not in _SAID)
    settings += [f"{name.replace('_', ' ')} {getattr(method, name)}" for name in others]
    return method.path, ", ".join(settings)


def _polynomial(coefficients: Sequence[float]) -> str:
    terms = []
    for exponent, p in enumerate(coefficients, start=1):
        if p:
            power = "" if exponent == 1 else str(exponent).translate(_POWERS)
            terms.append(f"{'' if p == 1 else f'{p:g}'}t{power}")
    return " + ".join(terms)
