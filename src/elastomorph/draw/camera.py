"""Where a picture is taken from, and how a face is made to fill it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.draw.materials import parts_of
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.rig.performance import HeadTurn

VIEWS: dict[str, tuple[float, float]] = {
    "front": (0.0, 0.0),
    "three-quarter": (35.0, 4.0),
    "side": (90.0, 0.0),
    "below": (0.0, -35.0),
    "mouth": (0.0, 0.0),
    "eyes": (0.0, 0.0),
    "whole": (0.0, 0.0),
}
"""Degrees round the vertical axis to the face's left, and up, of each view by name."""

TINY = 1e-12
LENS = 14.0
"""Vertical angle of view in degrees: a long portrait lens, which does not swell the nose."""


@dataclass(frozen=True)
class Camera:
    """A camera that looks at a face. Pictures to be compared share one.

    The face looks along +Z and its top is +Y, as in the formats that say so (glTF) and by
    convention in the others.

    Attributes:
        position: Where the camera stands.
        focus: The point in the middle of the picture.
        up: The direction that is up in the picture.
        angle: Vertical angle of view in degrees.
    """

    position: tuple[float, float, float]
    focus: tuple[float, float, float]
    up: tuple[float, float, float]
    angle: float = LENS

    @classmethod
    def framing(
        cls,
        points: ArrayLike,
        view: str | tuple[float, float] = "front",
        *,
        size: tuple[int, int] = (720, 900),
        margin: float = 0.04,
    ) -> Camera:
        """The camera for which all (..., 3) points just fill a picture of this size in pixels.

        The view is a name of `VIEWS`, or degrees to the face's left and up; the margin is a
        fraction of the picture's width and height on each side.
        """
        cloud = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        if not len(cloud) or not np.isfinite(cloud).all():
            raise ParameterError("a camera needs at least one point, with finite coordinates")
        if min(size) < 1 or not 0 <= margin < 0.5:
            raise ParameterError(
                f"a picture needs a size of at least 1 × 1 and a margin from 0 to 0.5, "
                f"found {size} and {margin}"
            )
        right, up, back = axes = _axes(view)
        # In the camera's axes, a point (x, y, z) at eye (a, b, c) is seen at slope
        # (x - a)/(c - z), and the picture spans slopes ± tan(angle/2)·(aspect, 1).
        x, y, z = axes @ cloud.T
        tall = np.tan(np.radians(LENS / 2)) * (1 - 2 * margin)
        wide = tall * size[0] / size[1]
        a, depth_x = _fit(x, z, wide)
        b, depth_y = _fit(y, z, tall)
        eye = max(depth_x, depth_y)
        # Points all on one ray would put the eye among them.
        gap = max(
            1e-3 * float(np.ptp(cloud, axis=0).max()), 1e-9 * float(np.abs(cloud).max()), TINY
        )
        eye = max(eye, float(z.max()) + gap)
        middle = float(z.min() + z.max()) / 2
        a, b = _centre(x, z, eye, a), _centre(y, z, eye, b)
        return cls(
            position=_triple(a * right + b * up + eye * back),
            focus=_triple(a * right + b * up + middle * back),
            up=_triple(up),
        )

    def towards(self, points: NDArray[np.float64], fraction: float) -> NDArray[np.float64]:
        """The points moved towards the camera, for lines to stay free: by a fraction of the way."""
        eye = np.array(self.position)
        rays = eye - points
        step = fraction * np.linalg.norm(eye - np.array(self.focus))
        lengths = np.linalg.norm(rays, axis=-1, keepdims=True)
        return np.asarray(points + rays / lengths * step)

    def seen(self, points: NDArray[np.float64], size: tuple[int, int]) -> NDArray[np.float64]:
        """(N, 2) column and row at which (N, 3) points are seen in a picture of this size.

        They count from its upper left corner.
        """
        back = np.array(self.position) - np.array(self.focus)
        back /= np.linalg.norm(back)
        right = np.cross(self.up, back)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(back, right), back])
        across, above, behind = axes @ (points - np.array(self.position)).T
        focal = size[1] / 2 / np.tan(np.radians(self.angle / 2))
        columns = size[0] / 2 - focal * across / behind
        rows = size[1] / 2 + focal * above / behind
        return np.stack([columns, rows], axis=1)


