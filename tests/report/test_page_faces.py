"""What the pictures of a report say of themselves is so."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.evaluation import Evaluation
from elastomorph.evaluation.shape import ClosureSeam, Shape
from elastomorph.report.faces import look_alikes, telling_frame
from elastomorph.report.walkthrough_page import closures_picture


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
