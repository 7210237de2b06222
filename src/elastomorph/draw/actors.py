"""What a stage shows: the parts of a mesh with their normals, and lines on its surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.dressed import Dress
from elastomorph.draw.pictures import colour_bytes, imported
from elastomorph.draw.window import rendering
from elastomorph.model.appearance import Material, Wrap
from elastomorph.model.polygons import Polygons

AMBIENT = 0.17
# An image of skin or cloth holds some shade already.
IMAGE_AMBIENT, IMAGE_DIFFUSE = 0.40, 0.88
# A heat map is read by its colours: less of them is left to light and shade than on skin.
HEAT_AMBIENT, HEAT_DIFFUSE = 0.30, 0.72
_WET = 0.8
# Where VTK's shader has multiplied its colour with the texture.
_OPACITY = "//VTK::TCoord::Impl"
_SHINE = _OPACITY + "\n  gl_FragData[0].rgb += specular;\n"
_MASK = _OPACITY + "\n  if (gl_FragData[0].a < {}) discard;\n  gl_FragData[0].a = 1.0;\n"


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

    Attributes:
        actor: What a vtkRenderer draws.
        corners: (C,) vertex of each point.
        blends: Whether what is behind it shines through.
    """

    def __init__(self, faces: Polygons, dress: Dress) -> None:
        self._own = np.flatnonzero(np.isin(faces.corner_faces, dress.polygons))
        self.corners = faces.indices[self._own]
        self._polygons = imported("vtkmodules.vtkCommonDataModel").vtkPolyData()
        self._sizes = faces.sizes[dress.polygons]
        self._offsets = np.concatenate([[0], np.cumsum(self._sizes)])
        self._polygons.SetPolys(_cells(self._sizes))
        self.actor = _actor(self._polygons)
        self._texture: Any = None
        self._veil: Any = None
        self._unlit = self._dressed = self.blends = False
        self._light = (AMBIENT, 1.0)
        self._look = dress.look
        self._shade = self.actor.GetProperty()
        self._shade.SetInterpolationToPhong()
        self._shade.SetSpecularPower(dress.look.polish)
        if dress.image is not None and dress.places is not None:
            self._paint(dress, dress.image, dress.places)
        if dress.material is not None:
            self._make_of(dress.material)

    def _paint(self, dress: Dress, image: NDArray[np.uint8], places: NDArray[np.float64]) -> None:
        """Show the image; where colours take its place, its opacity stays."""
        self._texture = _texture(image, dress.wrap, dress.smooth)
        if image.shape[2] == 4 and (image[..., 3] < 255).any():
            veil = image.copy()
            veil[..., :3] = 255
            self._veil = _texture(veil, dress.wrap, dress.smooth)
        self._polygons.GetPointData().SetTCoords(_array(places.astype(np.float32)))

    def _make_of(self, material: Material) -> None:
        """Take opacity and sides of a material, and whether light leaves it as it is."""
        self._unlit = material.unlit
        self._light, self._dressed = (IMAGE_AMBIENT, IMAGE_DIFFUSE), True
        self._shade.SetBackfaceCulling(not material.double_sided)
        self.blends = material.opacity == "blend"
        if self.blends:
            self._shade.SetOpacity(material.colour[3] if self._texture is None else 1.0)
            self.actor.ForceTranslucentOn()
            return
        self.actor.ForceOpaqueOn()
        if material.opacity == "mask" and self._texture is None:
            self.actor.SetVisibility(material.colour[3] >= material.cutoff)
        elif material.opacity == "mask":
            self.actor.GetShaderProperty().AddFragmentShaderReplacement(
                _OPACITY, True, _MASK.format(material.cutoff), False
            )

    def pose(
        self,
        positions: NDArray[np.float64],
        normals: NDArray[np.float64],
        colours: NDArray[np.uint8] | None,
        lit: bool,
    ) -> None:
        """Take a pose: (V, 3) positions in the scene, (C, 3) normals of all corners of the mesh.

        Colours (V, 3) take the place of the look; light and shade change them if it is lit.
        """
        self._polygons.SetPoints(_points(positions[self.corners]))
        of_points = self._polygons.GetPointData()
        of_points.SetNormals(_array(normals[self._own].astype(np.float32)))
        painted = colours is not None
        of_points.SetScalars(None if colours is None else _array(colours[self.corners]))
        self.actor.SetTexture(self._veil if painted else self._texture)
        white = painted or self._texture is not None
        self._shade.SetColor(*((1.0, 1.0, 1.0) if white else self._look.colour))
        lighting = lit and (painted or not self._unlit)
        self._shade.SetLighting(lighting)
        ambient, diffuse = (HEAT_AMBIENT, HEAT_DIFFUSE) if painted else self._light
        if self._dressed and not (painted or lighting):
            ambient, diffuse = 0.0, 1.0  # VTK adds them up
        self._shade.SetAmbient(ambient)
        self._shade.SetDiffuse(diffuse)
        self._shade.SetSpecular(0.0 if painted else self._look.shine)
        if self._texture is not None and self._look.shine > _WET:
            # VTK multiplies highlights with the texture too: on a black pupil there are none.
            shader = self.actor.GetShaderProperty()
            shader.ClearFragmentShaderReplacement(_OPACITY, True)
            if lighting and not painted:
                shader.AddFragmentShaderReplacement(_OPACITY, True, _SHINE, False)

    def sort(self, positions: NDArray[np.float64], towards: NDArray[np.float64]) -> None:
        """Draw the polygons from the farthest to the nearest, for what blends.

        The (V, 3) positions are those of the pose, the direction (3,) goes to the camera.
        """
        near = np.add.reduceat(positions[self.corners] @ towards, self._offsets[:-1])
        order = np.argsort(near / self._sizes, kind="stable")
        self._polygons.SetPolys(_cells(self._sizes[order], self._offsets[:-1][order]))


