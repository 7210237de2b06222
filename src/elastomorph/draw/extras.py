"""The packages that only pictures need, imported when the first picture is drawn."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from elastomorph.errors import MissingExtraError

__all__ = ["imported", "rendering"]

_EXTRA = "demo"
_NAME_TO_INSTALL = {"vtkmodules": "vtk", "PIL": "pillow", "imageio_ffmpeg": "imageio-ffmpeg"}


def imported(module: str) -> Any:
    """A module of vtk, matplotlib, Pillow or imageio-ffmpeg, by its dotted name.

    Raises:
        MissingExtraError: The package is not installed.
    """
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != package:
            raise
        raise MissingExtraError(_NAME_TO_INSTALL.get(package, package), _EXTRA) from None


def rendering() -> Any:
    """VTK's ``vtkRenderingCore``, fit to draw.

    Its classes are made into ones that draw by ``vtkRenderingOpenGL2``, and only those made after
    that is imported: a mapper made before would draw nothing, without a word.

    Raises:
        MissingExtraError: vtk is not installed.
    """
    imported("vtkmodules.vtkRenderingOpenGL2")
    return imported("vtkmodules.vtkRenderingCore")
