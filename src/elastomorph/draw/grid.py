"""Pictures side by side, with words above, beside and below them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.draw.extras import imported
from elastomorph.draw.heat import COLOUR_MAP, heat_colours
from elastomorph.draw.stage import Image
from elastomorph.errors import ParameterError

__all__ = ["ColourScale", "picture_grid", "stack", "text_size_for"]

PAPER = (255, 255, 255)
SMALLEST = 10
"""Captions shrink to fit their pictures, but not below this height in pixels."""
INK = (25, 25, 30)
FAINT = (95, 95, 105)


@dataclass(frozen=True)
class ColourScale:
    """The legend of a heat map.

    Attributes:
        highest: Value of the last colour; the first stands for 0.
        label: What the numbers are, with their unit.
        colour_map: A colour map of matplotlib.
    """

    highest: float
    label: str
    colour_map: str = COLOUR_MAP


def picture_grid(
    rows: Sequence[Sequence[Image]],
    *,
    row_labels: Sequence[str] = (),
    column_labels: Sequence[str] = (),
    captions: Sequence[Sequence[str]] = (),
    title: str = "",
    scale: ColourScale | None = None,
    text_size: int | None = None,
    gap: int = 4,
) -> Image:
    """Put pictures of one size into rows and columns.

    Args:
        rows: Rows of (h, w, 3) pictures; the last row may be shorter.
        row_labels: One text a row, written to its left; a line break starts a new line.
        column_labels: One text a column, written above.
        captions: A text below each picture, in rows as the pictures.
        title: Above everything.
        scale: Legend of colours, below everything.
        text_size: Height of the letters in pixels; fits the pictures by default.
        gap: White pixels between pictures.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No pictures, or of several sizes, or texts that do not match in number.
        MissingExtraError: Pillow or matplotlib is not installed.
    """
    shapes = {image.shape for row in rows for image in row}
    if len(shapes) != 1:
        raise ParameterError(f"a grid needs pictures of one size, found {sorted(shapes)}")
    height, width = shapes.pop()[:2]
    columns = max(len(row) for row in rows)
    for texts, count, what in (
        (row_labels, len(rows), "row"),
        (column_labels, columns, "column"),
        (captions, len(rows), "row"),
    ):
        if len(texts) not in (0, count):
            raise ParameterError(f"expected a text for each {what} ({count}), found {len(texts)}")
    if captions and [len(row) for row in captions] != [len(row) for row in rows]:
        raise ParameterError("expected a caption for each picture, in the same rows")
    size = text_size or text_size_for(width)
    font, bold = _font(size), _font(size, bold=True)
    line = round(1.3 * size)
    below_pictures = [text for row in captions for text in row]
    wide = max((_widest(text, font) for text in below_pictures), default=0)
    if wide > 0.94 * width:
        font = _font(max(SMALLEST, int(size * 0.94 * width / wide)))
        wide = max(_widest(text, font) for text in below_pictures)
    cell = max(width, wide, *(_widest(text, bold) for text in column_labels)) + gap
    left = max((_widest(text, bold) for text in row_labels), default=0)
    left += size if left else gap
    head = line * max((text.count("\n") + 1 for text in column_labels), default=0)
    top = (round(2.2 * size) if title else 0) + (head + size // 2 if head else gap)
    below = max((line * (text.count("\n") + 1) for text in below_pictures), default=0)
    below += size // 2 if below else 0
    foot = round(4.2 * size) if scale else 0
    across = left + columns * cell
    if title:
        across = max(across, _widest(title, _font(round(1.25 * size), bold=True)) + 2 * size)
    down = top + len(rows) * (height + gap + below) + foot
    sheet = imported("PIL.Image").new("RGB", (across, down), PAPER)
    draw = imported("PIL.ImageDraw").Draw(sheet)
    if title:
        place = ((across + (left if row_labels else 0)) / 2, 0.5 * size)
        draw.text(place, title, INK, font=_font(round(1.25 * size), bold=True), anchor="ma")
    for column, text in enumerate(column_labels):
        middle = left + column * cell + (cell - gap) / 2
        draw.multiline_text(
            (middle, top - head - size // 4), text, INK, font=bold, anchor="ma", align="center"
        )
    for number, row in enumerate(rows):
        y = top + number * (height + gap + below)
        if row_labels:
            draw.multiline_text(
                (left - size // 2, y + height / 2),
                row_labels[number],
                INK,
                font=bold,
                anchor="rm",
                align="right",
            )
        for column, image in enumerate(row):
            x = left + column * cell + (cell - gap - width) // 2
            sheet.paste(imported("PIL.Image").fromarray(image), (x, y))
            if captions:
                text = captions[number][column]
                draw.multiline_text(
                    (x + width / 2, y + height + size // 4),
                    text,
                    INK,
                    font=font,
                    anchor="ma",
                    align="center",
                )
    if scale:
        _draw_scale(sheet, draw, scale, size, (left, down - foot), across - left)
    return np.asarray(sheet).copy()


def stack(*sheets: Image, gap: int = 12) -> Image:
    """Sheets one below the other, each in the middle."""
    width = max(sheet.shape[1] for sheet in sheets)
    height = sum(sheet.shape[0] for sheet in sheets) + gap * (len(sheets) - 1)
    whole = np.full((height, width, 3), PAPER, dtype=np.uint8)
    y = 0
    for sheet in sheets:
        x = (width - sheet.shape[1]) // 2
        whole[y : y + sheet.shape[0], x : x + sheet.shape[1]] = sheet
        y += sheet.shape[0] + gap
    return whole


def text_size_for(width: int) -> int:
    """Height of letters that suits pictures of this width."""
    return int(np.clip(round(width / 13), 13, 30))


def _draw_scale(
    sheet: Any, draw: Any, scale: ColourScale, size: int, corner: tuple[int, int], room: int
) -> None:
    length = min(round(0.9 * room), 40 * size)
    x, y = corner[0] + (room - length) // 2, corner[1] + round(0.6 * size)
    thick = round(0.8 * size)
    colours = heat_colours(np.linspace(0, 1, length), 1.0, colour_map=scale.colour_map)
    bar = np.broadcast_to(np.rint(colours * 255).astype(np.uint8), (thick, length, 3))
    sheet.paste(imported("PIL.Image").fromarray(np.ascontiguousarray(bar)), (x, y))
    draw.rectangle((x - 1, y - 1, x + length, y + thick), outline=FAINT)
    font = _font(round(0.85 * size))
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        at = x + share * (length - 1)
        draw.line((at, y + thick, at, y + thick + size // 4), fill=FAINT)
        text = f"{share * scale.highest:.3g}"
        draw.text((at, y + thick + size // 3), text, INK, font=font, anchor="ma")
    label = (x + length / 2, y + thick + round(1.35 * size))
    draw.text(label, scale.label, INK, font=font, anchor="ma")


def _widest(text: str, font: Any) -> int:
    return max(int(np.ceil(font.getlength(part))) for part in text.split("\n"))


@cache
def _font(size: int, *, bold: bool = False) -> Any:
    """DejaVu Sans, which matplotlib brings along: the same letters on every machine."""
    folder = Path(imported("matplotlib").get_data_path()) / "fonts" / "ttf"
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return imported("PIL.ImageFont").truetype(str(folder / name), size)
