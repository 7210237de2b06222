"""Videos that the page records: their length, and that sound and picture belong together."""

from __future__ import annotations

import io
import re
import subprocess
import wave
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from faces import Faces, glb
from numpy.typing import NDArray
from PIL import Image
from takes import alone, open_files, told
from visiting import Visit, settled, state, update, wait

from elastomorph.io.performance import write_performance_csv
from elastomorph.rig.performance import Performance
from needs import extra

if TYPE_CHECKING:
    from playwright.sync_api import Page

RATE, SAMPLES = 30, 48_000
EVENT = 1.0  # second of the take at which the jaw falls open, and of the sound at which it clicks
RANGE = (0.5, 1.5)


class Film(NamedTuple):
    """What a video file holds."""

    times: NDArray[np.float64]  # (F,) seconds of its pictures
    pictures: NDArray[np.uint8]  # (F, H, W) grey
    begin: float  # second of the first sample
    sound: NDArray[np.float32]


def write_take(folder: Path, seconds: int = 2) -> Path:
    """In which the jaw falls open from one frame to the next, and stays open."""
    times = np.arange(seconds * RATE + 1) / RATE
    jaw = (times >= EVENT - 1e-9).astype(float)
    path = folder / "flash.csv"
    write_performance_csv(path, Performance(("jawOpen",), times, jaw[:, None], RATE))
    return path


def write_click(folder: Path, seconds: float = 2.0, at: float = EVENT) -> Path:
    """Silence with a tenth of a second of 1 kHz."""
    times = np.arange(int(seconds * SAMPLES)) / SAMPLES
    loud = np.sin(2 * np.pi * 1000 * times) * ((times >= at) & (times < at + 0.1))
    path = folder / "click.wav"
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(SAMPLES)
        file.writeframes((30_000 * loud).astype("<i2").tobytes())
    return path


def film(path: Path) -> Film:
    """Decodes a video with its own time stamps."""
    program = extra("imageio_ffmpeg", "demo").get_ffmpeg_exe()

    def run(*arguments: str) -> subprocess.CompletedProcess[bytes]:
        command = [program, "-hide_banner", "-copyts", "-i", str(path), *arguments, "-"]
        return subprocess.run(command, capture_output=True, check=True, timeout=60)

    shown = "scale=64:64,format=gray,showinfo"
    decoded = run("-vf", shown, "-fps_mode", "passthrough", "-f", "rawvideo")
    stamps = [float(t) for t in re.findall(rb"pts_time:\s*([-\d.]+)", decoded.stderr)]
    pictures = np.frombuffer(decoded.stdout, np.uint8).reshape(-1, 64, 64)
    heard = run("-af", "ashowinfo", "-ac", "1", "-ar", str(SAMPLES), "-f", "f32le")
    begin = float(re.findall(rb"pts_time:\s*([-\d.]+)", heard.stderr)[0])
    return Film(np.array(stamps), pictures, begin, np.frombuffer(heard.stdout, "<f4"))


def record(page: Page, folder: Path, **choices: str) -> Path:
    page.get_by_role("button", name="Video…").click()
    for name, value in choices.items():
        page.get_by_label(name).select_option(value)
    with page.expect_download() as download:
        page.get_by_role("button", name="Record", exact=True).click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def moments(found: Film) -> tuple[float, float]:
    """Seconds at which the picture changes and at which the sound begins."""
    steps = np.abs(np.diff(found.pictures.astype(float), axis=0)).mean(axis=(1, 2))
    loud = np.flatnonzero(np.abs(found.sound) > 0.2)
    return float(found.times[1 + steps.argmax()]), found.begin + loud[0] / SAMPLES


