"""Paths learned from movements whose paths are known, and from recorded ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import learning
from elastomorph.evaluation import learning as repeating
from elastomorph.evaluation.curve_errors import CurveVertices
from elastomorph.evaluation.learning import Take
from elastomorph.evaluation.movements import find_movements
from elastomorph.evaluation.path_fit import Observed, Splines, fitted
from elastomorph.io.sequences import read_recording
from elastomorph.io.vertex_lists import read_curves

CURVES = Path(__file__).parents[2] / "benchmarks" / "animface_curves.json"
TIMES = np.linspace(0, 1, 41)


def movement(network: CurveNetwork, bends: int, *, noise: float = 0.0) -> em.MeshSequence:
    """A path with a pace of its own and so many bends, on 29 points at random."""
    random = np.random.default_rng(3)
    shapes = random.normal(size=(2 + bends, network.vertex_count, 3))
    pace = TIMES**2 * (3 - 2 * TIMES)
    laws = [4 * TIMES * (1 - TIMES), TIMES * (1 - TIMES) * (1 - 2 * TIMES) * 6][:bends]
    frames = shapes[0] + np.tensordot(
        np.stack([0.5 * pace, *(0.2 * b for b in laws)], 1), shapes[1:], 1
    )
    frames[1:-1] += noise * random.normal(size=frames[1:-1].shape)
    return em.MeshSequence(em.Mesh(shapes[0]), frames, TIMES)


@pytest.mark.parametrize("bends", [0, 1, 2])
def test_a_path_of_so_many_bends_is_found_again(network: CurveNetwork, bends: int) -> None:
    """To rounding: pace and bends are cubic splines themselves."""
    take = movement(network, bends)
    found = em.learn(take, bends, curves=network)
    assert len(found.bends) == bends + 1  # and the curve of Δ
    np.testing.assert_allclose(found.at(TIMES), take.frames, atol=1e-9)
    assert found.gain > 1e6


def test_ends_are_those_of_the_recording_to_the_last_bit(network: CurveNetwork) -> None:
    take = movement(network, 2, noise=0.01)
    found = em.learn(take, 1, curves=network)
    np.testing.assert_array_equal(found.at([0.0, 1.0]), take.frames[[0, -1]])
    assert found.bends[-1].tobytes() == found.delta.tobytes()


def test_more_bends_leave_smaller_errors(network: CurveNetwork) -> None:
    take = movement(network, 2, noise=0.02)
    found = [em.learn(take, bends, curves=network) for bends in range(3)]
    errors = [each.errors.lme for each in found]
    assert sorted(errors, reverse=True) == errors
    assert errors[0] < found[0].straight.lme


def test_the_largest_error_is_smaller_than_that_of_least_squares(network: CurveNetwork) -> None:
    take = movement(network, 2, noise=0.02)
    offsets = (
        take.frames - take.frames[0] - TIMES[:, None, None] * (take.frames[-1] - take.frames[0])
    )
    from scipy.sparse import csr_array

    seen = Observed(
        offsets.transpose(0, 2, 1),
        None,
        None,
        csr_array(np.eye(offsets.shape[1])),
        np.ones((41, 1)),
    )
    splines = Splines.at(TIMES, 7)
    first, rows = np.linalg.qr(splines.values)[0], offsets.reshape(len(TIMES), -1)
    inside = first @ (first.T @ rows)
    left, sizes, right = np.linalg.svd(inside, full_matrices=False)
    squares = (left[:, :2] * sizes[:2]) @ right[:2] - rows
    largest = np.linalg.norm(squares.reshape(offsets.shape), axis=2).max()
    assert fitted(seen, splines, 2).largest < 0.85 * largest


def test_errors_are_those_that_evaluate_finds(network: CurveNetwork) -> None:
    take = movement(network, 2, noise=0.02)
    found = em.learn(take, 1, curves=network)
    linear, learned = em.evaluate(take, {"linear": "linear", "own": found}, network).results
    for measure in ("lme", "lae", "mean_lme", "mean_lae"):
        assert getattr(found.errors, measure) == pytest.approx(getattr(learned, measure))
        assert getattr(found.straight, measure) == pytest.approx(getattr(linear, measure))


def test_what_is_straight_already_stays_so(network: CurveNetwork) -> None:
    """A path that nothing can make better never becomes worse."""
    ends = movement(network, 0).frames[[0, -1]]
    line = ends[0] + TIMES[:, None, None] * (ends[1] - ends[0])
    found = em.learn(em.MeshSequence(em.Mesh(line[0]), line, TIMES), 2, curves=network)
    assert found.errors.lme <= found.straight.lme < 1e-12


@pytest.mark.parametrize("frames", [2, 3, 4, 5, 6])
def test_few_frames_are_passed_through(network: CurveNetwork, frames: int) -> None:
    whole = movement(network, 2)
    pick = np.linspace(0, 40, frames).astype(int)
    take = em.MeshSequence(whole.mesh, whole.frames[pick], TIMES[pick])
    found = em.learn(take, frames - 2, curves=network)
    np.testing.assert_allclose(found.at(take.times), take.frames, atol=1e-6)


def test_dense_meshes_are_learned_from_a_sample(
    network: CurveNetwork, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Curves from some vertices, shapes for all: nearly as good as all at once."""
    take = movement(network, 2, noise=0.02)
    whole = em.learn(take, 1, curves=network).errors.lme
    monkeypatch.setattr(learning, "_LEAST_SAMPLE", 8)
    monkeypatch.setattr(learning, "_SAMPLE", 8 * len(TIMES))
    monkeypatch.setattr(learning, "_BLOCK", 5 * len(TIMES))
    assert em.learn(take, 1, curves=network).errors.lme < 1.15 * whole


