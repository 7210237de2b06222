"""Weights that run together with one time."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from elastomorph.draw.camera import turn_angles
from elastomorph.draw.posed import (
    PosedRig,
    clip_frames,
    compare,
    pose_picture,
    pose_strip,
    swing,
    with_paths,
)
from elastomorph.draw.sheet import Style
from elastomorph.draw.stage import BACKGROUND
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.paths import Method, prepare
from elastomorph.rig import Rig
from elastomorph.rig.timing import by_name, from_keys
from small_head import head, shapes


@pytest.fixture(scope="module")
def rig() -> Rig:
    """A square whose corners go to different places; c corrects a and b together."""
    neutral = Mesh([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    steps = np.random.default_rng(1).normal(size=(4, 4, 3))
    to = prepare(neutral, "ease:2")
    morphs = {
        name: to(neutral.with_vertices(neutral.vertices + step))
        for name, step in zip("abcd", steps, strict=True)
    }
    return Rig(neutral, morphs, correctives={"c": ("a", "b")})


def test_every_path_is_at_its_weight_times_t(rig: Rig) -> None:
    posed = PosedRig("", rig, {"a": 0.8, "d": 1.5})
    np.testing.assert_allclose(posed.at(0.5), rig.pose({"a": 0.4, "d": 0.75}))
    np.testing.assert_allclose(posed.at(0.0), rig.neutral.vertices)
    with pytest.raises(ParameterError, match="finite"):
        posed.at(float("nan"))


@pytest.mark.parametrize("sliders", [{"a": 0.7}, {"a": 0.7, "b": 0.4}, {"d": 1.0, "b": 0.2}, {}])
def test_other_paths_to_the_same_targets(rig: Rig, sliders: dict[str, float]) -> None:
    """Straight ones are the sum of weighted displacements; correctives are kept where they act."""
    other = with_paths(rig, Method.parse("linear"), sliders)
    expected = rig.neutral.vertices.copy()
    for name, weight in sliders.items():
        expected += weight * rig.morphs[name].delta
    expected += sliders.get("a", 0) * sliders.get("b", 0) * rig.morphs["c"].delta
    np.testing.assert_allclose(other.pose(sliders), expected, atol=1e-12)
    same = with_paths(rig, Method.parse("ease:2"), sliders)
    np.testing.assert_allclose(same.pose(sliders), rig.pose(sliders), atol=1e-12)
    still = set(rig.morphs) - {*sliders, "c"}
    assert all(other.morphs[name] is rig.morphs[name] for name in still)


def test_unknown_sliders(rig: Rig) -> None:
    with pytest.raises(ParameterError, match="no slider"):
        with_paths(rig, Method.parse("linear"), {"e": 1.0})


def test_there_and_back_is_a_loop() -> None:
    times = swing(8, by_name("linear"))
    np.testing.assert_allclose(times, [0, 0.25, 0.5, 0.75, 1, 0.75, 0.5, 0.25])
    smooth = swing(50, by_name("smoothstep"), 0.6)
    assert smooth[0] == 0
    assert smooth[25] == pytest.approx(0.6)
    np.testing.assert_allclose(smooth[1:], smooth[1:][::-1])
    around = np.diff(np.append(smooth, smooth[0]))
    assert np.abs(around).max() < 0.6 * 1.5 / 25 + 1e-9  # the steepest slope of smoothstep is 3/2
    np.testing.assert_allclose(swing(1, by_name("linear")), [0])


def test_a_timing_that_comes_back_is_played_once() -> None:
    keys = from_keys([(0, 0), (0.25, 1), (1, 0)])
    times = swing(4, keys)
    np.testing.assert_allclose(times, keys.at([0, 0.25, 0.5, 0.75]))
    blink = swing(20, by_name("blink:0.3"))
    assert int(blink.argmax()) == 6


SIZE = (120, 150)
PAPER = np.rint(np.array(BACKGROUND) * 255)


def _covered(image: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return (np.abs(image.astype(float) - PAPER) > 8).any(axis=2)


@pytest.fixture(scope="module")
def posed() -> PosedRig:
    """The small head, opening its jaw."""
    to = prepare(head(), "beam:2")
    return PosedRig("beam", Rig(head(), {"jawOpen": to(shapes()["jawOpen"])}), {"jawOpen": 1.0})


@pytest.fixture(scope="module")
def straight(posed: PosedRig) -> PosedRig:
    to = prepare(head(), "linear")
    return PosedRig("linear", Rig(head(), {"jawOpen": to(shapes()["jawOpen"])}), posed.weights)


def test_a_face_fills_the_picture_and_changes_with_the_pose_where_it_moves(
    posed: PosedRig,
) -> None:
    closed, half, wide = (pose_picture(posed, t, size=SIZE) for t in (0.0, 0.5, 1.0))
    assert closed.shape == (150, 120, 3)
    assert 0.4 < _covered(closed).mean() < 0.9
    upper, lower = slice(0, 60), slice(75, 150)
    # one camera for the whole path: the forehead stays, the mouth opens further and further
    np.testing.assert_allclose(closed[upper], wide[upper], atol=2)
    far = np.abs(wide[lower].astype(int) - closed[lower]).mean()
    near = np.abs(half[lower].astype(int) - closed[lower]).mean()
    assert far > near > 0.5


def test_a_clip_is_the_stills_at_its_times(posed: PosedRig) -> None:
    frames = list(clip_frames(posed, [0.0, 0.5, 1.0], size=SIZE))
    for t, frame in zip([0.0, 0.5, 1.0], frames, strict=True):
        np.testing.assert_array_equal(frame, pose_picture(posed, t, size=SIZE))


def test_a_turn_begins_in_front_and_goes_once_round(posed: PosedRig) -> None:
    frames = list(clip_frames(posed, [0.0] * 4, turn_angles(4), size=SIZE))
    outlines = [_covered(frame) for frame in frames]
    assert (outlines[1] == outlines[3][:, ::-1]).mean() > 0.99
    assert (outlines[0] == outlines[0][:, ::-1]).mean() > 0.99
    assert (outlines[1] == outlines[1][:, ::-1]).mean() < 0.97
    # lips in front, none behind
    lips = [(frame[..., 0] > 1.35 * frame[..., 1].astype(float)).sum() for frame in frames]
    assert lips[0] > 20
    assert lips[2] == 0


def test_frames_are_drawn_when_they_are_asked_for(posed: PosedRig) -> None:
    """So a clip of any length takes the memory of one frame."""
    asked: list[float] = []

    class Watched(PosedRig):
        def at(self, t: float) -> NDArray[np.float64]:
            asked.append(t)
            return super().at(t)

    times = [0.301 + 0.001 * number for number in range(400)]
    frames = clip_frames(Watched("", posed.rig, posed.weights), times, size=(32, 40))
    assert not asked
    next(frames)
    next(frames)
    assert asked[-2:] == times[:2]
    assert len(asked) < 20
    frames.close()


def test_distances_have_their_statistics_and_one_scale(posed: PosedRig, straight: PosedRig) -> None:
    times = [0.0, 0.5, 1.0]
    found = compare([posed], times, "linear", straight.at, unit="cm")
    distances = [np.linalg.norm(posed.at(t) - straight.at(t), axis=1) for t in times]
    assert found.largest == pytest.approx(np.max(distances))
    assert found.mean == pytest.approx(np.mean(distances))
    assert found.scale.highest >= found.largest
    share = 100 * found.largest / head().diameter
    assert f"{share:.2g} % of D" in found.scale.label
    assert "cm" in found.scale.label
    image = pose_picture(posed, 0.5, size=(240, 300), comparison=found)
    assert image.shape == (300, 240, 3)
    # the chin is coloured, the forehead is pale
    assert image[190:215, 110:130].mean() < 0.6 * image[40:60, 110:130].mean()
    with pytest.raises(ParameterError, match="above 0"):
        compare([posed], times, "linear", straight.at, highest=0.0)
    with pytest.raises(ParameterError, match="legend"):
        pose_picture(posed, 0.5, size=(64, 24), comparison=found)
    with pytest.raises(ParameterError, match="transparent"):
        pose_picture(posed, 0.5, style=Style(background=None), comparison=found)


def test_a_strip_has_a_row_for_each_rig_and_a_column_for_each_time(
    posed: PosedRig, straight: PosedRig
) -> None:
    face = (60, 75)
    one = pose_strip([posed], [0.0, 1.0], face=face)
    two = pose_strip([posed, straight], [0.0, 0.5, 1.0], face=face, title="jawOpen 1")
    assert one.shape[0] >= 75
    assert one.shape[1] >= 2 * 60
    assert two.shape[0] >= one.shape[0] + 75
    assert two.shape[1] >= 3 * 60
    found = compare([posed, straight], [0.0, 0.5, 1.0], "linear", straight.at)
    heat = pose_strip(
        [posed, straight],
        [0.0, 0.5, 1.0],
        face=face,
        comparison=found,
    )
    assert heat.shape[0] > two.shape[0]
    with pytest.raises(ParameterError, match="strip"):
        pose_strip([posed], [])
    with pytest.raises(ParameterError, match="transparent"):
        pose_strip([posed], [0.5], style=Style(background=None))


def test_angles_must_fit_the_times(posed: PosedRig) -> None:
    with pytest.raises(ParameterError, match="2 angles"):
        next(clip_frames(posed, [0.0, 1.0], [0.0], size=SIZE))


def test_a_mesh_without_sliders_is_drawn_too(sphere: Mesh) -> None:
    image = pose_picture(PosedRig("", Rig(sphere, {}), {}), 1.0, size=SIZE)
    assert _covered(image).mean() > 0.4
