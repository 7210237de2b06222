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
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method
from elastomorph.paths.method import SETTINGS
from elastomorph.physics import CLOSURES
from elastomorph.physics.equation import HIGHEST_ORDER
from elastomorph.report.about import About, percent
from elastomorph.report.error_table import scrolling
from elastomorph.report.markup import Markup, element, joined

__all__ = ["fact_list", "frames_digest", "method_words", "methods_table", "recipe"]

_PACKAGES = ("elastomorph", "numpy", "scipy", "matplotlib", "vtk", "pillow")
_NAMES = {"numpy": "NumPy", "scipy": "SciPy", "vtk": "VTK", "pillow": "Pillow"}
_POWERS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_WORDS = {
    "linear": "straight line at an even pace (Eq. 34)",
    "cosine": "straight line, slow start and slow stop, (1 − cos πt)/2",
    "ease": "straight line at the pace p(t)/p(1): the timing of the beam without its physics",
    "beam": "each curve an elastic beam between the two shapes (Eqs. 31–33)",
    "plate": "the whole surface an elastic plate between the two shapes",
    "arc": "circular arcs of the local rotation",
    "rotation": "least distortion of the surface: parts that turn are turned",
    "auto": "the straight line where rotation hardly differs from it, else rotation",
}


def recipe(
    truth: MeshSequence, about: About, methods: Markup, now: datetime | None = None
) -> Markup:
    """The last section of a report.

    Args:
        truth: What was compared.
        about: Where it came from.
        methods: The settings, from `methods_table`.
        now: The time of the report; the present by default.
    """
    when = (now or datetime.now(UTC)).astimezone(UTC)
    versions = [f"Python {platform.python_version()}"]
    for package in _PACKAGES:
        try:
            versions.append(f"{_NAMES.get(package, package)} {version(package)}")
        except PackageNotFoundError:
            continue
    facts: list[tuple[str, object]] = []
    if about.call:
        facts.append(("Made by", element("code", about.call)))
    facts += [
        ("Versions", ", ".join(versions)),
        ("Platform", f"{platform.system()} {platform.machine()}"),
        ("Date", element("time", f"{when:%Y-%m-%d %H:%M} UTC", datetime=f"{when:%Y-%m-%dT%H:%MZ}")),
        ("Curves", about.curves),
        (
            "SHA-256",
            joined(
                [
                    element("code", frames_digest(truth), class_="digest"),
                    " of the positions of all frames as they were read, little-endian 64-bit "
                    "numbers, frame by frame and vertex by vertex",
                ]
            ),
        ),
    ]
    return joined([fact_list(facts), methods])


def fact_list(facts: Sequence[tuple[str, object]]) -> Markup:
    """Names and what they stand for."""
    return element(
        "dl",
        *(
            element("div", element("dt", name), element("dd", value), class_="fact")
            for name, value in facts
        ),
        class_="facts",
    )


def frames_digest(truth: MeshSequence) -> str:
    """SHA-256 of ``truth.frames`` as (T, V, 3) little-endian float64."""
    frames = np.ascontiguousarray(truth.frames, dtype="<f8")
    return hashlib.sha256(frames.tobytes()).hexdigest()


def methods_table(
    evaluation: Evaluation, about: About, heading: str, *, several: bool = False
) -> Markup:
    """Every method with all its settings and what its path takes to store.

    Args:
        evaluation: The methods compared.
        about: Their settings.
        heading: Caption of the table.
        several: Whether this is one of several motions, each with paths of its own.
    """
    titles = ("Method", "Path", "Settings", *(() if several else ("Bends", "Stored within")))
    rows = []
    for result in evaluation.results:
        method = about.methods.get(result.label) or _named(result.morph)
        words, settings = method_words(method)
        if several and isinstance(method, Morph):
            settings = "at the best frames of each"
        cells = [element("td", words), element("td", settings or "none")]
        if not several:
            cells.append(element("td", str(len(result.morph.bends)), class_="number"))
            cells.append(element("td", _stored(result), class_="number"))
        name = element("th", result.label, scope="row", class_="name")
        rows.append(element("tr", name, *cells))
    table = element(
        "table",
        element("caption", heading),
        element("thead", element("tr", *(element("th", t, scope="col") for t in titles))),
        element("tbody", *rows),
        class_="settings",
    )
    return scrolling(table, heading)


def _stored(result: MethodResult) -> str:
    return percent(result.morph.bake_error) if result.morph.bake_error else "exact"


def _named(morph: Morph) -> Method | Morph:
    """The method whose label a path carries: a label leaves no setting unsaid but the tolerance."""
    if morph.choice is not None:
        return Method("auto", straight_within=morph.choice.allowed)
    for name, has in SETTINGS.items():
        for order in range(1, HIGHEST_ORDER + 1):
            for closure in CLOSURES:
                stated: dict[str, Any] = {"order": order, "closure": closure}
                method = Method(name, **{key: stated[key] for key in stated if key in has})
                if method.label == morph.method:
                    return method
    return morph


def method_words(method: Method | Morph) -> tuple[str, str]:
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
    if method.name in ("ease", "beam", "plate"):
        settings.append(f"p(t) = {_polynomial(method.external_load.coefficients)}")
    if method.name in ("beam", "plate"):
        material = method.material
        settings += [
            f"m = {material.mass:g}",
            f"c = {material.damping:g}",
            f"k = {material.rigidity:g}",
            f"closure {method.closure}",
            "all modes" if method.harmonics is None else f"{method.harmonics} modes",
        ]
    if method.name == "beam":
        settings += [f"basis {method.basis} on open curves", f"stiffness {method.stiffness}"]
    if method.name in ("arc", "rotation", "auto"):
        settings.append(f"tolerance {percent(method.tolerance)}")
    if method.name == "auto":
        settings.append(f"straight within {percent(method.straight_within)}")
    return _WORDS[method.name], ", ".join(settings)


def _polynomial(coefficients: Sequence[float]) -> str:
    terms = []
    for exponent, p in enumerate(coefficients, start=1):
        if p:
            power = "" if exponent == 1 else str(exponent).translate(_POWERS)
            terms.append(f"{'' if p == 1 else f'{p:g}'}t{power}")
    return " + ".join(terms)