def test_what_is_not_trusted_does_not_count(network: CurveNetwork) -> None:
    """A vertex that was lost for some frames changes nothing where it is masked."""
    take = movement(network, 1)
    frames, sure = np.array(take.frames), np.ones(take.frames.shape[:2])
    frames[10:14, 5] += 3.0
    sure[10:14, 5] = 0.0
    torn = em.MeshSequence(take.mesh, frames, TIMES)
    found = em.learn(torn, 1, curves=network, confidence=sure)
    np.testing.assert_allclose(found.at(TIMES), take.frames, atol=1e-6)
    assert em.learn(torn, 1, curves=network).errors.lme > 100 * found.errors.lme


def test_scanned_shapes_are_recorded_frames(network: CurveNetwork) -> None:
    """Each bend is a multiple of what one frame is off the straight path."""
    take = movement(network, 2, noise=0.01)
    found = em.learn(take, 2, shapes="scanned", curves=network)
    ends = take.frames[[0, -1]]
    off = take.frames - ends[0] - TIMES[:, None, None] * (ends[1] - ends[0])
    rows = off[1:-1].reshape(len(off) - 2, -1)
    for bend in found.bends[:2]:
        alike = rows @ bend.ravel() / np.linalg.norm(rows, axis=1) / np.linalg.norm(bend)
        assert np.abs(alike).max() == pytest.approx(1.0)
    free = em.learn(take, 2, curves=network)
    assert free.errors.lme < found.errors.lme < 0.5 * found.straight.lme


def test_a_path_apart_from_its_timing(network: CurveNetwork) -> None:
    """The recording played at another pace teaches the same path and another timing."""
    shapes = np.random.default_rng(5).normal(size=(3, network.vertex_count, 3))
    shapes[2] -= shapes[1] * (shapes[2] * shapes[1]).sum() / (shapes[1] ** 2).sum()

    def played(pace: np.ndarray) -> em.MeshSequence:
        weights = np.stack([pace, 0.4 * pace * (1 - pace)], axis=1)
        frames = shapes[0] + np.tensordot(weights, shapes[1:], 1)
        return em.MeshSequence(em.Mesh(shapes[0]), frames, TIMES)

    late = TIMES**2 * (3 - 2 * TIMES)
    found = em.learn(played(late), 1, timing="even", curves=network)
    other = em.learn(played(TIMES), 1, timing="even", curves=network)
    assert len(found.bends) == 1  # Δ has no curve
    np.testing.assert_allclose(found.timing.at(TIMES), late, atol=0.02)
    np.testing.assert_allclose(other.timing.at(TIMES), TIMES, atol=0.02)
    size = np.abs(found.at(TIMES) - found.neutral.vertices).max()
    np.testing.assert_allclose(found.at(TIMES), other.at(TIMES), atol=0.003 * size)
    assert found.errors.lme < 0.02 * found.straight.lme