def test_a_video_has_the_range_and_its_sound_in_step(
    visit: Visit, faces: Faces, tmp_path: Path
) -> None:
    page = visit(alone(glb(faces.rigs["linear"])), size=(420, 640))
    open_files(page, write_take(tmp_path), write_click(tmp_path))
    assert told(page) == []
    update(page, range=RANGE, clipTime=1.2)
    path = record(page, tmp_path)
    assert path.name == "flash.webm"
    assert told(page) == []
    found = film(path)
    frames = round((RANGE[1] - RANGE[0]) * RATE) + 1
    np.testing.assert_allclose(found.times, np.arange(frames) / RATE, atol=1e-3)
    assert len(found.sound) / SAMPLES == pytest.approx(frames / RATE, abs=0.03)
    seen, heard = moments(found)
    assert seen == pytest.approx(EVENT - RANGE[0], abs=2e-3)
    assert abs(seen - heard) < 0.5 / RATE
    assert page.evaluate("elastomorph.state().clipTime") == pytest.approx(1.2), "all is as it was"
    box = page.locator(".picture").bounding_box()
    for moment in (0.6, 1.2):  # the jaw closed and open
        update(page, clipTime=moment)
        settled(page)
        still = Image.open(io.BytesIO(page.screenshot(clip=box))).convert("L").resize((64, 64))
        frames = [found.pictures[round((t - RANGE[0]) * RATE)] for t in (moment, 1.8 - moment)]
        face = np.s_[16:48, 16:48]  # nothing lies over it
        own, other = (
            np.abs(frame[face] - np.asarray(still, float)[face]).mean() for frame in frames
        )
        assert own < 4
        assert own < 0.6 * other


def test_speed_and_offset_are_those_of_the_page(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """At twice the speed half as long; the sound, set off by a quarter of a second, keeps pace."""
    page = visit(alone(glb(faces.rigs["linear"])), size=(420, 640))
    open_files(page, write_take(tmp_path), write_click(tmp_path, seconds=1.9, at=0.75))
    update(page, range=RANGE, speed=2, soundOffsets={"flash": 0.25})
    found = film(record(page, tmp_path, Background="Dark"))
    assert len(found.times) == 16
    seen, heard = moments(found)
    assert seen == pytest.approx(0.267, abs=2e-3)  # the first frame of the video after it
    assert heard == pytest.approx(0.25, abs=0.01)
    assert found.pictures[0].mean() < 110


def test_a_video_has_the_size_that_was_chosen(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """And frames enough, also of a take with a key a second."""
    page = visit(alone(glb(faces.rigs["linear"])), size=(420, 640))
    path = tmp_path / "slow.csv"
    path.write_text("time,jawOpen\n0,0\n1,1\n2,0\n")
    open_files(page, path)
    update(page, range=[0.9, 1.0])
    before = page.evaluate("(c => [c.width, c.height])(document.querySelector('canvas'))")
    path = record(page, tmp_path, Size="1280 × 720")
    program = extra("imageio_ffmpeg", "demo").get_ffmpeg_exe()
    said = subprocess.run([program, "-i", str(path)], capture_output=True, check=False).stderr
    assert b"1280x720" in said
    assert b"Duration: 00:00:00.15" in said
    assert b"Audio" not in said
    after = page.evaluate("(c => [c.width, c.height])(document.querySelector('canvas'))")
    assert after == before


def test_a_recording_is_stopped(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """Until then nothing disturbs it, nor another size of the window."""
    page = visit(alone(glb(faces.rigs["linear"])), size=(420, 640))
    open_files(page, write_take(tmp_path, 600))  # longer than any machine takes to press a button
    page.get_by_role("button", name="Video…").click()
    page.get_by_role("button", name="Record", exact=True).dblclick()
    page.set_viewport_size({"width": 380, "height": 500})
    page.keyboard.press("0")
    page.wait_for_timeout(200)
    page.get_by_role("button", name="Stop (").click()
    page.get_by_role("button", name="Video…").wait_for()
    wait(page, "!document.querySelector('dialog[open]')")
    assert told(page) == []
    assert state(page)["clip"] == "flash"
