"""What an evaluation found: one result a method, and ways to print, store and draw them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError
from elastomorph.evaluation.confidence import (
    Confidence,
    coverage_words,
    mean_covered,
)
from elastomorph.evaluation.curve_errors import CurveErrors, CurveVertices, inner_mean
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence

if TYPE_CHECKING:
    from pandas import DataFrame
    from rich.console import Group


@dataclass(frozen=True, eq=False, repr=False)
class MethodResult(CurveErrors):
    """How one method did. All errors are fractions of D, the diameter of the neutral.

    With free timing `path_lme` and `path_lae` are the smallest that any order of moments reaches,
    each at moments of its own, so neither is larger than at the captured times. `path_mean_lme`
    and `path_mean_lae` are the means at these same moments.

    Attributes:
        label: Name of the method.
        morph: Its path.
        average: (C, T) E_A of each curve in each frame (Eq. 35 with the norm).
        maximum: (C, T) E_M of each curve in each frame.
        path_times: (T,) the moments of the path at which `path_lme` is smallest, see `free_timing`.
        path_average_times: (T,) the moments at which `path_lae` is smallest.
        path_average: (C, T) E_A at ``path_average_times``.
        path_maximum: (C, T) E_M at ``path_times``.
        seam: Largest jump between two curves, over the frames; see `Shape`.
        flips: Polygons turned over in the worst frame.
        stretch: Largest ratio of edge lengths, over the frames.
        informed: Whether it was given frames of the recording besides its ends.
        unmasked_lme: `lme` of all vertices, where the others leave out those of low confidence.
        unmasked_lae: `lae` of all vertices, likewise.
    """

    label: str
    morph: Morph
    average: NDArray[np.float64]
    maximum: NDArray[np.float64]
    path_times: NDArray[np.float64]
    path_average_times: NDArray[np.float64]
    path_average: NDArray[np.float64]
    path_maximum: NDArray[np.float64]
    seam: float
    flips: int
    stretch: float
    informed: bool = False
    unmasked_lme: float | None = None
    unmasked_lae: float | None = None

    @property
    def path_lme(self) -> float:
        """Largest maximum error over curves and times with free timing."""
        return float(self.path_maximum.max())

    @property
    def path_lae(self) -> float:
        """Largest average error over curves and times with free timing."""
        return float(self.path_average.max())

    @property
    def path_mean_lme(self) -> float:
        """Mean over the inner times of the largest maximum error, at ``path_times``."""
        return inner_mean(self.path_maximum)

    @property
    def path_mean_lae(self) -> float:
        """Mean over the inner times of the largest average error, at ``path_average_times``."""
        return inner_mean(self.path_average)

    def __repr__(self) -> str:
        return (
            f"MethodResult({self.label}: LME {self.lme:.3%}, LAE {self.lae:.3%}, "
            f"with free timing {self.path_lme:.3%}, {self.path_lae:.3%} of D)"
        )


@dataclass(frozen=True, eq=False, repr=False)
class Evaluation:
    """Methods compared with one recorded motion.

    Attributes:
        truth: The motion.
        curves: The curves along which errors are measured.
        results: One for each method, in the order they were given.
        settings: The settings of the character they were made with, as JSON, where there are any.
        extent: D, where it is not that of the first frame: the size of the whole that it is part
            of.
        confidence: How far vertices are to be trusted, where only some of them counted.
    """

    truth: MeshSequence
    curves: CurveNetwork
    results: tuple[MethodResult, ...]
    settings: Mapping[str, Any] | None = None
    extent: float | None = None
    confidence: Confidence | None = None

    @property
    def diameter(self) -> float:
        """D, in the unit of the vertices."""
        return self.truth.mesh.diameter if self.extent is None else self.extent

    def __getitem__(self, label: str) -> MethodResult:
        """The result of the method with this label.

        Raises:
            ParameterError: There is none.
        """
        for result in self.results:
            if result.label == label:
                return result
        known = ", ".join(result.label for result in self.results)
        raise ParameterError(f"no method {label!r} was evaluated; there are: {known}")

    @property
    def covered(self) -> float:
        """Share of the vertices of curves that count in the frames between the first and last."""
        if self.confidence is None:
            return 1.0
        return mean_covered(self.confidence.covered(self._along))

    @property
    def coverage(self) -> str:
        """How much of the vertices count, in a sentence; empty where all do."""
        if self.confidence is None:
            return ""
        return coverage_words(self.confidence, self._along, self.truth)

    @property
    def _along(self) -> CurveVertices:
        return CurveVertices.of(self.curves, len(self.truth.mesh.vertices))

    def table(self) -> Group:
        """The table of the methods and what it shows, to print with rich."""
        from elastomorph.evaluation.table import evaluation_table

        return evaluation_table(self)

    def to_csv(self, path: str | Path | None = None) -> str:
        """One line a method, errors as fractions of D.

        Args:
            path: File to write the text to as well, whole or not at all.

        Raises:
            FileError: The file cannot be written.
        """
        from elastomorph.evaluation.table import csv_text

        return _kept(csv_text(self, long=False), path)

    def to_long_csv(self, path: str | Path | None = None) -> str:
        """One line for each method, curve and frame, errors as fractions of D.

        Arguments and errors as for `to_csv`.
        """
        from elastomorph.evaluation.table import csv_text

        return _kept(csv_text(self, long=True), path)

    def to_json(self, path: str | Path | None = None) -> str:
        """Everything measured, as strict JSON. Arguments and errors as for `to_csv`."""
        from elastomorph.evaluation.table import evaluation_json

        return _kept(evaluation_json(self), path)

    def to_dataframe(self, *, long: bool = False) -> DataFrame:
        """The table for pandas: one row a method, errors as fractions of D.

        Args:
            long: One row for each method, curve and frame instead, as `to_long_csv`.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        from elastomorph.evaluation.table import data_frame

        return data_frame(self, long)

    def plot(self, path: str | Path) -> None:
        """Draw the error of each method over curves and over time.

        Args:
            path: Picture to write; its suffix chooses the format.

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        # An upward import: pictures belong to report, and a user with an evaluation in hand looks
        # for them here.
        from elastomorph.draw.graphs import error_graphs

        error_graphs(self, path)

    def report(self, path: str | Path, name: str = "face") -> None:
        """Write one HTML page with the tables, graphs and faces, and a viewer among them.

        Args:
            path: Page to write.
            name: What was recorded, for the title.

        Raises:
            FileError: The page cannot be written.
            MissingExtraError: matplotlib, vtk or Pillow is not installed.
        """
        from elastomorph.report import About, write_report

        write_report(self, path, About(name=name))

    def _repr_html_(self) -> str:
        """The table and what it shows, for a notebook."""
        from elastomorph.evaluation.table import evaluation_html

        return evaluation_html(self)

    def __str__(self) -> str:
        from elastomorph.evaluation.table import plain_text

        return plain_text(self.table())

    def __repr__(self) -> str:
        return (
            f"Evaluation({len(self.results)} methods, {len(self.curves)} curves, "
            f"{len(self.truth)} frames)"
        )


def _kept(text: str, path: str | Path | None) -> str:
    """The text, written to a file too where one is named."""
    if path is not None:
        from elastomorph.io.atomic import replacing

        with replacing(path) as file:
            file.write(text.encode())
    return text
