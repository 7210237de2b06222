"""A fit as text, with its tables and conclusions, and as plain values."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from elastomorph.evaluation.summary import same
from elastomorph.fitting.modal_sums import EXCURSION
from elastomorph.physics import Load

if TYPE_CHECKING:
    from rich.table import Table

    from elastomorph.fitting.results import CurveFit, Fit, Ratio

# An interval wider than this factor is called wide.
_WIDE = 10.0
# A fit this close to the border of the range allowed may only be the best inside it.
_AT_BORDER = 0.95
# p(1) is 1: a term this small is not written out.
_NEGLIGIBLE = 1e-6
_UNKNOWN = (
    "Leave-one-out needs two motions or more: whether this fit holds for another repetition is "
    "unknown."
)


def fit_text(fit: Fit, width: int) -> str:
    """Constants, table and sentences, for a page of this width."""
    from elastomorph.evaluation.table import plain_text

    lines = [
        f"{_several(fit.motions, 'motion')}, {_several(fit.frames, 'frame')} between their ends, "
        f"{_several(fit.curves, 'curve')} with {fit.vertices} vertices, D = {fit.diameter:.4g}",
        f"load  p(t) = {_polynomial(fit.load.coefficients)}  ({_degree(fit)})",
    ]
    if fit.degree > 1:
        lines += [
            f"      p{r}: {low:.4g} to {high:.4g}"
            for r, (low, high) in enumerate(fit.load_intervals, start=1)
        ]
    lines += [
        f"c/k   {ratio_words(fit.damping)}",
        f"m/k   {ratio_words(fit.mass)}",
        f"method  {fit.method.label}",
        "Intervals: 95 % if residuals are independent and first and last frames exact; of the load "
        "from the Jacobian at the optimum, of c/k and m/k from the profile of the squared "
        "distance.",
        "",
        plain_text(_error_table(fit), width).strip("\n"),
    ]
    if len(fit.degree_errors) > 1:
        where = "left out" if fit.left_out else "fitted"
        by = ", ".join(f"{r}: {100 * e:.3f}" for r, e in sorted(fit.degree_errors.items()))
        lines.append(f"RMS of the motions {where} by degree of the load, % of D: {by}.")
    lines += conclusions(fit)
    if fit.per_curve:
        lines += ["", plain_text(_curve_table(fit.per_curve), width).strip("\n")]
    return "\n".join(
        line if len(line) <= width or "\n" in line else textwrap.fill(line, width) for line in lines
    )


def conclusions(fit: Fit) -> list[str]:
    """What the errors show, in sentences computed from them."""
    said = [_UNKNOWN] if not fit.left_out else _left_out_words(fit)
    if fit.degree == 1:
        said.append("A linear load is linear interpolation for every mode but the means.")
    if fit.material is not None and max(fit.damping.low, fit.mass.low) <= 0 and fit.degree > 2:
        said.append(
            "c/k and m/k are not told apart: either may be as small as you like, but not both."
        )
    if fit.excursion > _AT_BORDER * EXCURSION:
        said.append(
            f"A law leaves [0, 1] or runs back by {fit.excursion:.1%}, the border of the range "
            "that is searched: the best fit may lie at a resonance beyond it."
        )
    return said


def _left_out_words(fit: Fit) -> list[str]:
    linear, ease, beam = fit.left_out
    won = int((fit.left_out_rms[:, 2] < fit.left_out_rms[:, 0]).sum())
    beats = "beats" if fit.beats_linear else "does not beat"
    said = [
        f"On motions left out of the fit it {beats} linear interpolation: RMS "
        f"{_percent(beam.rms)} of D against {_percent(linear.rms)}, closer on {won} of "
        f"{fit.motions}."
    ]
    alike, size = "ease with a load fitted alike", _percent(ease.rms)
    if fit.beats_ease:
        said.append(f"It also beats {alike} ({size}): the material adds to the timing.")
    elif fit.degree > 1 and same(ease.rms, beam.rms):
        said.append(f"E{alike[1:]} is as close ({size}): the material adds nothing to the timing.")
    elif fit.degree > 1:
        said.append(
            f"It does not beat {alike} ({size}): the material adds nothing that can be relied on."
        )
    if fit.chosen == "leave-one-out":
        said.append("The degree was chosen by these same errors, which flatters them a little.")
    return said


def ratio_words(ratio: Ratio) -> str:
    """One ratio and its interval."""
    if ratio.low <= 0 and math.isinf(ratio.high):
        return "not identified: these motions say nothing about it"
    if ratio.low <= 0:
        return f"not identified: anything below {ratio.high:.3g} fits as well"
    if math.isinf(ratio.high):
        return f"not identified: anything above {ratio.low:.3g} fits as well"
    words = f"{ratio.value:.5g}, between {ratio.low:.5g} and {ratio.high:.5g}"
    if ratio.high > _WIDE * ratio.low:
        words += " (wide: known to its order of magnitude at best)"
    if ratio.refits is not None:
        words += f"; {ratio.refits[0]:.4g} to {ratio.refits[1]:.4g} with one motion left out"
        if not ratio.reproducible:
            words += ", so not reproducible"
    return words


_FACTS = """
    material load load_intervals degree degree_chosen_by=chosen degree_rms=degree_errors closure
    damping mass method=method.label excursion in_sample left_out left_out_rms beats_linear
    beats_ease conclusions per_curve motions frames curves vertices diameter