def _axes(view: str | tuple[float, float]) -> NDArray[np.float64]:
    """Rows: right, up and back of the camera."""
    if isinstance(view, str):
        if view not in VIEWS:
            raise ParameterError(f"view must be one of {', '.join(VIEWS)}, found {view!r}")
        view = VIEWS[view]
    turn, rise = np.radians(view)
    back = np.array([np.sin(turn) * np.cos(rise), np.sin(rise), np.cos(turn) * np.cos(rise)])
    right = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    return np.stack([right, np.cross(back, right), back])


def _fit(
    across: NDArray[np.float64], depth: NDArray[np.float64], slope: float
) -> tuple[float, float]:
    """Where the eye stands across and in depth so that |across - a| ≤ slope·(eye - depth)."""
    high = float((across + slope * depth).max())
    low = float((across - slope * depth).min())
    return (high + low) / 2, (high - low) / (2 * slope)


def _centre(
    across: NDArray[np.float64], depth: NDArray[np.float64], eye: float, start: float
) -> float:
    """Where the eye stands across so that the outermost points are seen equally far out."""
    a = start
    for _ in range(20):
        seen = (across - a) / (eye - depth)
        outer, inner = int(seen.argmax()), int(seen.argmin())
        # equal and opposite slopes of these two points
        near, far = eye - depth[outer], eye - depth[inner]
        a = float((across[outer] * far + across[inner] * near) / (near + far))
    return a


