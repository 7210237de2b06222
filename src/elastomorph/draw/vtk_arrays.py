"""Our arrays as VTK's: whole arrays at a time, never polygon by polygon."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.extras import imported

__all__ = ["array", "cells", "image_grid", "points", "poly_data"]


def array(values: NDArray[Any]) -> Any:
    """A VTK array of the same numbers, in memory of its own."""
    support = imported("vtkmodules.util.numpy_support")
    return support.numpy_to_vtk(np.ascontiguousarray(values), deep=True)


def points(positions: NDArray[np.float64]) -> Any:
    """vtkPoints at (N, 3) positions, in single precision."""
    found = imported("vtkmodules.vtkCommonCore").vtkPoints()
    found.SetData(array(positions.astype(np.float32)))
    return found


def cells(sizes: NDArray[np.integer[Any]]) -> Any:
    """Cells of these sizes whose points are numbered one after another, the first cell's first."""
    support = imported("vtkmodules.util.numpy_support")
    id_type = imported("vtkmodules.vtkCommonCore").VTK_ID_TYPE
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    found = imported("vtkmodules.vtkCommonDataModel").vtkCellArray()
    found.SetData(
        support.numpy_to_vtk(offsets, deep=True, array_type=id_type),
        support.numpy_to_vtk(np.arange(offsets[-1]), deep=True, array_type=id_type),
    )
    return found


def poly_data() -> Any:
    """An empty vtkPolyData."""
    return imported("vtkmodules.vtkCommonDataModel").vtkPolyData()


def image_grid(image: NDArray[np.uint8]) -> Any:
    """(H, W, 3) colours as vtkImageData; row 0 is the bottom."""
    grid = imported("vtkmodules.vtkCommonDataModel").vtkImageData()
    grid.SetDimensions(image.shape[1], image.shape[0], 1)
    grid.GetPointData().SetScalars(array(image.reshape(-1, 3)))
    return grid
