"""Pictures of faces of one rig, with labels that are right to the pixel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.pictures.colours import colour_picture
from elastomorph.farm.pictures.scenes import Frame, Scene, scene_of
from elastomorph.farm.pictures.settings import ARRAYS, LARGEST
from elastomorph.farm.pictures.subject import PARTS, Subject
from elastomorph.farm.pictures.view import View
from elastomorph.rig.build import extent_of
from elastomorph.rig.rig import Rig

__all__ = ["Painter"]

Label = tuple[tuple[int, ...], str, Mapping[str, Any]]
_PIXELS = "x right, y down, the middle of the first pixel at 0, 0"
_HIDDEN = 0.003
"""In D: how far behind what is seen a landmark still counts as seen; it is on the surface."""


class Painter:
    """Draws faces of a rig: the same bytes for the same input, in every process of a machine.

    Args:
        rig: Whose faces they are; its appearance and the names of its parts tell how they look.
        size: Height and width in pixels.
        landmarks: Vertex of each landmark by its name.
        arrays: Those of `ARRAYS` that are wanted; by default all.

    Attributes:
        labels: The arrays that `draw` returns: shape of one face, type, and what the numbers mean
            for those who read them without this package.
    """

    def __init__(
        self,
        rig: Rig,
        size: tuple[int, int],
        landmarks: Mapping[str, int] | None = None,
        arrays: Sequence[str] = ARRAYS,
    ) -> None:
        _check(rig, size, landmarks or {}, arrays)
        self._subject = Subject(rig.neutral, max(size))
        self._frame = _frame(rig, size)
        self._marks = np.array(list((landmarks or {}).values()), dtype=np.int64)
        self._arrays = tuple(arrays)
        self.labels = self._described(list(landmarks or {}))

    def draw(
        self, positions: NDArray[np.floating], values: Mapping[str, ArrayLike]
    ) -> dict[str, NDArray[Any]]:
        """The arrays of `labels`, (n, …) each.

        Args:
            positions: (n, V, 3) of the rig's vertices, in its own coordinates.
            values: (n,) of each column by its name, see `SETTINGS`; others are ignored.
        """
        count = len(positions)
        columns = {name: np.broadcast_to(own, count) for name, own in values.items()}
        made = {
            name: np.zeros((count, *shape), kind) for name, (shape, kind, _) in self.labels.items()
        }
        for face in range(count):
            scene = scene_of(self._frame, {name: own[face] for name, own in columns.items()})
            for name, values_of in self._drawn(positions[face], scene).items():
                made[name][face] = values_of
        return made

    def _drawn(self, positions: NDArray[np.floating], scene: Scene) -> dict[str, NDArray[Any]]:
        view = View(self._subject, positions, scene)
        size, extent = self._frame.size, self._frame.extent
        pixel = _pixels(view, size)
        found = view.look(np.column_stack([pixel % size[1], pixel // size[1]]))
        shown: dict[str, NDArray[Any]] = {"camera": scene.camera, "head": scene.head}
        shown["intrinsics"] = scene.intrinsics
        if "colour" in self.labels:
            shown["colour"] = colour_picture(view, found, pixel, size, extent)
        ray, points = view.labelled(found)
        parts = self._subject.part[points.triangle]
        codes = np.rint(127 * points.normal)
        for name, values in (
            ("depth", points.position[:, 2]),
            ("normals", codes),
            ("parts", parts),
        ):
            whole = np.zeros((size[0] * size[1], *values.shape[1:]), values.dtype)
            whole[pixel[ray]] = values
            shown[name] = whole.reshape(*size, *values.shape[1:])
        shown["landmarks"] = self._seen_marks(view)
        return {name: shown[name] for name in self.labels}

    def _seen_marks(self, view: View) -> NDArray[np.float64]:
        """(L, 3) x, y and whether the landmark is in the picture with nothing before it."""
        places, own = view.places[self._marks], view.seen[self._marks, 2]
        x, y = np.nan_to_num(places, nan=-1e9).T
        height, width = self._frame.size
        inside = (own > 0) & (x >= -0.5) & (x < width - 0.5) & (y >= -0.5) & (y < height - 0.5)
        ray, points = view.labelled(view.look(places[inside]))
        depth = np.full(np.count_nonzero(inside), np.inf)
        depth[ray] = points.position[:, 2]
        seen = inside.astype(np.float64)
        seen[inside] = own[inside] <= depth + _HIDDEN * self._frame.extent
        return np.column_stack([places, seen])

    def _described(self, landmarks: list[str]) -> Mapping[str, Label]:
        size = self._frame.size
        axes = "the camera's axes: x right, y down, z away from it"
        every: dict[str, Label] = {
            "colour": ((*size, 3), "uint8", {"colours": "sRGB"}),
            "depth": (
                size,
                "float32",
                {"unit": "of the rig, along the camera's axis", "nothing": 0},
            ),
            "normals": ((*size, 3), "int8", {"axes": axes, "scale": 1 / 127, "nothing": 0}),
            "parts": (size, "uint8", {"names": list(PARTS)}),
            "landmarks": (
                (len(landmarks), 3),
                "float32",
                {"names": landmarks, "columns": ["x", "y", "visible"], "pixels": _PIXELS},
            ),
            "camera": ((3, 4), "float64", {"maps": "world to camera", "axes": axes}),
            "head": ((3, 4), "float64", {"maps": "the rig's coordinates to the world"}),
            "intrinsics": ((3, 3), "float64", {"maps": "camera to pixels", "pixels": _PIXELS}),
        }
        if not landmarks:
            del every["landmarks"]
        wanted = {"head", "intrinsics"} if "camera" in self._arrays else set()
        wanted.update(self._arrays)
        return {name: label for name, label in every.items() if name in wanted}


def _pixels(view: View, size: tuple[int, int]) -> NDArray[np.int64]:
    """Numbers of the pixels in the box round the subject, rising."""
    used = view.places[view.subject.vertices]
    used = used[np.isfinite(used).all(axis=1)]
    last = np.array([size[1] - 1, size[0] - 1])
    if not len(used):
        return np.zeros(0, dtype=np.int64)
    low = np.clip(np.floor(used.min(axis=0)), 0, last + 1).astype(np.int64)
    high = np.clip(np.ceil(used.max(axis=0)), -1, last).astype(np.int64)
    rows, columns = np.arange(low[1], high[1] + 1), np.arange(low[0], high[0] + 1)
    return (rows[:, None] * size[1] + columns).reshape(-1)


def _frame(rig: Rig, size: tuple[int, int]) -> Frame:
    """The pivot is the middle of the box round what the targets move; else round everything."""
    vertices = rig.neutral.vertices
    moved = np.zeros(len(vertices), dtype=bool)
    for morph in rig.morphs.values():
        moved |= morph.delta.any(axis=1)
    own = vertices[moved] if moved.any() else vertices
    extent = extent_of(rig) or rig.neutral.diameter
    return Frame((own.min(axis=0) + own.max(axis=0)) / 2, extent, size)


def _check(
    rig: Rig, size: tuple[int, int], landmarks: Mapping[str, int], arrays: Sequence[str]
) -> None:
    if len(size) != 2 or not all(1 <= side <= LARGEST for side in size):
        raise ParameterError(f"a picture has 1 to {LARGEST} pixels on a side, found {size}")
    unknown = [name for name in arrays if name not in ARRAYS]
    if unknown or not arrays:
        raise ParameterError(
            f"pictures have the arrays {', '.join(ARRAYS)}; found {', '.join(unknown) or 'none'}"
        )
    count = len(rig.neutral.vertices)
    for name, vertex in landmarks.items():
        if not 0 <= vertex < count:
            raise ParameterError(
                f"landmark {name} is vertex {vertex}, but the rig has {count:,}: from 0 to "
                f"{count - 1:,}"
            )
