"""What stands on the stage: the parts of a mesh, and lines on its surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.draw import vtk_arrays
from elastomorph.draw.extras import imported, rendering
from elastomorph.draw.materials import Look
from elastomorph.errors import ParameterError
from elastomorph.model.polygons import Polygons

__all__ = ["Lines", "Part", "colour_bytes", "line_actor"]

AMBIENT = 0.17
# A heat map is read by its colours: less of them is left to light and shade than on skin.
HEAT_AMBIENT, HEAT_DIFFUSE = 0.30, 0.72


@dataclass(frozen=True)
class Lines:
    """Polylines on the surface.

    Attributes:
        paths: Each (M,) vertex indices in order; repeat the first to close.
        colours: (N, 3) red, green, blue from 0 to 1, one for each path.
        width: In pixels of the finished picture.
    """

    paths: Sequence[NDArray[np.integer[Any]]] | NDArray[np.integer[Any]]
    colours: NDArray[np.float64]
    width: float = 1.6


class Part:
    """The polygons of one look; every corner is a point with its own normal.

    Args:
        faces: All polygons of the mesh.
        numbers: Which of them belong to the part.
        look: How they reflect light.

    Attributes:
        actor: What a vtkRenderer draws.
        corners: (C,) vertex of each point.
    """

    def __init__(self, faces: Polygons, numbers: NDArray[np.int64], look: Look) -> None:
        core = rendering()
        chosen = np.zeros(len(faces), dtype=bool)
        chosen[numbers] = True
        self._own = np.flatnonzero(chosen[faces.corner_faces])
        self.corners = faces.indices[self._own]
        self._polygons = vtk_arrays.poly_data()
        self._polygons.SetPolys(vtk_arrays.cells(faces.sizes[chosen]))
        mapper = core.vtkPolyDataMapper()
        mapper.SetInputData(self._polygons)
        self.actor = core.vtkActor()
        self.actor.SetMapper(mapper)
        self._texture: Any = None
        self._look = look
        self._shade = self.actor.GetProperty()
        self._shade.SetInterpolationToPhong()
        self._shade.SetSpecularPower(look.polish)

    def wear(self, image: NDArray[np.uint8], coordinates: NDArray[np.float64]) -> None:
        """Paint the part with an image, of which each corner shows the given place."""
        self._texture = imported("vtkmodules.vtkRenderingOpenGL2").vtkOpenGLTexture()
        self._texture.SetInputData(vtk_arrays.image_grid(image))
        self._texture.InterpolateOn()
        self._texture.MipmapOn()
        self._texture.SetWrap(self._texture.ClampToEdge)
        places = vtk_arrays.array(coordinates.astype(np.float32))
        self._polygons.GetPointData().SetTCoords(places)

    def pose(
        self,
        positions: NDArray[np.float64],
        normals: NDArray[np.float64],
        colours: NDArray[np.uint8] | None,
        lit: bool,
    ) -> None:
        """Take a pose.

        Args:
            positions: (V, 3) of the whole mesh, in the scene.
            normals: (C, 3) of all corners of the mesh.
            colours: (V, 3) of the whole mesh, instead of the look.
            lit: Whether light and shade change the colours.
        """
        self._polygons.SetPoints(vtk_arrays.points(positions[self.corners]))
        of_points = self._polygons.GetPointData()
        of_points.SetNormals(vtk_arrays.array(normals[self._own].astype(np.float32)))
        painted = colours is not None
        of_points.SetScalars(None if colours is None else vtk_arrays.array(colours[self.corners]))
        self.actor.SetTexture(None if painted else self._texture)
        white = painted or self._texture is not None
        self._shade.SetColor(*((1.0, 1.0, 1.0) if white else self._look.colour))
        self._shade.SetLighting(lit)
        self._shade.SetAmbient(HEAT_AMBIENT if painted else AMBIENT)
        self._shade.SetDiffuse(HEAT_DIFFUSE if painted else 1.0)
        self._shade.SetSpecular(0.0 if painted else self._look.shine)


def line_actor(
    positions: NDArray[np.float64], lengths: NDArray[np.int64], lines: Lines, scale: float
) -> Any:
    """Lines as a vtkActor.

    Args:
        positions: (N, 3) points of all paths one after another, in the scene.
        lengths: (P,) number of points of each path.
        lines: Their colours and width.
        scale: Pixels rendered for one pixel of the picture.
    """
    core = rendering()
    polylines = vtk_arrays.poly_data()
    polylines.SetPoints(vtk_arrays.points(positions))
    polylines.SetLines(vtk_arrays.cells(lengths))
    colours = vtk_arrays.array(colour_bytes(lines.colours, len(lengths)))
    polylines.GetCellData().SetScalars(colours)
    mapper = core.vtkPolyDataMapper()
    mapper.SetInputData(polylines)
    actor = core.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    actor.GetProperty().SetLineWidth(lines.width * scale)
    return actor


def colour_bytes(colours: ArrayLike, count: int) -> NDArray[np.uint8]:
    """Colours from 0 to 1 as bytes.

    Raises:
        ParameterError: Not (count, 3) numbers from 0 to 1.
    """
    values = np.asarray(colours, dtype=np.float64)
    if values.shape != (count, 3) or not ((values >= 0) & (values <= 1)).all():
        raise ParameterError(
            f"expected ({count}, 3) colours with numbers from 0 to 1, found {values.shape}"
        )
    return np.rint(values * 255).astype(np.uint8)
