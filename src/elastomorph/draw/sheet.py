"""Pictures in rows and columns, with words above, beside and below them and a scale of colours."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.camera import Camera
from elastomorph.draw.pictures import (
    COLOUR_MAP,
    RGB,
    ColourScale,
    Image,
    imported,
    round_up,
    written,
)
from elastomorph.draw.stage import BACKGROUND, Lines, Stage
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh

CLAY = 0.9
"""Grey of a surface that has lines on it."""
PAPER = (255, 255, 255)
INK = (25, 25, 30)
FAINT = (95, 95, 105)
SMALLEST = 10
"""Captions shrink to fit their pictures, but not below this height in pixels."""
_SCALE_HEIGHT = 4.2
"""Of a scale of colours with its words, over the height of its letters."""
_LEGEND_LETTERS, _SMALLEST_LEGEND = 40, 7
"""The letters below a single face: this much smaller than it is wide; but not smaller than this."""


@dataclass(frozen=True)
class Style:
    """How faces are drawn; with lines on it, a surface is of clay. No background is transparent."""

    wireframe: bool = False
    lines: tuple[Lines, ...] = ()
    background: RGB | None = BACKGROUND

    def draw(
        self,
        stage: Stage,
        vertices: NDArray[np.float64],
        colours: NDArray[np.float64] | None = None,
    ) -> Image:
        """A pose on a stage; colours as for `Stage.picture`."""
        if colours is None and self.lines:
            colours = np.full(vertices.shape, CLAY)
        return stage.picture(
            vertices,
            colours=colours,
            lines=self.lines,
            wireframe=self.wireframe,
            background=self.background,
        )


@dataclass(frozen=True, eq=False)
class Face:
    """One face of a sheet: (V, 3), what stands below it, and (V,) numbers for the sheet's scale."""

    vertices: NDArray[np.float64]
    caption: str = ""
    values: NDArray[np.float64] | None = None


def face_sheet(
    mesh: Mesh,
    rows: Sequence[Sequence[Face]],
    camera: Camera,
    size: tuple[int, int],
    path: str | Path | None = None,
    *,
    row_labels: Sequence[str] = (),
    column_labels: Sequence[str] = (),
    title: str = "",
    scale: ColourScale | None = None,
    style: Style | None = None,
) -> Image:
    """Draw faces of one mesh, all seen by one camera; those that are equal are drawn once.

    The size is that of one face in pixels; texts are as for `picture_grid`, the style is on a
    background that is not transparent, and the last row may be shorter.
    """
    style = style or Style()
    drawn: dict[tuple[bytes, bytes], Image] = {}
    with Stage(mesh, camera, size=size) as stage:
        for face in chain.from_iterable(rows):
            if _key(face) not in drawn:
                colours = None
                if scale is not None and face.values is not None:
                    colours = scale.colours(face.values)
                drawn[_key(face)] = style.draw(stage, face.vertices, colours)
    image = picture_grid(
        [[drawn[_key(face)] for face in row] for row in rows],
        row_labels=row_labels,
        column_labels=column_labels,
        captions=[[face.caption for face in row] for row in rows]
        if any(face.caption for row in rows for face in row)
        else (),
        title=title,
        scale=scale,
    )
    return written(image, path)


def _key(face: Face) -> tuple[bytes, bytes]:
    return face.vertices.tobytes(), b"" if face.values is None else face.values.tobytes()


def scale_of(
    faces: Iterable[Face], label: str, highest: float | None = None, colour_map: str = COLOUR_MAP
) -> ColourScale:
    """One scale for the values of these faces: up to their largest, rounded up, by default."""
    if highest is None:
        highest = round_up(
            max(float(face.values.max()) for face in faces if face.values is not None)
        )
    return ColourScale(highest, label, colour_map)


