"""A take of markers becomes weights, whatever the head does, the unit is, or a marker lacks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.rig import Rig

FRAMES = 14
SCALE = 12.5


@pytest.fixture(scope="module")
def wide(many: Callable[[int, float, float], Rig]) -> Rig:
    """Thirty vertices and six gently bent morphs."""
    return many(6, 0.4, 0.1)


@pytest.fixture(scope="module")
def weights() -> np.ndarray:
    """A slow rise and fall of four of six sliders; in the first frame all are at rest."""
    phase = np.linspace(0, np.pi, FRAMES)[:, None] * [1.0, 0.7, 0.5, 1.0]
    moving = np.sin(phase) ** 2 * [0.9, 0.5, 0.7, 0.3]
    return np.concatenate([moving, np.zeros((FRAMES, 2))], axis=1)


@pytest.fixture(scope="module")
def head() -> tuple[np.ndarray, np.ndarray]:
    """Rotations and offsets of a head that nods and walks."""
    way = np.linspace(0, 1, FRAMES)[:, None]
    return Rotation.from_rotvec(way * [0.5, -0.3, 1.2]).as_matrix(), way * [40.0, 5.0, -80.0]


@pytest.fixture(scope="module")
def markers(wide: Rig, weights: np.ndarray, head: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    faces = wide.batch(weights, dtype=np.float64)
    return SCALE * np.einsum("fij,fmj->fmi", head[0], faces) + head[1][:, None]


def test_weights_head_and_scale_are_found(
    wide: Rig, weights: np.ndarray, head: tuple[np.ndarray, np.ndarray], markers: np.ndarray
) -> None:
    found = wide.track(markers, range(30), smooth=0, prior=1e-8)
    np.testing.assert_allclose(found.weights, weights, atol=1e-4)
    np.testing.assert_allclose(found.rotations, head[0], atol=1e-4)
    np.testing.assert_allclose(found.offsets, head[1], atol=1e-2)
    assert found.scale == pytest.approx(SCALE, rel=1e-5)
    assert np.abs(found.distances).max() < 1e-3
    assert str(found).startswith("14 frames, scale 12.5, ")


def test_a_take_on_paths_without_speed_at_rest_is_found(wide: Rig, weights: np.ndarray) -> None:
    """On V0 + t² Δ every face of V0 + t Δ is at the roots of its weights."""
    slow = em.BendCurve.power(2)
    eased = {
        name: em.Morph(wide.neutral, morph.target, morph.delta[None], (slow,))
        for name, morph in wide.morphs.items()
    }
    straight = np.einsum("fj,jvc->fvc", weights, np.stack([m.delta for m in wide.morphs.values()]))
    markers = SCALE * (wide.neutral.vertices + straight)
    found = Rig(wide.neutral, eased).track(markers, range(30), smooth=0, prior=1e-8)
    np.testing.assert_allclose(found.weights, np.sqrt(weights), atol=1e-3)
    assert found.scale == pytest.approx(SCALE, rel=1e-3)


def test_missing_markers_are_missed_by_nobody(
    wide: Rig, weights: np.ndarray, markers: np.ndarray
) -> None:
    random = np.random.default_rng(3)
    taken = markers.copy()
    gone = random.random(taken.shape[:2]) < 0.2
    taken[gone] = np.nan
    found = wide.track(taken, range(30), smooth=0, prior=1e-8)
    np.testing.assert_allclose(found.weights, weights, atol=1e-3)
    np.testing.assert_array_equal(np.isnan(found.distances), gone)
    assert not found.trust[gone].any()


def test_markers_that_jump_are_left_out(
    wide: Rig, weights: np.ndarray, markers: np.ndarray
) -> None:
    taken = markers.copy()
    taken[3:6, 7] += [100.0, -40.0, 0.0]
    found = wide.track(taken, range(30), smooth=0, prior=1e-8)
    np.testing.assert_allclose(found.weights, weights, atol=0.02)
    assert found.trust[3:6, 7].max() < 0.01
    assert "far off and left out" in str(found)


def test_a_slider_that_two_markers_show_may_jump(wide: Rig) -> None:
    """Two of thirty markers that are far off together are no errors."""
    lifted = wide.neutral.vertices.copy()
    lifted[:2] += [0.0, 0.0, 1.0]
    brow = em.interpolate(wide.neutral, wide.neutral.with_vertices(lifted), "linear")
    rig = Rig(wide.neutral, {**wide.morphs, "brow": brow})
    weights = np.zeros((4, 7))
    weights[2:, -1] = 1.0
    found = rig.track(rig.batch(weights, dtype=np.float64), range(30))
    np.testing.assert_allclose(found.weights, weights, atol=0.02)


def test_frames_without_markers_are_between_their_neighbours(
    wide: Rig, markers: np.ndarray
) -> None:
    taken = markers.copy()
    taken[5:7, 3:] = np.nan
    found = wide.track(taken, range(30))
    steps = np.diff(found.weights[4:8], axis=0)
    np.testing.assert_allclose(steps, np.repeat(steps[:1], 3, axis=0), atol=1e-12)
    assert np.isnan(found.rotations[5:7]).all()
    assert np.isfinite(found.rotations[[4, 7]]).all()
    np.testing.assert_array_equal(found.between, [5, 6])
    assert str(found).endswith("; 2 frames with too few are between their neighbours")


def test_a_marker_that_is_never_seen_is_done_without(
    wide: Rig, weights: np.ndarray, markers: np.ndarray
) -> None:
    taken = markers.copy()
    taken[:, 3] = np.nan
    found = wide.track(taken, range(30), rest=0)
    np.testing.assert_allclose(found.weights, weights, atol=0.01)
    assert np.flatnonzero(np.isnan(found.left)).tolist() == [3]


def test_smoothness_lessens_noise(wide: Rig, weights: np.ndarray, markers: np.ndarray) -> None:
    noisy = markers + np.random.default_rng(4).normal(scale=0.1 * SCALE, size=markers.shape)
    rough, smooth = (wide.track(noisy, range(30), smooth=mu).weights for mu in (0.0, 1.0))
    assert np.abs(np.diff(smooth, axis=0)).sum() < np.abs(np.diff(rough, axis=0)).sum()
    assert np.square(smooth - weights).sum() < np.square(rough - weights).sum()


def test_a_frame_at_rest_takes_out_the_difference_of_faces(
    wide: Rig, weights: np.ndarray, head: tuple[np.ndarray, np.ndarray]
) -> None:
    """Another face with the same movements: frame 0 shows it at rest."""
    other = 0.2 * np.random.default_rng(5).normal(size=(30, 3))
    faces = wide.batch(weights, dtype=np.float64) + other
    taken = np.einsum("fij,fmj->fmi", head[0], faces) + head[1][:, None]
    plain, worn = (wide.track(taken, range(30), rest=rest).weights for rest in (None, 0))
    assert np.abs(worn - weights).max() < 0.05
    assert np.abs(worn - weights).max() < 0.3 * np.abs(plain - weights).max()


def test_places_may_be_landmarks_and_points_between_vertices(
    wide: Rig, weights: np.ndarray, markers: np.ndarray
) -> None:
    between = ((1, 2), (0.25, 0.75))
    taken = np.concatenate([markers, (markers[:, [1, 2]] * [[0.25], [0.75]]).sum(1)[:, None]], 1)
    found = wide.track(
        taken[:3], ["chin", *range(1, 30), between], landmarks={"chin": 0}, smooth=0, prior=1e-8
    )
    np.testing.assert_allclose(found.weights, weights[:3], atol=1e-3)


@pytest.mark.parametrize("rest", [None, 0])
def test_places_of_other_markers_are_told(
    wide: Rig, markers: np.ndarray, rest: int | None, recwarn: pytest.WarningsRecorder
) -> None:
    """Not where they are right; where left and right are exchanged, or each is its neighbour's."""
    wide.track(markers[:3], range(30), rest=rest)
    assert not recwarn
    for wrong in (markers[:3] * [-1, 1, 1], np.roll(markers[:3], 1, axis=1)):
        with pytest.warns(em.ElastomorphWarning, match="off their places on the rig"):
            wide.track(wrong, range(30), rest=rest)


