"""Pictures of pixels: as files, coloured by numbers, and the packages that only drawing needs."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ElastomorphError, MissingExtraError, ParameterError
from elastomorph.io.atomic import replacing

Image = NDArray[np.uint8]
SUFFIXES = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WEBP"}
_NAME_TO_INSTALL = {"vtkmodules": "vtk", "PIL": "pillow", "imageio_ffmpeg": "imageio-ffmpeg"}


def imported(module: str) -> Any:
    """A module of vtk, matplotlib, Pillow or imageio-ffmpeg, imported when it is first needed."""
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != package:
            raise
        raise MissingExtraError(_NAME_TO_INSTALL.get(package, package), "demo") from None


def picture_suffix(path: str | Path) -> str:
    """The suffix of a picture's file, one of `SUFFIXES`; others are refused."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise ParameterError(
            f"{path}: a picture is written as {', '.join(SUFFIXES)}, found {suffix or 'no suffix'}"
        )
    return suffix


def write_picture(image: Image, path: str | Path) -> None:
    """Write an (H, W, 3) uint8 picture, whole or not at all, in a format of `SUFFIXES`."""
    suffix = picture_suffix(path)
    picture = as_pillow(image)
    settings = {} if suffix == ".png" else {"quality": 92}
    with replacing(path) as file:
        picture.save(file, format=SUFFIXES[suffix], **settings)


def written(image: Image, path: str | Path | None) -> Image:
    """The picture, written first where a path is given."""
    if path is not None:
        write_picture(image, path)
    return image


def as_png(image: Image) -> bytes:
    """The picture as the content of a PNG file, to embed in a page."""
    file = BytesIO()
    as_pillow(image).save(file, format="PNG")
    return file.getvalue()


def as_pillow(image: Image) -> Any:
    """The picture as an ``Image`` of Pillow."""
    return imported("PIL.Image").fromarray(np.ascontiguousarray(image))


RGB = tuple[float, float, float]
COLOUR_MAP = "magma_r"
"""Perceptually uniform, readable in grey and by the colour-blind; no error is pale, like skin."""
SCALE_ENDS = (1, 1.2, 1.6, 2, 2.4, 3.2, 4, 6, 8, 10)
"""A quarter of each has two digits, so that a scale in four parts is marked by round numbers."""


@dataclass(frozen=True)
class ColourScale:
    """The legend of a heat map from 0 to `highest`; the label names the numbers and their unit."""

    highest: float
    label: str
    colour_map: str = COLOUR_MAP

    def colours(self, values: ArrayLike) -> NDArray[np.float64]:
        """(N, 3) colours of (N,) values, see `heat_colours`."""
        return heat_colours(values, self.highest, colour_map=self.colour_map)


def heat_colours(
    values: ArrayLike, highest: float, *, lowest: float = 0.0, colour_map: str = COLOUR_MAP
) -> NDArray[np.float64]:
    """(N, 3) red, green, blue from 0 to 1 of (N,) values on a range; beyond it are its end colours.

    The colour map is one of matplotlib.
    """
    numbers = np.asarray(values, dtype=np.float64)
    if numbers.ndim != 1 or not np.isfinite(numbers).all():
        raise ParameterError("a heat map needs one finite number for each vertex")
    if not (np.isfinite(lowest) and np.isfinite(highest) and lowest < highest):
        raise ParameterError(f"a heat map needs a range above 0, found {lowest} to {highest}")
    maps = imported("matplotlib").colormaps
    if colour_map not in maps:
        raise ParameterError(f"matplotlib has no colour map {colour_map!r}; try {COLOUR_MAP!r}")
    table = maps[colour_map]
    return np.asarray(table((numbers - lowest) / (highest - lowest)))[:, :3]


def round_up(value: float) -> float:
    """The end of a scale: the next of `SCALE_ENDS` times a power of ten; 1 for 0."""
    if not np.isfinite(value) or value < 0:
        raise ParameterError(f"a scale needs a number of at least 0, found {value}")
    if value == 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array(SCALE_ENDS) * power
    return float(steps[np.argmax(steps >= value * (1 - 1e-12))])