def in_rows(faces: Sequence[Face], columns: int) -> list[Sequence[Face]]:
    """Faces in rows of this many, the last of which may be shorter."""
    if columns < 1:
        raise ParameterError(f"a row needs at least 1 column, found {columns}")
    return [faces[start : start + columns] for start in range(0, len(faces), columns)]


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
    height, width, columns = _checked(rows, row_labels, column_labels, captions)
    size = text_size or text_size_for(width)
    under = list(chain.from_iterable(captions))
    font, bold = _font(_caption_size(size, width, under)), _font(size, bold=True)
    heading = _font(round(1.25 * size), bold=True)
    cell = max(width, _widest(under, font), _widest(column_labels, bold)) + gap
    left = _widest(row_labels, bold) + size if any(row_labels) else gap
    above, below = _text_height(column_labels, size), _text_height(under, size)
    top = (round(2.2 * size) if title else 0) + (above or gap)
    across = max(left + columns * cell, _widest([title], heading) + 2 * size if title else 0)
    step, foot = height + gap + below, round(_SCALE_HEIGHT * size) if scale else 0
    sheet = imported("PIL.Image").new("RGB", (across, top + len(rows) * step + foot), PAPER)
    write = partial(imported("PIL.ImageDraw").Draw(sheet).text, fill=INK, anchor="ma")
    write, beside = partial(write, align="center"), partial(write, anchor="rm", align="right")
    if title:
        write(((across + (left if row_labels else 0)) / 2, 0.5 * size), title, font=heading)
    for column, text in enumerate(column_labels):
        middle = left + column * cell + (cell - gap) / 2
        write((middle, top - above + size // 2 - size // 4), text, font=bold)
    for number, text in enumerate(row_labels):
        beside((left - size // 2, top + number * step + height / 2), text, font=bold)
    for number, row in enumerate(rows):
        for column, image in enumerate(row):
            x, y = left + column * cell + (cell - gap - width) // 2, top + number * step
            sheet.paste(imported("PIL.Image").fromarray(image), (x, y))
            if captions:
                write((x + width / 2, y + height + size // 4), captions[number][column], font=font)
    if scale:
        _draw_scale(sheet, scale, size, left)
    return np.asarray(sheet).copy()


def _checked(
    rows: Sequence[Sequence[Image]],
    row_labels: Sequence[str],
    column_labels: Sequence[str],
    captions: Sequence[Sequence[str]],
) -> tuple[int, int, int]:
    """Height and width of the pictures, and the number of columns."""
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
    return height, width, columns


def _draw_scale(sheet: Any, scale: ColourScale, size: int, left: int) -> None:
    """Draw a scale with its words at the foot of a sheet, right of its row labels."""
    draw = imported("PIL.ImageDraw").Draw(sheet)
    length, thick = min(round(0.9 * (sheet.width - left)), 40 * size), round(0.8 * size)
    x = left + (sheet.width - left - length) // 2
    y = sheet.height - round(_SCALE_HEIGHT * size) + round(0.6 * size)
    colours = ColourScale(1.0, "", scale.colour_map).colours(np.linspace(0, 1, length))
    bar = np.broadcast_to(np.rint(colours * 255).astype(np.uint8), (thick, length, 3))
    sheet.paste(imported("PIL.Image").fromarray(np.ascontiguousarray(bar)), (x, y))
    draw.rectangle((x - 1, y - 1, x + length, y + thick), outline=FAINT)
    write = partial(draw.text, fill=INK, font=_font(round(0.85 * size)), anchor="ma")
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        at = x + share * (length - 1)
        draw.line((at, y + thick, at, y + thick + size // 4), fill=FAINT)
        write((at, y + thick + size // 3), f"{share * scale.highest:.3g}")
    write((x + length / 2, y + thick + round(1.35 * size)), scale.label)


def with_legend(image: Image, scale: ColourScale | None) -> Image:
    """A face above the legend of its colours: `legend_height` more pixels, of the same width."""
    if scale is None:
        return image
    letters = _legend_letters(image.shape[1], scale)
    return picture_grid([[image]], scale=scale, text_size=letters, gap=0)


def legend_height(width: int, scale: ColourScale | None) -> int:
    """How much higher `with_legend` makes a picture of this width."""
    return 0 if scale is None else round(_SCALE_HEIGHT * _legend_letters(width, scale))


def _legend_letters(width: int, scale: ColourScale) -> int:
    """Height of the letters such that the words of the legend fit into its width."""
    fitting = 2 * width // max(len(scale.label), 1)
    return max(_SMALLEST_LEGEND, min(width // _LEGEND_LETTERS, fitting))


def stack(*sheets: Image) -> Image:
    """Sheets one below the other, each in the middle."""
    width = max(sheet.shape[1] for sheet in sheets)
    whole = np.full((sum(len(sheet) for sheet in sheets), width, 3), PAPER, dtype=np.uint8)
    y = 0
    for sheet in sheets:
        x = (width - sheet.shape[1]) // 2
        whole[y : y + len(sheet), x : x + sheet.shape[1]] = sheet
        y += len(sheet)
    return whole


def text_size_for(width: int) -> int:
    """Height of letters that suits pictures of this width."""
    return int(np.clip(round(width / 13), 13, 30))


def _caption_size(size: int, width: int, captions: Sequence[str]) -> int:
    wide = _widest(captions, _font(size))
    return size if wide <= 0.94 * width else max(SMALLEST, int(size * 0.94 * width / wide))


def _widest(texts: Iterable[str], font: Any) -> int:
    lines = (line for text in texts for line in text.split("\n"))
    return max((int(np.ceil(font.getlength(line))) for line in lines), default=0)


def _text_height(texts: Iterable[str], size: int) -> int:
    """Room for the tallest of these texts; none for none."""
    lines = max((text.count("\n") + 1 for text in texts), default=0)
    return lines * round(1.3 * size) + size // 2 if lines else 0


@cache
def _font(size: int, *, bold: bool = False) -> Any:
    """DejaVu Sans, which matplotlib brings along: the same letters on every machine."""
    folder = Path(imported("matplotlib").get_data_path()) / "fonts" / "ttf"
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return imported("PIL.ImageFont").truetype(str(folder / name), size)