def test_markers_fade_by_how_far_they_are_beside_the_middle_one(
    wide: Rig, weights: np.ndarray, markers: np.ndarray
) -> None:
    """1 / (1 + x²)² (Geman and McClure), x the distance over four times the middle one."""
    random = np.random.default_rng(8)
    off = random.normal(size=markers.shape)
    off *= (0.3 * SCALE * random.uniform(0.2, 1, size=(len(off), 30)) ** 2)[:, :, None]
    off[:, [4, 17]] *= 4.0
    found = wide.track(markers + off, range(30), rest=None)
    middle = np.median(found.distances, axis=1, keepdims=True)
    expected = (1 + (found.distances / (4 * middle)) ** 2) ** -2.0
    assert (expected < 0.5).sum() > 10
    np.testing.assert_allclose(found.trust, expected, atol=0.05)


def with_blink(wide: Rig, vertices: slice, size: float) -> Rig:
    """A seventh slider, that lifts some vertices only."""
    lifted = wide.neutral.vertices.copy()
    lifted[vertices, 2] += size
    blink = em.interpolate(wide.neutral, wide.neutral.with_vertices(lifted), "linear")
    return Rig(wide.neutral, {"blink": blink, **wide.morphs})


def test_sliders_that_no_marker_shows_are_named_and_left_out(
    wide: Rig, weights: np.ndarray, head: tuple[np.ndarray, np.ndarray]
) -> None:
    """A blink of 0.92 with no marker on the lids is not known, and not 0."""
    rig = with_blink(wide, slice(3), 1.0)
    blinking = np.insert(weights, 0, 0.92, axis=1)
    faces = rig.batch(blinking, dtype=np.float64)
    taken = SCALE * np.einsum("fij,fmj->fmi", head[0], faces) + head[1][:, None]
    found = rig.track(taken[:, 3:], range(3, 30), smooth=0, prior=1e-8)
    assert (found.names, found.unseen) == (wide.names, ("blink",))
    np.testing.assert_allclose(found.weights, weights, atol=1e-4)
    assert "1 slider that no marker shows" in str(found)
    gone = taken.copy()
    gone[:, :3] = np.nan  # markers there are, but never seen
    assert rig.track(gone, range(30)).unseen == ("blink",)
    whole = rig.track(taken, range(30), smooth=0, prior=1e-8)
    assert (whole.names, whole.unseen) == (rig.names, ())
    np.testing.assert_allclose(whole.weights[:, 0], 0.92, atol=1e-3)


