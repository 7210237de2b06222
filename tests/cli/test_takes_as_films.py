"""Takes and poses from the command line to films: every frame, and the sound, at its time."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
import wave
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run
from numpy.typing import NDArray
from PIL import Image

import elastomorph as em
from children import started
from elastomorph.draw.film import film_camera
from elastomorph.draw.head import neck_of
from elastomorph.draw.movie import find_encoder
from elastomorph.draw.stage import Stage
from elastomorph.rig.performance import HeadTurn
from needs import extra

extra("imageio_ffmpeg", "demo")
extra("vtkmodules", "demo")

SIZE = (48, 60)
SMALL = ("--size", "48x60")
RATES = (24, 25, 29.97, 30, 60)
FLASH, SECONDS = 0.5, 0.8
HERTZ = 44_100


@pytest.fixture(scope="module")
def rig() -> em.Rig:
    """A board that turns to the light."""
    grid = np.stack(np.meshgrid(np.arange(4), np.arange(5), indexing="xy"), axis=-1).reshape(-1, 2)
    flat = np.column_stack([grid, np.zeros(len(grid))]).astype(float)
    corners = [4 * row + column for row in range(4) for column in range(3)]
    faces = [[corner, corner + 1, corner + 5, corner + 4] for corner in corners]
    neutral = em.Mesh(flat, faces)
    turned = flat * [0.2, 1, 1] + np.outer(flat[:, 0], [0, 0, -1.0])
    return em.Rig(neutral, {"jawOpen": neutral.with_vertices(turned)}, method="linear")


@pytest.fixture(scope="module")
def folder(rig: em.Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A take that flashes a pose from half a second on, and a click at the same moment."""
    place = tmp_path_factory.mktemp("takes")
    em.write(place / "rig.npz", rig)
    rows = [f"{n / 600},{float(n >= 600 * FLASH):g}" for n in range(int(600 * SECONDS) + 1)]
    (place / "take.csv").write_text("\n".join(["time,jawOpen", *rows]))
    _click(place / "click.wav", 1.0)
    program = [find_encoder(), "-y", "-loglevel", "error", "-i", str(place / "click.wav")]
    subprocess.run([*program, str(place / "click.mp3")], check=True)
    picture = ["-f", "lavfi", "-i", "color=c=red:size=32x32:rate=25:duration=1"]
    subprocess.run([*program, *picture, str(place / "click.mov")], check=True)
    return place


def _click(path: Path, seconds: float) -> None:
    samples = np.zeros(round(seconds * HERTZ), "<i2")
    samples[round(FLASH * HERTZ) :][:300] = 30_000
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(HERTZ)
        file.writeframes(samples.tobytes())


def _decoded(path: Path, *options: str) -> bytes:
    """What ffmpeg reads of a movie."""
    words = [find_encoder(), "-loglevel", "error", "-i", str(path), *options, "-"]
    return subprocess.run(words, capture_output=True, check=True).stdout


def pictures(path: Path) -> NDArray[np.float64]:
    """(T, H, W, 3) frames."""
    raw = _decoded(path, "-f", "rawvideo", "-pix_fmt", "rgb24")
    return np.frombuffer(raw, np.uint8).reshape(-1, SIZE[1], SIZE[0], 3).astype(float)


def clicks(path: Path) -> tuple[float, float]:
    """The second at which sound begins, and how long the sound is, silence and all."""
    raw = _decoded(path, "-map", "0:a", "-f", "s16le", "-ac", "1", "-ar", str(HERTZ))
    samples = np.abs(np.frombuffer(raw, "<i2").astype(int))
    return float(np.argmax(samples > 5000)) / HERTZ, len(samples) / HERTZ


