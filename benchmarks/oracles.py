"""What `together.py` measures by: nothing of what is measured."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.distance import pdist

import elastomorph as em
from elastomorph.samples import landmarks

Floats = NDArray[np.float64]

NEAR, TOUCHING, KEPT = 1.2e-2, 2e-3, 2e-3  # fractions of D
PLACES = np.array([[1, 1, 1], [2.4, 0.3, 0.3], [0.3, 2.4, 0.3], [0.3, 0.3, 2.4]]) / 3
SIZE = 336, 240  # pixels of a picture of an eye
CORNERS = {"eyeBlinkLeft": (42, 45), "eyeBlinkRight": (36, 39)}  # among 68 landmarks


def diameter(points: Floats) -> float:
    """The largest distance between two of (N, 3) points."""
    return float(pdist(points[ConvexHull(points).vertices]).max())


def diameters(rig: em.Rig) -> tuple[float, float]:
    """D that figures are parts of, and that of what targets move: one, but for the built-in head.

    Of the built-in head D is that of its face, without ears and the back of the head.
    """
    points, groups = rig.neutral.vertices, rig.neutral.groups
    moved = np.any([rig[name].delta.any(axis=1) for name in rig.names], axis=0)
    of_targets = diameter(points[moved])
    if groups is None or "skin" not in groups.names:
        return of_targets, of_targets
    chosen = np.flatnonzero(groups.of_face == groups.names.index("skin"))
    skin = np.unique(np.concatenate([rig.neutral.faces[i] for i in chosen]))
    return diameter(points[skin]), of_targets


def spelt(name: str) -> str:
    """A name of a shape in the one spelling in which names are compared."""
    for end, side in (("_L", "Left"), ("_R", "Right")):
        name = name.removesuffix(end) + side if name.endswith(end) else name
    return name.lower().replace("_", "")


def named(rig: em.Rig, name: str) -> str | None:
    """The slider of a name of ARKit, in any spelling."""
    return next((own for own in rig.names if spelt(own) == spelt(name)), None)


def triangles_of(mesh: em.Mesh) -> NDArray[np.int64]:
    """(T, 3) polygons split in fans."""
    return np.array([(f[0], f[k], f[k + 1]) for f in mesh.faces for k in range(1, len(f) - 1)])


class Contacts:
    """Vertices of a rig that face each other, and what moves them against each other.

    Attributes:
        pairs: (C, 2) vertices.
        touching: (C,) bool, which of them touch in the neutral.
    """

    def __init__(self, rig: em.Rig, extent: float) -> None:
        self.rig, self.extent = rig, extent
        neutral = rig.neutral.vertices
        moved = np.any([rig[name].delta.any(axis=1) for name in rig.names], axis=0)
        normals, places = _normals(rig.neutral), np.flatnonzero(moved)
        tree = cKDTree(neutral[places])
        found = set()
        for one in places.tolist():
            near = places[tree.query_ball_point(neutral[one], NEAR * extent)]
            near = near[normals[near] @ normals[one] < -0.3]
            # In front of it, not behind a sheet of two sides.
            near = near[(neutral[near] - neutral[one]) @ normals[one] > -0.2 * KEPT * extent]
            if len(near):
                other = int(near[np.linalg.norm(neutral[near] - neutral[one], axis=1).argmin()])
                found.add((min(one, other), max(one, other)))
        self.pairs = np.array(sorted(found)).reshape(-1, 2)
        rest = np.linalg.norm(self._between(neutral), axis=1)
        self.touching = rest < TOUCHING * extent
        self.fields = {name: self._between(rig[name].delta) for name in rig.morphs}
        self.bends = {name: [self._between(b) for b in rig[name].bends] for name in rig.morphs}

    def _between(self, field: Floats) -> Floats:
        return np.asarray(field[self.pairs[:, 0]] - field[self.pairs[:, 1]])

    def bent(self, weights: Mapping[str, float], *, pairs: bool) -> Floats:
        """(C, 3) what the bends of the paths add, with pair bends or without."""
        added = np.zeros((len(self.pairs), 3))
        times = dict(weights)
        if pairs:
            for name, own in self.rig.pair_bends().items():
                times[name] = max(0.0, min(weights.get(driver, 0.0) for driver in own.drivers))
        for name, t in times.items():
            for curve, bend in zip(self.rig[name].bend_curves, self.bends[name], strict=True):
                added += curve.at(t) * bend
        return added

    def slide(self, weights: Mapping[str, float], *, pairs: bool) -> float:
        """The largest slide, of what the straight rig keeps, as a fraction of D."""
        straight = sum((w * self.fields[name] for name, w in weights.items()), np.zeros(3))
        kept = np.linalg.norm(straight, axis=1) <= KEPT * self.extent
        slides = np.linalg.norm(self.bent(weights, pairs=pairs)[kept], axis=1)
        return float(slides.max(initial=0.0)) / self.extent


def _normals(mesh: em.Mesh) -> Floats:
    corners = triangles_of(mesh)
    a, b, c = (mesh.vertices[corners[:, k]] for k in range(3))
    found = np.zeros_like(mesh.vertices)
    for k in range(3):
        np.add.at(found, corners[:, k], np.cross(b - a, c - a))
    return np.asarray(found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-30))


class Lids:
    """Flat pictures of one eye from the front: of the skin of each lid by itself.

    The line between the corners of the eye parts them. Corners are landmarks of the built-in head;
    else the ends of what the blink moves by more than a third of its way.
    """

    def __init__(self, rig: em.Rig, blink: str) -> None:
        points, triangles = rig.neutral.vertices, triangles_of(rig.neutral)
        moved = np.linalg.norm(rig[blink].delta, axis=1)
        part = _parts(points, triangles)
        skin = part == np.bincount(part[moved > 0.05 * moved.max()]).argmax()
        drawn = skin[triangles[:, 0]]
        groups = rig.neutral.groups
        if groups is not None and "skin" in groups.names:
            ends = np.array([landmarks()[place] for place in CORNERS[blink]])
            shown = np.isin(groups.of_face, [groups.names.index(own) for own in ("skin", "head")])
            drawn &= np.repeat(shown, rig.neutral.faces.sizes - 2)
        else:
            lid = np.flatnonzero(skin & (moved > moved[skin].max() / 3))
            ends = lid[[points[lid, 0].argmin(), points[lid, 0].argmax()]]
        one, other = points[ends]
        self.middle = (one + other) / 2
        self.wide = 1.4 * float(np.linalg.norm((other - one)[:2]))
        centres = points[triangles].mean(axis=1)
        near = drawn & (centres[:, 2] > self.middle[2] - self.wide)
        near &= np.linalg.norm((centres - self.middle)[:, :2], axis=1) < self.wide / 2
        slope = (other - one)[1] / (other - one)[0]
        above = centres[:, 1] > one[1] + slope * (centres[:, 0] - one[0])
        self.points = _vtk("vtkCommonCore").vtkPoints()
        self.windows = [self._window(triangles[near & side]) for side in (above, ~above)]

    def _window(self, triangles: NDArray[np.int64]) -> Any:
        drawn = _vtk("vtkRenderingCore")
        import_module("vtkmodules.vtkRenderingOpenGL2")
        mapper, actor = drawn.vtkPolyDataMapper(), drawn.vtkActor()
        mapper.SetInputData(_surface(self.points, triangles))
        actor.SetMapper(mapper)
        actor.GetProperty().LightingOff()
        renderer, window = drawn.vtkRenderer(), drawn.vtkRenderWindow()
        renderer.AddActor(actor)
        camera = renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(*self.middle)
        camera.SetPosition(*(self.middle + [0, 0, 10 * self.wide]))
        camera.SetParallelScale(self.wide / 2 * SIZE[1] / SIZE[0])
        camera.SetClippingRange(self.wide, 30 * self.wide)
        window.SetOffScreenRendering(1)
        window.SetMultiSamples(0)
        window.SetSize(*SIZE)
        window.AddRenderer(renderer)
        return window

    def slit(self, positions: Floats) -> Floats:
        """(K,) height by which lids are apart in columns between the corners, past each other < 0.

        Not a number where one of them covers nothing.
        """
        arrays = _vtk("util.numpy_support")
        self.points.SetData(arrays.numpy_to_vtk(np.ascontiguousarray(positions), deep=1))
        self.points.Modified()
        above, below = (self._covered(window) for window in self.windows)
        beside = np.abs(np.arange(SIZE[0]) - SIZE[0] / 2) * 1.4 > SIZE[0] / 2
        there = above.any(axis=0) & below.any(axis=0) & ~beside
        # Rows are counted from below.
        gap = above.argmax(axis=0) - (SIZE[1] - below[::-1].argmax(axis=0))
        over = (above & below).sum(axis=0)
        return np.where(there, np.where(over, -over, gap) * self.wide / SIZE[0], np.nan)

    def _covered(self, window: Any) -> NDArray[np.bool_]:
        window.Render()
        grab = _vtk("vtkRenderingCore").vtkWindowToImageFilter()
        grab.SetInput(window)
        grab.ReadFrontBufferOff()
        grab.ShouldRerenderOff()
        grab.Update()
        flat = _vtk("util.numpy_support").vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars())
        return np.asarray(flat.reshape(SIZE[1], SIZE[0], -1)[..., 0] > 127)


def _parts(points: Floats, triangles: NDArray[np.int64]) -> NDArray[np.int32]:
    """(V,) the connected part of each vertex; vertices at one place are one."""
    _, place = np.unique(points, axis=0, return_inverse=True)
    ends = place.ravel()[triangles]
    pairs = np.concatenate([ends[:, :2], ends[:, 1:]]).T
    graph = coo_array((np.ones(pairs.shape[1]), tuple(pairs)), (len(points), len(points)))
    return np.asarray(connected_components(graph, directed=False)[1][place.ravel()])


class Folds:
    """Counts triangles that are folded and seen from the front.

    One is folded where its normal points against the sum of those of all triangles in three rings,
    gathered by walking from corner to corner; it is seen where that sum faces +Z and a ray from the
    front reaches one of four points of it before anything that lies in front by 0.05 % of the box.
    """

    def __init__(self, neutral: em.Mesh) -> None:
        self.triangles = triangles_of(neutral)
        around: list[list[int]] = [[] for _ in neutral.vertices]
        for number, triangle in enumerate(self.triangles.tolist()):
            for corner in triangle:
                around[corner].append(number)
        lists = []
        for triangle in self.triangles.tolist():
            reached = set(triangle)
            for _ in range(2):
                faces = {face for corner in reached for face in around[corner]}
                reached = {corner for face in faces for corner in self.triangles[face].tolist()}
            lists.append(sorted({face for corner in reached for face in around[corner]}))
        self.near = np.concatenate(lists)
        self.starts = np.cumsum([0, *map(len, lists[:-1])])
        self.free = 5e-4 * float(np.linalg.norm(np.ptp(neutral.vertices, axis=0)))
        self.rest = np.zeros(len(self.triangles), dtype=bool)
        self.rest = self._folded(neutral.vertices)[0]

    def _folded(self, points: Floats) -> tuple[NDArray[np.bool_], Floats]:
        a, b, c = (points[self.triangles[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        sums = np.add.reduceat(normals[self.near], self.starts, axis=0)
        return ((normals * sums).sum(axis=1) < 0) & ~self.rest, sums

    def count(self, points: Floats) -> int:
        """How many there are in a pose."""
        core = _vtk("vtkCommonCore")
        folded, sums = self._folded(points)
        rows = np.flatnonzero(folded & (sums[:, 2] > 0))
        if not len(rows):
            return 0
        places = core.vtkPoints()
        places.SetData(
            _vtk("util.numpy_support").numpy_to_vtk(np.ascontiguousarray(points), deep=1)
        )
        locator = _vtk("vtkCommonDataModel").vtkStaticCellLocator()
        locator.SetDataSet(_surface(places, self.triangles))
        locator.BuildLocator()
        front = float(points[:, 2].max()) + 1.0

        def is_reached(place: Floats) -> bool:
            start, stop = [*place[:2], front], [*place[:2], place[2] + self.free]
            hit, t, cell = [0.0] * 3, core.mutable(0.0), core.mutable(0)
            return not locator.IntersectWithLine(start, stop, 0.0, t, hit, [0.0] * 3, cell)

        return sum(any(map(is_reached, PLACES @ points[self.triangles[row]])) for row in rows)


class Lips:
    """How deep the vertices of each lip are behind the surface of the other.

    Of a lip are vertices that mouthClose moves by more than 0.1 % of D and that face such of the
    other in the neutral, within 1.2 % of D, one upward and one downward. Its surface goes on for
    three rings of triangles, as far as none has a vertex of the other lip. The depth is the signed
    distance of VTK. What is closest to the border of the surface is beside it, and neither.
    """

    def __init__(self, rig: em.Rig, extent: float, close: str) -> None:
        contacts, triangles = Contacts(rig, extent), triangles_of(rig.neutral)
        moved = np.linalg.norm(rig[close].delta, axis=1) > 1e-3 * extent
        up = _normals(rig.neutral)[:, 1] > 0
        one, other = contacts.pairs.T
        every = np.unique(contacts.pairs[moved[one] & moved[other] & (up[one] != up[other])])
        self.farthest, self.lips = NEAR * extent, [every[up[every]], every[~up[every]]]
        self.across = []
        for own, across in (self.lips[::-1], self.lips):
            free = ~np.isin(triangles, across).any(axis=1)
            for _ in range(3):
                rows = np.isin(triangles, own).any(axis=1) & free
                own = np.unique(triangles[rows])
            corners = np.searchsorted(own, triangles[rows])
            sides = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
            sides, uses = np.unique(sides, axis=0, return_counts=True)
            self.across.append((own, corners, sides[uses == 1]))

    def depths(self, positions: Floats) -> Floats:
        """(N,) depths of the vertices of the lower lip, then of the upper; in front below 0.

        Minus infinity where a vertex is beside the other lip, or far from it.
        """
        found = []
        for lip, (near, corners, border) in zip(self.lips, self.across, strict=True):
            points = _vtk("vtkCommonCore").vtkPoints()
            places = np.ascontiguousarray(positions[near])
            points.SetData(_vtk("util.numpy_support").numpy_to_vtk(places, deep=1))
            surface = _vtk("vtkFiltersCore").vtkImplicitPolyDataDistance()
            surface.SetInput(_surface(points, corners))
            closest, place = np.empty((len(lip), 3)), [0.0] * 3
            depths = np.empty(len(lip))
            for row, own in enumerate(positions[lip].tolist()):
                depths[row] = -surface.EvaluateFunctionAndGetClosestPoint(own, place)
                closest[row] = place
            start, stop = places[border[:, 0]], places[border[:, 1]]
            ways = [np.linalg.norm(closest[:, None] - end, axis=2) for end in (start, stop)]
            slack = sum(ways) - np.linalg.norm(stop - start, axis=1)
            beside = (slack < 1e-5 * self.farthest).any(axis=1)
            found.append(np.where(beside | (abs(depths) > self.farthest), -np.inf, depths))
        return np.concatenate(found)


def _surface(points: Any, triangles: NDArray[np.int64]) -> Any:
    """Triangles of vtkPoints."""
    model = _vtk("vtkCommonDataModel")
    surface, cells = model.vtkPolyData(), model.vtkCellArray()
    rows = np.insert(triangles, 0, 3, axis=1).astype(np.int64).ravel()
    cells.ImportLegacyFormat(_vtk("util.numpy_support").numpy_to_vtkIdTypeArray(rows, deep=1))
    surface.SetPoints(points)
    surface.SetPolys(cells)
    return surface


def _vtk(module: str) -> Any:
    return import_module(f"vtkmodules.{module}")
