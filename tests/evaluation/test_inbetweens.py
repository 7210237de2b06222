"""Where in-betweens pay: found where they were put, and measured as methods are."""

from __future__ import annotations

import warnings
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import CurveError, ElastomorphWarning, MeshError, ParameterError
from elastomorph.evaluation import evaluate, find_movements
from elastomorph.evaluation.inbetweens import MEASURES, suggest_inbetweens
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths.through import LAWS, through

FRAMES = 13


@pytest.fixture(scope="module")
def splined(neutral: Mesh, target: Mesh) -> MeshSequence:
    """A motion that is a natural spline through two shapes, at frames 3 and 8."""
    rng = np.random.default_rng(5)
    shaken = [
        neutral.with_vertices(neutral.vertices + rng.normal(size=neutral.vertices.shape))
        for _ in range(2)
    ]
    times = np.linspace(0, 1, FRAMES)
    path = through(neutral, target, {times[3]: shaken[0], times[8]: shaken[1]})
    return MeshSequence(neutral, path.at(times))


@pytest.fixture(scope="module")
def wild(neutral: Mesh) -> MeshSequence:
    """A motion of irregular times in which every vertex goes its own way."""
    rng = np.random.default_rng(8)
    steps = np.cumsum(rng.normal(size=(FRAMES, *neutral.vertices.shape)), axis=0)
    times = np.concatenate([[0], np.cumsum(rng.uniform(1, 3, FRAMES - 1))])
    return MeshSequence(neutral, neutral.vertices + steps - steps[0], times)


@pytest.mark.parametrize("measure", MEASURES)
def test_shapes_of_a_spline_are_found(
    splined: MeshSequence, rows: CurveNetwork, measure: str
) -> None:
    """Two in-betweens at the right frames leave nothing but rounding."""
    found = suggest_inbetweens(splined, 2, curves=rows, measure=measure)
    assert [len(each.frames) for each in found] == [0, 1, 2]
    assert found[2].frames == (3, 8)
    assert found[2].names == ("3", "8")
    assert found[2].times == (3 / 12, 8 / 12)
    assert found[2].lme < 1e-14
    assert found[2].mean_lae < 1e-14
    assert found[1].lme > 1e-3


@pytest.mark.parametrize("measure", MEASURES)
def test_corners_of_a_broken_line_are_found(
    neutral: Mesh, target: Mesh, rows: CurveNetwork, measure: str
) -> None:
    times = np.linspace(0, 1, 9)
    corner = neutral.with_vertices(neutral.vertices + np.sin(9 * neutral.vertices))
    path = through(neutral, target, {0.625: corner}, method="piecewise")
    broken = MeshSequence(neutral, path.at(times))
    found = suggest_inbetweens(broken, 1, curves=rows, measure=measure, method="piecewise")[1]
    assert found.frames == (5,)
    assert found.lme < 1e-14
    assert suggest_inbetweens(broken, 1, curves=rows, measure=measure)[1].lme > 1e-2


@pytest.mark.parametrize("method", LAWS)
def test_errors_are_those_of_an_evaluation(
    wild: MeshSequence, rows: CurveNetwork, method: str
) -> None:
    """The first is linear interpolation, and each path is measured as any method is."""
    found = suggest_inbetweens(wild, 3, curves=rows, method=method)
    methods = {"linear": "linear"} | {str(n): found[n].morph for n in (1, 2, 3)}
    judged = evaluate(wild, methods, rows)
    for each, result in zip(found, judged.results, strict=True):
        for name in ("lme", "lae", "mean_lme", "mean_lae"):
            assert getattr(each, name) == pytest.approx(getattr(result, name), rel=1e-12)
        np.testing.assert_allclose(each.maximum[list(each.frames)], 0, atol=1e-14)


