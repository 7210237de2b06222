"""What is asked for is bounded: frames that no disk holds, weights that no face has."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from small_meshes import grid

SIDE = 30


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a neutral and a target as meshes and as a rig, and a take."""
    monkeypatch.chdir(tmp_path)
    neutral = grid(SIDE, SIDE)
    raised = neutral.with_vertices(neutral.vertices + [0, 0, 3.0])
    em.write("neutral.obj", neutral)
    em.write("target.obj", raised)
    em.write("rig.npz", em.Rig(neutral, {"jawOpen": em.interpolate(neutral, raised, "ease:2")}))
    Path("take.csv").write_text("time,jawOpen\n0,0\n1,1\n2,0\n")
    return tmp_path


def interpolated(*words: object) -> int:
    return run("interpolate", "neutral.obj", "target.obj", "--method", "ease:2", *words)


class TestFrames:
    """Frames are written as they are computed, where there is room for all of them."""

    def test_many_frames_need_the_memory_of_few(self) -> None:
        count, frame = 2000, SIDE * SIDE * 24
        run("interpolate", "--help")
        tracemalloc.start()
        assert interpolated("--frames", count, "-o", "many.npz") == 0
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert Path("many.npz").stat().st_size > count * frame
        assert peak < 0.5 * count * frame

    @pytest.mark.parametrize("name", ["half.###.obj", "half.npz", "half.mdd", "half.pc2"])
    def test_frames_are_those_of_the_path(self, name: str) -> None:
        assert interpolated("--frames", 9, "-o", name) == 0
        em.write("half.obj", em.read("neutral.obj"))  # the polygons of a point cache
        morph = em.interpolate(em.read("neutral.obj"), em.read("target.obj"), "ease:2")
        expected, frames = morph.at(np.linspace(0, 1, 9)), em.read_sequence(name).frames
        if name.endswith((".obj", ".npz")):
            np.testing.assert_array_equal(frames, expected)
        else:
            np.testing.assert_array_equal(frames, expected.astype(np.float32))

    def test_a_count_that_nobody_means(self) -> None:
        assert interpolated("--frames", 1_000_000_000, "-o", "half.npz") == 2
        words = ["--pose", "jawOpen=1", "--animate", "--frames", 1_000_000_000]
        assert run("render", "rig.npz", *words, "-o", "x.mp4") == 1
        assert run("render", "rig.npz", *words, "-o", "x.####.png") == 1

    @pytest.mark.parametrize(
        "words",
        [
            ["interpolate", "neutral.obj", "target.obj", "--frames", "50", "-o", "a.##.ply"],
            ["interpolate", "neutral.obj", "target.obj", "--frames", "50", "-o", "a.npz"],
            ["interpolate", "neutral.obj", "target.obj", "--frames", "50", "-o", "a.mdd"],
            ["blend", "rig.npz", "--levels", "50", "-o", "a.npy"],
            ["blend", "rig.npz", "--levels", "50", "-o", "a.npz"],
            ["blend", "rig.npz", "--levels", "50", "-o", "a.##.obj"],
            ["animate", "rig.npz", "take.csv", "--rate", "25", "-o", "a.mdd"],
            ["animate", "rig.npz", "take.csv", "--rate", "25", "-o", "a.pc2"],
            ["animate", "rig.npz", "take.csv", "--rate", "25", "-o", "a.npz"],
            ["animate", "rig.npz", "take.csv", "--rate", "25", "-o", "a.##.obj"],
        ],
        ids=lambda words: f"{words[0]} {words[-1]}",
    )
    def test_a_disk_without_room_is_refused_at_once(
        self, folder: Path, words: list[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """49 frames of 900 vertices are 529,200 bytes at least."""
        before = sorted(folder.iterdir())
        monkeypatch.setattr(
            "elastomorph.io.atomic.disk_usage", lambda _: SimpleNamespace(free=500_000)
        )
        assert run(*words) == 1
        assert sorted(folder.iterdir()) == before
        monkeypatch.undo()
        monkeypatch.chdir(folder)
        assert run(*words) == 0


@pytest.mark.parametrize(
    "words",
    [
        ["interpolate", "no.obj", "no.obj", "-o", "missing/half.obj"],
        ["interpolate", "no.obj", "no.obj", "--frames", "3", "-o", "missing/half.#.obj"],
        ["export", "no.glb", "-o", "missing/face.glb"],
        ["blend", "no.glb", "-w", "jawOpen=1", "-o", "missing/face.obj"],
        ["animate", "no.glb", "no.csv", "-o", "missing/take.usda"],
    ],
    ids=lambda words: words[0],
)
def test_the_output_is_looked_at_before_anything_is_read(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*words) == 1
    assert "missing" in capsys.readouterr().err


class TestWeights:
    """A weight of 1e30 is a slip of the hand wherever it comes from."""

    @pytest.mark.parametrize(
        "words",
        [
            ["blend", "rig.npz", "-w", "jawOpen=1e30", "-o", "a.obj"],
            ["blend", "rig.npz", "-w", "jawOpen=1", "-t", "1e30", "-o", "a.obj"],
            ["interpolate", "neutral.obj", "target.obj", "-t", "1e30", "-o", "a.obj"],
            ["animate", "rig.npz", "far.csv", "-o", "a.glb"],
            ["animate", "rig.npz", "far.csv", "-o", "a.mdd"],
            ["animate", "rig.npz", "far.json", "-o", "a.glb"],
            ["render", "rig.npz", "--pose", "jawOpen=1e30", "-o", "a.png"],
            ["render", "rig.npz", "--pose", "far.json#A", "-o", "a.png"],
            ["render", "rig.npz", "--take", "far.csv", "-o", "a.gif"],
        ],
        ids=" ".join,
    )
    def test_from_every_door(self, folder: Path, words: list[str]) -> None:
        Path("far.csv").write_text("time,jawOpen\n0,0\n1,1e30\n2,0\n")
        em.write_poses("far.json", {"A": {"jawOpen": 1.0}, "B": {"jawOpen": 0.0}})
        Path("far.json").write_text(Path("far.json").read_text().replace("1.0", "1e30"))
        assert json.loads(Path("far.json").read_text())["poses"][0]["weights"] == {"jawOpen": 1e30}
        before = sorted(folder.iterdir())
        assert run(*words) == 1
        assert sorted(folder.iterdir()) == before

    @pytest.mark.parametrize("words", [["-w", "jawOpen=1", "-o", "a.obj"], ["-o", "a.npy"]])
    def test_of_a_time_no_slider_is_named(
        self, folder: Path, words: list[str], capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run("blend", "rig.npz", *words, "-t", "1e30") == 1
        told = capsys.readouterr().err
        assert "times of a path are about 0 to 1, at most 1000, found 1e+30" in told
        assert "jawOpen" not in told

    def test_percentages_and_signs_pass(self) -> None:
        rig = em.read_rig("rig.npz")
        for weight in (-1.0, 100.0, 1000.0):
            assert np.isfinite(rig.pose({"jawOpen": weight})).all()
        with pytest.raises(em.ParameterError):
            rig.batch(np.array([[0.5], [-1000.5]]))
