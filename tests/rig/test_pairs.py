"""Pair bends: single sliders stay what they are, and both together are on the path to both."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.rig.build import extent_of, with_paths
from elastomorph.rig.pairs import is_pair_bend
from small_head import head, shapes

NAME = "jawOpen_mouthClose"
WEIGHT = st.floats(-0.5, 1.5)


@pytest.fixture(scope="module")
def rig() -> em.Rig:
    """Two targets that meet and one that does not."""
    return em.Rig(head(), {n: shapes()[n] for n in ("jawOpen", "mouthClose", "browDown_L")})


@pytest.fixture(scope="module")
def alone(rig: em.Rig) -> em.Rig:
    """The same without the pair bend."""
    return em.Rig(rig.neutral, {name: rig[name] for name in rig.names})


def test_auto_finds_the_two_that_meet(rig: em.Rig) -> None:
    assert rig.names == ("jawOpen", "mouthClose", "browDown_L")
    assert rig.pair_bends() == {NAME: em.Corrective(("jawOpen", "mouthClose"), "min")}
    pair = rig[NAME]
    assert is_pair_bend(pair)
    assert not pair.delta.any()
    assert pair.choice is not None
    assert pair.choice.meeting > 2.5
    assert not pair.choice.straight
    assert "pair bend" in pair.choice.text


def test_its_ratio_is_what_a_search_over_the_grid_finds(rig: em.Rig) -> None:
    """Every vertex, with nothing left out that cannot be large."""
    one, other = rig["jawOpen"], rig["mouthClose"]
    least, levels = 1e-3 * extent_of(rig), np.arange(1, 9) / 8
    found = np.zeros(len(rig.neutral.vertices))
    for s in levels:
        for t in levels:
            straight = s * one.delta + t * other.delta
            bent = one.at(s) + other.at(t) - 2 * rig.neutral.vertices - straight
            away, moved = (np.linalg.norm(own, axis=1) for own in (bent, straight))
            ratio = np.where(away > least, away / np.maximum(moved, least), 0.0)
            found = np.maximum(found, ratio)
    choice = rig[NAME].choice
    assert choice is not None
    assert choice.meeting == pytest.approx(np.sort(found)[-10], rel=1e-9)


@given(name=st.sampled_from(["jawOpen", "mouthClose", "browDown_L"]), t=WEIGHT, other=WEIGHT)
def test_what_does_not_meet_moves_to_the_bit_as_before(
    rig: em.Rig, alone: em.Rig, name: str, t: float, other: float
) -> None:
    for weights in ({name: t}, {name: t, "browDown_L": other}, {"jawOpen": t, "mouthClose": 0.0}):
        assert np.array_equal(rig.pose(weights), alone.pose(weights))


def test_targets_and_corners_stay(rig: em.Rig, alone: em.Rig) -> None:
    both = {"jawOpen": 1.0, "mouthClose": 1.0}
    assert np.array_equal(rig.pose(both), alone.pose(both))


@given(m=st.floats(0, 1))
def test_both_alike_are_on_the_path_to_both(rig: em.Rig, m: float) -> None:
    one, other = rig["jawOpen"], rig["mouthClose"]
    target = rig.neutral.with_vertices(rig.neutral.vertices + one.delta + other.delta)
    path = _path(rig.neutral, target, extent_of(rig))
    away = np.linalg.norm(path.at(m) - rig.pose({"jawOpen": m, "mouthClose": m}), axis=1).max()
    assert away <= 1e-4 * extent_of(rig) + 1e-10


def test_what_it_hardly_moves_it_does_not_move(rig: em.Rig) -> None:
    peaks = [curve.height for curve in rig[NAME].bend_curves]
    moves = np.einsum("k,kv->v", peaks, np.linalg.norm(rig[NAME].bends, axis=2))
    assert moves[moves > 0].min() >= 1e-4 * extent_of(rig)


_PATHS: dict[bytes, em.Morph] = {}


def _path(neutral: em.Mesh, target: em.Mesh, extent: float) -> em.Morph:
    key = target.vertices.tobytes()
    if key not in _PATHS:
        ends = [*(shapes()[n] for n in ("jawOpen", "mouthClose", "browDown_L")), target]
        _PATHS[key] = em.prepare(neutral, "auto", extent=extent, targets=ends)(target)
    return _PATHS[key]


def test_facing_lips_slide_less(rig: em.Rig, alone: em.Rig) -> None:
    """Between lips that the straight rig keeps together, at most 0.1 % of D is left."""
    straight = with_paths(alone, "linear")
    rest, normals = rig.neutral.vertices, _normals(rig.neutral)
    moved = np.flatnonzero(
        np.linalg.norm(rig["jawOpen"].delta + 0 * rest, axis=1)
        * np.linalg.norm(rig["mouthClose"].delta, axis=1)
        > 0
    )
    apart = np.linalg.norm(rest[moved, None] - rest[moved], axis=2)
    apart[normals[moved] @ normals[moved].T > -0.3] = np.inf
    facing = apart.argmin(axis=1)
    extent = extent_of(rig)
    close = apart.min(axis=1) < 0.02 * extent
    one, other = moved[close], moved[facing[close]]

    def between(of: em.Rig, m: float) -> np.ndarray:
        face = of.pose({"jawOpen": m, "mouthClose": m})
        return face[one] - face[other]

    times = np.linspace(0, 1, 9)
    line = np.stack([between(straight, m) for m in times])
    kept = np.linalg.norm(line - line[0], axis=2).max(axis=0) < 2e-3 * extent
    assert kept.sum() >= 10
    slides = [
        np.linalg.norm(np.stack([between(of, m) for m in times]) - line, axis=2)[:, kept].max()
        for of in (alone, rig)
    ]
    assert slides[1] <= 1e-3 * extent
    assert slides[1] <= 0.35 * slides[0]


def _normals(mesh: em.Mesh) -> np.ndarray:
    corners = mesh.faces.triangles()
    a, b, c = (mesh.vertices[corners[:, k]] for k in range(3))
    found = np.zeros_like(mesh.vertices)
    for k in range(3):
        np.add.at(found, corners[:, k], np.cross(b - a, c - a))
    return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-30)


@pytest.mark.parametrize("method", ["linear", "ease:2", "beam:2"])
def test_paths_that_turn_nothing_add_up(method: str) -> None:
    rig = em.Rig(head(), {n: shapes()[n] for n in ("jawOpen", "mouthClose")}, method=method)
    assert list(rig.morphs) == ["jawOpen", "mouthClose"]


def test_paths_made_anew_have_pair_bends_of_their_own(rig: em.Rig) -> None:
    assert with_paths(rig, "linear").names == tuple(with_paths(rig, "linear").morphs)
    again = with_paths(with_paths(rig, "linear"), "auto")
    assert np.array_equal(again[NAME].bends, rig[NAME].bends)
    assert list(again.morphs) == list(rig.morphs)
    one = with_paths(rig, "linear", names=["browDown_L"])
    assert one[NAME] is rig[NAME]
    assert NAME not in with_paths(rig, "linear", names=["jawOpen"])


def test_shapes_that_correct_paths_stay_straight(rig: em.Rig) -> None:
    law = em.Corrective(("jawOpen", "browDown_L"), "hinge", (1.0, 0.5))
    morphs = {name: rig[name] for name in rig.names}
    morphs["held"] = em.interpolate(head(), shapes()["jawOpen"], "linear")
    for method in (None, "auto"):
        made = with_paths(em.Rig(head(), morphs, correctives={"held": law}), method)
        assert made["held"] is morphs["held"]


def test_a_path_made_anew_meets_those_that_stay(rig: em.Rig) -> None:
    """One after the other as all at once, also by another method that turns."""
    straight = with_paths(rig, "linear", names=["jawOpen"])
    again = with_paths(straight, "auto", names=["jawOpen"])
    assert again.pair_bends() == rig.pair_bends()
    assert np.allclose(again[NAME].bends, rig[NAME].bends, rtol=0, atol=1e-12 * head().diameter)
    assert with_paths(rig, "rotation", names=["mouthClose"]).pair_bends() == rig.pair_bends()
    assert not with_paths(straight, "auto", names=["browDown_L"]).pair_bends()


def test_a_part_of_a_rig_keeps_the_pair_bends_within(rig: em.Rig) -> None:
    assert list(rig.only(["mouthClose", "jawOpen"]).morphs) == ["mouthClose", "jawOpen", NAME]
    assert list(rig.only(["jawOpen"]).morphs) == ["jawOpen"]
    with pytest.raises(em.ParameterError):
        rig.only([NAME])


def test_what_others_drive_has_no_pair_bend() -> None:
    drivers = ("jawOpen", "mouthClose")
    morphs = {name: shapes()[name] for name in drivers}
    rig = em.Rig(head(), morphs, correctives={"mouthClose": drivers})
    assert list(rig.morphs) == [*drivers]


def test_where_another_has_its_name_it_has_another(rig: em.Rig) -> None:
    morphs = {name: rig[name].target for name in rig.names} | {NAME: shapes()["browDown_L"]}
    made = em.Rig(head(), morphs)
    assert made.pair_bends().keys() == {NAME + "_"}
    assert NAME in made.names


@pytest.mark.parametrize("suffix", ["npz", "glb", "usda"])
def test_a_file_gives_it_back(rig: em.Rig, tmp_path, suffix: str) -> None:
    em.write(tmp_path / f"rig.{suffix}", rig)
    read = em.read_rig(tmp_path / f"rig.{suffix}")
    assert read.pair_bends() == rig.pair_bends()
    weights = {"jawOpen": 0.6, "mouthClose": 0.45}
    away = np.abs(read.pose(weights) - rig.pose(weights)).max()
    assert away <= {"npz": 0.0}.get(suffix, 1e-6) * head().diameter


@pytest.mark.parametrize("still", ["jawOpen", "mouthClose"])
def test_where_one_is_at_time_0_the_other_is_alone(rig: em.Rig, still: str) -> None:
    """Whichever of both is named first."""
    both = {"jawOpen": 1.0, "mouthClose": 1.0}
    (other,) = {*both} - {still}
    alone = rig.blend({other: 1.0}, 0.5)
    found = rig.blend(both, {still: 0.0, other: 0.5})
    assert np.allclose(found, alone, rtol=0, atol=1e-12 * head().diameter)
    table = np.array([[both.get(name, 0.0) for name in rig.names]])
    times = np.array([[{still: 0.0, other: 0.5}.get(name, 1.0) for name in rig.names]])
    (batched,) = rig.batch(table, times, dtype=np.float64)
    assert np.allclose(batched, alone, rtol=0, atol=1e-12 * head().diameter)


def test_both_sliders_are_found_from_rest(rig: em.Rig) -> None:
    """Handles where the two nearly cancel; a pair bend has a kink where either is at 0."""
    wanted = {"jawOpen": 0.6, "mouthClose": 0.5, "browDown_L": 0.0}
    face = rig.pose(wanted)
    farthest = np.argsort(-np.linalg.norm(rig["mouthClose"].delta, axis=1))[:40]
    solved = rig.solve({int(vertex): face[vertex] for vertex in farthest})
    assert solved.reached
    assert dict(solved.weights) == pytest.approx(wanted, abs=1e-3)