def error_through(motion: MeshSequence, law: str, frames: tuple[int, ...]) -> float:
    """LME of one choice, frame by frame and vertex by vertex."""
    times = motion.times
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ElastomorphWarning)
        shapes = {float(times[frame]): motion[frame] for frame in frames}
        path = through(motion.mesh, motion.target, shapes, method=law)
    off = [path.at(float(t)) - frame for t, frame in zip(times, motion.frames, strict=True)]
    return float(np.linalg.norm(off, axis=2).max() / motion.mesh.diameter)


@pytest.mark.parametrize("method", [None, *LAWS])
def test_brute_force_over_frames_and_laws_finds_nothing_better(
    wild: MeshSequence, rows: CurveNetwork, method: str | None
) -> None:
    """By default the smooth laws compete; what is returned is the best frame under the best law."""
    laws = ("smooth", "spline") if method is None else (method,)
    found = suggest_inbetweens(wild, 2, curves=rows, method=method)
    for count in (1, 2):
        every = {
            (law, frames): error_through(wild, law, frames)
            for law in laws
            for frames in combinations(range(1, FRAMES - 1), count)
        }
        law, frames = min(every, key=lambda choice: every[choice])
        assert (found[count].law, found[count].frames) == (law, frames)
        assert found[count].lme == pytest.approx(every[law, frames], rel=1e-12)
    assert found[0].law == "linear"


def test_what_a_suggestion_says_makes_its_path_again(
    wild: MeshSequence, rows: CurveNetwork
) -> None:
    best = suggest_inbetweens(wild, 1, curves=rows)[1]
    shapes = {time: wild[frame] for time, frame in zip(best.times, best.frames, strict=True)}
    again = through(wild.mesh, wild.target, shapes, method=best.law)
    np.testing.assert_array_equal(again.at(wild.times), best.morph.at(wild.times))


def test_a_suggestion_tells_how_far_its_path_overshoots(
    wild: MeshSequence, rows: CurveNetwork
) -> None:
    """Weights by scipy's spline; the other laws stay within 1."""
    best = suggest_inbetweens(wild, 1, curves=rows, method="spline")[1]
    weight = CubicSpline([0, *best.times, 1], [0, 1, 0], bc_type="natural")(np.linspace(0, 1, 9999))
    assert best.largest_weight == pytest.approx(weight.max(), abs=1e-6)
    smooth = suggest_inbetweens(wild, 1, curves=rows, method="smooth")
    assert smooth[0].largest_weight == 0
    assert smooth[1].largest_weight == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize(("measure", "name"), [("lme", "lme"), ("lae", "lae")])
def test_each_measure_is_smallest_where_it_was_chosen_by(
    wild: MeshSequence, rows: CurveNetwork, measure: str, name: str
) -> None:
    best = suggest_inbetweens(wild, 3, curves=rows, measure=measure)
    for other in MEASURES:
        others = suggest_inbetweens(wild, 3, curves=rows, measure=other)
        for ours, theirs in zip(best, others, strict=True):
            assert getattr(ours, name) <= getattr(theirs, name) * (1 + 1e-12)


@pytest.mark.parametrize("measure", MEASURES)
def test_played_backwards_the_same_frames_pay(
    wild: MeshSequence, rows: CurveNetwork, measure: str
) -> None:
    """D is of the first frame, so errors as fractions differ by one factor."""
    last = len(wild) - 1
    forward = suggest_inbetweens(wild, 2, curves=rows, measure=measure)
    backward = suggest_inbetweens(wild.part(last, 0), 2, curves=rows, measure=measure)
    factor = wild.mesh.diameter / wild.target.diameter
    for ours, theirs in zip(forward, backward, strict=True):
        assert ours.frames == tuple(last - frame for frame in reversed(theirs.frames))
        np.testing.assert_allclose(theirs.maximum[::-1], ours.maximum * factor, atol=1e-12)


