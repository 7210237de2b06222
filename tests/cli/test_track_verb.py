"""``elastomorph track``, from a rig and markers to weights that ``animate`` reads."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import printed_by
from calls import status_of as run
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.capturing.landmarks import Landmarks, write_landmarks
from elastomorph.io.performance import read_performance

NAMES = [f"m{number}" for number in range(12)]


@pytest.fixture
def weights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> np.ndarray:
    """A rig, rig.npz, and twelve markers on it while the head turns, take.npz; its weights."""
    monkeypatch.chdir(tmp_path)
    random = np.random.default_rng(1)
    neutral = em.Mesh(random.normal(size=(12, 3)))
    morphs = {}
    for name in ("jawOpen", "smile"):
        delta, bend = 0.5 * random.normal(size=(12, 3)), 0.1 * random.normal(size=(1, 12, 3))
        target = neutral.with_vertices(neutral.vertices + delta)
        morphs[name] = em.Morph(neutral, target, bend, (em.BendCurve.power(2),))
    rig = em.Rig(neutral, morphs)
    rig.save("rig.npz")
    way = np.linspace(0, 1, 9)
    weights = np.stack([way, 0.5 * way**2], axis=1)
    turns = Rotation.from_rotvec(way[:, None] * [0.2, 0.5, 0.1]).as_matrix()
    markers = 3.0 * np.einsum("fij,fmj->fmi", turns, rig.batch(weights, dtype=np.float64))
    markers[4, 2] = np.nan
    np.savez("take.npz", names=NAMES, markers=markers, vertices=np.arange(12), times=way)
    np.savez("bare.npz", names=NAMES, markers=markers)
    write_landmarks("markers.json", Landmarks({name: i for i, name in enumerate(NAMES[:-1])}))
    return weights


def test_markers_become_weights(weights: np.ndarray) -> None:
    printed = printed_by("track", "rig.npz", "take.npz", "-o", "take.csv", "--smooth", "0")
    assert "9 frames, scale 3," in printed
    assert "written to take.csv" in printed
    found = read_performance("take.csv")
    assert found.names == ("jawOpen", "smile")
    np.testing.assert_allclose(found.weights, weights, atol=0.01)
    np.testing.assert_array_equal(found.times, np.linspace(0, 1, 9))


def test_places_by_name_and_frames_a_second(weights: np.ndarray) -> None:
    words = ("track", "rig.npz", "bare.npz", "--landmarks", "markers.json", "-o", "take.csv")
    facts = json.loads(printed_by(*words, "--rate", "24", "--rest", "0", "--json"))
    assert facts["left_out"] == ["m11"]
    assert (facts["frames"], facts["markers"]) == (9, 11)
    assert facts["scale"] == pytest.approx(3.0, rel=1e-6)
    assert read_performance("take.csv").rate == pytest.approx(24)
    printed = printed_by(*words, "--overwrite")
    assert "without a place on the rig: m11" in printed
    assert "farthest: m" in printed


def test_sliders_that_no_marker_shows_are_named(weights: np.ndarray) -> None:
    """In text and JSON, and not written as zeros."""
    rig = em.read_rig("rig.npz")
    lids = rig.neutral.vertices.copy()
    lids[11] += 1.0
    blink = em.interpolate(rig.neutral, rig.neutral.with_vertices(lids), "linear")
    em.Rig(rig.neutral, {**rig.morphs, "eyeBlink": blink}).save("lids.npz")
    words = ("track", "lids.npz", "bare.npz", "--landmarks", "markers.json", "-o", "take.csv")
    assert json.loads(printed_by(*words, "--json"))["unseen"] == ["eyeBlink"]
    assert read_performance("take.csv").names == ("jawOpen", "smile")
    assert "left out: eyeBlink" in printed_by(*words, "--overwrite")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["bare.npz", "-o", "a.csv"], "is not said: name a file"),
        (["take.npz", "-o", "a.glb"], "written as .csv"),
        (["take.npz", "-o", "a.csv", "--rate", "0"], "--rate must be"),
        (["take.npz", "-o", "a.csv", "--rest", "4"], "must have all markers"),
        (["rig.npz", "-o", "a.csv"], "no array 'frames'"),
        (["bare.npz", "-o", "a.csv", "--landmarks", "other.json"], "name of a marker"),
        (["other.json", "-o", "a.csv"], "recorded motion is numbered meshes"),
        (["take.npz", "-o", "a.csv", "--rate", "30"], "has times of its own: leave --rate out"),
        (["take.npz", "-o", "a.csv", "--clip", "x"], "have animations to choose one of"),
        (
            ["beyond.npz", "-o", "a.csv"],
            "beyond.npz: it has a marker on vertex 20 of the rig, which",
        ),
        (["back.npz", "-o", "a.csv"], "times must be finite numbers that rise"),
    ],
)
def test_what_cannot_be_meant(
    weights: np.ndarray, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_landmarks("other.json", Landmarks({"chin": 3}))
    held = np.load("take.npz")
    np.savez("back.npz", **{**held, "times": held["times"][::-1]})
    np.savez("beyond.npz", **{**held, "vertices": np.arange(12) * 10})
    assert run("track", "rig.npz", *words) == 1
    assert message in " ".join(capsys.readouterr().err.split())
    assert not Path("a.csv").exists()


def test_meshes_of_another_topology(weights: np.ndarray) -> None:
    """Their vertices are markers, by number or by the names that two files of landmarks share."""
    rig = em.read_rig("rig.npz")
    order = np.random.default_rng(2).permutation(12)
    faces = rig.batch(weights, dtype=np.float64)[:, order]
    for number in (0, 1, 2, 3, 5, 6, 7, 8):
        em.write(f"scan.{number}.obj", em.Mesh(faces[number], [[0, 1, 2], [9, 10, 11]]))
    np.savez("scan.npz", frames=faces, times=np.arange(9) / 25)
    numbers = {str(vertex): int(place) for vertex, place in enumerate(order)}
    write_landmarks("numbers.json", Landmarks(numbers))
    names = {f"p{vertex}": vertex for vertex in range(9)}
    write_landmarks("scan.json", Landmarks(names))
    write_landmarks("rig.json", Landmarks({name: int(order[v]) for name, v in names.items()}))
    for words in (
        ("scan.#.obj", "--landmarks", "numbers.json", "--rate", "25"),
        ("scan.npz", "--landmarks", "rig.json", "--mesh-landmarks", "scan.json"),
    ):
        printed_by("track", "rig.npz", *words, "-o", "a.csv", "--smooth", "0", "--overwrite")
        found = read_performance("a.csv")
        np.testing.assert_allclose(found.weights, weights, atol=0.02)
        np.testing.assert_allclose(found.times, np.arange(9) / 25)


def test_a_clip_of_an_animated_rig(weights: np.ndarray) -> None:
    """Its vertices are those of the rig, so places need not be said; the file says the times."""
    rig = em.read_rig("rig.npz")
    em.write("played.glb", rig, animation=(np.arange(9) / 30, weights, "take"))
    words = ("track", "rig.npz", "played.glb", "--clip", "take", "--smooth", "0", "-o", "a.csv")
    assert json.loads(printed_by(*words, "--json"))["rate"] == pytest.approx(30)
    np.testing.assert_allclose(read_performance("a.csv").weights, weights, atol=0.02)


def test_names_with_a_subject_and_names_that_two_markers_have(
    weights: np.ndarray, capsys: pytest.CaptureFixture[str]
) -> None:
    held = np.load("bare.npz")
    np.savez("actor.npz", names=[f"Ada:{name}" for name in NAMES], markers=held["markers"])
    np.savez("twice.npz", names=["m1", *NAMES[1:]], markers=held["markers"])
    words = ("--landmarks", "markers.json", "-o", "a.csv")
    facts = json.loads(printed_by("track", "rig.npz", "actor.npz", *words, "--json"))
    assert (facts["markers"], facts["left_out"]) == (11, ["Ada:m11"])
    assert facts["left"].keys() == {f"Ada:m{number}" for number in range(11)}
    Path("a.csv").unlink()
    assert run("track", "rig.npz", "twice.npz", *words) == 1
    assert "2 markers are called m1; rename them" in " ".join(capsys.readouterr().err.split())
    assert run("track", "rig.npz", "bare.npz", "--mesh-landmarks", *words[1:]) == 1
    assert "--landmarks must say where they are" in " ".join(capsys.readouterr().err.split())
    assert not Path("a.csv").exists()


def test_times_that_are_no_seconds_are_told(weights: np.ndarray) -> None:
    held = np.load("take.npz")
    np.savez("slow.npz", **{**held, "times": 1000 / 24 * np.arange(9)})
    with pytest.warns(em.ElastomorphWarning, match=r"slow.npz: .* a frame lasts 41\.67 s"):
        taken = em.read_markers("slow.npz")
    assert taken.times is not None
    assert taken.times[1] == pytest.approx(1000 / 24)
