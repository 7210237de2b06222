"""Vertices that are not to be trusted do not count, and nothing else changes."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import FormatError, ParameterError
from elastomorph.evaluation.confidence import Confidence
from elastomorph.evaluation.curve_errors import CurveVertices, curve_errors
from elastomorph.evaluation.inbetweens import Choice, LargestError
from elastomorph.evaluation.movements import evaluate_movements
from elastomorph.io.npz.confidence import write_confidence
from elastomorph.paths.through import cardinal_curves

METHODS = ["linear", "ease:2", "through:1", "beam:2"]
# Of these the path of a vertex is its own: a stray vertex spoils no other.
APART = ["linear", "cosine", "ease:3"]
NUMBERS = ("average", "maximum", "path_average", "path_maximum")


@pytest.fixture(scope="module")
def motion(curved: em.Morph) -> em.MeshSequence:
    times = np.linspace(0, 1, 7)
    frames = curved.at(times**1.3)
    return em.MeshSequence(curved.neutral, frames, times, [f"p{i:02d}.obj" for i in range(7)])


def spoiled(
    motion: em.MeshSequence, places: dict[int, list[int]]
) -> tuple[em.MeshSequence, dict[str, np.ndarray]]:
    """A motion with some vertices of some frames far off, and the confidence that says so."""
    frames = motion.frames.copy()
    confidence = {name: np.ones(frames.shape[1], np.float32) for name in motion.names}
    for frame, vertices in places.items():
        frames[frame, vertices] += [3.0, -2.0, 5.0]
        confidence[motion.names[frame]][vertices] = 0.2
    return em.MeshSequence(motion.mesh, frames, motion.times, motion.names), confidence


def without(rows: CurveNetwork, vertices: list[int]) -> CurveNetwork:
    """The curves without some of their vertices."""
    kept = [[v for v in curve.vertices.tolist() if v not in vertices] for curve in rows]
    return CurveNetwork([Curve(own) for own in kept if own], rows.vertex_count)


def numbers(result: Any) -> list[Any]:
    return [getattr(result, name) for name in (*NUMBERS, "path_times", "path_average_times")]


@pytest.mark.parametrize("values", [1.0, 0.5])
def test_a_mask_of_ones_changes_nothing(
    motion: em.MeshSequence, rows: CurveNetwork, values: float
) -> None:
    plain = em.evaluate(motion, METHODS, rows)
    shape = (len(motion), len(motion.mesh.vertices))
    masked = em.evaluate(motion, METHODS, rows, confidence=np.full(shape, values))
    assert masked.covered == plain.covered == 1
    for result, expected in zip(masked.results, plain.results, strict=True):
        for own, other in zip(numbers(result), numbers(expected), strict=True):
            np.testing.assert_array_equal(own, other)
        assert (result.unmasked_lme, result.unmasked_lae) == (expected.lme, expected.lae)
        assert expected.unmasked_lme is None


def test_spoiled_vertices_in_between_do_not_count(
    motion: em.MeshSequence, rows: CurveNetwork
) -> None:
    """Ends are as they were, so that paths are too, and masked vertices are no error of theirs."""
    truth, confidence = spoiled(motion, {2: [3], 4: [3, 11, 17]})
    found = em.evaluate(truth, METHODS, rows, confidence=confidence)
    plain = em.evaluate(truth, METHODS, rows)
    clean = em.evaluate(motion, METHODS, rows)
    along = CurveVertices.of(rows, len(motion.mesh.vertices))
    for result, unmasked, expected in zip(found.results, plain.results, clean.results, strict=True):
        if expected.label.startswith("through"):  # leads through what is spoiled
            continue
        assert result.lme <= expected.lme + 1e-12
        assert (result.unmasked_lme, result.unmasked_lae) == (unmasked.lme, unmasked.lae)
        assert unmasked.lme > 0.5 > result.lme
        for frame, time in enumerate(motion.times):
            counted = np.ones(20, bool)
            counted[{2: [3], 4: [3, 11, 17]}.get(frame, [])] = False
            positions = expected.morph.at(float(time))
            kept = np.flatnonzero(counted)
            away = np.linalg.norm(positions - motion.frames[frame], axis=1) / found.diameter
            assert result.maximum[:, frame].max() == pytest.approx(away[kept].max(), rel=1e-12)
            for number, curve in enumerate(rows):
                own = [v for v in curve.vertices if counted[v]]
                assert result.average[number, frame] == pytest.approx(away[own].mean(), rel=1e-9)
    np.testing.assert_array_equal(along.counts, 5)


@pytest.mark.parametrize("frames", [[3], [0], [6], [0, 2, 6]])
def test_masking_what_was_spoiled_restores_the_errors(
    motion: em.MeshSequence, rows: CurveNetwork, frames: list[int]
) -> None:
    """Vertices that were never to be trusted leave the errors of all others, at the ends too."""
    vertices = [4, 9, 13]
    truth, confidence = spoiled(motion, dict.fromkeys(frames, vertices))
    for own in confidence.values():
        own[vertices] = 0.1
    found = em.evaluate(truth, APART, rows, confidence=confidence, extent=motion.mesh.diameter)
    clean = em.evaluate(motion, APART, without(rows, vertices))
    for result, expected in zip(found.results, clean.results, strict=True):
        for name in ("lme", "lae", "path_lme", "path_lae", "mean_lme", "path_mean_lae"):
            assert getattr(result, name) == pytest.approx(getattr(expected, name), rel=1e-6)
        assert result.unmasked_lme > 2 * expected.lme or frames == [6]


def test_a_vertex_not_trusted_at_an_end_counts_nowhere(
    motion: em.MeshSequence, rows: CurveNetwork
) -> None:
    """The path of it leads from there."""
    vertices = [4, 9, 13]
    truth, confidence = spoiled(motion, {6: vertices})
    found = em.evaluate(truth, APART, rows, confidence=confidence, extent=motion.mesh.diameter)
    clean = em.evaluate(motion, APART, without(rows, vertices))
    assert found.covered == pytest.approx(17 / 20)
    for result, expected in zip(found.results, clean.results, strict=True):
        np.testing.assert_allclose(result.lme, expected.lme, rtol=1e-12)


def test_free_timing_and_in_betweens_do_not_follow_stray_vertices(
    motion: em.MeshSequence, rows: CurveNetwork
) -> None:
    vertices = [7]
    truth, confidence = spoiled(motion, dict.fromkeys(range(1, 6), vertices))
    found = em.evaluate(truth, ["linear", "through:2"], rows, confidence=confidence)
    clean = em.evaluate(motion, ["linear", "through:2"], without(rows, vertices))
    for result, expected in zip(found.results, clean.results, strict=True):
        np.testing.assert_allclose(result.path_times, expected.path_times, atol=1e-9)
        np.testing.assert_allclose(
            result.path_average_times, expected.path_average_times, atol=1e-9
        )
        assert result.lme == pytest.approx(expected.lme, rel=1e-9)
    curves = zip(
        found["through 2"].morph.bend_curves, clean["through 2"].morph.bend_curves, strict=True
    )
    for own, other in curves:
        np.testing.assert_array_equal(own.breaks, other.breaks)


@pytest.mark.parametrize("groups", [1, 5])
def test_the_best_frames_are_those_of_all_choices(groups: int) -> None:
    """The search by witnesses finds what looking at every choice finds, with a mask too."""
    rng = np.random.default_rng(4)
    offsets, times = rng.normal(size=(9, 20, 3)), np.linspace(0, 1, 9)
    offsets[[0, -1]] = 0
    counted = rng.random((9, 20)) < 0.7
    starts = np.arange(0, 20, groups)
    judge = LargestError(offsets, times, starts, np.full(20 // groups, groups), "spline", counted)
    choices = np.array([[a, b] for a in range(1, 8) for b in range(a + 1, 8)])
    best = judge.best(choices, Choice((), np.inf))
    errors = []
    for frames in choices:
        path = cardinal_curves(times[frames], "spline")
        missed = sum(
            curve(times)[:, None, None] * offsets[frame]
            for curve, frame in zip(path, frames, strict=True)
        )
        away = np.linalg.norm(missed - offsets, axis=2) * counted
        sums, counts = (own.reshape(9, -1, groups).sum(axis=2) for own in (away, counted))
        errors.append((sums / np.maximum(counts, 1)).max())
    assert best.error == pytest.approx(min(errors), rel=1e-9)
    assert list(best.frames) == choices[int(np.argmin(errors))].tolist()


def test_a_curve_of_which_nothing_counts_has_no_error(rows: CurveNetwork) -> None:
    along = CurveVertices.of(rows, 20)
    counted = np.arange(20) >= 5
    average, maximum = curve_errors(np.ones((20, 3)), np.zeros((20, 3)), along, 1.0, counted)
    np.testing.assert_allclose(average, np.sqrt([0, 3, 3, 3]))
    np.testing.assert_allclose(maximum, np.sqrt([0, 3, 3, 3]))


def test_texts_say_how_much_counts(motion: em.MeshSequence, rows: CurveNetwork) -> None:
    truth, confidence = spoiled(motion, {2: [3], 4: [3, 11, 17]})
    found = em.evaluate(truth, ["linear", "beam:2"], rows, confidence=confidence)
    text = " ".join(str(found).split())
    assert found.covered == pytest.approx((19 + 17 + 3 * 20) / 100)
    assert "Confidence: 96.0 % of the vertices count" in text.replace("\u00a0", " ")
    assert "85.0 % in frame p04.obj" in text.replace("\u00a0", " ")
    linear = found["linear"]
    assert linear.unmasked_lme is not None
    row = next(line for line in str(found).splitlines() if "linear " in line)
    assert row.split()[-1] == f"{100 * linear.unmasked_lme:.3f}"
    assert max(map(len, str(found.table()).splitlines())) <= 100
    assert "low confidence" in found._repr_html_()
    page = json.loads(found.to_json())
    assert page["methods"][0]["unmasked_lme"] == linear.unmasked_lme
    assert page["confidence"]["covered"] == found.covered
    assert page["confidence"]["least"] == 0.5
    np.testing.assert_allclose(page["confidence"]["covered_by_frame"][2], 0.95)
    assert page["confidence"]["counted"][0][4] == 4  # of the first curve in the fifth frame
    read = list(csv.DictReader(io.StringIO(found.to_csv())))
    assert float(read[0]["unmasked_lme"]) == linear.unmasked_lme


def test_without_confidence_nothing_is_said_of_it(
    motion: em.MeshSequence, rows: CurveNetwork
) -> None:
    plain = em.evaluate(motion, ["linear"], rows)
    assert plain.coverage == ""
    for text in (str(plain), plain.to_csv(), plain.to_json(), plain._repr_html_()):
        assert "onfidence" not in text
        assert "unmasked" not in text


def test_the_file_beside_the_poses_is_used(motion: em.MeshSequence, tmp_path: Path) -> None:
    truth, confidence = spoiled(motion, {3: [8]})
    em.write_sequence(tmp_path / "p##.obj", truth)
    names = em.read_sequence(tmp_path).names
    poses = {Path(name).stem: own for name, own in zip(names, confidence.values(), strict=True)}
    write_confidence(tmp_path / "confidence.npz", poses | {"another": np.ones(20)})
    for given in (tmp_path, str(tmp_path / "p##.obj")):
        found = em.evaluate(given, "linear")
        assert found.covered == pytest.approx(0.99)
        assert found["linear"].lme < 0.5 < (found["linear"].unmasked_lme or 0)
    assert em.evaluate(tmp_path, "linear", least_confidence=0.1).covered == 1
    everything = em.evaluate(tmp_path, "linear", least_confidence=0)
    assert everything.confidence is None
    assert everything["linear"].lme == found["linear"].unmasked_lme
    # A motion in hand has no folder; its confidence is given.
    sequence = em.read_sequence(tmp_path)
    assert em.evaluate(sequence, "linear").confidence is None
    again = em.evaluate(sequence, "linear", confidence=tmp_path / "confidence.npz")
    assert again["linear"].lme == found["linear"].lme


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"p00": np.ones(20)}, "no confidence for the frame p01.obj, but for p00"),
        ({f"p0{i}": np.ones(19) for i in range(7)}, "has 19 numbers, but the motion has 20"),
        ({f"p0{i}": np.full(20, 2.0) for i in range(7)}, "from 0 to 1, found 2 for vertex 0"),
        ({f"p0{i}": np.full(20, np.nan) for i in range(7)}, "found nan for vertex 0"),
        ({f"p0{i}": "sure" for i in range(7)}, "must be numbers"),
        (np.ones((6, 20)), r"the shape \(7, 20\), found \(6, 20\)"),
        (np.ones(20), r"found \(20,\)"),
        (-np.ones((7, 20)), "found -1 for vertex 0"),
        (np.zeros((7, 20)), "no vertex of any curve has a confidence of 0.5"),
        (Confidence(np.ones((5, 20))), r"found \(5, 20\)"),
    ],
)
def test_what_does_not_fit_is_refused(
    motion: em.MeshSequence, rows: CurveNetwork, given: Any, said: str
) -> None:
    with pytest.raises(ParameterError, match=said):
        em.evaluate(motion, "linear", rows, confidence=given)


@pytest.mark.parametrize("least", [-0.1, 1.5, np.nan, "half", True])
def test_the_least_confidence_is_a_share(motion: em.MeshSequence, least: Any) -> None:
    with pytest.raises(ParameterError, match="least confidence must be a"):
        em.evaluate(motion, "linear", least_confidence=least)


def test_a_file_of_other_poses_is_named(motion: em.MeshSequence, tmp_path: Path) -> None:
    write_confidence(tmp_path / "c.npz", {"smile": np.ones(20)})
    with pytest.raises(FormatError, match=r"c\.npz.* no confidence for the frame p00\.obj"):
        em.evaluate(motion, "linear", confidence=tmp_path / "c.npz")
    write_confidence(tmp_path / "d.npz", {f"p0{i}": np.ones(21) for i in range(7)})
    with pytest.raises(FormatError, match="belongs to other poses"):
        em.evaluate(motion, "linear", confidence=tmp_path / "d.npz")


def test_parts_of_a_take_have_their_own_confidence(rows: CurveNetwork, curved: em.Morph) -> None:
    """Each movement is judged as it would be alone, with its part of the confidence."""
    rise = np.concatenate([np.zeros(40), np.linspace(0, 1, 20), np.ones(3), np.linspace(1, 0, 20)])
    take = em.MeshSequence(curved.neutral, curved.at(np.concatenate([rise, np.zeros(40)])))
    values = np.random.default_rng(1).uniform(0.3, 1, (len(take), 20))
    mask = Confidence(values, 0.35)
    judged = evaluate_movements(take, rows, lambda *_: ["linear"], confidence=mask)
    assert len(judged) == 2
    for one in judged:
        move = one.movement
        part = take.part(move.start, move.stop)
        own = values[move.start : move.stop + 1]
        expected = em.evaluate(part, "linear", rows, confidence=own, least_confidence=0.35)
        assert one.evaluation["linear"].lme == expected["linear"].lme
        assert one.evaluation.covered == expected.covered < 1
    backwards = mask.part(9, 4)
    np.testing.assert_array_equal(backwards.values, values[4:10][::-1])
    assert replace(backwards, least=0.5).counted.sum() < backwards.counted.sum()


def test_what_moves_is_told_apart(motion: em.MeshSequence, rows: CurveNetwork) -> None:
    """A still back of the head that nobody photographed takes nothing from the face."""
    frames = motion.frames.copy()
    frames[:, :10] = frames[0, :10]  # still, but for less than anybody sees
    frames[3, :10] += 1e-3
    truth = em.MeshSequence(motion.mesh, frames, motion.times, motion.names)
    values = np.ones((7, 20))
    values[:, :8], values[:, 15] = 0, 0.4
    found = em.evaluate(truth, "linear", rows, confidence=values)
    page = json.loads(found.to_json())["confidence"]
    assert page["covered"] == pytest.approx(11 / 20)
    assert page["covered_moving"] == pytest.approx(9 / 10)
    assert "55.0 % of the vertices count, 90.0 % of those that move" in found.coverage.replace(
        "\u00a0", " "
    )
    ends = em.evaluate(motion.part(0, 6), "linear", rows, confidence=values)
    assert "between the ends" in ends.coverage
