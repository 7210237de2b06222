"""Pictures for the report of a capture: cameras around the head, and poses through their cameras.

Drawn by the rays and the pixels that a capture works with anyway, so that its report needs nothing
that is not installed for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera, open_colours
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.work.registered import FLAGGED, Registered
from elastomorph.draw.camera import Camera as Looking
from elastomorph.draw.over_photographs import box_of, over_photograph
from elastomorph.model.mesh import Mesh
from elastomorph.report.images import Picture

Points = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_CLAY = np.array([0.86, 0.87, 0.88])
_DOUBT = np.array([0.98, 0.80, 0.30])
_FLAG = np.array([0.93, 0.42, 0.28]), np.array([0.66, 0.07, 0.12])
_PAPER = 255
_QUALITY = 82
_HEIGHT = 560  # of a pose in pixels
_GAP = 8
# White: a packed picture keeps colours in coarse blocks, and coloured lines would tint the skin.
_LINE, _FLAGGED_LINE = (1.0, 1.0, 1.0), (1.0, 0.2, 0.15)
_PYRAMID = 0.09  # height of that of a camera, of its distance from the head
_SIDES = {"front": (0.0, 0.0), "side": (90.0, 0.0), "above": (0.0, 89.0)}


@dataclass(frozen=True, eq=False)
class Shown(Picture):
    """A picture that is packed by the library that opened the photographs."""

    @property
    def source(self) -> str:
        """The picture itself as a ``data:`` address of WebP."""
        from base64 import b64encode

        import cv2

        own = np.ascontiguousarray(self.image[..., ::-1])
        _, packed = cv2.imencode(".webp", own, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])
        return f"data:image/webp;base64,{b64encode(packed.tobytes()).decode('ascii')}"


def confidence_colours(confidence: NDArray[np.floating]) -> Points:
    """(V, 3) red, green, blue of (V,) confidences: clay, yellow where in doubt, red where flagged.

    The step at the confidence from which on a vertex is flagged is one of colour, too.
    """
    share = np.asarray(confidence, dtype=np.float64)[:, None]
    sure = np.clip((share - FLAGGED) / (1 - FLAGGED), 0, 1)
    kept = _DOUBT + (_CLAY - _DOUBT) * sure
    lost = _FLAG[1] + (_FLAG[0] - _FLAG[1]) * np.clip(share / FLAGGED, 0, 1)
    found: Points = np.where(share >= FLAGGED, kept, lost)
    return found


def frontal(cameras: Sequence[Camera], mesh: Registered) -> Camera:
    """The camera that most of what is to be trusted faces."""
    normals = Surface(mesh.vertices, mesh.faces.triangles()).normals

    def faced(camera: Camera) -> float:
        towards = camera.position - mesh.vertices
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        cosines = np.einsum("vi,vi->v", normals, towards)
        return float((np.maximum(cosines, 0) * mesh.confidence).sum())

    return max(cameras, key=faced)


def beside(front: Camera, cameras: Sequence[Camera], mesh: Registered) -> Camera:
    """The camera that sees the mesh most nearly from where another one did."""
    middle = mesh.vertices.mean(axis=0)

    def direction(camera: Camera) -> Points:
        away = camera.position - middle
        found: Points = away / np.linalg.norm(away)
        return found

    return max(cameras, key=lambda camera: float(direction(camera) @ direction(front)))


def pose_picture(mesh: Registered, camera: Camera, photograph: Path) -> Pixels:
    """Through one camera: the photograph, the template drawn over it, and the confidence.

    Args:
        mesh: The pose, in the frame of the camera.
        camera: That took the photograph.
        photograph: Its file.

    Returns:
        (H, W, 3) uint8.

    Raises:
        FileError: The photograph cannot be read.
    """
    surface = Surface(mesh.vertices, mesh.faces.triangles())
    own, picture = _around(surface, camera, photograph)
    lines = np.where(mesh.flagged[:, None], _FLAGGED_LINE, _LINE)
    over = over_photograph(picture, own, mesh, colours=lines)
    painted = _rendered(surface, own, confidence_colours(mesh.confidence))
    gap = np.full((len(painted), _GAP, 3), _PAPER, dtype=np.uint8)
    return np.concatenate([picture, gap, over, gap, painted], axis=1)


def front_picture(mesh: Registered, size: tuple[int, int] = (420, 420)) -> Pixels:
    """(H, W, 3) uint8 a pose from the front and from the side, painted with its confidence."""
    surface = Surface(mesh.vertices, mesh.faces.triangles())
    colours = confidence_colours(mesh.confidence)
    views = [
        _rendered(surface, _looking(Looking.framing(mesh.vertices, side, size=size), size), colours)
        for side in (_SIDES["front"], _SIDES["side"])
    ]
    return np.concatenate(views, axis=1)


def _around(surface: Surface, camera: Camera, photograph: Path) -> tuple[Camera, Pixels]:
    """The part of a photograph that shows a pose, made as small as it is shown."""
    _, top, _, bottom = box_of(camera, surface.vertices)
    scale = min(1.0, _HEIGHT / (bottom - top))
    own, picture = open_colours(camera, photograph, scale=scale)
    left, top, right, bottom = box_of(own, surface.vertices)
    part = replace(own, size=(right - left, bottom - top), centre=own.centre - [left, top])
    return part, np.ascontiguousarray(picture[top:bottom, left:right])


def _rendered(surface: Surface, camera: Camera, colours: Points) -> Pixels:
    """(H, W, 3) uint8 the surface in the colours (V, 3) of its vertices, on paper."""
    hits = surface.seen(camera)
    towards = -camera.directions()
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    facing = np.abs(np.einsum("hwi,hwi->hw", surface.at(hits, surface.normals), towards))
    lit = surface.at(hits, colours) * (0.35 + 0.65 * np.clip(facing, 0, 1))[..., None]
    found = np.where(hits.met[..., None], lit, _PAPER / 255)
    return np.asarray(np.rint(255 * np.clip(found, 0, 1)), dtype=np.uint8)


def camera_picture(
    cameras: Mapping[str, Sequence[Camera]],
    colours: Mapping[str, tuple[int, int, int]],
    mesh: Mesh | None,
    size: tuple[int, int] = (420, 420),
) -> Pixels:
    """Where the cameras of all poses stood, from the front, the side and above.

    Args:
        cameras: Of each pose, in one frame.
        colours: Red, green and blue of each pose, from 0 to 255.
        mesh: The neutral; without one the cameras are turned so that up is up.
        size: Of one of the three views in pixels.
    """
    every = [camera for own in cameras.values() for camera in own]
    turn, head = np.eye(3), None
    if mesh is not None:
        middle = mesh.vertices.mean(axis=0)
        head = Surface(mesh.vertices - middle, mesh.faces.triangles())
    else:
        middle = np.mean([_ahead(camera, every) for camera in every], axis=0)
        turn = _upright(every, middle)
    reach = float(np.median([np.linalg.norm(c.position - middle) for c in every]))
    frusta = {
        pose: np.array([(_frustum(c, _PYRAMID * reach) - middle) @ turn.T for c in own])
        for pose, own in cameras.items()
        if own
    }
    cloud = np.concatenate([own.reshape(-1, 3) for own in frusta.values()])
    if head is not None:
        cloud = np.concatenate([cloud, head.vertices])
    views = []
    for side in _SIDES.values():
        looking = _looking(Looking.framing(cloud, side, size=size, margin=0.03), size)
        image = _blank(size)
        if head is not None:
            image = _rendered(head, looking, np.tile(_CLAY, (len(head.vertices), 1)))
        for pose, own in frusta.items():
            _draw_frusta(image, looking, own, colours[pose])
        views += [image, np.full((size[1], _GAP, 3), _PAPER, dtype=np.uint8)]
    picture = np.concatenate(views[:-1], axis=1)
    drawn = np.flatnonzero((picture < _PAPER).any(axis=(1, 2)))
    return picture[max(0, drawn[0] - _GAP) : drawn[-1] + _GAP]


def _blank(size: tuple[int, int]) -> Pixels:
    return np.full((size[1], size[0], 3), _PAPER, dtype=np.uint8)


def _frustum(camera: Camera, depth: float) -> Points:
    """(5, 3) where a camera stands, and the corners of what it sees at a depth."""
    width, height = camera.size
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=np.float64)
    rays = camera.through(corners)
    return np.concatenate([camera.position[None], camera.position + depth * rays])


def _draw_frusta(image: Pixels, camera: Camera, frusta: Points, colour: Any) -> None:
    import cv2

    pixels = np.rint(camera.project(frusta)[0] * 16).astype(np.int32)
    around = pixels[:, [1, 2, 3, 4, 1]]
    rays = np.stack([pixels[:, [0, k]] for k in range(1, 5)], axis=1).reshape(-1, 2, 2)
    lines = [np.ascontiguousarray(line) for line in (*around, *rays)]
    cv2.polylines(image, lines, False, colour, 1, cv2.LINE_AA, 4)


def _looking(eye: Looking, size: tuple[int, int]) -> Camera:
    """The camera of pictures as one of photographs."""
    position = np.array(eye.position)
    ahead = np.array(eye.focus) - position
    ahead /= np.linalg.norm(ahead)
    down = -np.array(eye.up)
    down = down - (down @ ahead) * ahead
    down /= np.linalg.norm(down)
    rotation = np.stack([np.cross(down, ahead), down, ahead])
    focal = size[1] / 2 / float(np.tan(np.radians(eye.angle) / 2))
    centre = (np.array(size) - 1) / 2
    return Camera("", size, focal, centre, 0.0, rotation, -rotation @ position)


def _ahead(camera: Camera, every: Sequence[Camera]) -> Points:
    """What a camera looks at, as far away as the others are."""
    reach = np.linalg.norm(camera.position - np.mean([c.position for c in every], axis=0))
    found: Points = camera.position + camera.rotation[2] * reach
    return found


def _upright(cameras: Sequence[Camera], middle: Points) -> Points:
    """(3, 3) a turn after which up in most photographs is +Y, and the cameras stand before +Z."""
    up = -np.mean([camera.rotation[1] for camera in cameras], axis=0)
    back = np.mean([camera.position for camera in cameras], axis=0) - middle
    up /= max(float(np.linalg.norm(up)), 1e-12)
    back = back - (back @ up) * up
    if not np.linalg.norm(back) > 1e-9:
        back = -cameras[0].rotation[2]
        back = back - (back @ up) * up
    back /= max(float(np.linalg.norm(back)), 1e-12)
    return np.stack([np.cross(up, back), up, back])
