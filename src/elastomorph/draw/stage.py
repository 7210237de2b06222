"""Pictures of one mesh: one render window, one camera, one light, any number of poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.draw.camera import Camera, View, camera_for
from elastomorph.draw.materials import (
    CornerNormals,
    Dress,
    corner_pairs,
    dresses_of,
    welded_corners,
)
from elastomorph.draw.pictures import (
    COLOUR_MAP,
    RGB,
    Image,
    Window,
    colour_bytes,
    heat_colours,
    imported,
    rendering,
    round_up,
    written,
)
from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import Material, Mesh, Wrap, as_vertices
from elastomorph.model.polygons import Polygons

# What a stage shows: the parts of a mesh with their normals, and lines on its surface.

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


BACKGROUND = (0.965, 0.965, 0.97)
LIGHTS = (  # where the light stands in the camera's axes, strength, colour
    ((-0.60, 0.60, 0.75), 0.80, (1.0, 0.99, 0.97)),  # key
    ((0.85, 0.10, 0.70), 0.34, (0.96, 0.98, 1.0)),  # fill
    ((-0.80, 0.50, -0.70), 0.35, (1.0, 1.0, 1.0)),  # rim
    ((0.85, 0.40, -0.60), 0.35, (1.0, 1.0, 1.0)),  # rim
)
DISTANCE = 127.0
"""Distance of the camera in the scene, just under a power of two: see OCCLUSION_BIAS."""
OCCLUSION_RADIUS = 0.035 * DISTANCE
"""Reach of ambient occlusion: in mouth, nostrils and between lids it is dark."""
OCCLUSION_BIAS = 0.0023 * DISTANCE
"""Least depth of a hollow: VTK keeps depths in half floats, here 1/2048 of the distance apart."""
OCCLUSION_SAMPLES = 64
BORDER = 0.04
"""Rendered round the picture and cut off, for ambient occlusion does not see beyond the border."""
LIFT = 0.0012
"""How far lines are lifted off the surface towards the camera, as a fraction of its distance."""
FINEST = 8
LARGE = 2048
"""Sides from which a pixel is one sample, for a window of four times as many would not fit."""
_BLACK, _WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


class Stage:
    """Renders poses of one mesh off screen with one camera and one light.

    Use as a context manager. Every pose costs only its normals and one rendering.

    Args:
        mesh: The polygons, and the names that tell skin from eyes and teeth.
        camera: Where pictures are taken from; frames ``mesh`` from the front by default.
        size: Width and height in pixels.
        supersampling: Each pixel is the mean of this number squared, from 1 to 8; by default of
            2, or of 1 where a side is longer than 2048 pixels.
        occlusion: Samples of the ambient occlusion, which cost most of a picture without a GPU.
    """

    def __init__(
        self,
        mesh: Mesh,
        camera: Camera | None = None,
        *,
        size: tuple[int, int] = (720, 900),
        supersampling: int | None = None,
        occlusion: int = OCCLUSION_SAMPLES,
    ) -> None:
        if not len(mesh.faces):
            raise MeshError(f"{mesh.name} has no polygons, so there is no surface to draw")
        if supersampling is None:
            supersampling = 1 if max(size) > LARGE else 2
        if min(size) < 1 or not 1 <= supersampling <= FINEST:
            raise ParameterError(
                f"a picture needs a size of at least 1 × 1 and a supersampling from 1 to "
                f"{FINEST}, found {size} and {supersampling}"
            )
        self.mesh = mesh
        self.size = size
        self.camera = camera or camera_for(mesh, size=size)
        self._factor = supersampling
        dressed = mesh.appearance is not None
        pairs = corner_pairs(mesh.faces, welded_corners(mesh) if dressed else None)
        # Who cuts vertices apart along seams does so along sharp edges too, and only there.
        one, other = (mesh.faces.indices[corners] for corners in pairs)
        self._normals = CornerNormals(mesh.faces, pairs, one == other if dressed else None)
        parts = [Part(mesh.faces, dress) for dress in dresses_of(mesh)]
        self._parts = sorted(parts, key=lambda part: part.blends)
        self._occlusion = _ambient_occlusion(occlusion)
        border = round(BORDER * max(size))
        self._renderer = rendering().vtkRenderer()
        self._light()
        self._aim(border)
        for part in self._parts:
            self._renderer.AddActor(part.actor)
        self._window = Window(self._renderer, size, border, supersampling)

    def picture(
        self,
        vertices: ArrayLike | None = None,
        *,
        colours: ArrayLike | None = None,
        lines: Sequence[Lines] = (),
        wireframe: bool = False,
        lit: bool = True,
        background: RGB | None = BACKGROUND,
    ) -> Image:
        """One pose: (height, width, 3) uint8, or (height, width, 4) on a transparent background.

        Args:
            vertices: (V, 3) positions; those of the mesh by default.
            colours: (V, 3) red, green, blue of each vertex from 0 to 1 instead of the looks of
                the parts, as from `heat_colours`.
            lines: Curves drawn on the surface.
            wireframe: Draw the edges of the polygons.
            lit: False shows the bare colours, without light and shade.
            background: Red, green, blue from 0 to 1; None is transparent.
        """
        points = self.mesh.vertices if vertices is None else as_vertices(vertices)
        if points.shape != self.mesh.vertices.shape:
            raise MeshError(
                f"expected {len(self.mesh.vertices):,} vertices to draw, found {len(points):,}"
            )
        painted = None if colours is None else colour_bytes(colours, len(points))
        drawn = [each for each in lines if len(each.paths)]
        if wireframe:
            drawn.insert(0, self._edges())
        actors = [self._line_actor(points, each) for each in drawn]
        normals = self._normals.of(points)
        placed = self._scene(points)
        to_camera = np.array(self.camera.position) - np.array(self.camera.focus)
        for part in self._parts:
            part.pose(placed, normals, painted, lit)
            if part.blends:
                part.sort(placed, to_camera)
        for actor in actors:
            self._renderer.AddActor(actor)
        self._renderer.SetPass(self._occlusion if lit else None)
        self._renderer.ResetCameraClippingRange()
        try:
            if background is not None:
                return self._drawn_on(background)
            return _cut_out(self._drawn_on(_BLACK), self._drawn_on(_WHITE))
        finally:
            for actor in actors:
                self._renderer.RemoveActor(actor)

    def _drawn_on(self, background: RGB) -> Image:
        self._renderer.SetBackground(*background)
        return self._window.picture()

    def close(self) -> None:
        """Give the render window back."""
        self._window.close()

    def __enter__(self) -> Stage:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _light(self) -> None:
        self._renderer.SetAutomaticLightCreation(False)
        for place, strength, colour in LIGHTS:
            light = rendering().vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*place)
            light.SetFocalPoint(0.0, 0.0, 0.0)
            light.SetIntensity(strength)
            light.SetColor(*colour)
            self._renderer.AddLight(light)

    def _aim(self, border: int) -> None:
        camera = self._renderer.GetActiveCamera()
        camera.SetPosition(*self._scene(np.array(self.camera.position)))
        camera.SetFocalPoint(0.0, 0.0, 0.0)
        camera.SetViewUp(*self.camera.up)
        with_border = (self.size[1] + 2 * border) / self.size[1]
        half = np.tan(np.radians(self.camera.angle / 2)) * with_border
        camera.SetViewAngle(float(2 * np.degrees(np.arctan(half))))

    def _scene(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Positions in the scene, whose origin the camera looks at from a fixed distance."""
        focus = np.array(self.camera.focus)
        distance = np.linalg.norm(np.array(self.camera.position) - focus)
        return np.asarray((points - focus) * (DISTANCE / distance))

    def _line_actor(self, points: NDArray[np.float64], lines: Lines) -> Any:
        indices = np.concatenate([np.asarray(path) for path in lines.paths])
        lengths = np.array([len(path) for path in lines.paths])
        lifted = self._scene(self.camera.towards(points[indices], LIFT))
        return line_actor(lifted, lengths, lines, self._factor)

    def _edges(self) -> Lines:
        used = np.zeros(len(self.mesh.vertices), dtype=bool)
        for part in self._parts:
            used[part.corners] = True
        edges = self.mesh.edges[used[self.mesh.edges].all(axis=1)]
        return Lines(edges, np.full((len(edges), 3), 0.2), 0.5)


