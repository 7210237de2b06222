"""Movies read back by another program hold what was drawn."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from elastomorph.draw import movie
from elastomorph.draw.movie import find_encoder, write_movie
from elastomorph.errors import ElastomorphError, FileError, ParameterError
from needs import extra

imageio_ffmpeg = extra("imageio_ffmpeg", "demo")

SIZE = (64, 48)


def _frame(number: int) -> NDArray[np.uint8]:
    """Four fields of plain colours that change places from frame to frame."""
    colours = np.array([(220, 40, 40), (40, 180, 60), (60, 70, 200), (225, 185, 165)], np.uint8)
    fields = np.roll(colours, number, axis=0).reshape(2, 2, 3)
    return fields.repeat(SIZE[1] // 2, axis=0).repeat(SIZE[0] // 2, axis=1)


def _read(path: Path) -> tuple[str, list[NDArray[np.float64]]]:
    """What ffmpeg says of a movie, and its frames."""
    program = find_encoder()
    told = subprocess.run(
        [program, "-hide_banner", "-i", str(path), "-f", "null", "-"],
        capture_output=True,
        text=True,
        check=True,
    ).stderr
    planes = ["-f", "rawvideo", "-pix_fmt", "yuv420p", "-"]
    raw = subprocess.run(
        [program, "-loglevel", "error", "-i", str(path), *planes], capture_output=True, check=True
    ).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, SIZE[0] * SIZE[1] * 3 // 2)
    return told, [_colours(frame.astype(float)) for frame in frames]


def _colours(planes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Red, green, blue of a frame by the definition of BT.709 in its limited range."""
    width, height = SIZE
    luma = (planes[: width * height].reshape(height, width) - 16) / 219
    chroma = (planes[width * height :].reshape(2, height // 2, width // 2) - 128) / 224
    blue, red = chroma.repeat(2, axis=1).repeat(2, axis=2)
    r, b = luma + 1.5748 * red, luma + 1.8556 * blue
    return 255 * np.stack([r, (luma - 0.2126 * r - 0.0722 * b) / 0.7152, b], axis=2)


@pytest.mark.parametrize(("fps", "count"), [(25.0, 12), (23.976, 5), (60.0, 1)])
def test_a_movie_has_its_frames_its_size_its_rate_and_its_colours(
    tmp_path: Path, fps: float, count: int
) -> None:
    path = tmp_path / "fields.mp4"
    write_movie(path, map(_frame, range(count)), SIZE, fps)
    facts, frames = _read(path)
    assert re.search(r"Video: h264.*yuv420p\(tv, bt709, progressive\), 64x48", facts)
    rate = re.search(r"([\d.]+) fps", facts)
    assert rate
    assert float(rate[1]) == pytest.approx(fps, abs=0.011)
    assert len(frames) == count
    for number, frame in enumerate(frames):
        for rows in (slice(4, 20), slice(28, 44)):
            for columns in (slice(4, 28), slice(36, 60)):
                inside = frame[rows, columns].mean(axis=(0, 1))
                expected = _frame(number)[rows, columns].mean(axis=(0, 1))
                np.testing.assert_allclose(inside, expected, atol=2)
    # a browser can start before it has all of it: the index lies in front of the pictures
    content = path.read_bytes()
    assert 0 < content.index(b"moov") < content.index(b"mdat")


def test_twice_the_same_frames_are_twice_the_same_file(tmp_path: Path) -> None:
    for name in ("one", "two"):
        write_movie(tmp_path / f"{name}.mp4", map(_frame, range(6)), SIZE, 25)
    assert (tmp_path / "one.mp4").read_bytes() == (tmp_path / "two.mp4").read_bytes()


def test_a_frame_that_does_not_fit_ends_the_movie(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="48, 64, 3"):
        write_movie(tmp_path / "a.mp4", [_frame(0), _frame(1)[:-2]], SIZE, 25)
    assert not list(tmp_path.iterdir())


def test_what_the_encoder_complains_about_reaches_the_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An encoder that stops by itself: the pipe breaks, and its last words are told."""
    script = "import sys; sys.stdin.buffer.read(10); sys.exit('no room on the moon')"
    monkeypatch.setattr(movie, "_command", lambda *_: [sys.executable, "-c", script])
    with pytest.raises(FileError, match="no room on the moon"):
        write_movie(tmp_path / "a.mp4", map(_frame, range(500)), SIZE, 25)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs /proc to list processes")
def test_no_encoder_survives_an_error(tmp_path: Path) -> None:
    others = set(_children())  # such as a browser that other tests look at pages with
    started: list[str] = []

    def frames() -> Iterator[NDArray[np.uint8]]:
        yield _frame(0)
        started.extend(set(_children()) - others)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_movie(tmp_path / "a.mp4", frames(), SIZE, 25)
    assert started
    assert not set(started) & set(_children())


def _children() -> list[str]:
    """Process numbers of the children of this process."""
    folder = Path(f"/proc/{os.getpid()}/task")
    return [pid for task in folder.iterdir() for pid in (task / "children").read_text().split()]


def test_a_machine_without_ffmpeg_is_told_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> str:
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", none)
    with pytest.raises(ElastomorphError, match="install ffmpeg"):
        find_encoder()


def test_without_the_package_the_extra_is_named() -> None:
    code = (
        "import sys; sys.modules['imageio_ffmpeg'] = None\n"
        "from elastomorph.errors import MissingExtraError\n"
        "from elastomorph.draw.movie import find_encoder\n"
        "try:\n    find_encoder()\nexcept MissingExtraError as error:\n    print(error)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert "'imageio-ffmpeg'" in done.stdout
    assert "elastomorph[demo]" in done.stdout