def colour_named(text: str) -> RGB:
    """Red, green, blue from 0 to 1 of a colour by its name in HTML, or as #rrggbb."""
    try:
        red, green, blue = imported("PIL.ImageColor").getrgb(text.strip())[:3]
    except ValueError:
        raise ParameterError(
            f"background {text!r}: expected transparent, a name such as white, or #rrggbb"
        ) from None
    return red / 255, green / 255, blue / 255


def colour_bytes(colours: ArrayLike, count: int) -> NDArray[np.uint8]:
    """(count, 3) colours from 0 to 1 as bytes."""
    values = np.asarray(colours, dtype=np.float64)
    if values.shape != (count, 3) or not ((values >= 0) & (values <= 1)).all():
        raise ParameterError(
            f"expected ({count}, 3) colours with numbers from 0 to 1, found {values.shape}"
        )
    return np.rint(values * 255).astype(np.uint8)


# A render window without a screen, and the pixels in it.

_SOFTWARE_ONLY = "vtkOSOpenGLRenderWindow"
_OSMESA = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


class Window:
    """An off-screen render window of VTK that can be read.

    A border in pixels is rendered on each side and cut off; each pixel is the mean of the
    supersampling squared.
    """

    def __init__(
        self, renderer: Any, size: tuple[int, int], border: int, supersampling: int
    ) -> None:
        self._size, self._border, self._factor = size, border, supersampling
        with _quiet():
            self._window = rendering().vtkRenderWindow()
            _require_opengl(self._window.GetClassName())
            self._window.SetOffScreenRendering(True)
            self._window.SetMultiSamples(0)
            self._window.SetSize(*(supersampling * (side + 2 * border) for side in size))
            self._window.AddRenderer(renderer)

    def picture(self) -> Image:
        """Render, and average the samples of each pixel: (height, width, 3) uint8."""
        n, (width, height), border = self._factor, self._size, self._border
        pixels = imported("vtkmodules.vtkCommonCore").vtkUnsignedCharArray()
        low, right, top = n * border, n * (border + width) - 1, n * (border + height) - 1
        with _quiet():
            self._window.Render()
            read = self._window.GetPixelData(low, low, right, top, 0, pixels, 0)
        if not read:
            raise ElastomorphError("vtk could not read back the picture it drew")
        support = imported("vtkmodules.util.numpy_support")
        raw = support.vtk_to_numpy(pixels).reshape(n * height, n * width, 3)[::-1]
        total = np.full((height, width, 3), n * n // 2, dtype=np.uint16)
        for row in range(n):
            for column in range(n):
                total += raw[row::n, column::n]
        return np.asarray(total // (n * n), dtype=np.uint8)

    def close(self) -> None:
        """Give the window and its graphics memory back."""
        self._window.Finalize()


def rendering() -> Any:
    """VTK's ``vtkRenderingCore``, fit to draw.

    Its classes are made into ones that draw by ``vtkRenderingOpenGL2``, and only those made after
    that is imported: a mapper made before would draw nothing, without a word.
    """
    imported("vtkmodules.vtkRenderingOpenGL2")
    return imported("vtkmodules.vtkRenderingCore")


def _require_opengl(window_class: str) -> None:
    """VTK crashes the process where its last resort, OSMesa, is missing too: ask before it does."""
    if window_class != _SOFTWARE_ONLY:
        return
    for name in _OSMESA:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return
    raise ElastomorphError(
        "pictures need OpenGL that works without a display, and this machine has none: install "
        "Mesa's EGL (on Debian and Ubuntu: apt install libegl1 libegl-mesa0), or OSMesa"
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """VTK tries displays one after another and complains about each that is missing."""
    messages = imported("vtkmodules.vtkCommonCore").vtkObject
    before = messages.GetGlobalWarningDisplay()
    messages.SetGlobalWarningDisplay(0)
    try:
        yield
    finally:
        messages.SetGlobalWarningDisplay(before)
