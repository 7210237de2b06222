"""Methods compared with a motion: identities, symmetries and limits of the whole."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.curves import CurveNetwork
from elastomorph.errors import CurveError, MeshError, ParameterError, TimeLawWarning, TopologyError
from elastomorph.evaluation import DEFAULT_METHODS, Evaluation, evaluate
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method, interpolate
from elastomorph.physics import Material
from small_head import recorded_motion

TIMES = np.array([0.0, 0.15, 0.4, 0.55, 0.8, 1.0])
ERRORS = ("average", "maximum", "path_average", "path_maximum")


@pytest.fixture
def truth(curved: Morph) -> MeshSequence:
    """A motion that no method knows."""
    shaken = curved.at(TIMES)
    noise = np.random.default_rng(4).normal(scale=0.05, size=shaken.shape)
    noise[[0, -1]] = 0
    return MeshSequence(curved.neutral, shaken + noise, TIMES)


def motion(neutral: Mesh, target: Mesh, method: str, curves: CurveNetwork) -> MeshSequence:
    """A path by some method, as if it had been recorded."""
    morph = interpolate(neutral, target, method, curves=curves)
    return MeshSequence(neutral, morph.at(TIMES), TIMES)


def assert_same_errors(first: Evaluation, second: Evaluation) -> None:
    for ours, theirs in zip(first.results, second.results, strict=True):
        for name in ERRORS:
            np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), atol=1e-7)
        assert ours.seam == pytest.approx(theirs.seam, abs=1e-9)
        assert ours.flips == theirs.flips
        assert ours.stretch == pytest.approx(theirs.stretch, rel=1e-9)


def test_two_poses_have_nothing_between_to_judge_by(curved: Morph, rows: CurveNetwork) -> None:
    """Every path is exact at both ends: a table of zeros would say that all methods are right."""
    two = MeshSequence(curved.neutral, curved.at([0.0, 1.0]))
    between = r"motion of 2 frames .* give a frame between"
    with pytest.raises(ParameterError, match=between) as caught:
        evaluate(two, curves=rows)
    assert "\n" not in str(caught.value)
    assert evaluate(MeshSequence(curved.neutral, curved.at([0, 0.5, 1])), ["linear"], rows).results


@pytest.mark.parametrize("method", DEFAULT_METHODS)
def test_a_method_has_no_error_on_its_own_motion(
    neutral: Mesh, target: Mesh, rows: CurveNetwork, method: str
) -> None:
    """Neither in time nor in path."""
    evaluation = evaluate(motion(neutral, target, method, rows), [method], rows)
    result = evaluation.results[0]
    for name in ERRORS:
        assert getattr(result, name).shape == (len(rows), len(TIMES))
        assert getattr(result, name).max() < 1e-9


def test_the_error_of_linear_on_an_ease_is_the_law_alone(
    neutral: Mesh, target: Mesh, rows: CurveNetwork
) -> None:
    """V₀ + t²Δ against V₀ + tΔ: off by (t - t²)‖Δ‖ in time, by nothing in path."""
    truth = motion(neutral, target, "ease:2", rows)
    linear = evaluate(truth, ["linear"], rows)["linear"]
    lengths = np.linalg.norm(target.vertices - neutral.vertices, axis=1) / neutral.diameter
    for number, curve in enumerate(rows):
        own = lengths[curve.vertices]
        late = TIMES - TIMES**2
        np.testing.assert_allclose(linear.average[number], late * own.mean(), atol=1e-12)
        np.testing.assert_allclose(linear.maximum[number], late * own.max(), atol=1e-12)
    assert linear.path_lme < 1e-9
    np.testing.assert_allclose(linear.path_times, TIMES**2, atol=1e-9)


def test_averages_and_largest_values(truth: MeshSequence, rows: CurveNetwork) -> None:
    """E_A ≤ E_M; LME and LAE are the largest of all, the means leave out both ends."""
    for result in evaluate(truth, curves=rows).results:
        assert (result.average <= result.maximum + 1e-15).all()
        assert result.lme == result.maximum.max() > 0
        assert result.lae == result.average.max() > 0
        worst = [max(result.maximum[:, i]) for i in range(1, len(TIMES) - 1)]
        assert result.mean_lme == pytest.approx(sum(worst) / len(worst))
        worst = [max(result.average[:, i]) for i in range(1, len(TIMES) - 1)]
        assert result.mean_lae == pytest.approx(sum(worst) / len(worst))
        worst = [max(result.path_maximum[:, i]) for i in range(1, len(TIMES) - 1)]
        assert result.path_mean_lme == pytest.approx(sum(worst) / len(worst))
        assert result.path_lae == result.path_average.max()
        assert result.path_mean_lae <= result.path_lae
        for ends in (result.maximum[:, 0], result.maximum[:, -1]):
            np.testing.assert_allclose(ends, 0, atol=1e-14)


def test_free_timing_is_never_worse(truth: MeshSequence, rows: CurveNetwork) -> None:
    """The captured times are one choice of many, so the best choice is no worse."""
    texts = [*DEFAULT_METHODS, "arc", "through:1", "through:2", "through:2:piecewise"]
    for result in evaluate(truth, texts, curves=rows).results:
        assert result.path_lme <= result.lme * (1 + 1e-12)
        assert result.path_lae <= result.lae * (1 + 1e-12)
        assert (np.diff(result.path_times) >= 0).all()
        assert (np.diff(result.path_average_times) >= 0).all()


def test_straight_methods_share_one_path(truth: MeshSequence, rows: CurveNetwork) -> None:
    """Linear, cosine and ease differ in timing only, so their path errors are equal."""
    results = evaluate(truth, ["linear", "cosine", "ease:2", "ease:3"], rows).results
    for result in results[1:]:
        np.testing.assert_allclose(result.path_maximum, results[0].path_maximum, atol=1e-7)


def test_scale_does_not_matter(truth: MeshSequence, rows: CurveNetwork) -> None:
    """Errors are fractions of D: metres or millimetres."""
    scaled = MeshSequence(truth.mesh, 1000 * truth.frames, TIMES)
    assert_same_errors(evaluate(truth, curves=rows), evaluate(scaled, curves=rows))


def test_where_the_face_is_does_not_matter(truth: MeshSequence, rows: CurveNetwork) -> None:
    """Every method commutes with rotation and translation, and so does every measure."""
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    moved = MeshSequence(truth.mesh, truth.frames @ turn.T + [5.0, -3.0, 2.0], TIMES)
    assert_same_errors(evaluate(truth, curves=rows), evaluate(moved, curves=rows))


def test_the_order_of_vertices_does_not_matter(truth: MeshSequence, rows: CurveNetwork) -> None:
    """Renumbered vertices, with polygons and curves renumbered alike."""
    count = len(truth.mesh.vertices)
    new = np.random.default_rng(7).permutation(count)
    frames = np.empty_like(truth.frames)
    frames[:, new] = truth.frames
    mesh = Mesh(frames[0], [new[face] for face in truth.mesh.faces])
    renumbered = MeshSequence(mesh, frames, TIMES)
    assert_same_errors(
        evaluate(truth, curves=rows), evaluate(renumbered, curves=rows.relabelled(new))
    )


def test_seams_open_where_the_mean_has_its_own_law(truth: MeshSequence, rows: CurveNetwork) -> None:
    """None on the straight line; an unforced mean tears more than the limit closure."""
    methods = ["linear", "cosine", "ease:3", "beam:2", "beam:2:unforced"]
    seams = [result.seam for result in evaluate(truth, methods, rows).results]
    assert seams[:3] == [0, 0, 0]
    assert seams[4] > 10 * seams[3] > 0


def test_a_law_that_runs_backwards_is_warned_of(truth: MeshSequence, rows: CurveNetwork) -> None:
    """The compatible closure starts backwards at m = c = 1; it is evaluated all the same."""
    with pytest.warns(TimeLawWarning, match="backwards"):
        evaluation = evaluate(truth, "beam:2:compatible", rows)
    assert evaluation.results[0].lme > 0


def test_markers_without_polygons(truth: MeshSequence, rows: CurveNetwork) -> None:
    """Errors are those of the mesh; there are no edges to part or stretch."""
    markers = MeshSequence(Mesh(truth.mesh.vertices), truth.frames, TIMES)
    for with_faces, without in zip(
        evaluate(truth, curves=rows).results, evaluate(markers, curves=rows).results, strict=True
    ):
        np.testing.assert_array_equal(with_faces.maximum, without.maximum)
        assert (without.seam, without.flips, without.stretch) == (0, 0, 1)


def test_curves_are_found_where_none_are_given(truth: MeshSequence) -> None:
    """A mesh with polygons brings its own curves, which cover every vertex."""
    evaluation = evaluate(truth, ["linear"])
    covered = np.concatenate([curve.vertices for curve in evaluation.curves])
    assert set(covered.tolist()) == set(range(len(truth.mesh.vertices)))


def test_methods_may_be_texts_methods_or_morphs(
    truth: MeshSequence, rows: CurveNetwork, curved: Morph
) -> None:
    """Labels are the methods' own, or those of a mapping; a material is for texts."""
    soft = Material(damping=3.0)
    evaluation = evaluate(truth, ["beam:2", Method("ease"), curved], rows, material=soft)
    labels = [result.label for result in evaluation.results]
    assert labels == [Method("beam", material=soft).label, "ease R=2", "curved"]
    assert evaluation["curved"].morph is curved
    mine = evaluate(truth, {"mine": curved, "yours": "linear"}, rows)
    assert [result.label for result in mine.results] == ["mine", "yours"]
    np.testing.assert_array_equal(mine["mine"].maximum, evaluation["curved"].maximum)
    assert [result.label for result in evaluate(truth, "linear", rows).results] == ["linear"]
    with pytest.raises(ParameterError, match=r"no method 'ours'.*there are: mine, yours"):
        mine["ours"]