"""
"""The keys of a fit as plain values, with what they show where it has another name."""


def fit_facts(fit: Fit) -> dict[str, Any]:
    """Everything found, as plain values; what is infinite or unknown is None."""
    facts = {}
    for fact in _FACTS.split():
        key, _, name = fact.partition("=")
        value = conclusions(fit) if key == "conclusions" else attrgetter(name or key)(fit)
        facts[key] = _plain(value)
    return facts


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Load):
        return _plain(value.coefficients)
    if is_dataclass(value):
        shown = getattr(value, "SHOWN", None) or [field.name for field in fields(value)]
        return {name: _plain(getattr(value, name)) for name in shown}
    if isinstance(value, dict):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(each) for each in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def _degree(fit: Fit) -> str:
    if fit.chosen == "given":
        return f"degree {fit.degree}, as asked for"
    least, most = min(fit.degree_errors), max(fit.degree_errors)
    return f"degree {fit.degree} of {least} to {most}, by {fit.chosen}"


def _polynomial(coefficients: Sequence[float]) -> str:
    powers = ("t", "t²", "t³", "t⁴", "t⁵", "t⁶")
    words = ""
    for p, power in zip(coefficients, powers, strict=False):
        if abs(p) < _NEGLIGIBLE:
            continue
        sign = (" - " if p < 0 else " + ") if words else ("-" if p < 0 else "")
        size = f"{abs(p):.4g}"
        words += sign + (power if size == "1" else f"{size} {power}")
    return words


def _several(count: int, thing: str) -> str:
    return f"{count} {thing}" if count == 1 else f"{count:,} {thing}s"


def _table(columns: Sequence[str], caption: str, title: str | None = None) -> Table:
    """A table of numbers whose first column is names."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, pad_edge=False, title=title, title_justify="left")
    table.caption, table.caption_justify = caption, "left"
    for number, column in enumerate(columns):
        table.add_column(column, justify="right" if number else "left")
    return table


def _error_table(fit: Fit) -> Table:
    blocks = {"fitted": fit.in_sample, **({"left out": fit.left_out} if fit.left_out else {})}
    caption = "% of D. left out: each motion with the fit of all others"
    headers = [f"{title}\n{measure}" for title in blocks for measure in ("RMS", "LME", "LAE")]
    table = _table(["method", *headers], caption if fit.left_out else "% of D")
    for rows in zip(*blocks.values(), strict=True):
        values = [value for each in rows for value in (each.rms, each.lme, each.lae)]
        table.add_row(rows[0].label, *(f"{100 * value:.3f}" for value in values))
    return table


def _curve_table(curves: Sequence[CurveFit]) -> Table:
    table = _table(
        ["curve", "linear", "fitted", "left out", "c/k", "m/k", "load"],
        "RMS in % of D; –: not identified",
        "Every curve alone",
    )
    table.columns[-1].justify = "left"
    for one in curves:
        left_out = "" if math.isnan(one.left_out_rms) else f"{100 * one.left_out_rms:.3f}"
        table.add_row(
            one.name,
            f"{100 * one.linear_rms:.3f}",
            f"{100 * one.rms:.3f}",
            left_out,
            *("–" if r.value is None else f"{r.value:.3g}" for r in (one.damping, one.mass)),
            "does not move" if one.load is None else _polynomial(one.load.coefficients),
        )
    return table


def _percent(fraction: float) -> str:
    """A distance as a share of D, such as "1.376 %"."""
    return f"{100 * fraction:.3f} %"
