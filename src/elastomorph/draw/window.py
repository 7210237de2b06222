"""A render window without a screen, and the pixels in it."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from elastomorph.draw.pictures import Image, imported
from elastomorph.errors import ElastomorphError

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
