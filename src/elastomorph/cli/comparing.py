"""What ``evaluate`` compares, and the files and pages it writes of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastomorph.cli import options
from elastomorph.cli.output import Say
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.character import Settings
    from elastomorph.curves import CurveNetwork
    from elastomorph.evaluation import Evaluation
    from elastomorph.evaluation.confidence import Confidence
    from elastomorph.io.sequences import Recording
    from elastomorph.model.morph import Morph
    from elastomorph.model.sequence import MeshSequence
    from elastomorph.paths import Method
    from elastomorph.physics import Material
    from elastomorph.report import About
    from elastomorph.rivals import Comparison

_MOST_INBETWEENS = 3
_LONG = 200
_LONG_WORDS = (
    "A take this long holds several movements, and no path between its two ends can follow them: "
    "--movements judges each onset and offset by itself."
)


def read_motion(
    truth: str, keep: Path | None, clip: str | None = None
) -> tuple[Recording, CurveNetwork]:
    """A recorded motion, or one of markers, and its curves."""
    from elastomorph.io.sequences import read_recording

    found = read_recording(truth, clip=clip)
    return found, options.network(found.motion.mesh, keep, found.names)


def confidence_for(
    truth: str, recording: Recording, named: Path | None, least: float | None
) -> Confidence | None:
    """The confidence of a motion as a mask: that of the file named, or of the one beside it."""
    from elastomorph.evaluation.confidence import LEAST
    from elastomorph.evaluation.evaluation import confidence_in
    from elastomorph.io.npz.confidence import confidence_beside

    found = confidence_beside(truth) if named is None else named
    if found is None and least:
        raise ParameterError(
            "--least-confidence is for recordings with a confidence.npz beside them: name one "
            "with --confidence, or leave it out"
        )
    return confidence_in(recording, found, LEAST if least is None else least)


@dataclass(frozen=True)
class Asked:
    """What the comparison is to be made of, and the report that is wanted, if any."""

    named: list[str]
    every: bool
    material: Material
    network: CurveNetwork
    mask: Confidence | None
    keep: Path | None
    report: Path | None
    unit: str
    call: str
    pictures: bool
    say: Say
    rivals: bool = False

    def methods(
        self, motion: MeshSequence, mask: Confidence | None = None
    ) -> dict[str, Method | Morph]:
        """The methods for one motion by their labels: those named, or all and those named."""
        from elastomorph.evaluation.evaluation import every_method, method_of

        how: dict[str, Any] = {
            "material": self.material,
            "confidence": mask,
            "progress": self.say,
        }
        found: dict[str, Method | Morph] = {}
        for text in self.named:
            label, method = method_of(text, motion, self.network, **how)
            if label in found:
                raise ParameterError(f"the method {text!r} was given twice")
            found[label] = method
        return every_method(motion, self.network, **how) | found if self.every else found

    def about(
        self,
        source: str,
        truth: MeshSequence,
        methods: Mapping[str, Method | Morph],
        *,
        movements: bool = False,
    ) -> About:
        """What the report says of its making."""
        from elastomorph.evaluation import left_out
        from elastomorph.report import About

        long = not movements and len(truth) >= _LONG
        remarks = [_LONG_WORDS if long else "", left_out(truth) if self.every else ""]
        said: dict[str, Any] = {"unit": self.unit, "call": self.call, "methods": methods}
        said["remarks"] = tuple(filter(None, remarks))
        about = About(Path(source).name or source, **said)
        if self.keep is None:
            return about
        rest = ", and the rest of the face traced along its edges" if len(truth.mesh.faces) else ""
        return replace(about, curves=f"the artists' curves of {self.keep.name}{rest}")


def compared(
    asked: Asked,
    source: str,
    motion: MeshSequence,
    character: Settings | None,
    output: Path | None,
) -> tuple[Evaluation, list[str], Comparison | None]:
    """The comparison, the files and the report that were asked for, written, and the rivals."""
    from elastomorph.character import settings_tables
    from elastomorph.evaluation import evaluate as compare
    from elastomorph.io.atomic import made_folder

    methods = asked.methods(motion, asked.mask)
    if output is not None:
        made_folder(output)
    how: dict[str, Any] = {"confidence": asked.mask, "progress": asked.say}
    result = compare(motion, methods, asked.network, **how)
    beside = None
    if asked.rivals:
        from elastomorph.rivals import RIVALS, with_rivals

        beside = with_rivals(result, RIVALS, progress=asked.say)
        result = beside.evaluation
    if character is not None:
        result = replace(result, settings=settings_tables(character))
    drawn, written = None, []
    if output is not None:
        from elastomorph.evaluation.summary import informed_methods
        from elastomorph.evaluation.words import Lengths
        from elastomorph.report.comparison import write_evaluation
        from elastomorph.report.faces import evaluation_pictures

        drawn = []
        if asked.pictures and len(motion.mesh.faces):
            lengths, informed = Lengths(result.diameter, asked.unit), informed_methods(result)
            drawn = evaluation_pictures(result, lengths, informed, asked.say)
        write_evaluation(result, output, graphs=asked.pictures, faces=drawn, say=asked.say)
        written.append(f"{output}/")
    if asked.report is not None:
        from elastomorph.evaluation import suggest_inbetweens
        from elastomorph.evaluation.confidence import counted_of
        from elastomorph.report import write_report

        count = min(_MOST_INBETWEENS, len(motion) - 2)
        how = {"curves": result.curves, "counted": counted_of(asked.mask), "progress": asked.say}
        found = suggest_inbetweens(motion, count, **how) if count else []
        how = {"suggestions": found, "faces": drawn, "draw": asked.pictures, "say": asked.say}
        write_report(result, asked.report, asked.about(source, motion, methods), **how)
        written.append(str(asked.report))
    return result, written, beside
