"""Which weight drives which slider."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from spellings import spelled

from elastomorph.errors import ParameterError
from elastomorph.rig.naming import ARKIT
from elastomorph.rig.performance import Drive, Match, match

LIVE_LINK = [spelled(shape, "livelink") for shape in ARKIT]
SIDED = [spelled(shape, "sided") for shape in ARKIT]
STYLES = st.sampled_from(["arkit", "livelink", "sided", "lower"])


@given(STYLES, STYLES, st.randoms(use_true_random=False))
def test_all_shapes_meet_in_any_two_spellings(
    recorded: str, modelled: str, shuffle: random.Random
) -> None:
    """52 weights drive 52 sliders one to one, in whatever order."""
    order = list(ARKIT)
    shuffle.shuffle(order)
    weights = [spelled(shape, recorded) for shape in ARKIT]
    sliders = [spelled(shape, modelled) for shape in order]
    found = match(weights, sliders)
    assert not found.unmatched_weights
    assert not found.unmatched_sliders
    values = np.arange(52.0)[None]
    driven = dict(zip(order, found.drive(values)[0], strict=True))
    assert driven == {shape: i for i, shape in enumerate(ARKIT)}


def test_one_weight_drives_both_sides_in_full() -> None:
    found = match(["BrowInnerUp", "CheekPuff"], ["browInnerUp_L", "browInnerUp_R", "cheekPuff_R"])
    assert found.drive([[0.7, 0.2]]).tolist() == [[0.7, 0.7, 0.2]]
    assert not found.unmatched_weights


def test_two_sides_drive_one_slider_by_their_mean() -> None:
    found = match(["noseSneer_L", "noseSneer_R", "eyeBlink_L"], ["noseSneer", "eyeBlink"])
    assert found.drives == {"noseSneer": (("noseSneer_L", "noseSneer_R"), (0.5, 0.5))}
    assert found.drive([[0.2, 0.6, 1]]).tolist() == [[pytest.approx(0.4), 0]]
    assert found.unmatched_weights == ("eyeBlink_L",)  # one side alone closes no two eyes
    assert found.unmatched_sliders == ("eyeBlink",)


def test_there_and_back_is_the_same() -> None:
    """One weight onto two sides, and their mean back onto one."""
    out = match(["browInnerUp"], ["browInnerUp_L", "browInnerUp_R"])
    back = match(["browInnerUp_L", "browInnerUp_R"], ["browInnerUp"])
    np.testing.assert_allclose(out.factors @ back.factors, [[1.0]])


def test_directions_are_not_sides() -> None:
    found = match(["JawLeft", "JawRight", "MouthLeft"], ["jaw", "mouth", "jawRight"])
    assert found.drives == {"jawRight": (("JawRight",), (1.0,))}


def test_a_rig_with_whole_and_halves_is_driven_once() -> None:
    found = match(["BrowInnerUp"], ["browInnerUp_L", "browInnerUp", "browInnerUp_R"])
    assert list(found.drives) == ["browInnerUp"]
    avatar = match(LIVE_LINK, [*ARKIT, "blink", "blinkLeft", "lookLeft"])
    assert avatar.unmatched_sliders == ("blink", "blinkLeft", "lookLeft")


def test_vrm_presets_where_they_are_shapes_of_arkit() -> None:
    found = match(LIVE_LINK, ["blinkLeft", "Blink_R", "lookLeft", "aa", "happy"])
    assert found.drives["blinkLeft"] == (("EyeBlinkLeft",), (1.0,))
    assert found.drives["Blink_R"] == (("EyeBlinkRight",), (1.0,))
    assert found.drives["lookLeft"] == (("EyeLookOutLeft", "EyeLookInRight"), (0.5, 0.5))
    assert found.unmatched_sliders == ("aa", "happy")
    other = match(["blink", "A"], ["eyeBlink_L", "eyeBlink_R", "aa"])
    assert other.drive([[0.5, 1.0]]).tolist() == [[0.5, 0.5, 1.0]]


def test_rotations_are_listed_apart_and_never_drive() -> None:
    found = match(["HeadYaw", "JawOpen"], ["HeadYaw", "jawOpen", "LeftEyeYaw"])
    assert found.rotations == ("HeadYaw",)
    assert found.unmatched_weights == ()
    assert found.unmatched_sliders == ("HeadYaw", "LeftEyeYaw")


def test_other_names_match_only_themselves() -> None:
    found = match(
        ["PupilDilate_L", "cheekRaiser"], ["PupilDilate_L", "cheekRaiser_L", "CheekRaiser"]
    )
    assert list(found.drives) == ["PupilDilate_L"]
    assert found.unmatched_weights == ("cheekRaiser",)


def test_every_node_of_a_rig_is_driven() -> None:
    found = match(["JawOpen"], ["face.jawOpen", "teeth.JawOpen", "jawopen"])
    assert found.drive([[0.3]]).tolist() == [[0.3, 0.3, 0.3]]


def test_two_spellings_on_one_node() -> None:
    """The one that is spelled as recorded is meant; else nobody can know."""
    assert list(match(["JawOpen"], ["jawOpen", "JawOpen"]).drives) == ["JawOpen"]
    with pytest.raises(ParameterError, match=r"rig has jawOpen and JAWOPEN.*both jawOpen"):
        match(["JawOpen"], ["jawOpen", "JAWOPEN"])
    with pytest.raises(ParameterError, match=r"recording has jawOpen and JawOpen"):
        match(["jawOpen", "JawOpen"], ["jawOpen"])
    with pytest.raises(ParameterError, match="'x' twice"):
        match(["x", "x"], ["x"])


@given(
    st.lists(st.sampled_from(LIVE_LINK + ["x", "HeadYaw"]), unique=True),
    st.lists(
        st.sampled_from(SIDED + ["x", "browInnerUp_L"]),
        unique=True,
    ),
)
def test_nothing_is_lost(weights: list[str], sliders: list[str]) -> None:
    """Each weight drives, is a rotation, or is left over; each slider is driven or left over."""
    found = match(weights, sliders)
    used = {name for drive in found.drives.values() for name in drive.names}
    assert used | set(found.rotations) | set(found.unmatched_weights) == set(weights)
    assert not used & set(found.unmatched_weights)
    assert set(found.drives) | set(found.unmatched_sliders) == set(sliders)
    assert found.drive(np.zeros((2, len(weights)))).shape == (2, len(sliders))
    for name in (*found.unmatched_weights, *found.unmatched_sliders, *found.rotations):
        assert name in found.text()


def test_text_says_what_is_not_obvious() -> None:
    text = match(
        ["BrowInnerUp", "TongueOut", "JawOpen", "HeadYaw", "noseSneerLeft", "noseSneerRight"],
        ["browInnerUp_L", "browInnerUp_R", "jawOpen", "smile", "noseSneer"],
    ).text()
    assert text.splitlines() == [
        "4 of 5 weights drive 4 of 5 sliders",
        "  browInnerUp_L = BrowInnerUp",
        "  browInnerUp_R = BrowInnerUp",
        "  noseSneer = 0.5 noseSneerLeft + 0.5 noseSneerRight",
        "in the recording but not on the rig: TongueOut",
        "on the rig but not driven: smile",
        "rotations, which drive no slider: HeadYaw",
    ]


def test_text_names_the_first_of_many() -> None:
    many = [f"s{n}" for n in range(200)]
    found = Match(("a", "b"), ("w", *many), {f"s{n}": Drive(("a",), (2.0,)) for n in range(5)})
    assert found.text(3).splitlines()[1:] == [
        *(f"  s{n} = 2 a" for n in range(3)),
        "  and 2 more",
        "in the recording but not on the rig: b",
        "on the rig but not driven: w, s5, s6 and 193 more",
    ]


def test_a_match_of_ones_own() -> None:
    own = Match(("a", "b"), ("x", "y"), {"y": Drive(("a", "b"), (2.0, -1.0))})
    assert own.drive([[1.0, 0.5]]).tolist() == [[0.0, 1.5]]
    with pytest.raises(TypeError):
        own.drives["x"] = Drive(("a",), (1.0,))  # type: ignore[index]


@pytest.mark.parametrize(
    ("drives", "message"),
    [
        ({"z": (("a",), (1.0,))}, "no slider 'z'"),
        ({"x": (("c",), (1.0,))}, "no weight 'c'"),
        ({"x": (("a",), (1.0, 2.0))}, "one finite factor"),
        ({"x": (("a",), (float("nan"),))}, "one finite factor"),
    ],
)
def test_a_match_must_fit(drives: dict[str, Drive], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        Match(("a", "b"), ("x", "y"), drives)


@pytest.mark.parametrize("weights", [[1.0, 2.0], [[1.0]], [[1.0, float("inf")]]])
def test_weights_must_fit(weights: object) -> None:
    with pytest.raises(ParameterError):
        match(["a", "b"], ["a", "b"]).drive(weights)  # type: ignore[arg-type]