def repetitions(network: CurveNetwork, *, alike: bool) -> list[em.MeshSequence]:
    """Three movements with ends and paces of their own, and one bend, the same or not."""
    random = np.random.default_rng(8)
    shapes = random.normal(size=(3, network.vertex_count, 3))
    takes = []
    for power in (1.0, 1.5, 2.0):
        start = shapes[0] + 0.05 * random.normal(size=shapes[0].shape)
        way = shapes[1] + 0.05 * random.normal(size=shapes[0].shape)
        bend = shapes[2] if alike else random.normal(size=shapes[0].shape)
        pace = TIMES**power
        weights = np.stack([pace, pace * (1 - pace)], axis=1)
        frames = start + np.tensordot(weights, np.stack([way, bend]), 1)
        takes.append(em.MeshSequence(em.Mesh(start), frames, TIMES))
    return takes


def test_what_repetitions_share_carries_over(network: CurveNetwork) -> None:
    found = em.learn(repetitions(network, alike=True), 1, curves=network)
    assert len(found.repetitions) == 3
    assert found.carried is not None
    assert found.carried > 4
    assert found.conclusion.startswith("It carries over: ")
    assert "worse than the straight line on 0 of 3" in found.conclusion
    np.testing.assert_allclose(found.repetitions[2].timing.at(TIMES), TIMES**2, atol=0.08)


def test_repetitions_without_bends_are_straight(network: CurveNetwork) -> None:
    """Paths with an even pace and no shapes: nothing is fitted, and nothing is worse for it."""
    found = em.learn(repetitions(network, alike=True), 0, curves=network)
    assert not len(found.bends)
    assert found.carried == pytest.approx(1.0)
    alone = em.learn(movement(network, 1), 0, timing="even", curves=network)
    assert alone.errors.lme == pytest.approx(alone.straight.lme)


def test_repetitions_are_different_and_in_one_unit(network: CurveNetwork) -> None:
    takes = repetitions(network, alike=True)
    with pytest.raises(em.ParameterError, match="recordings 1 and 3 are the same"):
        em.learn([*takes[:2], takes[0]], curves=network)
    first = takes[1]
    millimetres = em.MeshSequence(em.Mesh(10 * first.frames[0]), 10 * first.frames, TIMES)
    with pytest.raises(em.MeshError, match=r"recording 2 is .* times as large as the first"):
        em.learn([takes[0], millimetres], curves=network)


def test_what_they_do_not_share_does_not(network: CurveNetwork) -> None:
    found = em.learn(repetitions(network, alike=False), 1, curves=network)
    assert found.carried is not None
    assert found.carried < 1.1
    assert found.conclusion.startswith("It does not carry over: ")
    assert "only another one can tell" in em.learn(movement(network, 1), curves=network).conclusion
    for one in found.repetitions:
        assert one.errors.lme <= one.straight.lme


def test_a_recording_of_several_movements_is_refused(network: CurveNetwork) -> None:
    """Who goes and comes back, or goes twice, is told where the first movement ends."""
    take = movement(network, 1)
    both = np.concatenate([take.frames, take.frames[-2::-1]])
    twice = np.concatenate([take.frames, take.frames[-2:10:-1], take.frames[11:]])
    for frames, share in ((both, "100%"), (twice, r"\d\d%")):
        said = rf"until frame 40 \(40\), and then comes back by {share} .* --frames 0-40, or take"
        with pytest.raises(em.MeshError, match=said):
            em.learn(em.MeshSequence(take.mesh, frames), curves=network)
    with pytest.raises(em.MeshError, match="does not move"):
        em.learn(em.MeshSequence(take.mesh, np.stack([take.frames[0]] * 4)))


def test_a_recording_that_ends_on_its_way_back_is_told(network: CurveNetwork) -> None:
    take = movement(network, 0)
    part = np.concatenate([take.frames, take.frames[-2:25:-1]])
    motion = em.MeshSequence(take.mesh, part)
    with pytest.warns(em.ElastomorphWarning, match=r"ends with \d+% of its way.*--frames 0-40"):
        em.learn(motion, curves=network)