def render(
    mesh: Mesh,
    path: str | Path | None = None,
    *,
    size: tuple[int, int] = (720, 900),
    view: View | Camera = "front",
    scalars: ArrayLike | None = None,
    highest: float | None = None,
    colour_map: str = COLOUR_MAP,
    wireframe: bool = False,
    lit: bool = True,
) -> Image:
    """Draw a mesh.

    For several poses of one mesh, `Stage` is quicker and keeps one camera.

    Args:
        mesh: Names of materials or groups tell skin from lips, eyes and teeth.
        path: Picture to write, if any; the suffix chooses the format.
        size: Width and height in pixels.
        view: ``front``, ``three-quarter``, ``side``, ``below``, ``mouth``, ``eyes``,
            ``whole``; degrees to the face's left and up; or a camera.
        scalars: (V,) numbers to draw as a heat map instead.
        highest: Their value at the end of the colour map; their largest, rounded up, by default.
        colour_map: A colour map of matplotlib.
        wireframe: Draw the edges of the polygons.
        lit: False shows bare colours, without light and shade.

    Returns:
        (height, width, 3) uint8.

    Raises:
        ParameterError: No such view or colour map, or scalars that do not fit.
        MissingExtraError: vtk (or matplotlib, for a heat map) is not installed.
    """
    camera = view if isinstance(view, Camera) else camera_for(mesh, view, size=size)
    colours = None
    if scalars is not None:
        top = round_up(float(np.max(scalars))) if highest is None else highest
        colours = heat_colours(scalars, top, colour_map=colour_map)
    with Stage(mesh, camera, size=size) as stage:
        image = stage.picture(colours=colours, wireframe=wireframe, lit=lit)
    return written(image, path)


def _ambient_occlusion(samples: int) -> Any:
    opengl = imported("vtkmodules.vtkRenderingOpenGL2")
    shade = opengl.vtkSSAOPass()
    shade.SetRadius(OCCLUSION_RADIUS)
    shade.SetBias(OCCLUSION_BIAS)
    shade.SetKernelSize(samples)
    shade.SetBlur(True)
    shade.SetDelegatePass(opengl.vtkRenderStepsPass())
    return shade


def _cut_out(on_black: Image, on_white: Image) -> Image:
    """What hides the background, and how much: a colour C with opacity a is aC and aC + (1 - a)."""
    shine_through = np.subtract(on_white, on_black, dtype=np.int16).mean(axis=2)
    opacity = np.clip(255.0 - shine_through, 0.0, 255.0)
    share = np.where(opacity > 0, opacity, 255.0)[..., None] / 255.0
    colour = np.where(opacity[..., None] > 0, on_black / share, 0.0)
    whole = np.concatenate([colour, opacity[..., None]], axis=2)
    return np.asarray(np.clip(np.rint(whole), 0, 255), dtype=np.uint8)
