"""``elastomorph learn``, from files to a rig, text and JSON."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import printed_by
from calls import status_of as run
from small_files import sheet

import elastomorph as em
from elastomorph.io.gltf.clips import read_weight_clips
from elastomorph.io.gltf.container import open_gltf

TIMES = np.linspace(0, 1, 13)


@pytest.fixture
def take(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> em.MeshSequence:
    """A sheet that starts late and bends on its way, as take.####.obj and take.npz."""
    monkeypatch.chdir(tmp_path)
    neutral = sheet()
    way = np.sin(neutral.vertices)
    bend = np.cos(neutral.vertices[:, [1, 2, 0]])
    bend -= way * (bend * way).sum() / (way**2).sum()
    pace = TIMES**2 * (3 - 2 * TIMES)
    frames = neutral.vertices + np.tensordot(
        np.stack([0.4 * pace, 0.3 * TIMES * (1 - TIMES)], axis=1), np.stack([way, bend]), 1
    )
    take = em.MeshSequence(neutral, frames, TIMES)
    em.write_sequence("take.####.obj", take)
    em.write_sequence("take.npz", take)
    return take


def test_a_recording_becomes_a_rig(take: em.MeshSequence) -> None:
    """Ends and path come back from the file, in single precision."""
    printed = printed_by("learn", "take.####.obj", "-o", "rig.glb")
    assert "only another one can tell" in " ".join(printed.split())
    rig = em.read_rig("rig.glb")
    assert list(rig.morphs) == ["take"]
    # The curve of Δ is played on Δ: one bend is one further target.
    assert open_gltf("rig.glb").document["meshes"][0]["extras"]["targetNames"] == [
        *("take", "take.bend1")
    ]
    np.testing.assert_allclose(rig.morphs["take"].at(TIMES), take.frames, atol=1e-5)
    # Its animation plays the path at an even pace, whatever the weight of Δ does for that.
    (clip,) = read_weight_clips("rig.glb", rig.sliders)
    np.testing.assert_allclose(clip.weights[:, 0], clip.times, atol=2e-3)


def test_json_has_what_the_library_finds(take: em.MeshSequence) -> None:
    facts = json.loads(printed_by("learn", "take.npz", "-k", 1, "--json"))
    found = em.learn(take, 1)
    assert facts["errors"]["lme"] == pytest.approx(found.errors.lme, rel=1e-6, abs=1e-9)
    assert facts["linear"]["lme"] == pytest.approx(found.straight.lme)
    assert (facts["frames"], facts["written"], facts["carried"]) == ([13], None, None)


def test_timing_beside_the_path_is_that_of_the_clip(take: em.MeshSequence) -> None:
    """The rig has the path alone; its animation plays it as it was recorded."""
    printed_by("learn", "take.npz", "--timing", "even", "-o", "rig.glb", "--name", "smile")
    rig = em.read_rig("rig.glb")
    clip = read_weight_clips("rig.glb", rig.sliders)[0]
    assert clip.name == "smile"
    played = np.interp(TIMES, clip.times, clip.weights[:, 0])
    size = np.abs(take.frames - take.frames[0]).max()
    np.testing.assert_allclose(rig.morphs["smile"].at(played), take.frames, atol=0.02 * size)
    assert np.abs(played - TIMES).max() > 0.05


def test_parts_of_a_take_are_repetitions(take: em.MeshSequence) -> None:
    back = take.frames[-2::-1]
    there_and_back = np.concatenate([take.frames, back + 1e-4 * np.sin(9 * back)])
    em.write_sequence("both.npz", em.MeshSequence(take.mesh, there_and_back))
    printed = printed_by("learn", "both.npz", "--frames", "0-12", "--frames", "24-12")
    assert "It carries over" in printed
    assert "worse than the straight line on 0 of 2" in " ".join(printed.split())
    moves = printed_by("learn", "both.npz", "--movements")
    assert "onset" in moves
    assert "offset" in moves
    assert "mean" in moves


@pytest.mark.usefixtures("take")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["take.npz", "-k", 12, "--knots", 20], "12 bends need a frame each"),
        (["take.npz", "--frames", "3"], "two numbers such as 84-132"),
        (["take.npz", "--frames", "3-13"], "two different frames from 0 to 12"),
        (["take.npz", "take.npz", "--frames", "0-12"], "--frames is for one recording"),
        (["take.npz", "--movements", "-o", "a.glb"], "leave --output"),
        (["take.npz", "--name", "smile"], "add --output"),
        (["take.npz", "-o", "rig.fbx"], "rig.fbx"),
        (["take.npz", "--shapes", "any"], "shapes must be free or scanned"),
        (["nowhere.####.obj"], "nowhere"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    words: list[object], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("learn", *words) == 1
    shown = capsys.readouterr().err
    assert said in shown
    assert shown.count("\n") == 1


@pytest.mark.parametrize("verb", ["evaluate", "inbetweens", "learn"])
def test_every_verb_of_recordings_plays_an_animation(verb: str, take: em.MeshSequence) -> None:
    """The clip that is named, of two, as the frames that it was written from."""
    path = em.learn(take, 1)
    straight = em.interpolate(take.neutral, take.target, "linear")
    em.write("two.glb", em.Rig(take.neutral, {"bent": path, "straight": straight}), clips=True)
    words = ["suggest"] if verb == "inbetweens" else []
    words += ["two.glb", "--clip", "bent", "--json"]
    if verb == "evaluate":
        words += ["--method", "linear"]
    facts = json.loads(printed_by(verb, *words))
    found = {
        "evaluate": lambda: facts["methods"][0],
        "inbetweens": lambda: facts["suggestions"][0],
        "learn": lambda: facts["linear"],
    }[verb]()
    assert found["lme"] == pytest.approx(path.straight.lme, rel=0.05)


def test_a_take_with_gaps_is_learned_and_what_is_lost_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    ways = np.random.default_rng(4).normal(size=(2, 6, 3))
    frames = ways[0] + (TIMES**2)[:, None, None] * ways[1]
    frames[3:6, 1] = frames[:, 5] = np.nan
    np.savez("take.npz", markers=frames, names=np.array(list("abcdef")))
    Path("curves.json").write_text(json.dumps([["a", "b", "c"], ["d", "e"]]))
    words = ("take.npz", "--curves", "curves.json")
    assert run("learn", *words) == 0
    shown = capsys.readouterr()
    assert "warning: take.npz: never seen, and left out: f" in shown.err
    assert "only another one can tell" in " ".join(shown.out.split())


def test_points_without_polygons_have_the_errors_of_the_library(take: em.MeshSequence) -> None:
    """All are one curve, so that LAE is their mean, and no second LME."""
    np.savez("points.npz", frames=take.frames)
    errors = json.loads(printed_by("learn", "points.npz", "--json"))["errors"]
    found = em.learn("points.npz")
    assert errors["lae"] == pytest.approx(found.errors.lae)
    assert errors["lae"] < 0.9 * errors["lme"]
