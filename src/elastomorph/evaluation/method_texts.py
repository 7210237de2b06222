"""What a text such as ``beam:2`` or ``through:1:smooth`` asks an evaluation to judge."""

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
