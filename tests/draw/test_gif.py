"""A GIF looks like its frames: flat paper, no bands, nothing that crawls."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from elastomorph.draw.movie import dither_pattern, write_gif

PAPER = (246, 246, 247)


def _frame(shift: int) -> NDArray[np.uint8]:
    """Skin from light to dark on paper, and a dark square that moves in a corner."""
    frame = np.empty((96, 128, 3), dtype=np.uint8)
    frame[:] = PAPER
    shade = np.linspace(1.0, 0.35, 96)[None, :, None]
    frame[16:80, 16:112] = np.rint(shade * np.array([225, 185, 165]))
    frame[84:92, 4 + shift : 12 + shift] = (60, 30, 30)
    return frame


def _read(path: Path) -> list[NDArray[np.int64]]:
    with Image.open(path) as picture:
        return [
            np.asarray(frame.convert("RGB")).astype(int)
            for frame in ImageSequence.Iterator(picture)
        ]


def test_paper_is_flat_and_shades_are_right_on_average(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    drawn = [_frame(shift) for shift in range(0, 12, 3)]
    write_gif(path, drawn, [40] * 4)
    for frame, found in zip(drawn, _read(path), strict=True):
        paper = (frame == PAPER).all(axis=2)
        np.testing.assert_array_equal(found[paper], np.broadcast_to(PAPER, (paper.sum(), 3)))
        error = found - frame
        assert np.abs(error).mean() < 2
        # over 8 × 8 pixels, the period of the dither, what is too light is too dark elsewhere
        blocks = error[16:80, 16:112].reshape(8, 8, 12, 8, 3).mean(axis=(1, 3))
        assert np.abs(blocks).max() < 2.5


def test_what_stands_still_stays_the_same(tmp_path: Path) -> None:
    write_gif(tmp_path / "a.gif", [_frame(shift) for shift in range(0, 12, 3)], [40] * 4)
    found = _read(tmp_path / "a.gif")
    for frame in found[1:]:
        np.testing.assert_array_equal(frame[:80], found[0][:80])


def test_one_palette_serves_all_frames(tmp_path: Path) -> None:
    write_gif(tmp_path / "a.gif", [_frame(shift) for shift in range(24)], [40] * 24)
    found = _read(tmp_path / "a.gif")
    assert len(found) == 24
    colours = {
        tuple(colour) for frame in found for colour in np.unique(frame.reshape(-1, 3), axis=0)
    }
    assert 60 < len(colours) <= 255


def test_what_stands_still_costs_nothing(tmp_path: Path) -> None:
    """Twenty more frames with a moving corner are smaller than one whole picture."""
    one, many = tmp_path / "one.gif", tmp_path / "many.gif"
    write_gif(one, [_frame(0)], [40])
    write_gif(many, [_frame(shift) for shift in range(21)], [40] * 21)
    palettes = 20 * 768
    assert many.stat().st_size - palettes < 2 * one.stat().st_size


def test_a_picture_of_one_colour(tmp_path: Path) -> None:
    plain = np.full((8, 8, 3), 77, dtype=np.uint8)
    write_gif(tmp_path / "a.gif", [plain], [40])
    np.testing.assert_array_equal(_read(tmp_path / "a.gif")[0], plain)


def test_the_dither_takes_every_level_once_and_favours_none() -> None:
    pattern = dither_pattern(8, 8)
    assert len(np.unique(pattern)) == 64
    assert abs(pattern.mean()) < 1e-12
    np.testing.assert_array_equal(dither_pattern(20, 13)[8:16, :8], pattern)
