"""Lids of an eye whose geometry is known: margins by their numbers, latitudes about its middle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import elastomorph as em
from elastomorph.holding import lids
from elastomorph.holding.eyes import blinks_of, fit_sphere
from elastomorph.rig.laws import Corrective
from small_eye import LONGITUDES, MOVES, SKIN_VERTICES, Points, eye, slit
from small_head import straight


def added(held: em.Held) -> list[em.Morph]:
    """The morphs that were added."""
    return [held.rig[row.name] for row in held.corrections if row.law]


def test_gains_are_the_parts_of_the_opening_that_sliders_take_away() -> None:
    """Of the blink 1, whose overlap is that of shut lids; of others in the ratio they move.

    To a few percent: up is the way of the blink, which leans back, so that places along the slit
    are not quite those of its vertices.
    """
    (row, *_) = em.hold(eye(**MOVES)).corrections
    gains = dict(zip(row.drivers, row.numbers, strict=True))
    assert row.law == "hinge"
    assert gains["eyeBlinkLeft"] == pytest.approx(1, abs=0.02)
    assert gains["eyeSquintLeft"] == pytest.approx(0.3 / 1.1, abs=0.02)
    assert gains["eyeWideLeft"] == pytest.approx(-0.2 / 1.1, abs=0.02)


def test_nothing_changes_where_the_eye_is_not_shut() -> None:
    """To the bit: every slider alone, and together up to Σ κ w = 1."""
    rig = eye(**MOVES)
    held = em.hold(rig).rig
    faces = [{name: weight} for name in MOVES for weight in (0.3, 1.0)]
    faces += [{"eyeBlinkLeft": 0.6, "eyeSquintLeft": 1.0}, dict.fromkeys(MOVES, 0.9)]
    for face in faces:
        np.testing.assert_array_equal(held.pose(face), rig.pose(face))
    assert held.names == rig.names
    assert all(held.morphs[name] is rig.morphs[name] for name in rig)


@pytest.mark.parametrize("blink", [0.8, 0.9, 1.0])
@pytest.mark.parametrize("squint", [0.8, 1.0])
def test_lids_that_are_shut_stay_on_each_other(blink: float, squint: float) -> None:
    """Where the sum leads them past each other, they lie as far over each other as by the blink."""
    rig = eye(**MOVES)
    held = em.hold(rig).rig
    face = {"eyeBlinkLeft": blink, "eyeSquintLeft": squint}
    alone = slit(rig.pose({"eyeBlinkLeft": 1.0}))
    before, after = slit(rig.pose(face)), slit(held.pose(face))
    assert after.max() < 0
    assert np.abs(after - alone).max() < max(0.01, 0.2 * np.abs(before - alone).max())


def test_no_vertex_sinks_into_the_eyeball() -> None:
    """No deeper than by one slider alone."""
    rig = eye(**MOVES)
    held = em.hold(rig).rig
    skin = slice(0, SKIN_VERTICES)

    def lowest(positions: Points) -> float:
        return float(np.linalg.norm(positions[skin], axis=1).min())

    alone = min(lowest(rig.pose({n: w})) for n in MOVES for w in (0.25, 0.5, 0.75, 1.0))
    for squint in (0.5, 1.0):
        assert lowest(held.pose({"eyeBlinkLeft": 1.0, "eyeSquintLeft": squint})) > alone - 2e-3


def test_to_hold_a_rig_that_is_held_adds_nothing() -> None:
    once = em.hold(eye(**MOVES))
    twice = em.hold(once.rig)
    assert twice.rig is once.rig
    assert [row.note for row in twice.corrections] == ["eyeBlinkLeft is held already, and kept"]


def test_a_take_says_in_how_many_frames_lids_pass() -> None:
    rig = eye(**MOVES)
    weights = np.zeros((20, 3))
    weights[:, rig.names.index("eyeBlinkLeft")] = 0.9
    weights[5:, rig.names.index("eyeSquintLeft")] = 0.9
    take = em.Performance(rig.names, np.arange(20) / 30, weights, 30.0)
    rows = em.hold(rig, take).corrections
    assert [row.frames for row in rows] == [15, 15]
    assert [row.targets for row in rows] == [1, 1]
    assert all(row.after < 0.2 * row.before for row in rows)
    assert all(row.fractions[0] == row.before / rig.neutral.diameter for row in rows)


def test_other_correctives_are_kept() -> None:
    rig = eye(**MOVES, fold=(0.0, 0.05))
    product = Corrective(("eyeBlinkLeft", "eyeSquintLeft"))
    with_fold = em.Rig(rig.neutral, dict(rig.morphs), correctives={"fold": product})
    held = em.hold(with_fold).rig
    assert held.sliders.correctives["fold"] == product
    assert len(held.sliders.correctives) == 3


def pair(names: Sequence[str]) -> em.Rig:
    """Return two eyes side by side, which the same sliders shut."""
    one = eye(**MOVES)
    rest = one.neutral.vertices

    def both(points: Points) -> Points:
        return np.concatenate([points + (x, 0, 0) for x in (-2.0, 2.0)])

    faces = [face + offset for offset in (0, len(rest)) for face in one.neutral.faces]
    neutral = em.Mesh(both(rest), faces)
    ends = [neutral.with_vertices(both(morph.target.vertices)) for morph in one.morphs.values()]
    return em.Rig(neutral, dict(zip(names, ends, strict=True)), method="linear")


def bridged(rig: em.Rig) -> em.Rig:
    """Return the rig with its two eyes in one skin: a strip from one to the other."""
    half, columns = len(rig.neutral.vertices) // 2, len(LONGITUDES)
    strip = [half + columns, half, columns - 1, 2 * columns - 1]
    neutral = em.Mesh(rig.neutral.vertices, [*rig.neutral.faces, strip])
    ends = {n: neutral.with_vertices(m.target.vertices) for n, m in rig.morphs.items()}
    return em.Rig(neutral, ends, method="linear")


def test_one_slider_may_shut_both_eyes() -> None:
    rows = em.hold(bridged(pair(("Blink", "squint", "wide")))).corrections
    assert [row.name for row in rows] == [f"hold_Blink_{number}" for number in (1, 2, 3, 4)]
    assert not any(row.note for row in rows)


def test_a_blink_of_one_eye_that_shuts_two_is_left_out() -> None:
    rows = em.hold(bridged(pair(("eyeBlinkLeft", "squint", "wide")))).corrections
    assert [row.note for row in rows] == ["eyeBlinkLeft moves 2 lids far, expected 1"]


@pytest.mark.parametrize(
    ("rig", "problem"),
    [
        (eye(eyeSquintLeft=(0.0, 0.1)), "no slider that shuts an eye"),
        (em.Rig(em.Mesh([[0, 0, 0], [1, 0, 0]]), {}), "polygons"),
        ("rig.glb", "a Rig, found str"),
    ],
)
def test_what_cannot_be_held_is_an_error(rig: em.Rig, problem: str) -> None:
    with pytest.raises(em.ParameterError, match=problem):
        em.hold(rig)


def test_a_take_must_be_one() -> None:
    with pytest.raises(em.ParameterError, match="takes are performances, found str"):
        em.hold(eye(**MOVES), "take.csv")  # type: ignore[arg-type]


def test_lids_modelled_shut_are_told() -> None:
    rig = eye(eyeBlinkLeft=(-1.0, 0.0))
    closed = rig.morphs["eyeBlinkLeft"].target
    held = em.hold(em.Rig(closed, {"eyeBlinkLeft": rig.neutral}, method="linear"))
    (row,) = held.corrections
    assert "slit" in row.note
    assert row.targets == 0


@pytest.mark.parametrize(
    ("above", "note"),
    [(0.0, "moves nothing"), (-0.3, "takes away only"), (-1.1, "nothing shuts the eye beyond")],
)
def test_an_eye_that_is_left_out_is_told(above: float, note: str) -> None:
    """A blink that moves nothing, one that shuts little, and one beside which nothing shuts."""
    rig = eye(eyeBlinkLeft=(above, 0.0))
    held = em.hold(rig)
    assert held.rig is rig
    (row,) = held.corrections
    assert note in row.note
    assert row.targets == 0


def test_blinks_are_known_in_any_spelling() -> None:
    """Those of one eye where there are any."""
    assert blinks_of(["face.EyeBlink_L", "Blink", "smile"]) == {"face.EyeBlink_L": False}
    assert blinks_of(["Fcl_EYE_Close", "Fcl_EYE_Joy"]) == {"Fcl_EYE_Close": True}
    assert blinks_of(["Blink_R", "jawOpen"]) == {"Blink_R": False}


def test_a_sphere_is_found_without_the_cornea() -> None:
    random = np.random.default_rng(1)
    points = random.normal(size=(400, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    points[points[:, 2] > 0.8] *= 1.1
    centre, radius, uneven = fit_sphere(2.5 * points + [3, 4, 5])
    np.testing.assert_allclose(centre, [3, 4, 5], atol=1e-6)
    assert radius == pytest.approx(2.5, rel=1e-6)
    assert uneven < 1e-6


def test_a_head_is_held() -> None:
    names = ("eyeBlink_L", "eyeBlink_R", "eyeSquint_L", "eyeSquint_R", "eyeLookDown_L",
             "eyeLookDown_R", "cheekSquint_L", "cheekSquint_R")  # fmt: skip
    rows = em.hold(straight(*names)).corrections
    assert {row.name[:-2] for row in rows} == {"hold_eyeBlink_L", "hold_eyeBlink_R"}
    assert all(row.after < 0.5 * row.before for row in rows)


def test_an_eye_that_looks_aside_stays_shut() -> None:
    """Its bulge shuts one half of the slit and opens another: neither is taken back."""
    names = ("eyeBlink_L", "eyeSquint_L", "eyeLookIn_L", "eyeLookOut_L")
    rig = straight(*names)
    held = em.hold(rig)
    for row in held.corrections:
        gains = dict(zip(row.drivers, row.numbers, strict=True))
        assert gains.get("eyeLookIn_L", 0) <= 0
        assert gains.get("eyeLookOut_L", 0) <= 0
    for aside in names[2:]:
        face = {"eyeBlink_L": 1.0, aside: 1.0}
        np.testing.assert_array_equal(held.rig.pose(face), rig.pose(face))


def test_a_corrective_takes_back_no_more_of_the_blink_than_it_may(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(lids, "_BACK", 0.5)
    rig = eye(**MOVES)
    blink = np.linalg.norm(rig["eyeBlinkLeft"].delta, axis=1)
    far = sum(np.linalg.norm(one.delta, axis=1) for one in added(em.hold(rig)))
    assert (far <= 0.5 * blink + 1e-4).all()
    assert far.max() == pytest.approx(0.5 * blink.max(), rel=0.05)
