"""Clips have the frames, the size and the rate that were asked for, or are not there."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from elastomorph.draw.movie import check_clip, frame_durations, is_clip, write_clip
from elastomorph.errors import FileError, ParameterError

WIDTH, HEIGHT = 48, 32


def _frame(number: int, channels: int = 3) -> NDArray[np.uint8]:
    """A bar that moves by two pixels a frame."""
    frame = np.full((HEIGHT, WIDTH, channels), 240, dtype=np.uint8)
    frame[8:24, 2 * number : 2 * number + 10, :3] = (200, 60, 40)
    if channels == 4:
        frame[:8, :, 3] = 0
    return frame


def _frames(count: int) -> list[NDArray[np.uint8]]:
    return [_frame(number) for number in range(count)]


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_moving_pictures_come_back_frame_by_frame(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"bar{suffix}"
    write_clip(path, iter(_frames(9)), count=9, fps=25)
    with Image.open(path) as picture:
        assert picture.n_frames == 9
        assert picture.info["loop"] == 0
        for number, frame in enumerate(ImageSequence.Iterator(picture)):
            picture.load()
            assert picture.info["duration"] == 40
            found = np.asarray(frame.convert("RGB")).astype(int)
            assert np.abs(found - _frame(number)).mean() < 4
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_webp_keeps_what_is_transparent(tmp_path: Path) -> None:
    path = tmp_path / "bar.webp"
    write_clip(path, [_frame(number, 4) for number in range(3)], count=3, fps=10)
    with Image.open(path) as picture:
        assert picture.mode == "RGBA"
        np.testing.assert_array_equal(np.asarray(picture)[..., 3], _frame(0, 4)[..., 3])


def test_numbered_pictures_are_the_frames(tmp_path: Path) -> None:
    write_clip(tmp_path / "bar.##.png", _frames(11), count=11, fps=25)
    names = sorted(file.name for file in tmp_path.iterdir())
    assert names == [f"bar.{number:02d}.png" for number in range(1, 12)]
    for number, name in enumerate(names):
        np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / name)), _frame(number))
    # the same once more takes their places, a shorter clip would leave a wrong end behind
    write_clip(tmp_path / "bar.##.png", _frames(11), count=11, fps=25)
    with pytest.raises(FileError, match=r"bar\.11\.png"):
        write_clip(tmp_path / "bar.##.png", _frames(10), count=10, fps=25)


@given(st.integers(1, 300), st.floats(0.5, 50), st.sampled_from([1, 10]))
def test_durations_never_drift(count: int, fps: float, step: int) -> None:
    """Each frame ends within half a step of where it should."""
    ends = np.cumsum(frame_durations(count, fps, step))
    assert (np.array(frame_durations(count, fps, step)) % step == 0).all()
    np.testing.assert_array_less(
        np.abs(ends - np.arange(1, count + 1) * 1000 / fps), step / 2 + 1e-6
    )


@pytest.mark.parametrize("name", ["bar.mp4", "bar.gif", "bar.webp"])
@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_nothing_is_left_of_a_clip_that_failed_midway(
    tmp_path: Path, name: str, error: type[BaseException]
) -> None:
    (tmp_path / name).write_bytes(b"the old one")

    def frames() -> Iterator[NDArray[np.uint8]]:
        yield from _frames(5)
        raise error

    with pytest.raises(error):
        write_clip(tmp_path / name, frames(), count=9, fps=25)
    assert [file.name for file in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == b"the old one"


@pytest.mark.parametrize("name", ["bar.mp4", "bar.gif", "bar.webp"])
def test_frames_must_be_alike_and_as_many_as_said(tmp_path: Path, name: str) -> None:
    odd = [*_frames(2), _frame(2)[:-2]]
    with pytest.raises(ParameterError, match="frame 3"):
        write_clip(tmp_path / name, odd, count=3, fps=25)
    with pytest.raises(ParameterError, match="expected 4"):
        write_clip(tmp_path / name, _frames(3), count=4, fps=25)
    with pytest.raises(ParameterError, match="frame 3"):
        write_clip(tmp_path / name, _frames(3), count=2, fps=25)
    assert not list(tmp_path.iterdir())


def test_of_numbered_pictures_those_that_were_finished_stay(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="expected 4"):
        write_clip(tmp_path / "bar.#.png", _frames(3), count=4, fps=25)
    assert sorted(file.name for file in tmp_path.iterdir()) == [f"bar.{n}.png" for n in (1, 2, 3)]


@pytest.mark.parametrize(
    ("name", "size", "count", "fps", "message"),
    [
        ("a.txt", (8, 8), 3, 25, r"\.mp4"),
        ("a", (8, 8), 3, 25, "no suffix"),
        ("a.##.txt", (8, 8), 3, 25, r"\.png"),
        ("a.mp4", (9, 8), 3, 25, "10x8"),
        ("a.gif", (8, 8), 3, 60, "50 frames"),
        ("a.gif", (4000, 4000), 30, 25, "memory"),
        ("a.webp", (4000, 4000), 30, 25, "memory"),
        ("a.mp4", (8, 8), 0, 25, "at least 1 frame"),
        ("a.mp4", (8, 8), 3, 0, "fps"),
        ("a.mp4", (8, 8), 3, float("nan"), "fps"),
        ("a.mp4", (8, 8), 3, float("inf"), "fps"),
    ],
)
def test_what_cannot_be_written_is_said_before_it_is_drawn(
    tmp_path: Path, name: str, size: tuple[int, int], count: int, fps: float, message: str
) -> None:
    with pytest.raises(ParameterError, match=message):
        check_clip(tmp_path / name, size, count, fps)


def test_places_that_are_not_there(tmp_path: Path) -> None:
    for name in ("a.mp4", "a.gif", "a.#.png"):
        with pytest.raises(FileError, match="nowhere"):
            check_clip(tmp_path / "nowhere" / name, (8, 8), 3, 25)
    with pytest.raises(FileError, match="one run of #"):
        check_clip(tmp_path / "a.#.#.png", (8, 8), 3, 25)


def test_no_frames_make_no_clip(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="at least 1"):
        write_clip(tmp_path / "a.mp4", [], count=1, fps=25)


def test_what_can_only_be_a_clip() -> None:
    assert [is_clip(name) for name in ("a.mp4", "a.GIF", "a.##.png", "a.webp", "a.png")] == [
        *(True, True, True),
        *(False, False),
    ]