def test_only_vertices_on_curves_count(wild: MeshSequence) -> None:
    """Frames are chosen by what is measured: the curve given, and nothing beside it."""
    vertices = [0, 1, 2]
    part = Mesh(wild.mesh.vertices[vertices])
    alone = MeshSequence(part, wild.frames[:, vertices], wild.times)
    few = CurveNetwork([Curve(vertices)], len(wild.mesh.vertices))
    own = CurveNetwork([Curve(vertices)], 3)
    for ours, theirs in zip(
        suggest_inbetweens(wild, 2, curves=few),
        suggest_inbetweens(alone, 2, curves=own),
        strict=True,
    ):
        assert ours.frames == theirs.frames
        assert ours.lme * wild.mesh.diameter == pytest.approx(theirs.lme * part.diameter)


def test_curves_are_found_where_none_are_given(splined: MeshSequence) -> None:
    assert suggest_inbetweens(splined, 2)[2].frames == (3, 8)


def test_straight_motion_needs_nothing(neutral: Mesh, target: Mesh, rows: CurveNetwork) -> None:
    times = np.linspace(0, 1, 5)[:, None, None]
    frames = (1 - times) * neutral.vertices + times * target.vertices
    for each in suggest_inbetweens(MeshSequence(neutral, frames), 3, curves=rows):
        assert each.lme < 1e-15


def test_two_frames_have_room_for_none(neutral: Mesh, target: Mesh, rows: CurveNetwork) -> None:
    pair = MeshSequence(neutral, [neutral.vertices, target.vertices])
    (only,) = suggest_inbetweens(pair, 0, curves=rows)
    assert (only.frames, only.lme, only.mean_lme, only.mean_lae) == ((), 0, 0, 0)
    assert "linear" in repr(only)


@pytest.mark.parametrize("count", [-1, FRAMES - 1, 1.5, True])
def test_counts_have_a_range(wild: MeshSequence, rows: CurveNetwork, count: int) -> None:
    with pytest.raises(ParameterError, match=f"room for 0 to {FRAMES - 2} in-betweens"):
        suggest_inbetweens(wild, count, curves=rows)


def test_an_unknown_measure_or_method(wild: MeshSequence, rows: CurveNetwork) -> None:
    with pytest.raises(ParameterError, match="lme, lae, mean"):
        suggest_inbetweens(wild, 1, curves=rows, measure="worst")
    with pytest.raises(ParameterError, match="smooth, spline, piecewise"):
        suggest_inbetweens(wild, 1, curves=rows, method="cubic")


def test_curves_of_another_mesh(wild: MeshSequence) -> None:
    with pytest.raises(CurveError, match="the first frame has 20: extract them"):
        suggest_inbetweens(wild, 1, curves=CurveNetwork([Curve([0, 1])], 2))


def test_a_face_without_size(rows: CurveNetwork) -> None:
    count = rows.vertex_count
    point = MeshSequence(Mesh(np.zeros((count, 3))), np.zeros((3, count, 3)))
    with pytest.raises(MeshError, match="D is 0"):
        suggest_inbetweens(point, 1, curves=rows)


@pytest.mark.realdata
def test_on_real_faces_two_well_placed_in_betweens_more_than_halve_the_error(
    data_dir: Path,
) -> None:
    """Mean LME over all onsets and offsets: by 2 and more with one, by 3 with two."""
    errors = []
    for take in ("jaw", "eyebrows"):
        with np.load(data_dir / "animface" / f"{take}.npz", allow_pickle=False) as file:
            frames = file["stab"].astype(np.float64)
        markers = frames.shape[1]
        whole = MeshSequence(Mesh(frames[0]), frames)
        curves = CurveNetwork([Curve([marker]) for marker in range(markers)], markers)
        for move in find_movements(frames):
            found = suggest_inbetweens(whole.part(move.start, move.stop), 2, curves=curves)
            errors.append([each.lme for each in found])
    linear, one, two = np.mean(errors, axis=0)
    assert linear / one > 2.0
    assert linear / two > 3.0
