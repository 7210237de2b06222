"""What a plan adds to a character, on meshes small enough to know it beforehand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from elastomorph.bending.plan import BentMorph, Plan, make_plan
from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.build import bare_rig, extent_of
from elastomorph.rig.laws import Corrective
from small_head import head, shapes
from small_meshes import grid

ARCH = BendCurve.polynomial([0, 1, -1])  # t - t², at most 1/4
FLAT = grid(4, 3)
SWING = BendCurve.polynomial([0, 0, 4, -4])
SIZE = np.hypot(3, 2)
TIMES = np.linspace(0, 1, 101)


def pushed(direction: tuple[float, float, float], *vertices: int) -> NDArray[np.float64]:
    """(12, 3) some vertices moved, all by default."""
    field = np.zeros(FLAT.vertices.shape)
    field[list(vertices) if vertices else slice(None)] = direction
    return field


def morph(delta: NDArray[np.float64], *bends: tuple[BendCurve, NDArray[np.float64]]) -> Morph:
    target = replace(FLAT, vertices=FLAT.vertices + delta)
    fields = np.array([field for _, field in bends]).reshape(-1, *delta.shape)
    return Morph(FLAT, target, fields, tuple(curve for curve, _ in bends))


UP = pushed((0, 0, 1))


def shape_of(bent: BentMorph, t: float) -> NDArray[np.float64]:
    """Where a runtime puts the vertices, which knows Δ, fold, bends and curves."""
    own = bent.morph
    weight = t + (bent.fold.at(t) if bent.fold else 0.0)
    bends = sum((c.at(t) * d for c, d in zip(own.bend_curves, own.bends, strict=True)), start=0.0)
    return own.neutral.vertices + weight * own.delta + bends


def strayed(plan: Plan, bent: BentMorph) -> float:
    """How far what is stored is from the path, as a fraction of D."""
    whole = plan.rig.morphs[bent.name]
    gaps = [shape_of(bent, float(t)) - whole.at(float(t)) for t in TIMES]
    return float(np.linalg.norm(gaps, axis=2).max()) / plan.extent


def test_the_gain_is_the_largest_distance_from_the_straight_line():
    # t - t² times 0.4 to the side: 0.1 at most, at t = 1/2.
    rig = Rig(FLAT, {"a": morph(UP, (ARCH, pushed((0.4, 0, 0), 5)))})
    plan = make_plan(rig)
    assert plan.extent == pytest.approx(SIZE)
    (bent,) = plan.bent
    assert (bent.name, bent.fold) == ("a", None)
    assert bent.gain == pytest.approx(0.1 / SIZE, rel=1e-12)
    assert bent.error == 0


def test_a_peak_between_samples_is_found_to_a_thousandth():
    curve = BendCurve.power(7)
    rig = Rig(FLAT, {"a": morph(UP, (curve, pushed((2, 0, 0), 5)))})
    found = make_plan(rig).bent[0].gain * SIZE
    assert 2 * abs(curve.peak[1]) * (1 - 1.2e-3) <= found <= 2 * abs(curve.peak[1]) * (1 + 1e-12)


@pytest.mark.parametrize("noise", [0, 1e-18, 1e-17, 1e-16, 3e-16, 1e-15, 1e-12])
def test_noise_in_one_of_two_bends_leaves_the_most_of_the_path(noise):
    """Merged into fewer bends, t - t² times 0.4 is off by noise only, whatever t³ - t² adds."""
    arch, cubic = (ARCH, pushed((0.4, 0, 0), 5)), BendCurve.polynomial([0, 0, -1, 1])
    side = pushed((0, 0.4, 0), 7)
    own = morph(UP, arch, (ARCH, side), (cubic, noise * side), (cubic, 0.3 * side))
    plan = make_plan(Rig(FLAT, {"a": own}))
    assert strayed(plan, plan.bent[0]) < 1e-3
    (only,) = make_plan(Rig(FLAT, {"a": morph(UP, arch, (cubic, noise * side))})).bent
    assert only.morph.bend_curves[0].height * only.morph.bends[0].max() == pytest.approx(0.1)


def test_what_stays_within_the_tolerance_of_its_straight_line_is_not_bent():
    rig = Rig(
        FLAT,
        {
            "straight": morph(UP),
            "hardly": morph(UP, (ARCH, pushed((4 * 0.9e-3 * SIZE, 0, 0), 5))),
            "bent": morph(UP, (ARCH, pushed((4 * 1.1e-3 * SIZE, 0, 0), 5))),
        },
    )
    plan = make_plan(rig, tolerance=1e-3)
    assert [bent.name for bent in plan.bent] == ["bent"]
    assert plan.left_out == ()


def test_curves_are_turned_positive():
    plan = make_plan(Rig(FLAT, {"a": morph(UP, (BendCurve.power(2), pushed((1, 0, 0), 5)))}))
    own = plan.bent[0].morph
    assert own.bend_curves[0].at(0.5) == 0.25
    assert own.bends[0, 5].tolist() == [-1, 0, 0]


def test_what_moves_next_to_nothing_is_left_out_within_the_tolerance():
    small = 4 * 0.4e-3 * SIZE
    bends = (pushed((1, 0, 0), 5), pushed((0, small, 0), 5, 6), pushed((0, 0, small), 6))
    curves = (ARCH, BendCurve.polynomial([0, 0, 1, -1]), ARCH)
    plan = make_plan(Rig(FLAT, {"a": morph(UP, *zip(curves, bends, strict=True))}), tolerance=1e-3)
    (bent,) = plan.bent
    assert len(bent.morph.bends) == 1
    assert not bent.morph.bends[0, 6].any()
    assert 0 < strayed(plan, bent) <= bent.error <= 1e-3


def test_paths_with_more_bends_than_directions_need_fewer():
    # Three curves, but everything moves along one field: one product of curve and field.
    field = pushed((0.3, 0.1, 0), 4, 5, 6)
    curves = [BendCurve.power(k) for k in (2, 3, 4)]
    whole = morph(UP, *((curve, (k + 1) * field) for k, curve in enumerate(curves)))
    plan = make_plan(Rig(FLAT, {"a": whole}))
    (bent,) = plan.bent
    assert len(bent.morph.bends) == 1
    assert bent.morph.bend_curves[0].peak[1] == pytest.approx(1)
    assert strayed(plan, bent) <= 1e-12


def test_fewer_bends_have_positive_curves_too():
    fields = [pushed((0.5, 0, 0), 4, 5), pushed((0.2, 0.4, 0), 5, 6)]
    mixed = [fields[0], fields[1], fields[0] - 0.5 * fields[1]]
    curves = [BendCurve.power(k) for k in (2, 3, 4)]
    plan = make_plan(Rig(FLAT, {"a": morph(UP, *zip(curves, mixed, strict=True))}))
    (bent,) = plan.bent
    assert len(bent.morph.bends) == 2
    assert min(curve(TIMES).min() for curve in bent.morph.bend_curves) >= -1e-9
    assert strayed(plan, bent) <= max(bent.error, 1e-12)


@pytest.mark.parametrize("method", ["ease:2", "cosine", "beam:2"])
def test_a_path_at_another_pace_folds_entirely(method):
    # Where all moves alike, a beam has only its rigid mode: the line at the pace of the load.
    target = replace(FLAT, vertices=FLAT.vertices + pushed((0.2, 0, 1)))
    plan = make_plan(bare_rig(FLAT, {"a": target}), method, fold=True)
    (bent,) = plan.bent
    assert bent.fold is not None
    assert len(bent.morph.bends) == 0
    assert bent.gain > 0.01
    assert strayed(plan, bent) <= bent.error + 1e-12 <= 1e-5
    for ends in (0.0, 1.0):
        assert bent.fold.at(ends) == 0
    # Beyond the ends it goes on as the path does.
    beyond = plan.rig.morphs["a"].at([-0.5, 1.5])
    assert np.array([shape_of(bent, t) for t in (-0.5, 1.5)]) == pytest.approx(beyond, abs=1e-4)


def test_a_fold_that_saves_no_target_is_not_made():
    # Half of the bend is Δ: folding it would leave a bend all the same.
    rig = Rig(FLAT, {"a": morph(UP, (ARCH, 0.5 * UP + pushed((1, 0, 0), 5)))})
    (bent,) = make_plan(rig, fold=True).bent
    assert bent.fold is None
    assert np.array_equal(bent.morph.bends, rig.morphs["a"].bends)


def test_a_part_is_folded_where_that_saves_a_target():
    side = pushed((1, 0, 0), 5)
    cubic = BendCurve.polynomial([0, 0, 1, -1])
    rig = Rig(FLAT, {"a": morph(UP, (ARCH, 0.5 * UP), (cubic, 0.3 * UP + side))})
    (plain,) = make_plan(rig).bent
    plan = make_plan(rig, fold=True)
    (bent,) = plan.bent
    assert (len(plain.morph.bends), len(bent.morph.bends)) == (2, 1)
    assert bent.fold is not None
    assert strayed(plan, bent) <= max(bent.error, 1e-12)


def sideways(size: float, *vertices: int) -> tuple[BendCurve, NDArray[np.float64]]:
    return ARCH, pushed((size, 0, 0), *vertices)


def names(bent: tuple[BentMorph, ...]) -> list[str]:
    return [own.name for own in bent]


class TestMaxTargets:
    RIG = Rig(
        FLAT,
        {
            "little": morph(UP, sideways(0.1, 5)),
            "most": morph(UP, sideways(0.9, 5)),
            "twice": morph(UP, sideways(0.4, 5), (SWING, pushed((0, 0.1, 0), 5))),
            "more": morph(UP, sideways(0.5, 5)),
        },
    )

    def test_those_that_gain_most_come_first(self):
        plan = make_plan(self.RIG, max_targets=6)
        assert names(plan.bent) == ["most", "more"]
        assert names(plan.left_out) == ["little", "twice"]
        assert [len(own.morph.bends) for own in plan.left_out] == [1, 2]

    def test_one_bend_of_two_where_that_brings_most(self):
        plan = make_plan(self.RIG, max_targets=7)
        assert names(plan.bent) == ["most", "twice", "more"]
        (_, twice, _) = plan.bent
        assert len(twice.morph.bends) == 1
        assert strayed(plan, twice) == pytest.approx(twice.error, rel=0.02)
        assert 1e-5 < twice.error < twice.gain

    def test_with_room_for_all_nothing_changes(self):
        assert names(make_plan(self.RIG, max_targets=9).bent) == [*self.RIG.morphs]
        assert make_plan(self.RIG, max_targets=9).left_out == ()

    def test_a_file_that_is_full_already_gets_nothing(self):
        plan = make_plan(self.RIG, max_targets=3)
        assert plan.bent == ()
        assert names(plan.left_out) == [*self.RIG.morphs]

    def test_a_fold_needs_no_place(self):
        rig = Rig(FLAT, {"paced": morph(UP, (ARCH, UP)), "side": morph(UP, sideways(0.5, 5))})
        plan = make_plan(rig, max_targets=2, fold=True)
        assert names(plan.bent) == ["paced"]
        assert names(plan.left_out) == ["side"]

    def test_a_pair_bend_comes_with_both_of_its_paths(self):
        """Alone it would part what it keeps together; and so would both without it."""
        rig = Rig(
            FLAT,
            {
                "open": morph(UP, sideways(0.4, 5)),
                "close": morph(pushed((0, 0, -1)), sideways(0.5, 5)),
                "other": morph(UP, sideways(0.1, 6)),
                "both": morph(0 * UP, sideways(-0.9, 5)),
            },
            correctives={"both": Corrective(("open", "close"), "min")},
        )
        found = [names(make_plan(rig, max_targets=most).bent) for most in range(3, 8)]
        assert found[0] == []
        assert found[1] == ["close"]
        assert found[2] == ["close", "other"]
        assert found[3] == ["open", "close", "both"]
        assert found[4] == [*rig.morphs]

    def test_each_mesh_counts_what_moves_in_it(self):
        rig = Rig(
            FLAT,
            {"left": morph(UP, sideways(0.5, 0, 4)), "right": morph(UP, sideways(0.4, 3, 7))},
        )
        left, right = np.flatnonzero(FLAT.vertices[:, 0] < 2), np.array([3, 7, 11])
        assert names(make_plan(rig, max_targets=3).bent) == ["left"]
        both = make_plan(rig, max_targets=3, meshes=[(2, left), (2, right)])
        assert names(both.bent) == ["left", "right"]
        full = make_plan(rig, max_targets=3, meshes=[(3, left), (2, right)])
        assert names(full.bent) == ["right"]


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    """A rig of paths with any bends."""
    seeds = draw(st.lists(st.integers(0, 2**32 - 1), min_size=1, max_size=3))
    morphs = {}
    for number, seed in enumerate(seeds):
        rng = np.random.default_rng(seed)
        fields = rng.normal(size=(rng.integers(0, 5), *UP.shape))
        fields *= 10.0 ** rng.uniform(-5, 0, size=(len(fields), 1, 1))
        curves = [BendCurve.power(k + 2) for k in range(len(fields))]
        delta = rng.normal(size=UP.shape)
        share = rng.choice([0.0, 1.0]) * rng.normal(size=(len(fields), 1, 1))
        morphs[f"m{number}"] = morph(
            delta, *zip(curves, fields * rng.choice([0, 1]) + share * delta, strict=True)
        )
    return Rig(FLAT, morphs)


@settings(max_examples=80, deadline=None)
@given(rigs(), st.sampled_from([1e-6, 1e-4, 1e-2]), st.booleans(), st.integers(0, 8))
def test_what_is_stored_is_as_near_to_the_path_as_it_says(rig, tolerance, fold, room):
    whole = make_plan(rig, tolerance=tolerance, fold=fold)
    tight = make_plan(rig, tolerance=tolerance, fold=fold, max_targets=room)
    assert whole.left_out == ()
    assert {*names(tight.bent), *names(tight.left_out)} == {*names(whole.bent)}
    added = sum(len(own.morph.bends) for own in tight.bent)
    assert added == 0 or len(rig.morphs) + added <= room
    for plan in (whole, tight):
        for own in (*plan.bent, *plan.left_out):
            # The bound is found to 0.12 %.
            assert strayed(plan, own) <= own.error * 1.0013 + 1e-12
            assert own.gain > tolerance
    assert all(own.error <= tolerance for own in (*whole.bent, *whole.left_out))
    for own in whole.bent:
        assert len(own.morph.bends) <= len(rig.morphs[own.name].bends)
        assert own.fold or len(own.morph.bends)


def turned_grid(angle: float) -> Mesh:
    """The far half of the grid folded up about x = 1."""
    vertices = FLAT.vertices.copy()
    far = vertices[:, 0] > 1
    arm = vertices[far, 0] - 1
    vertices[far, 0] = 1 + np.cos(angle) * arm
    vertices[far, 2] = np.sin(angle) * arm
    return replace(FLAT, vertices=vertices)


def test_methods_by_name_and_the_others_by_auto():
    rig = bare_rig(FLAT, {name: turned_grid(angle) for name, angle in (("a", 1.0), ("b", 0.8))})
    plan = make_plan(rig, {"a": "ease:3"})
    assert plan.rig.morphs["a"].method == Method.parse("ease:3").label
    assert plan.rig.morphs["b"].choice is not None
    assert names(make_plan(rig, {"a": "linear"}).bent) == ["b"]


def test_only_some_bend():
    rig = bare_rig(FLAT, {name: turned_grid(angle) for name, angle in (("a", 1.0), ("b", 0.8))})
    plan = make_plan(rig, only=["b"])
    assert names(plan.bent) == ["b"]
    assert plan.rig.morphs["a"].bare


def test_methods_hold_their_tolerance_of_what_moves_however_large_the_body():
    far = Mesh(
        np.concatenate([FLAT.vertices, [[0, 1000, 0], [0, 1001, 0], [1, 1000, 0]]]),
        [*FLAT.faces, [12, 13, 14]],
    )
    moved = far.vertices.copy()
    moved[:12] = turned_grid(2.0).vertices
    rig = bare_rig(far, {"a": replace(far, vertices=moved)})
    plan = make_plan(rig, "rotation")
    assert plan.extent == extent_of(rig) < 5
    assert plan.bent[0].error <= 1e-4 + 1e-5


def test_paths_that_a_rig_has_stay():
    rig = Rig(FLAT, {"a": morph(UP, sideways(0.4, 5))})
    assert make_plan(rig).rig is rig
    assert make_plan(rig, "linear").bent == ()


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"only": ["jawopen"]}, "did you mean 'jawOpen'"),
        ({"only": "jawOpen"}, "only is a list of names"),
        ({"method": {"jaw": "linear"}}, "no slider 'jaw'"),
        ({"method": "bent"}, "bent"),
        ({"tolerance": 0}, "tolerance"),
        ({"max_targets": -1}, "most targets"),
    ],
)
def test_what_is_no_plan_is_refused(settings, words):
    with pytest.raises(ParameterError, match=words):
        make_plan(bare_rig(FLAT, {"jawOpen": turned_grid(1.0)}), **settings)


def test_paths_by_several_methods_have_pair_bends():
    ends = {name: shapes()[name] for name in ("jawOpen", "mouthClose", "browDown_L")}
    rig = bare_rig(head(), ends)
    for method in ({"jawOpen": "rotation"}, {"mouthClose": "rotation"}, None):
        assert "jawOpen_mouthClose" in names(make_plan(rig, method).bent)
    assert "jawOpen_mouthClose" not in names(make_plan(rig, {"jawOpen": "linear"}).bent)