def line_actor(
    positions: NDArray[np.float64], lengths: NDArray[np.int64], lines: Lines, scale: float
) -> Any:
    """Lines as a vtkActor: (N, 3) points of all paths in the scene, (P,) points of each path.

    The scale is how many pixels are rendered for one pixel of the picture.
    """
    polylines = imported("vtkmodules.vtkCommonDataModel").vtkPolyData()
    polylines.SetPoints(_points(positions))
    polylines.SetLines(_cells(lengths))
    polylines.GetCellData().SetScalars(_array(colour_bytes(lines.colours, len(lengths))))
    actor = _actor(polylines)
    actor.GetProperty().LightingOff()
    actor.GetProperty().SetLineWidth(lines.width * scale)
    return actor


def _actor(shape: Any) -> Any:
    mapper = rendering().vtkPolyDataMapper()
    mapper.SetInputData(shape)
    actor = rendering().vtkActor()
    actor.SetMapper(mapper)
    return actor


def _array(values: NDArray[Any]) -> Any:
    """A VTK array of the same numbers, in memory of its own."""
    support = imported("vtkmodules.util.numpy_support")
    return support.numpy_to_vtk(np.ascontiguousarray(values), deep=True)


def _points(positions: NDArray[np.float64]) -> Any:
    found = imported("vtkmodules.vtkCommonCore").vtkPoints()
    found.SetData(_array(positions.astype(np.float32)))
    return found


def _cells(sizes: NDArray[np.integer[Any]], starts: NDArray[np.integer[Any]] | None = None) -> Any:
    """Cells of these sizes; each has the points from its start on, else those after the last."""
    support = imported("vtkmodules.util.numpy_support")
    id_type = imported("vtkmodules.vtkCommonCore").VTK_ID_TYPE
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    points = np.arange(offsets[-1])
    if starts is not None:
        points += np.repeat(starts - offsets[:-1], sizes)
    found = imported("vtkmodules.vtkCommonDataModel").vtkCellArray()
    found.SetData(
        support.numpy_to_vtk(offsets, deep=True, array_type=id_type),
        support.numpy_to_vtk(points, deep=True, array_type=id_type),
    )
    return found


def _texture(image: NDArray[np.uint8], wrap: Wrap, smooth: bool) -> Any:
    grid = imported("vtkmodules.vtkCommonDataModel").vtkImageData()
    grid.SetDimensions(image.shape[1], image.shape[0], 1)
    grid.GetPointData().SetScalars(_array(image.reshape(-1, image.shape[2])))
    found = imported("vtkmodules.vtkRenderingOpenGL2").vtkOpenGLTexture()
    found.SetInputData(grid)
    found.SetInterpolate(smooth)
    found.SetMipmap(smooth)
    ways = {"clamp": found.ClampToEdge, "repeat": found.Repeat, "mirror": found.MirroredRepeat}
    found.SetWrap(ways[wrap])
    return found