def test_frames_that_repeat_are_fine(network: CurveNetwork) -> None:
    """A rest in the middle and at both ends; times that repeat are refused."""
    take = movement(network, 0)
    pick = np.repeat(np.arange(0, 41, 4), 3)
    found = em.learn(em.MeshSequence(take.mesh, take.frames[pick]), 1, curves=network)
    assert found.errors.lme < found.straight.lme
    with pytest.raises(em.ParameterError, match="41 finite numbers that rise"):
        em.MeshSequence(take.mesh, take.frames, np.minimum(TIMES, 0.5))
    still = em.MeshSequence(take.mesh, take.frames[[0, 0, 0, 0, 40]])
    assert em.learn(still, 3, curves=network).errors.lme <= 1.01 * em.learn(still).straight.lme


def test_more_bends_than_frames_or_knots_are_refused(network: CurveNetwork) -> None:
    take = movement(network, 1)
    with pytest.raises(em.ParameterError, match="41 frames has 39: ask for 39 or fewer"):
        em.learn(take, 40, knots=50)
    with pytest.raises(em.ParameterError, match="3 knots tell 5 bends apart"):
        em.learn(take, 6, knots=3)
    two = take.part(0, 40)
    two = em.MeshSequence(two.mesh, two.frames[[0, -1]])
    with pytest.raises(em.ParameterError, match=r"^1 bend needs .* 2 frames has 0: ask for 0, the"):
        em.learn(two)
    with pytest.raises(
        em.ParameterError, match="each between the ends, but recording 2 of 2 frames"
    ):
        em.learn([take, two], 2, curves=network)
    assert not len(em.learn(two, 0, curves=network).bends)


@pytest.mark.realdata
def test_recorded_movements_are_never_worse_than_straight(data_dir: Path) -> None:
    """Of two takes of real faces, whole movements; the goal in the mean."""
    pairs = []
    for name in ("jaw", "eyebrows"):
        take = read_recording(data_dir / "animface" / f"{name}.npz")
        network = CurveNetwork(read_curves(CURVES, 41, take.names), 41)
        for move in find_movements(take.motion.frames, edge=0.0):
            part = take.motion.part(move.start, move.stop)
            found = em.learn(part, 1, curves=network)
            pairs.append(
                (found.straight.lme, found.straight.lae, found.errors.lme, found.errors.lae)
            )
    straight, learned = np.array(pairs)[:, :2], np.array(pairs)[:, 2:]
    assert (learned < straight).all()
    assert (straight.mean(axis=0) > (4.0, 4.2) * learned.mean(axis=0)).all()


def test_frames_that_nobody_can_write_to_are_not_copied(network: CurveNetwork) -> None:
    """A long recording is held once; others are safe from what is done to theirs later."""
    frames = np.array(movement(network, 1).frames)
    own = em.MeshSequence(em.Mesh(frames[0]), frames)
    assert not np.shares_memory(own.frames, frames)
    frames.flags.writeable = False
    assert em.MeshSequence(em.Mesh(frames[0]), frames).frames is frames
    assert not np.shares_memory(em.MeshSequence(em.Mesh(frames[0]), frames[:5]).frames, frames)


def test_a_recording_with_a_lost_marker_is_refused_by_name(
    network: CurveNetwork, tmp_path: Path
) -> None:
    frames = np.array(movement(network, 1).frames)
    frames[7, 3] = np.nan
    np.savez(tmp_path / "take.npz", frames=frames)
    with pytest.raises(em.FormatError, match=r"take\.npz: frame 7 has coordinates that are not"):
        em.learn(tmp_path / "take.npz")


def test_markers_that_are_missing_leave_the_path_as_it_is(
    network: CurveNetwork, tmp_path: Path
) -> None:
    """Least squares over what is there; one that an end does not see counts nowhere."""
    take = movement(network, 1)
    names = [f"marker {number}" for number in range(network.vertex_count)]
    frames = np.array(take.frames)
    frames[8:20, 5] = np.nan
    frames[30:, 11] = np.nan
    np.savez(tmp_path / "take.npz", markers=frames, names=np.array(names))
    found = em.learn(tmp_path / "take.npz", 1, curves=network)
    others = np.delete(np.arange(network.vertex_count), 11)
    np.testing.assert_allclose(found.at(TIMES)[:, others], take.frames[:, others], atol=1e-6)
    np.testing.assert_array_equal(found.target.vertices[11], take.frames[29, 11])
    assert found.errors.lme < 1e-6


