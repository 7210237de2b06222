"""What each target of a rig needs: decided by `auto`, counted and priced here."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.doctor import Thresholds
from elastomorph.evaluation.target_paths import TargetPath, TargetPaths, _flips, target_paths
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Choice, Morph
from small_meshes import grid


def sheet() -> em.Mesh:
    """5 by 5 vertices, one apart."""
    return grid(5, 5)


@pytest.fixture(scope="module")
def paths() -> TargetPaths:
    """One target slides the sheet, the other turns it by 60° about an edge."""
    neutral = sheet()
    turned = Rotation.from_rotvec([0, np.pi / 3, 0]).apply(neutral.vertices.copy())
    slid = neutral.vertices + [0.3, 0, 0]
    targets = {"slide": neutral.with_vertices(slid), "turn": neutral.with_vertices(turned)}
    return target_paths(neutral, targets)


def test_what_slides_goes_straight_and_what_turns_turns(paths: TargetPaths) -> None:
    """Those that need most come first; the middle of the chord is r (1 - cos 30°) off the arc."""
    turn, slide = paths.targets
    assert (turn.name, slide.name) == ("turn", "slide")
    sagitta = 4 * (1 - np.cos(np.pi / 6))
    assert paths.extent == pytest.approx(np.hypot(4, 4))
    assert turn.choice.distance == pytest.approx(sagitta / paths.extent, rel=1e-3)
    assert not turn.choice.straight
    assert turn.bends > 0
    assert 0 < turn.bake_error <= 1e-4
    assert slide.choice.straight
    assert (slide.bends, slide.bytes, slide.bake_error) == (0, 0, 0.0)


def test_what_it_costs(paths: TargetPaths) -> None:
    """An index and three numbers of 4 bytes for each of the 20 vertices off the axis, a bend."""
    turn = paths.targets[0]
    assert turn.bytes == 16 * turn.moved
    assert turn.moved <= 25 * turn.bends
    assert turn.moved >= 20


def test_where_the_ways_part_far_an_in_between_decides(paths: TargetPaths) -> None:
    turn, slide = paths.targets
    assert turn.words == "rotation; an in-between would pay here"
    assert slide.words == "straight is enough"
    assert paths.summary == (
        f"Of 2 targets 1 may go straight and 1 need rotation, which costs {turn.bends} more morph "
        f"targets ({turn.bytes / 1e6:.2g} MB); an in-between would pay for turn."
    )


def test_what_folds_either_way_wants_an_in_between() -> None:
    """Even where the ways hardly part: no law of ours mends it."""
    folded = TargetPath("roll", Choice(1e-4, 5e-4), 0, 0, 0.0, flips=3)
    assert folded.words == "straight is enough; an in-between would pay here"


def test_folds_are_counted() -> None:
    """A triangle that turns by 180° in its plane, on straight lines, is a point halfway: no fold.

    Before it looks like the neutral and after it like the target, which both face up. A corner
    that swings below the edge of the other two and back turns it over.
    """
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    neutral = em.Mesh(corners, [[0, 1, 2]])
    for moved, flips in ((-corners, 0), (corners + [0, 0, 1], 0)):
        path = em.interpolate(neutral, neutral.with_vertices(moved), "linear")
        assert _flips(path) == flips
    bend = np.zeros((1, 3, 3))
    bend[0, 2, 1] = -8.0
    swing = Morph(neutral, neutral, bend, (BendCurve.polynomial([0.0, 1.0, -1.0]),))
    assert _flips(swing) == 1


def test_progress_names_targets() -> None:
    said: list[str] = []
    neutral = sheet()
    moved = neutral.with_vertices(neutral.vertices + [0, 0, 1])
    target_paths(neutral, {"up": moved, "down": moved}, progress=said.append)
    assert said == ["choosing a path for up, 1 of 2", "choosing a path for down, 2 of 2"]


def test_the_doctor_asks_for_an_in_between_where_the_report_does() -> None:
    """The same distance of the two ways, whoever looks at them."""
    allowed = Choice(distance=Thresholds().bend, allowed=5e-4)
    beyond = Choice(distance=float(np.nextafter(allowed.distance, 1.0)), allowed=5e-4)
    for choice, pays in ((allowed, False), (beyond, True)):
        path = TargetPath("jawOpen", choice, 1, 8, 0.0, 0)
        assert path.inbetween_pays == pays