def test_progress_names_every_method(truth: MeshSequence, rows: CurveNetwork) -> None:
    """Once each, in order, before the work."""
    heard: list[str] = []
    evaluate(truth, ["linear", "ease:2"], rows, progress=heard.append)
    assert heard == ["linear (1 of 2)", "ease R=2 (2 of 2)"]


def test_a_morph_must_lead_from_the_first_frame_to_the_last(
    truth: MeshSequence, rows: CurveNetwork, neutral: Mesh, target: Mesh
) -> None:
    """Another start, another end and other polygons are refused by name."""
    none = np.zeros((0, *neutral.vertices.shape))
    with pytest.raises(MeshError, match="'back' must start at the first frame"):
        evaluate(truth, {"back": Morph(target, neutral, none, ())}, rows)
    with pytest.raises(MeshError, match="'still' must end at the last frame"):
        evaluate(truth, {"still": Morph(neutral, neutral, none, ())}, rows)
    bare = [Mesh(mesh.vertices) for mesh in (neutral, target)]
    with pytest.raises(TopologyError):
        evaluate(truth, {"bare": Morph(*bare, none, ())}, rows)
    rounded = [mesh.with_vertices(mesh.vertices.astype(np.float32)) for mesh in (neutral, target)]
    assert evaluate(truth, Morph(*rounded, none, ()), rows).results[0].lme > 0