@pytest.mark.parametrize("fps", RATES)
def test_frames_and_sound_are_at_their_times(
    folder: Path, rig: em.Rig, tmp_path: Path, fps: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """Frame n is the pose at n / fps; the click is heard with the first frame of the flash."""
    out = tmp_path / "take.mp4"
    words = (folder / "rig.npz", "--take", folder / "take.csv", "--audio", folder / "click.wav")
    assert run("render", *words, "--fps", fps, *SMALL, "-o", out, "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    exact = 30_000 / 1001 if fps == 29.97 else fps
    count = int(SECONDS * exact + 0.05) + 1
    assert facts["frames"] == count
    assert facts["seconds"] == pytest.approx(count / exact)
    take = em.read_performance(folder / "take.csv")
    poses = take.at(np.arange(count) / exact)
    shown = pictures(out)
    assert len(shown) == count
    with Stage(rig.neutral, film_camera(rig, poses, "front", SIZE), size=SIZE) as stage:
        stills = {w: stage.picture(rig.pose({"jawOpen": w})) for w in np.unique(poses).tolist()}
    assert np.abs(stills[0.0].astype(float) - stills[1.0]).mean() > 12
    for (weight,), frame in zip(poses.tolist(), shown, strict=True):
        assert np.abs(frame - stills[weight]).mean() < 4, weight
    changes = np.abs(np.diff(shown.mean(axis=(1, 2, 3))))
    flash = (int(changes.argmax()) + 1) / exact
    heard, length = clicks(out)
    assert abs(heard - FLASH) < 0.003
    assert abs(heard - flash) <= 1 / exact
    assert length == pytest.approx(count / exact, abs=0.025)


@pytest.mark.parametrize("name", ["click.mp3", "click.mov"])
def test_the_sound_of_other_files(folder: Path, tmp_path: Path, name: str) -> None:
    out = tmp_path / "take.mp4"
    words = (folder / "rig.npz", folder / "take.csv", "--audio", folder / name)
    assert run("animate", *words, "--fps", 30, *SMALL, "-o", out) == 0
    assert abs(clicks(out)[0] - FLASH) < 0.01


@pytest.mark.parametrize(
    ("options", "heard"),
    [
        (("--audio-offset", 0.1), FLASH + 0.1),
        (("--audio-offset", -0.1), FLASH - 0.1),
        (("--from", 0.3), FLASH - 0.3),
        (("--from", 0.3, "--to", 0.7, "--audio-offset", 0.1), FLASH - 0.2),
    ],
)
def test_parts_and_offsets(
    folder: Path, tmp_path: Path, options: tuple[object, ...], heard: float
) -> None:
    out = tmp_path / "take.mp4"
    words = (folder / "rig.npz", "--take", folder / "take.csv", "--audio", folder / "click.wav")
    assert run("render", *words, *options, "--fps", 25, *SMALL, "-o", out) == 0
    assert abs(clicks(out)[0] - heard) < 0.003
    flashed = int(np.abs(np.diff(pictures(out).mean(axis=(1, 2, 3)))).argmax()) + 1
    begun = 0.3 if "--from" in options else 0.0
    assert abs(flashed / 25 - (FLASH - begun)) <= 1 / 25


@pytest.mark.parametrize(
    ("seconds", "told"),
    [(0.6, "shorter than the take: its last 0.2"), (3.0, "longer than the take: its last 2.1")],
)
def test_a_sound_of_another_length_is_told(
    folder: Path, tmp_path: Path, seconds: float, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "take.mp4"
    _click(tmp_path / "s.wav", seconds)
    words = (folder / "rig.npz", folder / "take.csv", "--audio", tmp_path / "s.wav")
    assert run("animate", *words, "--rate", 30, *SMALL, "-o", out, "--json") == 0
    captured = capsys.readouterr()
    assert told in captured.err
    frames = json.loads(captured.out)["frames"]
    assert clicks(out)[1] == pytest.approx(frames / 30, abs=0.025)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--audio", "click.wav", "--audio-offset", "nan"), "--audio-offset must be a number"),
        (("--from", "nan"), "--from must be a number, found nan"),
        (("--from", 0.5, "--to", 0.1), "--from 0.5 comes after --to 0.1: exchange the two"),
        (("--fps", 1e-9), "a clip needs above 0 and at most 240 fps, found 0"),
        (("--fps", "inf"), "a clip needs above 0 and at most 240 fps, found inf"),
    ],
)
def test_what_makes_no_film_is_refused_in_a_sentence(
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    options: tuple[object, ...],
    told: str,
) -> None:
    monkeypatch.chdir(folder)
    words = (
        "rig.npz",
        "--take",
        "take.csv",
        "--fps",
        25,
        *options,
        *SMALL,
        "-o",
        tmp_path / "take.mp4",
    )
    assert run("render", *words) == 1
    assert told in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_part_between_two_keys_is_a_film_too(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As of an animator's clip. From 1 to 2 s of a rise in 5 s it goes from 0.2 to 0.4."""
    (tmp_path / "keys.csv").write_text("seconds,jawOpen\n0,0\n5,1\n")
    (tmp_path / "all.csv").write_text("seconds,jawOpen\n0,0.2\n1,0.4\n")
    words = (folder / "rig.npz", "--fps", 4, *SMALL)
    part = ("--take", tmp_path / "keys.csv", "--from", 1, "--to", 2)
    assert run("render", *words, *part, "-o", tmp_path / "a.#.png", "--json") == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 5
    assert run("render", *words, "--take", tmp_path / "all.csv", "-o", tmp_path / "b.#.png") == 0
    one, other = (
        np.stack([np.asarray(Image.open(path)) for path in sorted(tmp_path.glob(f"{of}.*.png"))])
        for of in "ab"
    )
    assert np.abs(one.astype(int) - other).max() <= 2
    assert (np.abs(np.diff(one.astype(int), axis=0)).max(axis=(1, 2, 3)) > 2).all()


def test_weights_beyond_1_are_clipped_by_both_verbs(folder: Path, tmp_path: Path) -> None:
    """Else the board goes on along the end of its path."""
    (tmp_path / "take.csv").write_text("seconds,jawOpen\n0,1.8\n0.1,1.8\n")
    (tmp_path / "full.csv").write_text("seconds,jawOpen\n0,1\n0.1,1\n")
    words = {
        "full": ("render", folder / "rig.npz", "--take", tmp_path / "full.csv"),
        "clipped": ("render", folder / "rig.npz", "--take", tmp_path / "take.csv", "--clip"),
        "animated": ("animate", folder / "rig.npz", tmp_path / "take.csv", "--clip"),
        "beyond": ("render", folder / "rig.npz", "--take", tmp_path / "take.csv"),
    }
    for name, call in words.items():
        assert run(*call, "--fps", 10, *SMALL, "-o", tmp_path / f"{name}.##.png") == 0
    full, *others = ((tmp_path / f"{name}.01.png").read_bytes() for name in words)
    assert [other == full for other in others] == [True, True, False]


def test_gifs_and_numbered_pictures_of_a_take(folder: Path, tmp_path: Path) -> None:
    words = (folder / "rig.npz", folder / "take.csv", "--fps", 5, *SMALL)
    assert run("animate", *words, "-o", tmp_path / "f.##.png") == 0
    assert len(list(tmp_path.glob("f.*.png"))) == 5
    assert run("animate", *words, "--view", "side", "-o", tmp_path / "a.gif") == 0
    assert (tmp_path / "a.gif").exists()


def test_poses_as_a_sheet_a_picture_and_a_clip(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "poses.json"
    wide, half = {"JawOpen": 1.0, "jawOpn": 1.0}, {"JawOpen": 0.5}
    em.write_poses(file, {"Rest": {}, "Wide": wide, "Half": half})
    made = folder / "rig.npz"
    assert run("render", made, "--pose", file, *SMALL, "-o", tmp_path / "s.png", "--json") == 0
    captured = capsys.readouterr()
    assert "no slider 'jawOpn' (did you mean 'jawOpen'?): left out" in captured.err
    facts = json.loads(captured.out)
    assert facts["poses"] == {"Rest": {}, "Wide": {"jawOpen": 1.0}, "Half": {"jawOpen": 0.5}}
    assert facts["width"] >= 3 * SIZE[0]
    words = ("--pose", f"{file}#Half", *SMALL, "-o", tmp_path / "h.png", "--json")
    assert run("render", made, *words) == 0
    assert json.loads(capsys.readouterr().out)["pose"] == {"jawOpen": 0.5}
    keys = ("--pose-times", "0,1,1.5", "--timing", "linear", "--rate", 10)
    assert run("animate", made, file, *keys, "-o", tmp_path / "p.glb") == 0
    take = em.read_performance(tmp_path / "p.glb")
    np.testing.assert_allclose(take.at([0, 0.5, 1, 1.5])[:, 0], [0, 0.5, 1, 0.5], atol=1e-6)
    assert run("render", made, "--take", file, "--fps", 10, *SMALL, "-o", tmp_path / "p.mp4") == 0
    assert len(pictures(tmp_path / "p.mp4")) == 21


@pytest.mark.skipif(os.name != "posix", reason="sends the signal of Ctrl-C")
def test_ctrl_c_leaves_nothing_behind(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("time,jawOpen\n0,0\n600,1\n")
    out = tmp_path / "out"
    out.mkdir()
    words = [folder / "rig.npz", tmp_path / "t.csv", "--audio", folder / "click.wav", "--rate", 30]
    code = "import sys; from elastomorph.cli import main; main(sys.argv[1:])"
    call = ["-c", code, "animate", *map(str, words), *SMALL, "-o", str(out / "a.mp4")]
    with started(*call, stderr=subprocess.PIPE) as process:
        until = time.monotonic() + 60
        while not list(out.iterdir()) and time.monotonic() < until:
            time.sleep(0.05)
        assert list(out.iterdir())
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode == 130
    assert not list(out.iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--take", "t.csv", "-o", "a.png"], "a clip is written as"),
        (["--take", "t.csv", "-o", "a.gif", "--audio", "click.wav"], "a.gif holds no sound"),
        (["--take", "t.csv", "-o", "a.mp4", "--audio", "t.csv"], "no sound in it"),
        (["--take", "t.csv", "-o", "a.mp4", "--audio", "none.wav"], "none.wav: "),
        (["--take", "t.csv", "-o", "a.mp4", "--audio-offset", "1"], "add --audio take.wav"),
        (
            ["--take", "t.csv", "-o", "a.mp4", "--audio", "click.wav", "--audio-offset", "-9"],
            "would not be heard",
        ),
        (["--take", "t.csv", "-o", "a.mp4", "--pose", "jawOpen=1"], "leave out --pose"),
        (["--take", "t.csv", "-o", "a.mp4", "--timing", "cosine"], "--timing is for poses"),
        (["--take", "t.csv", "-o", "a.mp4", "--fps", "0"], "above 0 and at most 240"),
        (["--take", "t.csv", "-o", "a.mp4", "--from", "9"], "no frame lies after 9 s"),
        (["--take", "other.csv", "-o", "a.mp4"], "no weight of other.csv drives a slider"),
        (["--take", "p.json#A", "-o", "a.mp4"], "is one pose, which does not move"),
        (["--audio", "click.wav", "-o", "a.png"], "--audio is for a --take"),
        (["--pose", "p.json", "--strip", "0,1", "-o", "a.png"], "name one pose"),
        (["--pose", "p.json", "--pose", "p.json#A", "-o", "a.png"], "a sheet of all its poses"),
        (["--pose", "p.json#B", "-o", "a.png"], "has no pose 'B': there are A"),
        (["--pose", "p.json#A", "-o", "a.png"], "these poses are for another rig"),
    ],
)
def test_what_cannot_be_filmed_is_one_sentence(
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    message: str,
) -> None:
    for file in folder.iterdir():
        (tmp_path / file.name).symlink_to(file)
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text("time,jawOpen\n0,0\n0.1,1\n0.2,0\n")
    Path("other.csv").write_text("time,smile\n0,1\n1,0\n")
    Path("p.json").write_text('{"A": {"smile": 1}}')
    before = set(tmp_path.iterdir())
    assert run("render", "rig.npz", *SMALL, *words) == 1
    error = capsys.readouterr().err.strip()
    assert message in error
    assert "\n" not in error
    assert set(tmp_path.iterdir()) == before


def test_a_face_without_sliders_is_not_filmed(
    rig: em.Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    still = tmp_path / "still.npz"
    em.write(still, em.Rig(rig.neutral, {}))
    (tmp_path / "t.csv").write_text("time,jawOpen\n0,0\n0.1,1\n0.2,0\n")
    words = ("--take", tmp_path / "t.csv", "-o", tmp_path / "a.mp4")
    assert run("render", still, *SMALL, *words) == 1
    assert "the rig has no sliders" in capsys.readouterr().err
    assert not (tmp_path / "a.mp4").exists()


def test_films_turn_the_head_unless_it_is_to_be_still(
    folder: Path, rig: em.Rig, tmp_path: Path
) -> None:
    """Numbered pictures: each is its pose, turned; left still, those of a take without angles."""
    takes = {"turned": "jawOpen,HeadYaw\n0,0,0\n0.5,1,0.5", "plain": "jawOpen\n0,0\n0.5,1"}
    for name, rows in takes.items():
        (tmp_path / f"{name}.csv").write_text(f"time,{rows}\n")
    films = {"turned": (), "plain": (), "still": ("--still-head",)}
    for name, words in films.items():
        take = tmp_path / f"{name if name in takes else 'turned'}.csv"
        out = tmp_path / f"{name}.##.png"
        words = (folder / "rig.npz", "--take", take, "--fps", 4, *SMALL, *words)
        assert run("render", *words, "-o", out) == 0
    drawn = {n: [tmp_path / f"{n}.{i:02d}.png" for i in (1, 2, 3)] for n in films}
    for plain, still in zip(drawn["plain"], drawn["still"], strict=True):
        assert plain.read_bytes() == still.read_bytes()
    neck = neck_of(rig.neutral, rig.morphs.values())
    turn = HeadTurn(neck, np.array([[0, 0, 0], [0.25, 0, 0], [0.5, 0, 0]]))
    camera = film_camera(rig, np.array([[0], [0.5], [1.0]]), "front", SIZE, turn)
    with Stage(rig.neutral, camera, size=SIZE, occlusion=16) as stage:
        for i, file in enumerate(drawn["turned"]):
            wanted = stage.picture(turn.of(rig.pose({"jawOpen": i / 2}), i))
            assert np.abs(np.asarray(Image.open(file)).astype(int) - wanted).max() <= 2