def wavering(network: CurveNetwork, waves: int, bends: int) -> em.MeshSequence:
    """Shapes whose weights rise and fall so many times, a little noise, and no two alike."""
    random = np.random.default_rng(5)
    shapes = random.normal(size=(2 + bends, network.vertex_count, 3))
    laws = [np.sin((waves - k) * np.pi * TIMES) for k in range(bends)]
    frames = shapes[0] + np.tensordot(np.stack([TIMES, *(0.2 * b for b in laws)], 1), shapes[1:], 1)
    frames[1:-1] += 1e-3 * random.normal(size=frames[1:-1].shape)
    return em.MeshSequence(em.Mesh(shapes[0]), frames, TIMES)


def test_knots_are_as_many_as_curves_need(network: CurveNetwork) -> None:
    """Weights that swing eight times: seven knots are the limit, and by default there are more."""
    take = wavering(network, 16, 2)
    few = em.learn(take, 2, knots=7, curves=network)
    own = em.learn(take, 2, curves=network)
    assert (few.knots, few.knots_are_the_limit) == (7, True)
    assert own.knots > 12
    assert not own.knots_are_the_limit
    assert own.errors.lme < few.errors.lme / 10
    assert {"knots": own.knots, "knots_are_the_limit": False}.items() <= own.to_dict().items()
    bends = em.learn(wavering(network, 3, 3), 1, curves=network)
    assert (bends.knots, bends.knots_are_the_limit) == (7, False)


@pytest.mark.parametrize(
    ("timing", "seed", "most"), [("recorded", 0, 4), ("recorded", 1, 4), ("even", 0, 3)]
)
def test_a_bend_more_is_never_worse(
    network: CurveNetwork, timing: str, seed: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On all vertices, the sample being a few; where curves are too stiff for what was recorded."""
    monkeypatch.setattr(learning, "_SAMPLE", 10 * len(TIMES))
    monkeypatch.setattr(learning, "_LEAST_SAMPLE", 10)
    random = np.random.default_rng(seed)
    take = wavering(network, 6, 4)
    frames = take.frames.copy()
    frames[1:-1] += 0.05 * random.normal(size=frames[1:-1].shape)
    take = em.MeshSequence(take.mesh, frames, TIMES)
    for knots in (2, None):
        found = [
            em.learn(take, k, knots=knots, timing=timing, curves=network).errors
            for k in range(most + 1)
        ]
        for measure in ("lme", "lae"):
            errors = [getattr(each, measure) for each in found]
            assert sorted(errors, reverse=True) == errors


def test_a_bend_more_goes_on_from_the_path_of_fewer(
    network: CurveNetwork, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a fit from nothing is worse on all vertices than what there was."""
    monkeypatch.setattr(learning, "_SAMPLE", 10 * len(TIMES))
    monkeypatch.setattr(learning, "_LEAST_SAMPLE", 10)
    take = wavering(network, 6, 4)
    frames = take.frames.copy()
    frames[1:-1] += 0.02 * np.random.default_rng(1).normal(size=frames[1:-1].shape)
    take = em.MeshSequence(take.mesh, frames, TIMES)
    none, one = (em.learn(take, k, knots=4, curves=network).errors.lme for k in (0, 1))
    assert one < 0.9 * none


def test_repetitions_with_more_bends_are_never_worse(network: CurveNetwork) -> None:
    takes = [movement(network, 2, noise=noise) for noise in (0.02, 0.03)]
    found = [em.learn(takes, k, curves=network).errors for k in range(3)]
    for measure in ("lme", "lae"):
        errors = [getattr(each, measure) for each in found]
        assert sorted(errors, reverse=True) == errors


@pytest.mark.realdata
def test_two_bends_of_three_openings_of_a_jaw_carry_over_to_the_fourth(data_dir: Path) -> None:
    """Two bends are not tied to the moments of one: those carried over to no other opening."""
    take = read_recording(data_dir / "animface" / "jaw.npz")
    network = CurveNetwork(read_curves(CURVES, 41, take.names), 41)
    parts = ((84, 132), (248, 132), (317, 408), (502, 408))
    along = CurveVertices.of(network, 41)
    fourth, *others = (Take(take.motion.part(*part), along) for part in parts)
    limits = [each.closest(each.line)[0] for each in others]
    path = repeating._path(others, repeating.Wanted(2, None, False), limits)
    straight, learned = (fourth.closest(each)[0].lme for each in (fourth.line, path))
    assert straight > 1.1 * learned