def test_arguments_that_do_not_fit_are_refused(truth: MeshSequence, rows: CurveNetwork) -> None:
    """With messages that name what was found."""
    with pytest.raises(ParameterError, match="no method"):
        evaluate(truth, [], rows)
    with pytest.raises(ParameterError, match="two methods are called 'linear'"):
        evaluate(truth, ["linear", Method("linear")], rows)
    with pytest.raises(ParameterError, match="found 3"):
        evaluate(truth, [3], rows)  # type: ignore[list-item]
    with pytest.raises(CurveError, match="99 vertices, the first frame has 20"):
        evaluate(truth, ["linear"], CurveNetwork(rows, 99))
    with pytest.raises(CurveError, match="there is none"):
        evaluate(truth, ["linear"], CurveNetwork([], 20))


METHODS = ("linear", "ease:2")


@pytest.fixture(scope="module")
def result() -> em.Evaluation:
    return em.evaluate(recorded_motion(), METHODS)


def test_a_motion_may_be_named_by_its_files(tmp_path: Path, result: em.Evaluation) -> None:
    pattern = tmp_path / "scan.##.obj"
    em.write_sequence(pattern, recorded_motion())
    for named in (pattern, str(pattern), tmp_path):
        found = em.evaluate(named, METHODS)
        for own, expected in zip(found.results, result.results, strict=True):
            assert own.lme == pytest.approx(expected.lme, rel=1e-9)
    with pytest.raises(em.FileError, match=r"take\.##\.obj"):
        em.evaluate(tmp_path / "take.##.obj")


def test_text_goes_to_a_file_as_well(tmp_path: Path, result: em.Evaluation) -> None:
    for name, write in (
        ("short.csv", result.to_csv),
        ("long.csv", result.to_long_csv),
        ("all.json", result.to_json),
    ):
        text = write(tmp_path / name)
        assert text == write()
        assert (tmp_path / name).read_bytes() == text.encode()
    with pytest.raises(em.FileError, match="does not exist"):
        result.to_csv(tmp_path / "nowhere" / "short.csv")


def test_without_pandas_one_sentence_says_so(
    monkeypatch: pytest.MonkeyPatch, result: em.Evaluation
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(
        em.MissingExtraError, match=r"'pandas', which is not .* pip install pandas$"
    ):
        result.to_dataframe()


def test_a_table_of_pandas_is_the_csv(result: em.Evaluation) -> None:
    pytest.importorskip("pandas", reason="pandas is not installed; it is optional")
    for long, text in ((False, result.to_csv()), (True, result.to_long_csv())):
        header, *rows = csv.reader(text.splitlines())
        frame = result.to_dataframe(long=long)
        assert list(frame.columns) == header
        assert len(frame) == len(rows)
        last = [float(value) for value in rows[-1][3:]]
        np.testing.assert_array_equal(frame.iloc[-1, 3:].to_numpy(dtype=float), last)
