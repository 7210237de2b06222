"""What a fit found, how well it holds, and how to use it: as values, as text, and as JSON.

What a fit needs to know of a captured motion: a few sums for each stiffness B.

By Parseval the squared distance between a captured frame and V₀ + Σ_n φ_n(t) Δ_n is a sum over
modes, and all modes of one B share one law φ. With y_n(t) the modes of Y(t) - V₀,

    Σ_n |y_n(t) - φ Δ_n|² = A (φ - C(t)/A)² + S(t) - C(t)²/A,
    A = Σ_n |Δ_n|²,   C(t) = Σ_n Re y_n(t)·Δ̄_n,   S(t) = Σ_n |y_n(t)|².

φ = Σ_r φ_r t^r is linear in its K coefficients, so over all frames of all motions each B keeps no
more than a (K, K) triangle F and K numbers z (one QR factorisation): misfit = ‖F φ - z‖² + rest.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import Curve
from elastomorph.evaluation.summary import same
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method
from elastomorph.physics import Load, Material, mean_response, modal_response
from elastomorph.physics.beam import ModeTransform
from elastomorph.physics.response import excursion

if TYPE_CHECKING:
    from rich.table import Table


@dataclass(frozen=True, eq=False)
class ModalSums:
    """The sums of one motion over some curves; its first and last frame are known and left out.

    Attributes:
        stiffness: (G,) distinct B/k, rising from 0 (the means).
        displacement: (G,) A.
        along: (T, G) C of the inner frames.
        total: S, summed over modes and frames.
        times: (T,) of the inner frames.
        vertices: Number of vertices of the curves.
    """

    stiffness: NDArray[np.float64]
    displacement: NDArray[np.float64]
    along: NDArray[np.float64]
    total: float
    times: NDArray[np.float64]
    vertices: int

    @classmethod
    def joined(cls, parts: Sequence[ModalSums]) -> ModalSums:
        """The sums of several sets of curves in one motion."""
        every = np.concatenate([part.stiffness for part in parts])
        stiffness, group = np.unique(every, return_inverse=True)
        displacement = np.zeros(len(stiffness))
        np.add.at(displacement, group, np.concatenate([part.displacement for part in parts]))
        along = np.zeros((len(stiffness), len(parts[0].times)))
        np.add.at(along, group, np.concatenate([part.along for part in parts], axis=1).T)
        return cls(
            stiffness,
            displacement,
            along.T,
            sum(part.total for part in parts),
            parts[0].times,
            sum(part.vertices for part in parts),
        )


def curve_sums(motion: MeshSequence, curves: Sequence[Curve]) -> list[ModalSums]:
    """The sums of every curve in one motion: cosine modes of open, Fourier modes of closed."""
    found = []
    start = motion.frames[0]
    for curve in curves:
        at = curve.vertices
        transform = ModeTransform(len(curve), curve.closed)
        weights = np.ones(transform.count)
        if curve.closed:  # a real series: modes ±n are stored once, and rfft is not normalised
            weights[1 : (len(curve) + 1) // 2] = 2.0
            weights /= len(curve)
        delta = transform.forward(motion.frames[-1][at] - start[at])
        moved = transform.forward(motion.frames[1:-1, at] - start[at])
        along = weights * (moved * delta.conj()).real.sum(axis=-1)
        squared = weights * (np.abs(moved) ** 2).sum(axis=-1)
        found.append(
            ModalSums(
                transform.stiffness(1.0),
                weights * (np.abs(delta) ** 2).sum(axis=-1),
                along,
                float(squared.sum()),
                motion.times[1:-1],
                len(curve),
            )
        )
    return found


@dataclass(frozen=True, eq=False)
class LawSums:
    """The squared distance to any number of motions as a function of the laws.

    Attributes:
        stiffness: (G,) distinct B/k, rising from 0.
        factors: (G, K, K) F.
        aims: (G, K) z.
        rest: What no law can remove.
        total: The squared distance of the motions from their first frames.
        count: Vertices times inner frames.
        frames: Inner frames.
    """

    stiffness: NDArray[np.float64]
    factors: NDArray[np.float64]
    aims: NDArray[np.float64]
    rest: float
    total: float
    count: int
    frames: int

    @classmethod
    def of(cls, sums: ModalSums, powers: int) -> LawSums:
        """The sums of one motion for laws of t … t^powers."""
        root = np.sqrt(sums.displacement)
        wanted = sums.along.T / np.where(root > 0, root, 1.0)[:, None]  # without motion both are 0
        basis = sums.times[:, None] ** np.arange(1, powers + 1)
        rows = root[:, None, None] * basis
        explained = float((wanted**2).sum())
        rest, count = max(sums.total - explained, 0.0), sums.vertices * len(sums.times)
        whole = cls(sums.stiffness, rows, wanted, rest, sums.total, count, len(sums.times))
        return whole._reduced()

    @classmethod
    def together(cls, parts: Sequence[LawSums]) -> LawSums:
        """The sums of several motions of the same curves."""
        if len(parts) == 1:
            return parts[0]
        return cls(
            parts[0].stiffness,
            np.concatenate([part.factors for part in parts], axis=1),
            np.concatenate([part.aims for part in parts], axis=1),
            sum(part.rest for part in parts),
            sum(part.total for part in parts),
            sum(part.count for part in parts),
            sum(part.frames for part in parts),
        )._reduced()

    def _reduced(self) -> LawSums:
        """The same with any number of rows for each B turned into at most K."""
        missing = max(self.factors.shape[2] - self.factors.shape[1], 0)
        rows = np.pad(self.factors, ((0, 0), (0, missing), (0, 0)))
        wanted = np.pad(self.aims, ((0, 0), (0, missing)))
        basis, factors = np.linalg.qr(rows)
        aims = np.einsum("gij,gi->gj", basis, wanted)
        beyond = wanted - np.einsum("gij,gj->gi", basis, aims)
        return replace(self, factors=factors, aims=aims, rest=self.rest + float((beyond**2).sum()))

    def residuals(self, laws: NDArray[np.float64]) -> NDArray[np.float64]:
        """(G, K) F φ - z for (G, K) coefficients of the laws."""
        return np.asarray(np.einsum("gij,gj->gi", self.factors, laws) - self.aims)

    def misfit(self, laws: NDArray[np.float64]) -> float:
        """Sum of squared distances over vertices and inner frames."""
        return float((self.residuals(laws) ** 2).sum()) + self.rest


EXCURSION = 0.1
# The penalty begins a little before the border, so that what it stops is still inside.
_PENALISED = 0.099
_STEEPNESS = 100.0
_HUGE = 1e6
_LARGEST_LOAD = 100.0
# Laws of materials this much softer or stiffer than any mode no longer change.
_STIFF = 1e-9
_SOFT = 1e3


@dataclass(frozen=True, eq=False)
class Objective:
    """What a fit makes small for some motions: the load has this degree, the means this closure."""

    sums: LawSums
    degree: int
    closure: str

    @cached_property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest value of each parameter.

        For a material at the lowest every law is the limit law to about eight digits.
        """
        b = self.sums.stiffness[1:]
        least, most = (float(b.min()), float(b.max())) if b.size else (1.0, 1.0)
        rest = np.full(self.degree - 1, _LARGEST_LOAD)
        low = np.concatenate([np.full(2, np.log(_STIFF * least)), -rest])
        return low, np.concatenate([np.full(2, np.log(_SOFT * most)), rest])

    @property
    def free(self) -> NDArray[np.bool_]:
        """(R + 1,) which parameters have any influence on the laws.

        A linear load is linear interpolation whatever the material (but for the means of some
        closures); with a quadratic one the mass drops out of every mode but the means. The laws of
        the means depend on m/c only, so a curve of one vertex has no c/k.
        """
        modes = len(self.sums.stiffness) > 1
        forced = self.closure in ("unforced", "rest")
        means = forced or (self.closure == "compatible" and self.degree >= 2)
        damping = modes and (self.degree >= 2 or forced)
        mass = means or (modes and self.degree >= 3)
        return np.array([damping, mass] + [True] * (self.degree - 1))

    def load(self, point: NDArray[np.float64]) -> Load:
        """p(t) at a point, with p(1) = 1."""
        return Load([1.0 - float(point[2:].sum()), *point[2:].tolist()])

    def material(self, point: NDArray[np.float64]) -> Material:
        """The material at a point, with k = 1."""
        damping, mass = np.exp(point[:2]).tolist()
        return Material(mass, damping, 1.0)

    def laws(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """(G, K) coefficients of t … t^K of the law of each B."""
        load, material = self.load(point), self.material(point)
        laws = np.zeros(self.sums.aims.shape)
        with np.errstate(all="ignore"):
            mean = mean_response(self.closure, load, material)
            laws[0, : len(mean)] = mean
            laws[1:, : load.order] = modal_response(self.sums.stiffness[1:], load, material)
        return np.where(np.isnan(laws), _HUGE, np.clip(laws, -_HUGE, _HUGE))

    def excursion(self, point: NDArray[np.float64]) -> float:
        """How far the worst law leaves [0, 1] or runs back."""
        return float(excursion(self.laws(point)).max())

    def misfit(self, point: NDArray[np.float64]) -> float:
        """Squared distance over that of the first frames; the penalty is not in it."""
        return self.sums.misfit(self.laws(point)) / self.sums.total

    def residuals(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """What to make small: distances over those of the first frames, and the penalty."""
        laws = self.laws(point)
        own = self.sums.residuals(laws).ravel() / np.sqrt(self.sums.total)
        penalty = _STEEPNESS * np.maximum(np.minimum(excursion(laws), _HUGE) - _PENALISED, 0.0)
        return np.concatenate([own, penalty])

    def cost(self, point: NDArray[np.float64]) -> float:
        """The misfit and the penalty."""
        return float((self.residuals(point) ** 2).sum()) + self.sums.rest / self.sums.total


@dataclass(frozen=True)
class Ratio:
    """c/k or m/k with its 95 % interval.

    Attributes:
        value: Where the fit is best; None if the motions do not identify it.
        low: 0 where nothing bounds it from below.
        high: Infinity where nothing bounds it from above.
        refits: Its lowest and highest value when one motion after the other is left out.
    """

    SHOWN: ClassVar = ("value", "low", "high", "identified", "reproducible", "refits")

    value: float | None
    low: float
    high: float
    refits: tuple[float, float] | None = None

    @property
    def identified(self) -> bool:
        """Whether it is bounded on both sides."""
        return self.low > 0 and math.isfinite(self.high)

    @property
    def reproducible(self) -> bool:
        """Whether it is identified and stays in its interval whichever motion is left out."""
        if not self.identified or self.refits is None:
            return False
        return self.low <= self.refits[0] and self.refits[1] <= self.high


@dataclass(frozen=True)
class Errors:
    """How far one method is from the motions, over the frames between first and last.

    Attributes:
        label: ``linear``, ``ease`` or ``beam``.
        rms: Root of the mean squared distance over the curves' vertices, frames and motions, as a
            fraction of D.
        lme: Largest maximum error over curves and times, mean over the motions.
        lae: Largest average error over curves and times, mean over the motions.
    """

    label: str
    rms: float
    lme: float
    lae: float


@dataclass(frozen=True, eq=False)
class CurveFit:
    """The fit of one curve alone, with the degree of the common fit.

    Attributes:
        name: Name of the curve, or its number.
        load: p(t) with p(1) = 1; None for a curve that does not move.
        damping: c/k.
        mass: m/k.
        rms: RMS of the beam over D.
        linear_rms: RMS of linear interpolation over D.
        left_out_rms: RMS on motions left out of the fit; NaN if there is only one.
    """

    name: str
    load: Load | None
    damping: Ratio
    mass: Ratio
    rms: float
    linear_rms: float
    left_out_rms: float


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """Material and load that captured motions have in common.

    Attributes:
        material: (m/k, c/k, 1); None if neither ratio is identified: the curves are so stiff that
            all of them follow the load, whatever they are made of.
        load: p(t) with p(1) = 1.
        degree: R, the degree of p.
        closure: Time law of the means.
        damping: c/k with its interval, from the profile of the squared distance.
        mass: m/k, likewise.
        load_intervals: 95 % intervals of p₁ … p_R, from the Jacobian at the optimum.
        degree_errors: RMS over D by degree, on motions left out (of all motions, if there is only
            one).
        chosen: How the degree was chosen: ``given``, ``leave-one-out`` or ``BIC``.
        excursion: How far the worst law leaves [0, 1] or runs back; the fit allows 0.1.
        in_sample: Errors of linear, ease and beam on the motions fitted.
        left_out: The same on each motion, fitted without it; empty if there is only one.
        left_out_rms: (motions, 3) RMS of each motion and method, over D.
        per_curve: Every curve fitted alone, if that was asked for.
        motions: Number of motions.
        frames: Number of frames between first and last ones.
        curves: Number of curves.
        vertices: Number of vertices of the curves.
        diameter: D of the first motion, in the unit of the vertices.
    """

    material: Material | None
    load: Load
    degree: int
    closure: str
    damping: Ratio
    mass: Ratio
    load_intervals: tuple[tuple[float, float], ...]
    degree_errors: dict[int, float]
    chosen: str
    excursion: float
    in_sample: tuple[Errors, ...]
    left_out: tuple[Errors, ...]
    left_out_rms: NDArray[np.float64]
    per_curve: tuple[CurveFit, ...]
    motions: int
    frames: int
    curves: int
    vertices: int
    diameter: float

    @property
    def method(self) -> Method:
        """The method to interpolate with: a beam, or `ease` where no material is identified."""
        if self.material is None:
            return Method("ease", load=self.load)
        return Method("beam", material=self.material, load=self.load, closure=self.closure)

    @property
    def beats_linear(self) -> bool | None:
        """Whether motions left out are closer to the fit than to linear; None if unknown.

        By 1 % or more in the RMS over all of them, and more than half of them one by one.
        """
        return self._beats(0)

    @property
    def beats_ease(self) -> bool | None:
        """The same of `ease` with a load fitted alike instead of linear."""
        return self._beats(1)

    def _beats(self, other: int) -> bool | None:
        if not self.left_out:
            return None
        theirs, ours = self.left_out[other].rms, self.left_out[2].rms
        closer = self.left_out_rms[:, 2] < self.left_out_rms[:, other]
        return ours < theirs and not same(ours, theirs) and 2 * int(closer.sum()) > self.motions

    def text(self, width: int = 100) -> str:
        """The fit for people: constants, a table of errors, and what they amount to."""
        return fit_text(self, width)

    def to_dict(self) -> dict[str, Any]:
        """Everything found, ready for JSON; what is infinite or unknown is null."""
        return fit_facts(self)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"Fit({self.method.label}, {self.motions} motions)"


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