def _triple(point: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(point[0]), float(point[1]), float(point[2])


# What of a mesh belongs in the picture: the head without its shoulders, the mouth, the eyes.
#
# Of a head that is turned, what is seen from every side. The camera and its light stay where they
# are, so a turn shows the shape as a sculptor's turntable does.

View = str | tuple[float, float]
"""A view by name, or degrees to the face's left and up."""

_SLICES = 48
_COLUMN = 0.4
"""A neck is at its lower end at least this wide, compared with its place under the chin."""
_THROAT = 0.1
"""How much of the neck is shown, over the height of the head."""
_MOVING = 0.25
"""What moves this much of the largest motion belongs in the picture, wherever it is."""
_CLOSE_UPS = {  # view: parts it shows in order of preference, and how much of their surroundings
    "mouth": ((("lips",), 0.25), (("teeth",), 0.15), (("mouth", "tongue"), 0.35)),
    "eyes": ((("sclera", "iris", "pupil"), 0.25), (("lash",), 0.2)),
}
_WHOLE = "whole"
_BOXES = {"mouth": ((0.25, 0.75), (0.14, 0.38)), "eyes": ((0.1, 0.9), (0.48, 0.68))}
"""Where to look on a head whose parts have no names: fractions of its width and height."""
_FULL_TURN = 360.0
_MOST_FRAMED = 72
"""Angles at which the camera makes sure that everything is seen; between them little changes."""


def camera_for(
    mesh: Mesh,
    view: View = "front",
    *,
    poses: ArrayLike | None = None,
    head: NDArray[np.int64] | None = None,
    size: tuple[int, int] = (720, 900),
    margin: float = 0.04,
    turn: HeadTurn | None = None,
) -> Camera:
    """One camera for all poses of a mesh.

    Args:
        mesh: The head, looking along +Z with +Y up.
        view: ``front``, ``three-quarter``, ``side`` and ``below`` show the head down to its neck,
            ``mouth`` and ``eyes`` come close, ``whole`` shows all there is; or degrees to the
            face's left and up.
        poses: (..., V, 3) positions that must all fit; those of the mesh by default.
        head: (N,) vertices of the head of a character, see `elastomorph.draw.head.head_of`; by
            default it is found by the shape of its neck.
        size: Width and height of the picture in pixels.
        margin: Empty border, as a fraction of the picture.
        turn: How the head is turned, for which there must be room in each pose.
    """
    positions = _positions(mesh, poses)
    shown = drawn_vertices(mesh)
    if view == _WHOLE:
        return Camera.framing(
            _everywhere(positions[:, shown], turn), view, size=size, margin=margin
        )
    if isinstance(view, str) and view in _CLOSE_UPS:
        chosen, border = _close_up(mesh, shown if head is None else head, view)
        points = positions[:, chosen].reshape(-1, 3)
        spread = border * np.ptp(points, axis=0).max() * np.array([1.0, 1.0, 0.0])
        points = _everywhere(np.concatenate([points - spread, points + spread]), turn)
        return Camera.framing(points, view, size=size, margin=0.0)
    points = _everywhere(_head_points(mesh, poses, head), turn)
    return Camera.framing(points, view, size=size, margin=margin)


def _everywhere(points: NDArray[np.float64], turn: HeadTurn | None) -> NDArray[np.float64]:
    """(..., 3) points, or the outermost of them wherever a head has them when it turns."""
    if turn is None:
        return points
    corners = _outermost(points.reshape(-1, 3))
    return np.stack([turn.of(corners, frame) for frame in range(len(turn))])


def _head_points(
    mesh: Mesh, poses: ArrayLike | None = None, head: NDArray[np.int64] | None = None
) -> NDArray[np.float64]:
    """(P, N, 3) of N vertices in each pose: no shoulders, but all that moves."""
    positions = _positions(mesh, poses)
    shown = drawn_vertices(mesh)
    if head is None:
        head = shown[mesh.vertices[shown, 1] >= _neck(mesh, shown)]
    motion = np.linalg.norm(positions[:, shown] - positions[0, shown], axis=2).max(axis=0)
    moving = shown[motion > _MOVING * motion.max()]
    return positions[:, np.union1d(head, moving)]


def drawn_vertices(mesh: Mesh) -> NDArray[np.int64]:
    """Vertices of polygons that are drawn; all of a mesh without polygons."""
    hidden = np.isin(mesh.faces.corner_faces, parts_of(mesh).get("hidden", ()))
    drawn = np.unique(mesh.faces.indices[~hidden]).astype(np.int64)
    return drawn if drawn.size else np.arange(len(mesh.vertices))


def _positions(mesh: Mesh, poses: ArrayLike | None) -> NDArray[np.float64]:
    """(P, V, 3)."""
    positions = mesh.vertices if poses is None else np.asarray(poses, dtype=np.float64)
    return positions.reshape(-1, *mesh.vertices.shape)


def _close_up(mesh: Mesh, shown: NDArray[np.int64], view: str) -> tuple[NDArray[np.int64], float]:
    """Vertices a close-up must show, and its border over their extent."""
    parts = parts_of(mesh)
    for names, border in _CLOSE_UPS[view]:
        numbers = [parts[name] for name in names if name in parts]
        if numbers:
            chosen = np.isin(mesh.faces.corner_faces, np.concatenate(numbers))
            return np.unique(mesh.faces.indices[chosen]).astype(np.int64), border
    points = mesh.vertices[shown]
    points = points[points[:, 1] >= _neck(mesh, shown)]
    low, sides = points.min(axis=0), np.ptp(points, axis=0)
    place = (mesh.vertices[shown] - low) / np.where(sides > 0, sides, 1.0)
    inside = place[:, 2] > 0.5
    for axis, (start, stop) in enumerate(_BOXES[view]):
        inside &= (place[:, axis] >= start) & (place[:, axis] <= stop)
    return (shown[inside], 0.0) if inside.any() else (shown, 0.0)


def _neck(mesh: Mesh, shown: NDArray[np.int64]) -> float:
    """Height at which the neck is cut, a little below the chin; minus infinity without a neck.

    Horizontal cuts through the mesh tell how wide it is and how far it comes forward at each
    height. Under the chin it recedes, and goes on as a column or as shoulders.
    """
    drawn = np.zeros(len(mesh.vertices), dtype=bool)
    drawn[shown] = True
    x, y, z = mesh.vertices.T
    floor, tall = float(y[shown].min()), float(np.ptp(y[shown]))
    edges = mesh.edges[drawn[mesh.edges].all(axis=1)]
    low, high = np.take_along_axis(edges, np.argsort(y[edges], axis=1), axis=1).T
    heights = floor + tall * (np.arange(_SLICES) + 0.5) / _SLICES
    width, front = np.full((2, _SLICES), np.nan)
    for number, height in enumerate(heights):
        cut = (y[low] <= height) & (height < y[high])
        if cut.any():
            one, other = low[cut], high[cut]
            share = (height - y[one]) / (y[other] - y[one])
            width[number] = np.ptp(x[one] + share * (x[other] - x[one]))
            front[number] = (z[one] + share * (z[other] - z[one])).max()
    lower = front[: _SLICES // 2]
    if np.isnan(lower).all():
        return -np.inf
    recedes = np.flatnonzero(lower < (np.nanmin(lower) + np.nanmax(front)) / 2)
    if not recedes.size or not width[0] > _COLUMN * width[recedes[-1]]:
        return -np.inf
    chin = float(heights[recedes[-1]])
    return chin - _THROAT * (floor + tall - chin)


@dataclass(frozen=True)
class Turntable:
    """The vertical axis (x, z) that a head turns round, and a camera that sees it at every angle.

    The camera keeps its distance, so the head keeps its size.
    """

    camera: Camera
    axis: tuple[float, float]

    @classmethod
    def around(
        cls,
        mesh: Mesh,
        angles: ArrayLike,
        view: View = "front",
        *,
        poses: ArrayLike | None = None,
        head: NDArray[np.int64] | None = None,
        size: tuple[int, int] = (720, 900),
        margin: float = 0.04,
    ) -> Turntable:
        """The turntable for degrees that will be shown; the others are as for `camera_for`."""
        if isinstance(view, str) and view in _CLOSE_UPS:
            raise ParameterError(
                f"a turntable shows the whole head, so it cannot start with the close-up {view!r}; "
                "take front, three-quarter, side, below or degrees such as 30,10"
            )
        if view == _WHOLE:
            head = drawn_vertices(mesh)
        seen = _head_points(mesh, poses, head)
        x, _, z = (seen[0].min(axis=0) + seen[0].max(axis=0)) / 2
        turns = np.asarray(angles, dtype=np.float64)
        framed = turns[np.linspace(0, len(turns) - 1, min(len(turns), _MOST_FRAMED)).astype(int)]
        corners = _outermost(seen.reshape(-1, 3))
        axis = (float(x), float(z))
        cloud = np.stack([_turned(corners, angle, axis) for angle in framed.tolist()])
        return cls(Camera.framing(cloud, view, size=size, margin=margin), axis)

    def turned(self, positions: NDArray[np.float64], degrees: float) -> NDArray[np.float64]:
        """(V, 3) positions as seen by a camera that went round the head to the face's left."""
        return _turned(positions, degrees, self.axis)


def turn_angles(count: int, degrees: float = _FULL_TURN) -> NDArray[np.float64]:
    """Degrees of each frame of a turn, from 0; negative ones go to the face's right.

    Whole turns leave out their last angle, which is the first again, so a loop does not stop
    there. Other turns end at their last angle.
    """
    if count < 1:
        raise ParameterError(f"a turn needs at least 1 frame, found {count}")
    if not np.isfinite(degrees) or degrees == 0:
        raise ParameterError(f"a turn needs an angle other than 0, found {degrees:g} degrees")
    return np.linspace(0.0, degrees, count, endpoint=degrees % _FULL_TURN != 0)


def _turned(
    positions: NDArray[np.float64], degrees: float, axis: tuple[float, float]
) -> NDArray[np.float64]:
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, z = positions[:, 0] - axis[0], positions[:, 2] - axis[1]
    turned = positions.copy()
    turned[:, 0] = axis[0] + cosine * x - sine * z
    turned[:, 2] = axis[1] + sine * x + cosine * z
    return turned


def _outermost(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The corners of the convex hull: whatever sees them sees all points."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:  # flat, or too few: all of them are as good, only slower
        return points
