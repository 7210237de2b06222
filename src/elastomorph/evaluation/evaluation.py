"""Compare ways to interpolate, those asked for or all, with a recorded motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from elastomorph.blas_threads import one_blas_thread
from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation.confidence import (
    LEAST,
    Confidence,
    ConfidenceLike,
    counted_of,
    require_least,
    require_some,
)
from elastomorph.evaluation.curve_errors import CurveVertices, curve_errors, free_timing
from elastomorph.evaluation.inbetweens import suggest_inbetweens
from elastomorph.evaluation.results import Evaluation, MethodResult
from elastomorph.evaluation.shape import Shape, ShapeProbe
from elastomorph.model.mesh import require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence, require_motion
from elastomorph.paths import Method, interpolate
from elastomorph.paths.through import law_for
from elastomorph.physics import Material

if TYPE_CHECKING:
    from elastomorph.io.sequences import Recording

# A morph read from a file of 32-bit numbers starts and ends this close to the captured frames.
_FEWEST_FRAMES = 3
_END_TOLERANCE = 1e-5

AnyMethod = str | Method | Morph


DEFAULT_METHODS = ("linear", "cosine", "ease:2", "ease:3", "beam:1", "beam:2", "beam:3")

_MOST_INBETWEENS = 2


def evaluate(
    truth: MeshSequence | str | Path,
    methods: Iterable[AnyMethod] | Mapping[str, AnyMethod] | AnyMethod = DEFAULT_METHODS,
    curves: CurveNetwork | None = None,
    *,
    material: Material | None = None,
    extent: float | None = None,
    confidence: ConfidenceLike | None = None,
    least_confidence: float = LEAST,
    progress: Callable[[str], None] | None = None,
) -> Evaluation:
    """Interpolate between the first and the last frame of a motion and compare with the rest.

    Every method is measured twice: at the times of the frames, and with free timing, where each
    frame picks its own moment of the path, in order, so that the largest error is as small as it
    can be. What vanishes with free timing was a matter of timing.

    Args:
        truth: The recorded motion; its frames carry times from 0 to 1. Or what
            `elastomorph.read_sequence` reads it from, such as ``scan.####.obj``.
        methods: Texts such as ``beam:2``, or ``through:1`` and ``through:2:spline`` for the best
            frames of the motion as in-betweens; `Method` objects; or finished morphs from the
            first frame to the last. A mapping gives them labels of your own.
        curves: The curves along which errors are measured and which beams follow; found by
            `extract_curves` by default. A mesh without polygons needs them.
        material: m, c, k of methods given as text; by default 1, 1, 1.
        extent: The length D that errors are fractions of, in the unit of the vertices: where the
            motion is that of a part, the size of the whole. That of the first frame by default.
        confidence: From 0 to 1, how far vertices are to be trusted: a file ``confidence.npz``,
            (V,) by the names of frames, or (T, V); of a motion named by its files, that in their
            folder. A vertex counts where it is high enough, at the first and last frame too.
        least_confidence: The confidence from which on a vertex counts; 0 lets all of them count.
        progress: Called with the label of each method before it is evaluated.

    Raises:
        CurveError: The curves belong to another mesh, or there are none.
        MeshError: A morph does not lead from the first frame to the last, or D is 0.
        TopologyError: A morph has other vertices or polygons.
        FileError: A motion or confidence named by its files cannot be read.
        ParameterError: The motion is none, a method is not understood, there is none, or two have
            one label; the confidence does not fit, or no vertex counts.
        ResonanceError: A material is singular for its load.
    """
    truth, mask = recorded_motion(truth, confidence, least_confidence)
    if len(truth) < _FEWEST_FRAMES:
        raise ParameterError(
            f"a motion of {len(truth)} frames has none between the first and the last, where every "
            "path is exact, so that nothing tells methods apart; give a frame between, or more"
        )
    if curves is None:
        curves = extract_curves(truth.mesh)
    require_curves_of(curves, len(truth.mesh.vertices), "the first frame")
    yardstick = Yardstick.of(truth, curves, extent, mask)
    chosen = _labelled(methods, material, truth, curves, mask)
    results, say = [], progress or (lambda _: None)
    for number, (label, method) in enumerate(chosen.items(), start=1):
        say(f"{label} ({number} of {len(chosen)})")
        path = _path(label, method, truth, curves)
        results.append(yardstick.measure(label, path))
    return Evaluation(truth, curves, tuple(results), extent=extent, confidence=mask)


def recorded_motion(
    truth: MeshSequence | str | Path, confidence: ConfidenceLike | None, least: float
) -> tuple[MeshSequence, Confidence | None]:
    """The motion, read where it is named by its files, and which of its vertices count."""
    if not isinstance(truth, str | Path):
        require_motion(truth)
        return truth, confidence_of(confidence, truth, least)
    from elastomorph.io.npz.confidence import confidence_beside
    from elastomorph.io.sequences import read_recording

    found = confidence_beside(truth) if confidence is None else confidence
    recording = read_recording(truth)
    return recording.motion, confidence_in(recording, found, least)


def confidence_in(
    recording: Recording, given: ConfidenceLike | None, least: float
) -> Confidence | None:
    """The confidence of a recording as a mask, in which what was not seen never counts."""
    mask = confidence_of(given, recording.motion, least)
    if recording.seen is None:
        return mask
    if mask is None:
        return Confidence(recording.seen.astype(np.float32))
    return Confidence(mask.values * recording.seen, mask.least)


def _path(label: str, method: Method | Morph, truth: MeshSequence, curves: CurveNetwork) -> Morph:
    """The path from the first frame to the last."""
    if isinstance(method, Method):
        return interpolate(truth.mesh, truth.target, method, curves=curves)
    _require_ends(method, truth, label)
    return method


def confidence_of(
    given: ConfidenceLike | None, truth: MeshSequence, least: float
) -> Confidence | None:
    """The confidence of a motion as a mask; None where there is none, or all vertices count."""
    if not require_least(least) or given is None:
        return None
    if isinstance(given, Confidence):
        return Confidence.of(given.values, truth, given.least)
    return Confidence.of(given, truth, least)


@dataclass(frozen=True, eq=False)
class Yardstick:
    """What every path is held against: a motion, its curves, and which vertices count."""

    truth: MeshSequence
    along: CurveVertices
    probe: ShapeProbe
    mask: Confidence | None

    @classmethod
    def of(
        cls,
        truth: MeshSequence,
        curves: CurveNetwork,
        extent: float | None = None,
        mask: Confidence | None = None,
    ) -> Yardstick:
        """Prepare for paths of one motion; D is its own extent by default."""
        along = CurveVertices.of(curves, len(truth.mesh.vertices))
        if mask is not None:
            require_some(mask, along)
        probe = ShapeProbe.of(truth.mesh, truth.target, curves.curve_of)
        return cls(truth, along, probe if extent is None else replace(probe, diameter=extent), mask)

    # Hundreds of small products: threads of BLAS would wait for each other after every one.
    @one_blas_thread()
    def measure(self, label: str, morph: Morph) -> MethodResult:
        """Frame by frame, so that memory holds one in-between at a time."""
        truth, along, diameter = self.truth, self.along, self.probe.diameter
        errors = np.empty((4, len(along.counts), len(truth)))
        average, maximum, path_average, path_maximum = errors
        counted = counted_of(self.mask)
        path_times = free_timing(morph, truth, along, "lme", counted)
        average_times = free_timing(morph, truth, along, "lae", counted)
        worst, unmasked = Shape(), np.zeros(2)
        each = zip(truth.times, path_times, average_times, strict=True)
        for i, moments in enumerate(each):
            own = None if counted is None else counted[i]
            off = partial(curve_errors, captured=truth.frames[i], curves=along, diameter=diameter)
            positions = morph.at(float(moments[0]))
            average[:, i], maximum[:, i] = off(positions, counted=own)
            if own is not None:
                every = [error.max() for error in off(positions)]
                unmasked = np.maximum(unmasked, every)
            worst = worst.worst(self.probe.at(morph, float(moments[0]), positions))
            _, path_maximum[:, i] = off(morph.at(float(moments[1])), counted=own)
            path_average[:, i], _ = off(morph.at(float(moments[2])), counted=own)
        found = MethodResult(
            label,
            morph,
            average,
            maximum,
            path_times,
            average_times,
            path_average,
            path_maximum,
            **asdict(worst),
            informed=morph.method.startswith("through "),
        )
        if self.mask is None:
            return found
        return replace(found, unmasked_lae=float(unmasked[0]), unmasked_lme=float(unmasked[1]))


def _labelled(
    methods: Iterable[AnyMethod] | Mapping[str, AnyMethod] | AnyMethod,
    material: Material | None,
    truth: MeshSequence,
    curves: CurveNetwork,
    mask: Confidence | None,
) -> dict[str, Method | Morph]:
    """The methods by their labels, in order."""
    if isinstance(methods, AnyMethod):
        methods = [methods]
    if not isinstance(methods, Iterable):
        raise ParameterError(
            f"methods are texts such as 'beam:2', Methods or Morphs, found {methods!r}"
        )
    pairs: Iterable[tuple[str | None, AnyMethod]] = (
        methods.items()
        if isinstance(methods, Mapping)
        else ((None, method) for method in cast("Iterable[AnyMethod]", methods))
    )
    found: dict[str, Method | Morph] = {}
    for label, method in pairs:
        if isinstance(method, str):
            own, method = method_of(method, truth, curves, material=material, confidence=mask)
        elif not isinstance(method, Method | Morph):
            raise ParameterError(
                f"a method is a text such as 'beam:2', a Method or a Morph, found {method!r}"
            )
        else:
            own = method.method if isinstance(method, Morph) else method.label
        name = own if label is None else str(label)
        if name in found:
            raise ParameterError(
                f"two methods are called {name!r}: give a mapping from labels of your own to "
                "methods"
            )
        found[name] = method
    if not found:
        raise ParameterError("there is no method to evaluate")
    return found


def _require_ends(morph: Morph, truth: MeshSequence, label: str) -> None:
    """Check that a finished path leads from the first frame to the last."""
    require_same_topology(truth.mesh, morph.neutral)
    allowed = _END_TOLERANCE * truth.mesh.diameter
    for mesh, frame, where in (
        (morph.neutral, truth.frames[0], "start at the first"),
        (morph.target, truth.frames[-1], "end at the last"),
    ):
        gap = float(np.linalg.norm(mesh.vertices - frame, axis=1).max())
        if gap > allowed:
            raise MeshError(
                f"the path {label!r} must {where} frame of the motion, but is {gap:.3g} away "
                f"from it (D is {truth.mesh.diameter:.3g}): build it from truth.neutral to "
                "truth.target"
            )


def method_of(
    text: str,
    truth: MeshSequence,
    curves: CurveNetwork,
    *,
    material: Material | None = None,
    confidence: Confidence | None = None,
    progress: Callable[[str], None] | None = None,
) -> tuple[str, Method | Morph]:
    """The label and the method of a text, as for `Method.parse`, or ``through:N[:law]``.

    That is the path through the N frames that leave the smallest LME, see `suggest_inbetweens`.
    """
    name, *options = text.strip().split(":")
    if name != "through":
        method = Method.parse(text).with_material(material or Material())
        return method.label, method
    if not (1 <= len(options) <= 2 and options[0].isascii() and options[0].isdigit()):
        raise ParameterError(
            f"method {text!r}: 'through' needs the number of recorded frames, and may name a law; "
            "examples: through:1, through:2:spline"
        )
    law = law_for(options[1], int(options[0])) if len(options) == 2 else None
    how: dict[str, Any] = {"curves": curves, "counted": counted_of(confidence)}
    found = suggest_inbetweens(truth, int(options[0]), method=law, progress=progress, **how)
    return " ".join(["through", options[0], *options[1:]]), found[-1].morph


def every_method(
    truth: MeshSequence,
    curves: CurveNetwork,
    *,
    material: Material | None = None,
    confidence: Confidence | None = None,
    progress: Callable[[str], None] | None = None,
) -> dict[str, Method | Morph]:
    """Every method by its label, scanned in-betweens at the frames where they pay most.

    Args:
        truth: The recorded motion.
        curves: The curves errors are measured along.
        material: Of the elastic methods; 1, 1, 1 by default.
        confidence: Which vertices count where in-betweens are chosen; all by default.
        progress: Told what is being prepared.

    Returns:
        linear, cosine, ease, beam, arc and auto; plate and rotation where there are polygons; a
        path through one and through two recorded frames, as far as there are frames.
    """
    methods = [Method.parse(text) for text in DEFAULT_METHODS]
    listed = {type(method) for method in methods}
    others = [kind for kind in Method.known if kind not in listed]
    if not len(truth.mesh.faces):
        others = [kind for kind in others if not kind.on_surfaces]
    methods += [kind() for kind in sorted(others, key=lambda kind: not kind.on_surfaces)]
    given = [method.with_material(material or Material()) for method in methods]
    found: dict[str, Method | Morph] = {method.label: method for method in given}
    most = min(_MOST_INBETWEENS, len(truth) - 2)
    if most > 0:
        if progress is not None:
            progress("looking for the best in-betweens")
        counted = counted_of(confidence)
        for suggestion in suggest_inbetweens(truth, most, curves=curves, counted=counted)[1:]:
            found[f"through {len(suggestion.frames)}"] = suggestion.morph
    return found


def left_out(truth: MeshSequence) -> str:
    """A sentence about the methods that this motion does not allow; empty where it allows all."""
    if len(truth.mesh.faces):
        return ""
    names = [kind.name for kind in Method.known if kind.on_surfaces]
    return f"Left out: {' and '.join(names)} follow a surface, and markers have no polygons."