def test_what_the_head_could_do_too_shows_no_slider(wide: Rig, markers: np.ndarray) -> None:
    """All vertices lifted alike: a slider, or a head that rises."""
    assert with_blink(wide, slice(None), 1.0).track(markers[:3], range(30)).unseen == ("blink",)


def test_a_slider_is_shown_where_the_prior_leaves_more_than_half_of_it(
    wide: Rig, markers: np.ndarray
) -> None:
    """One marker lifted by h: w - λ/s with s about (h/reach)²."""
    reach = max(np.linalg.norm(m.delta, axis=1).max() for m in wide.morphs.values())
    for part, shown in ((0.9, False), (1.5, True)):
        lift = reach * np.sqrt(2e-4 * part)
        found = with_blink(wide, slice(1), lift).track(markers[:2], range(30), prior=1e-4)
        assert ("blink" in found.names) == shown


def test_a_slider_that_only_drives_a_corrective_is_shown_by_it(wide: Rig) -> None:
    own = with_blink(wide, slice(3), 1.0)
    names = [name for name in wide.names if name != "blink"]
    rig = Rig(own.neutral, own.morphs, correctives={names[0]: ("blink", names[0])})
    weights = np.full((2, len(rig.names)), 0.1)
    found = rig.track(rig.batch(weights, dtype=np.float64)[:, 3:], range(3, 30))
    assert found.unseen == ()


def test_markers_that_show_no_slider_are_refused(wide: Rig, markers: np.ndarray) -> None:
    rig = with_blink(wide, slice(3), 1.0).only(["blink"])
    with pytest.raises(em.ParameterError):
        rig.track(markers[:2, 3:], range(3, 30))


@pytest.mark.parametrize(
    ("markers", "places", "settings", "message"),
    [
        (np.zeros((2, 3, 3)), [0, 1, 2], {}, "at least 4 markers"),
        (np.zeros((2, 4, 3)), [5, 5, 5, 5], {}, "not all on one line"),
        (np.full((2, 5, 3), np.nan), range(5), {}, "no frame has 4 markers"),
        (np.zeros((2, 4, 3)), range(5), {}, r"shape \(T, 5, 3\)"),
        (np.full((2, 5, 3), np.inf), range(5), {}, "or NaN where they are missing"),
        (np.zeros((2, 5, 3)), "chin", {}, "places are a list"),
        (np.zeros((2, 5, 3)), ["chin", 1, 2, 3, 4], {}, "landmark 'chin' is not known"),
        (np.ones((2, 5, 3)), range(5), {"rest": 2}, "rest is frame 2, but there are 2"),
        ("take.npz", range(5), {}, r"em\.read_markers"),
        (np.ones((2, 5, 3)), range(5), {"rest": "first"}, "rest is the number of a frame"),
        (np.ones((2, 5, 3)), range(5), {"smooth": -1}, "smooth must be a number ≥ 0"),
        (np.ones((2, 5, 3)), range(5), {}, "all in one place"),
    ],
)
def test_what_cannot_be_tracked(
    wide: Rig, markers: object, places: object, settings: dict, message: str
) -> None:
    with pytest.raises(em.ParameterError, match=message):
        wide.track(markers, places, **settings)
