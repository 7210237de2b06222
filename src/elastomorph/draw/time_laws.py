"""Graphs of the time laws φ_n(t) that a material and a load give the modes of a curve."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.figure import LineStyle, new_figure
from elastomorph.physics import CLOSURES, Load, Material, mean_response, modal_response

MODES = (1, 2, 3, 4, 6, 8)
_CLOSURE_STYLES = {
    "unforced": LineStyle("#c44e00", (6.0, 2.0, 1.2, 2.0), 1.8, 2),
    "rest": LineStyle("#6a3d9a", (1.2, 1.4), 1.8, 2),
    "linear": LineStyle("#555555", (8.0, 2.0), 1.8, 2),
    "compatible": LineStyle("#009e73", (), 1.8, 2),
    "limit": LineStyle("#0060a8", (3.0, 2.5), 1.8, 2),
}
_VISIBLE = 1e-14
"""Differences below this are the rounding of the computation."""


def time_law_graph(
    path: str | Path,
    material: Material | None = None,
    *,
    load: Load | int = 2,
    modes: tuple[int, ...] = MODES,
    title: str = "",
) -> None:
    """The law of the mean under each closure (a), and how far each mode is from the limit law (b).

    The modes n of (b) are those of a closed curve with uniform parameter, B_n = 16π⁴kn⁴ (Eq. 19).
    The load is p(t), or R of t^R; the title names it and the material by default.
    """
    material = material or Material()
    load = Load.power(load) if isinstance(load, int) else load
    t = np.linspace(0.0, 1.0, 401)
    limit = _values(load.limit_law, t)
    m = material
    words = f"p(t) = {_polynomial(load)}, m = {m.mass:g}, c = {m.damping:g}, k = {m.rigidity:g}"
    with new_figure(path, 11.0, 4.8, title or words) as figure:
        means, gaps = figure.subplots(1, 2)
        means.plot(t, limit, color="#b9dcf3", linewidth=6, label="limit law p(t)/p(1)")
        for closure in CLOSURES:
            style = _CLOSURE_STYLES[closure]
            law = mean_response(closure, load, material)
            if np.isfinite(law).all():
                means.plot(t, _values(law, t), **style.of(f"φ₀ {closure}"))
            else:
                means.plot([], [], color=style.colour, label=f"φ₀ {closure} (singular)")
        means.set_title("(a) the mean of a curve, by closure")
        means.set_xlabel("t")
        means.set_ylabel("φ₀(t)")
        means.set_xlim(0, 1)
        means.legend(loc="best")
        _draw_gaps(gaps, t, load, material, modes)


def mode_law_graph(
    path: str | Path,
    materials: Sequence[Material],
    *,
    loads: Sequence[Load | int] = (1, 2, 3),
    modes: Sequence[int] = (1, 2, 3),
) -> None:
    """The laws φ_n themselves: a row for each load, a column for each material.

    Args:
        path: The picture (.png, .svg, .pdf).
        materials: m, c and k of each column.
        loads: p(t) of each row, or R of t^R.
        modes: n of a closed curve with uniform parameter, B_n = 16π⁴kn⁴ (Eq. 19).

    Raises:
        ParameterError: Another suffix.
    """
    t = np.linspace(0.0, 1.0, 201)
    rows = [Load.power(load) if isinstance(load, int) else load for load in loads]
    with new_figure(path, 2.3 * len(materials) + 0.4, 1.9 * len(rows) + 0.7) as figure:
        grid = figure.subplots(len(rows), len(materials), sharex=True, sharey="row", squeeze=False)
        for axes_of_row, load in zip(grid, rows, strict=True):
            for axes, material in zip(axes_of_row, materials, strict=True):
                _draw_laws(axes, t, load, material, modes)
            axes_of_row[0].set_ylabel(f"φₙ(t), p(t) = {_polynomial(load)}")
        for axes, m in zip(grid[0], materials, strict=True):
            axes.set_title(f"m = {m.mass:g}, c = {m.damping:g}, k = {m.rigidity:g}")
        for axes in grid[-1]:
            axes.set_xlabel("t")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(handles))


def _draw_laws(
    axes: Any, t: NDArray[np.float64], load: Load, material: Material, modes: Sequence[int]
) -> None:
    limit = _values(load.limit_law, t)
    axes.plot(t, limit, color="#b9dcf3", linewidth=6, label="n → ∞: p(t)/p(1)")
    laws = modal_response(_stiffness(modes, material), load, material)
    for mode, law, shade in zip(modes, laws, np.linspace(0.0, 0.7, len(modes)), strict=True):
        if np.isfinite(law).all():
            axes.plot(t, _values(law, t), color=_blue(shade), label=f"n = {mode}")
        else:
            axes.plot([], [], color="#888888", label=f"n = {mode} (singular)")
    axes.set_xlim(0, 1)


def _stiffness(modes: Sequence[int], material: Material) -> NDArray[np.float64]:
    """B_n of a closed curve (Eq. 19)."""
    return 16 * np.pi**4 * material.rigidity * np.array(modes, dtype=np.float64) ** 4


def _blue(shade: float) -> tuple[float, float, float]:
    return (shade, 0.2 + 0.7 * shade, 0.45 + 0.5 * shade)


def _draw_gaps(
    axes: Any, t: NDArray[np.float64], load: Load, material: Material, modes: tuple[int, ...]
) -> None:
    laws = modal_response(_stiffness(modes, material), load, material) - load.limit_law
    shades = np.linspace(0.0, 0.75, len(modes))
    drawn = False
    for mode, law, shade in zip(modes, laws, shades, strict=True):
        gap = np.abs(_values(law, t))
        if not np.isfinite(gap).all():
            axes.plot([], [], color="#888888", label=f"n = {mode} (singular)")
        elif gap.max() > _VISIBLE:
            drawn = True
            gap[gap <= _VISIBLE] = np.nan
            axes.plot(t, gap, color=_blue(shade), linewidth=1.8, label=f"n = {mode}")
    axes.set_title("(b) closed curve: modes n off the limit law")
    axes.set_xlabel("t")
    axes.set_xlim(0, 1)
    axes.set_ylabel("|φₙ(t) - p(t)/p(1)|")
    if drawn:
        axes.set_yscale("log")
        axes.legend(loc="best", ncols=2)
    else:
        axes.set_yticks([])
        words = "every mode follows\nthe limit law exactly"
        axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center")


def _values(law: NDArray[np.float64], t: NDArray[np.float64]) -> NDArray[np.float64]:
    """The polynomial with these coefficients of t, t², and so on."""
    return np.asarray(np.polynomial.polynomial.polyval(t, np.concatenate([[0.0], law])))


def _polynomial(load: Load) -> str:
    powers = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
    terms = []
    for exponent, p in enumerate(load.coefficients, start=1):
        if p:
            factor = "" if p == 1 else f"{p:g}"
            terms.append(factor + "t" + ("" if exponent == 1 else str(exponent).translate(powers)))
    return " + ".join(terms)
