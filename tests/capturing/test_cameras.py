"""Cameras of one pose, from features whose true cameras are known."""

from dataclasses import replace

import numpy as np
import pytest
from spotted import FOCAL, NOISE, OFF, SIZE, cameras, centres_off, egg, finder, seen, taken

import elastomorph.capturing.cameras.cameras as cameras_module
import elastomorph.capturing.cameras.cameras as module
from elastomorph.capturing.cameras.cameras import solve_pose
from elastomorph.capturing.cameras.features import Features
from elastomorph.capturing.cameras.models import SolvedPose
from elastomorph.errors import CaptureError
from needs import extra

pytestmark = pytest.mark.photographs

extra("pycolmap", "capture")

CAMERAS = cameras()
EGG = egg()
VIEWS = {camera.name: seen(camera, EGG, k) for k, camera in enumerate(CAMERAS)}


@pytest.fixture
def shown(monkeypatch):
    """Makes photographs show what is given."""

    def show(views: dict[str, Features], pose: str = "neutral") -> None:
        monkeypatch.setattr(module, "find_features", finder({pose: views}))

    return show


@pytest.fixture(scope="module")
def solved() -> SolvedPose:
    """Cameras by what they show."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "find_features", finder({"neutral": VIEWS}))
        return solve_pose(taken(CAMERAS))


def test_cameras_and_their_lens_are_found(shown, capfd):
    shown(VIEWS)
    said = []
    found = solve_pose(taken(CAMERAS, focal=1.08 * FOCAL), say=lambda *what: said.append(what))
    assert [camera.name for camera in found.cameras] == [camera.name for camera in CAMERAS]
    assert centres_off(found.cameras, CAMERAS) < 0.03
    lens = found.cameras[0]
    assert lens.focal == pytest.approx(FOCAL, rel=0.01)
    np.testing.assert_allclose(lens.centre - (np.array(SIZE) - 1) / 2, OFF, atol=12)
    assert lens.radial == pytest.approx(-0.04, abs=0.025)
    # The mean length of a 2D error of which each coordinate has a spread of 0.15; points follow
    # the noise of the few features that they are seen by.
    usual = 0.15 * np.sqrt(np.pi / 2)
    assert 0.7 * usual < np.mean(list(found.reprojection.values())) < usual
    assert not found.rejected
    assert len(found.points) == len(found.descriptors) > 600
    np.testing.assert_allclose(np.linalg.norm(found.descriptors, axis=1), 1, rtol=1e-5)
    parts = [part for _, part in said]
    assert (np.diff(parts) > -1e-9).all()
    assert 0 <= parts[0] <= parts[-1] <= 1
    assert capfd.readouterr().err == ""


def test_points_look_as_they_do_in_photographs(solved):
    looks = EGG.looks / np.linalg.norm(EGG.looks, axis=1, keepdims=True)
    assert np.percentile((solved.descriptors @ looks.T.astype(np.float32)).max(axis=1), 2) > 0.98


def test_the_same_photographs_give_the_same_cameras(shown, solved):
    shown(VIEWS)
    again = solve_pose(taken(CAMERAS))
    for first, second in zip(solved.cameras, again.cameras, strict=True):
        np.testing.assert_allclose(first.position, second.position, rtol=0, atol=1e-6)


@pytest.mark.parametrize("focal", [None, 0.45 * FOCAL])
def test_a_focal_length_that_is_missing_or_wrong_is_found(shown, focal):
    shown(VIEWS)
    found = solve_pose(taken(CAMERAS, focal=focal))
    assert len(found.cameras) == len(CAMERAS)
    assert found.cameras[0].focal == pytest.approx(FOCAL, rel=0.015)
    assert any("was not followed" in remark for remark in found.remarks) == (focal is not None)


def test_a_lens_that_is_known_is_kept(shown, solved):
    other = [replace(camera, name=camera.name) for camera in cameras(9, seed=5)]
    shown({c.name: seen(c, EGG, 40 + k) for k, c in enumerate(other)}, "smile")
    found = solve_pose(taken(other, "smile", focal=None), like=solved)
    assert {camera.focal for camera in found.cameras} == {solved.cameras[0].focal}
    np.testing.assert_array_equal(found.cameras[0].centre, solved.cameras[0].centre)
    assert centres_off(found.cameras, other) < 0.04


def test_a_photograph_of_something_else_is_rejected(shown):
    shown(VIEWS | {"05.jpg": seen(CAMERAS[5], egg(9), 5)})
    found = solve_pose(taken(CAMERAS))
    assert list(found.rejected) == ["05.jpg"]
    assert "another subject" in found.rejected["05.jpg"]
    assert "05.jpg" not in [camera.name for camera in found.cameras]
    assert len(found.cameras) == 11


def test_two_subjects_are_refused(shown):
    other = egg(9)
    views = {c.name: seen(c, EGG if k % 2 else other, k) for k, c in enumerate(CAMERAS)}
    shown(views)
    with pytest.raises(CaptureError, match=r"pose 'neutral'.*of one subject"):
        solve_pose(taken(CAMERAS))


def test_photographs_without_overlap_are_refused(shown):
    shown({c.name: seen(c, egg(20 + k), k) for k, c in enumerate(CAMERAS)})
    with pytest.raises(CaptureError, match="cameras of 0 of 12 photographs"):
        solve_pose(taken(CAMERAS))


def test_photographs_of_which_few_agree_are_refused(shown, monkeypatch):
    shown(VIEWS)
    agree = {camera.name for camera in CAMERAS[:2]}
    names = [camera.name for camera in CAMERAS if camera.name not in agree]
    monkeypatch.setattr(module, "misfits", lambda *_: dict.fromkeys(names, "it does not agree"))
    with pytest.raises(CaptureError, match=r"the cameras of 2 of .* are found"):
        solve_pose(taken(CAMERAS))


def test_a_blurred_photograph_that_was_not_seen_to_be_is_rejected(shown):
    shown(VIEWS | {"07.jpg": seen(CAMERAS[7], EGG, 7, noise=3.0)})
    found = solve_pose(taken(CAMERAS))
    assert list(found.rejected) == ["07.jpg"]
    assert len(found.cameras) == 11


def counted(monkeypatch, of, name: str) -> list[object]:
    """What is called, once for each call."""
    calls: list[object] = []
    called = getattr(of, name)
    monkeypatch.setattr(of, name, lambda *given, **kept: calls.append(1) or called(*given, **kept))
    return calls


@pytest.mark.parametrize(
    ("strongest", "factor", "tries"), [(1500, 1.0, 1), (200, 1.0, 2), (200, 1.5, 3)]
)
def test_no_try_repeats_the_one_before(shown, monkeypatch, strongest, factor, tries):
    """Small photographs are enlarged at once, and of few features all are compared at once."""
    monkeypatch.setattr(module, "_STRONGEST", strongest)
    shown({c.name: seen(c, egg(20 + k), k) for k, c in enumerate(CAMERAS[:6])})
    calls = counted(monkeypatch, module, "found_cameras")
    given = [replace(c, size=(int(750 * factor), int(1000 * factor))) for c in CAMERAS[:6]]
    with pytest.raises(CaptureError, match="cameras of 0 of 6 photographs"):
        solve_pose(taken(given))
    assert len(calls) == tries


@pytest.mark.parametrize("noise", [None, 8.0])
def test_a_photograph_that_no_lens_would_place_sets_off_no_further_tries(shown, monkeypatch, noise):
    """Of eight, blurred or of something else: the others are found, and that is all there is."""
    few = cameras(8, widest=55.0)
    of = egg(9) if noise is None else EGG
    strange = seen(few[3], of, 3, noise=NOISE if noise is None else noise)
    if noise is not None:  # few of the looks of what is blurred are like those of the others
        looks = np.random.default_rng(4).permutation(strange.descriptors.T).T
        kept = np.arange(len(looks)) % 12 == 0
        strange = replace(strange, descriptors=np.where(kept[:, None], strange.descriptors, looks))
    shown({c.name: seen(c, EGG, k) for k, c in enumerate(few)} | {"03.jpg": strange})
    calls = counted(monkeypatch, cameras_module, "mapped")
    found = solve_pose(taken(few))
    assert (len(calls), len(found.cameras)) == (1, 7)


def test_the_centre_of_a_lens_is_fixed_by_the_photographs_that_are_found(shown):
    """Of twelve of which three show something else, nine; the axis stays in the middle."""
    strange = {c.name: seen(c, egg(30 + k), k) for k, c in enumerate(CAMERAS) if k in (1, 5, 10)}
    shown(VIEWS | strange)
    found = solve_pose(taken(CAMERAS))
    assert len(found.cameras) == 9
    np.testing.assert_array_equal(found.cameras[0].centre, (np.array(SIZE) - 1) / 2)


def test_a_centre_that_misfits_helped_to_move_is_put_back(shown, monkeypatch):
    """Ten are found, one of which turns out not to fit: nine do not fix the centre."""
    strange = {c.name: seen(c, egg(30 + k), k) for k, c in enumerate(CAMERAS) if k in (1, 10)}
    shown(VIEWS | strange)
    bad = iter([{"05.jpg": "it does not fit"}])
    monkeypatch.setattr(module, "misfits", lambda *_: next(bad))
    found = solve_pose(taken(CAMERAS))
    assert len(found.cameras) == 9
    np.testing.assert_array_equal(found.cameras[0].centre, (np.array(SIZE) - 1) / 2)
    assert centres_off(found.cameras, CAMERAS) < 0.2


def test_photographs_from_one_place_are_refused(shown):
    close = cameras(widest=4.0)
    shown({c.name: seen(c, EGG, k) for k, c in enumerate(close)})
    with pytest.raises(CaptureError, match="pose 'neutral'"):
        solve_pose(taken(close))


def test_cropped_photographs_are_solved_and_mentioned(shown):
    """As where the axis of the lens was taken for the middle of a photograph that was cut."""
    cut = [replace(camera, centre=camera.centre + [10.0, -130.0]) for camera in CAMERAS]
    shown({c.name: seen(c, EGG, k) for k, c in enumerate(cut)})
    found = solve_pose(taken(cut))
    assert centres_off(found.cameras, cut) < 0.08
    assert any("may be cropped" in remark for remark in found.remarks)
