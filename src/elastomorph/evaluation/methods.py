"""The methods that a motion is compared with: what a text asks for, and all of them at once."""

from __future__ import annotations

from collections.abc import Callable

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError
from elastomorph.evaluation.inbetweens import suggest_inbetweens
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method
from elastomorph.paths.through import law_for
from elastomorph.physics import Material

DEFAULT_METHODS = ("linear", "cosine", "ease:2", "ease:3", "beam:1", "beam:2", "beam:3")

_MOST_INBETWEENS = 2


def method_of(
    text: str,
    truth: MeshSequence,
    curves: CurveNetwork,
    *,
    material: Material | None = None,
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
    found = suggest_inbetweens(truth, int(options[0]), curves=curves, method=law, progress=progress)
    return " ".join(["through", options[0], *options[1:]]), found[-1].morph


def every_method(
    truth: MeshSequence,
    curves: CurveNetwork,
    *,
    material: Material | None = None,
    progress: Callable[[str], None] | None = None,
) -> dict[str, Method | Morph]:
    """Every method by its label, scanned in-betweens at the frames where they pay most.

    Args:
        truth: The recorded motion.
        curves: The curves errors are measured along.
        material: Of the elastic methods; 1, 1, 1 by default.
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
        for suggestion in suggest_inbetweens(truth, most, curves=curves)[1:]:
            found[f"through {len(suggestion.frames)}"] = suggestion.morph
    return found


def left_out(truth: MeshSequence) -> str:
    """A sentence about the methods that this motion does not allow; empty where it allows all."""
    if len(truth.mesh.faces):
        return ""
    names = [kind.name for kind in Method.known if kind.on_surfaces]
    return f"Left out: {' and '.join(names)} follow a surface, and markers have no polygons."
