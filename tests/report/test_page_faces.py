"""What the pictures of a report say of themselves is so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from elastomorph.draw.pictures import Image
from elastomorph.evaluation import Evaluation, evaluate
from elastomorph.evaluation.shape import ClosureSeam, Shape
from elastomorph.evaluation.words import Lengths
from elastomorph.model.sequence import MeshSequence
from elastomorph.report.faces import evaluation_pictures, look_alikes, telling_frame
from elastomorph.report.walkthrough import closures_picture
from small_meshes import grid


def test_faces_that_nobody_could_tell_apart_share_a_row(evaluation: Evaluation) -> None:
    """R = 1 is the straight line, R = 2 close to the ease; an unforced mean is another path."""
    found = look_alikes(evaluation)
    assert found["linear"] == ["linear", "beam R=1"]
    assert sum(len(group) for group in found.values()) == len(evaluation.results)
    times = evaluation.truth.times
    for label, group in found.items():
        own = evaluation[label].morph.at(times)
        for other in group:
            gap = np.linalg.norm(evaluation[other].morph.at(times) - own, axis=2).max()
            assert gap <= 2.5e-3 * evaluation.diameter
        for stranger in found:
            if stranger != label:
                gap = np.linalg.norm(evaluation[stranger].morph.at(times) - own, axis=2).max()
                assert gap > 2.5e-3 * evaluation.diameter


def test_the_moment_shown_is_the_worst_of_the_straight_line(evaluation: Evaluation) -> None:
    frame = telling_frame(evaluation)
    errors = [
        np.linalg.norm(evaluation["linear"].morph.at(float(time)) - truth, axis=1).max()
        for time, truth in zip(evaluation.truth.times, evaluation.truth.frames, strict=True)
    ]
    assert errors[frame] == pytest.approx(max(errors))


def test_the_words_on_closures_are_measured(evaluation: Evaluation) -> None:
    morph = evaluation.results[0].morph
    seams = [
        ClosureSeam("limit", morph, Shape(seam=0.0001)),
        ClosureSeam("unforced", morph, Shape(seam=0.03)),
    ]
    picture = closures_picture(np.zeros((2, 2, 3), dtype=np.uint8), "jawOpen", seams)
    said = picture.caption.replace("\u00a0", " ")
    assert "up to 3.00 % of D under unforced, 0.0100 % of D under limit" in said


def test_in_betweens_are_shown_at_the_nine_times_of_the_paper(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Fig. 6: t = 0.1 to 0.9, here with both ends beside them, also of a take of more frames."""
    mesh, times = grid(5, 4), np.linspace(0, 1, 21)
    frames = mesh.vertices + times[:, None, None] ** 2 * [0.0, 0.0, 1.0]
    drawn: dict[str, Any] = {}

    def strip(rows: object, times: object, **_: object) -> Image:
        drawn.update(rows=rows, times=times)
        return np.zeros((9, 9, 3), dtype=np.uint8)

    monkeypatch.setattr("elastomorph.report.faces.face_strip", strip)
    found = evaluate(MeshSequence(mesh, frames, times), ["linear"])
    picture = evaluation_pictures(found, Lengths(found.diameter, ""))[0]
    assert "at t = 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1. The first" in picture.alt
    (_, truth), (_, straight) = drawn["rows"].values()
    np.testing.assert_allclose(drawn["times"], np.arange(11) / 10, atol=1e-12)
    np.testing.assert_allclose(truth, frames[::2])
    np.testing.assert_allclose(straight[:, 0, 2] - mesh.vertices[0, 2], np.arange(11) / 10)
