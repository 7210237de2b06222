"""What is compared: the first section of a report, and what only its caller knows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import Evaluation
from elastomorph.evaluation.words import counted, listed, significant
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.numbers import first_few
from elastomorph.paths import Method
from elastomorph.report.document import Section

_NAMED = 12


@dataclass(frozen=True, eq=False)
class About:
    """Where a recording came from and how it was compared.

    Attributes:
        name: What the report is about, such as ``built-in head`` or the name of a file.
        source: What the frames are, in a sentence.
        unit: Unit of the coordinates, such as ``cm``; an empty string where nobody knows it.
        call: The command or the call that makes this report again.
        curves: Where the curves come from, in a sentence.
        methods: The methods by their labels, with all settings; those left out are described by
            what their paths say of themselves.
        timing_known: Whether the frames were recorded at their times. Where a motion is only known
            as a way, such as that of a rigid part, errors at given times mean nothing.
        remarks: Further findings, in sentences.
    """

    name: str = "a recorded motion"
    source: str = ""
    unit: str = ""
    call: str = ""
    curves: str = "traced along the edges of the polygons, every vertex on one curve"
    methods: Mapping[str, Method | Morph] = field(default_factory=dict)
    timing_known: bool = True
    remarks: tuple[str, ...] = ()

    @property
    def truth(self) -> str:
        """What the methods are compared with, in a word or two."""
        return "recorded" if self.timing_known else "known way"


def compared(evaluation: Evaluation, about: About, informed: Sequence[str] = ()) -> Section:
    """The facts of one comparison."""
    truth = evaluation.truth
    facts = [
        ("Face" if evaluation.extent is None else "Parts", face_words(truth.mesh)),
        ("Size", _size_words(evaluation, about.unit)),
        ("Curves", curve_words(evaluation.curves)),
        ("Motion", _motion_words(truth, about)),
        ("Methods", method_labels(evaluation)),
    ]
    if evaluation.coverage:
        facts.insert(4, ("Confidence", evaluation.coverage))
    if truth.missing:
        facts.insert(4, ("Missing", _missing_words(truth)))
    more = f", {listed(informed)} frames between them too" if informed else ""
    how = (
        f"Every method was given the first and the last frame{more}. What it makes of the way "
        "between them is compared with the "
        f"{'recorded frames' if about.timing_known else 'known way'}."
    )
    content = {"source": about.source, "facts": facts, "how": how, "remarks": about.remarks}
    return Section("compared", "What was compared", content, appendix=True)


def method_labels(evaluation: Evaluation) -> str:
    """How many methods there are, and which."""
    labels = [result.label for result in evaluation.results]
    return f"{counted(len(labels), 'method')}: {', '.join(labels)}"


def face_words(mesh: Mesh) -> str:
    """Vertices and polygons, such as "8 vertices, 7 polygons (5 quads and 2 triangles)"."""
    words = counted(len(mesh.vertices), "vertex", "vertices")
    if not len(mesh.faces):
        return f"{counted(len(mesh.vertices), 'marker')}, without polygons"
    corners = np.diff(mesh.faces.offsets)
    kinds = [
        counted(int(np.count_nonzero(chosen)), name)
        for chosen, name in (
            (corners == 4, "quad"),
            (corners == 3, "triangle"),
            (corners > 4, "n-gon"),
        )
        if chosen.any()
    ]
    polygons = counted(len(mesh.faces), "polygon")
    return f"{words}, {polygons} ({listed(kinds)})" if len(kinds) > 1 else f"{words}, {kinds[0]}"


def curve_words(curves: CurveNetwork) -> str:
    """How many curves there are, and of which kind."""
    closed = sum(curve.closed for curve in curves)
    single = sum(len(curve) == 1 for curve in curves)
    words = f"{counted(len(curves), 'curve')}: {closed:,} closed, {len(curves) - closed:,} open"
    return f"{words} ({single:,} of a single vertex)" if single else words


def diameter_words(diameter: float, unit: str) -> str:
    """D with its unit, and what it is."""
    words = (
        f"D = {significant(diameter)} {unit or 'units'}, the distance of the two vertices that "
        "are farthest apart in the first frame"
    )
    return words if unit else f"{words}; the unit is that of the file, which does not name it"


def _size_words(evaluation: Evaluation, unit: str) -> str:
    """D; where only a part is compared, that of the whole face, and the size of the part."""
    own = evaluation.truth.mesh.diameter
    if evaluation.extent is None:
        return diameter_words(own, unit)
    return (
        f"D = {significant(evaluation.diameter)} {unit or 'units'}, the size of the whole face; "
        f"the parts compared here measure {significant(own)}"
    )


def _motion_words(truth: MeshSequence, about: About) -> str:
    times = truth.times
    steps = np.diff(times)
    even = bool(np.ptp(steps) <= 1e-6)
    words = f"{counted(len(truth), 'frame')} at t = 0 to 1"
    if len(times) <= _NAMED:
        words = f"{counted(len(truth), 'frame')} at t = {', '.join(f'{t:.3g}' for t in times)}"
    elif even:
        words += f", {steps[0]:.3g} apart"
    else:
        words += f", {steps.min():.3g} to {steps.max():.3g} apart"
    if not about.timing_known:
        words += "; only the way is known, the times are made up"
    return words


def _missing_words(truth: MeshSequence) -> str:
    return (
        f"the numbering leaves out {first_few(truth.missing, _NAMED)}; the frames there are keep "
        "the times of their numbers"
    )
