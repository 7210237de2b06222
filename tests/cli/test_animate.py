"""``elastomorph animate`` from end to end, on a small rig."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import elastomorph as em
from elastomorph.cli import app
from elastomorph.errors import ElastomorphError
from elastomorph.io.sequences import read_mdd, read_pc2

ROWS = [
    "Timecode,BlendShapeCount,BrowInnerUp,JawOpen,TongueOut,HeadYaw",
    "10:00:00:56,4,0,0,0,0.1",
    "10:00:00:58,4,0.25,0.1,0,0.1",
    "10:00:01:00,4,0.5,0.2,0,0.1",
    "10:00:01:04,4,1,0.4,0,0.1",
    "10:00:01:06,4,1.25,0.5,0,0.1",
]
HEIGHTS = {"jawOpen": 4.0, "browInnerUp_L": 1.0, "browInnerUp_R": 2.0, "smile": 8.0}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A rig whose sliders each raise it by a height of their own, and a take with a lost frame."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    neutral = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    Path("rig").mkdir()
    em.write("rig/neutral.obj", neutral)
    for name, height in HEIGHTS.items():
        em.write(f"rig/{name}.obj", neutral.with_vertices(neutral.vertices + [0, 0, height]))
    Path("take.csv").write_text("\n".join(ROWS))
    Path("plain.csv").write_text("time,jawOpen\n-1,0\n0,0.5\n1,1\n")
    return tmp_path


def run(*arguments: object) -> str:
    """Standard output of one call; an error of ours is raised."""
    result = CliRunner().invoke(app, ["animate", *map(str, arguments), "--method", "linear"])
    if isinstance(result.exception, ElastomorphError):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.stdout


def facts(*arguments: object) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(run(*arguments, "--json"))
    return found


@pytest.mark.usefixtures("folder")
class TestAnimate:
    def test_frames_are_the_take_with_the_lost_frame_bridged(self) -> None:
        """30 fps, weights t and 0.4 t: height (1 + 2) · brow + 4 · jaw = 4.6 · brow."""
        found = facts("rig", "take.csv", "-o", "out/", "--still-head")
        assert found["frames"] == 6
        assert not found["head_turns"]
        assert found["recorded_frames"] == 5
        assert found["rate"] == 30
        assert found["dropped"] == ["10:00:01:02"]
        assert found["written"] == "out/"
        frames = em.read_sequence("out").frames
        np.testing.assert_allclose(frames[:, 0, 2], 4.6 * 0.25 * np.arange(6), atol=1e-9)

    def test_rate_start_stop_and_clip(self) -> None:
        words = ("--rate", 60, "--start", 0.06, "--clip", "--still-head")
        found = facts("rig", "take.csv", "-o", "t.npz", *words)
        assert found["frames"] == 7  # 2, 4 and 5 of 30 fps are left: 0.1 s
        brow = np.arange(0.5, 1.26, 0.125)
        expected = 3 * np.clip(brow, 0, 1) + 4 * 0.4 * brow
        np.testing.assert_allclose(em.read_sequence("t.npz").frames[:, 0, 2], expected, atol=1e-6)
        assert facts("rig", "take.csv", "--list", "--stop", 0.04)["frames"] == 2

    @pytest.mark.parametrize("output", ["t.npz", "out/", "t.mdd", "t.pc2"])
    def test_positions_turn_with_the_head(self, output: str) -> None:
        """By 0.1 about the neck, in the middle of the triangle and a quarter up."""
        assert facts("rig", "take.csv", "-o", output)["head_turns"]
        still = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) - [0.5, 0.25, 0]
        x, y, z = np.broadcast_to(still, (6, 3, 3)).transpose(2, 0, 1)
        z = z + 4.6 * 0.25 * np.arange(6)[:, None]
        c, s = np.cos(0.1), np.sin(0.1)
        turned = np.stack([c * x - s * z, y, s * x + c * z], axis=2) + [0.5, 0.25, 0]
        if output.endswith((".mdd", ".pc2")):
            frames = (read_mdd if output.endswith(".mdd") else read_pc2)(output).frames
        else:
            frames = em.read_sequence(output).frames
        np.testing.assert_allclose(frames, turned, atol=1e-6)

    def test_a_file_without_angles_is_one_that_is_left_still(self) -> None:
        """Zeros, columns that are not there, and --still-head leave the same bytes."""
        Path("bare.csv").write_text("time,jawOpen\n0,0\n0.5,1\n")
        Path("upright.csv").write_text("time,jawOpen,HeadYaw\n0,0,0\n0.5,1,0\n")
        Path("turned.csv").write_text("time,jawOpen,HeadYaw\n0,0,0\n0.5,1,0.4\n")
        for name, words in (("bare", ()), ("upright", ()), ("turned", ("--still-head",))):
            Path("take.csv").write_bytes(Path(f"{name}.csv").read_bytes())
            run("rig", "take.csv", "-o", f"{name}.glb", *words)
        bare, upright, turned = (
            Path(f"{n}.glb").read_bytes() for n in ("bare", "upright", "turned")
        )
        assert bare == upright == turned
        text = run("rig", "turned.csv", "-o", "t.glb")
        assert "the head turns by up to 22.9° yaw, 0° pitch, 0° roll" in text
        found = em.read_performance("t.glb")
        np.testing.assert_allclose(found.head, [[0, 0, 0], [0.4, 0, 0]], atol=1e-6)

    def test_degrees_are_doubted(self) -> None:
        Path("degrees.csv").write_text("time,jawOpen,HeadYaw\n0,0,0\n0.5,1,30\n")
        words = ["animate", "rig", "degrees.csv", "-o", "t.glb", "--method", "linear"]
        told = " ".join(CliRunner().invoke(app, words).stderr.split())
        assert "degrees.csv turns the head by up to 30 radians" in told
        assert "--still-head" in told

    def test_list_only_says_what_drives_what(self) -> None:
        before = sorted(Path().iterdir())
        text = run("rig", "take.csv", "--list", "-o", "t.glb")
        assert "2 of 3 weights drive 3 of 4 sliders" in text
        assert "browInnerUp_L = BrowInnerUp" in text
        assert "not on the rig: TongueOut" in text
        assert "not driven: smile" in text
        assert "HeadYaw" in text
        assert "dropped: 1 (10:00:01:02)" in text
        assert [p for p in sorted(Path().iterdir()) if p.name != "cache"] == before
        found = facts("rig", "take.csv", "--list")
        assert found["drives"]["browInnerUp_R"] == {"BrowInnerUp": 1.0}
        assert found["unmatched_weights"] == ["TongueOut"]
        assert found["unmatched_sliders"] == ["smile"]
        assert found["rotations"] == ["HeadYaw"]
        assert found["written"] is None

    def test_plain_columns_with_times_before_0(self) -> None:
        run("rig", "plain.csv", "-o", "f.#.obj", "--rate", 2)
        heights = em.read_sequence("f.#.obj").frames[:, 0, 2]
        np.testing.assert_allclose(heights, [0, 1, 2, 3, 4], atol=1e-9)

    def test_what_it_says(self) -> None:
        text = run("rig", "take.csv", "-o", "t.npz")
        assert "take.csv: 5 frames at 30 fps, 0.17 s" in text
        assert "6 frames at 30 fps → t.npz" in text

    def test_a_terminal_sees_a_bar(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """It counts every frame, and standard output stays as it is."""
        plain = run("rig", "take.csv", "-o", "t.npz")
        monkeypatch.setenv("FORCE_COLOR", "1")
        assert run("rig", "take.csv", "-o", "bar.npz") == plain.replace("t.npz", "bar.npz")
        assert Path("bar.npz").read_bytes() == Path("t.npz").read_bytes()

    def test_the_timecode_rate_can_be_told(self) -> None:
        found = facts("rig", "take.csv", "--list", "--timecode-rate", 59.94)
        assert found["rate"] == pytest.approx(30000 / 1001)

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (["rig", "take.csv"], "-o take.glb"),
            (["rig", "take.csv", "-o", "t.mpg"], "a take goes into"),
            (["rig", "none.csv", "-o", "t.npz"], "none.csv"),
            (["rig", "bad.csv", "-o", "t.npz"], "bad.csv, line 2"),
            (["none", "take.csv", "-o", "t.npz"], "none"),
            (["rig", "other.csv", "-o", "t.npz"], "no weight of other.csv drives"),
            (["rig", "take.csv", "-o", "t.npz", "--start", "9"], "no frame lies after 9 s"),
            (["rig", "take.csv", "-o", "t.npz", "--rate", "0"], "above 0"),
            (["rig", "take.csv", "-o", "none/t.npz"], "does not exist"),
        ],
    )
    def test_mistakes(self, arguments: list[str], message: str) -> None:
        """One sentence, and nothing is written."""
        Path("bad.csv").write_text("time,jawOpen\n0,x\n")
        Path("other.csv").write_text("time,wink\n0,1\n")
        before = {p for p in Path().iterdir() if p.name != "cache"}
        with pytest.raises(ElastomorphError, match=message):
            run(*arguments)
        assert {p for p in Path().iterdir() if p.name != "cache"} == before
