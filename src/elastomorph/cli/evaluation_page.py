"""The report that ``elastomorph evaluate`` writes when it is asked for one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from elastomorph.evaluation import Evaluation
    from elastomorph.evaluation.movements import JudgedMovement
    from elastomorph.model.sequence import MeshSequence
    from elastomorph.report import About, Picture

__all__ = ["EvaluationPage"]

_MOST_INBETWEENS = 3
_LONG = 200
_LONG_WORDS = (
    "A take this long holds several movements, and no path between its two ends can follow them: "
    "--movements judges each onset and offset by itself."
)


@dataclass(frozen=True)
class EvaluationPage:
    """What the command line knows of a report before anything is compared.

    Attributes:
        path: Where it goes; None for no report.
        call: The command.
        truth: The frames, as they were named.
        unit: Unit of the coordinates, or an empty string.
        curves: The file with artists' curves, if any.
        draw: Draw graphs, faces and the viewer.
        every: Whether every method was asked for, so that it is said which ones are missing.
    """

    path: Path | None
    call: str
    truth: str
    unit: str
    curves: Path | None
    draw: bool
    every: bool

    @property
    def names(self) -> list[str]:
        """The file written, if any."""
        return [] if self.path is None else [str(self.path)]

    def drawn(self, result: Evaluation, say: Callable[[str], None]) -> list[Picture]:
        """Pictures of the comparison, for the report and for files; none of markers."""
        from elastomorph.evaluation.summary import informed_methods
        from elastomorph.evaluation.words import Lengths
        from elastomorph.report.faces import evaluation_pictures

        if not self.draw or not len(result.truth.mesh.faces):
            return []
        lengths = Lengths(result.diameter, self.unit)
        return evaluation_pictures(result, lengths, informed_methods(result), say)

    def write(
        self,
        result: Evaluation,
        methods: Mapping[str, Any],
        say: Callable[[str], None],
        faces: Sequence[Picture] | None = None,
    ) -> None:
        """Write the report of one motion, if there is to be one, with faces drawn already."""
        if self.path is None:
            return
        from elastomorph.evaluation import suggest_inbetweens
        from elastomorph.report import write_report

        truth = result.truth
        count = min(_MOST_INBETWEENS, len(truth) - 2)
        suggestions = (
            suggest_inbetweens(truth, count, curves=result.curves, progress=say) if count else []
        )
        write_report(
            result,
            self.path,
            self._about(truth, methods),
            suggestions=suggestions,
            faces=faces,
            draw=self.draw,
            say=say,
        )

    def write_movements(
        self, judged: Sequence[JudgedMovement], take: MeshSequence, methods: Mapping[str, Any]
    ) -> None:
        """Write the report of a take's movements, if there is to be one."""
        if self.path is None:
            return
        from elastomorph.report import write_movements_report

        about = self._about(take, methods, movements=True)
        write_movements_report(judged, take, self.path, about, draw=self.draw)

    def _about(
        self, truth: MeshSequence, methods: Mapping[str, Any], *, movements: bool = False
    ) -> About:
        from elastomorph.evaluation import left_out
        from elastomorph.report import About

        name = Path(self.truth).name or self.truth
        traced = "traced along the edges of the polygons, every vertex on one curve"
        if self.curves is not None:
            traced = f"the artists' curves of {self.curves.name}"
            if len(truth.mesh.faces):
                traced += ", and the rest of the face traced along its edges"
        remarks = [_LONG_WORDS] if not movements and len(truth) >= _LONG else []
        if self.every and not len(truth.mesh.faces):
            remarks.append(left_out(truth))
        return About(
            name,
            unit=self.unit,
            call=self.call,
            curves=traced,
            methods=methods,
            remarks=tuple(remarks),
        )
