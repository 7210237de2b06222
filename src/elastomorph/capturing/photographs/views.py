"""The photographs of a pose, opened when they are looked at."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import overload

from elastomorph.capturing.geometry.camera import Camera, View, open_view

_LONGEST = 2400  # px; what is finer costs memory and time, and skin shows no more
_MOST_BYTES = 400 << 20


class Views(Sequence[View]):
    """Photographs without distortion in the order of their cameras.

    Those looked at last stay in memory, as many as fit into 400 MiB, so that a pose of a hundred
    large photographs takes no more than one of ten.

    Args:
        cameras: That took them.
        paths: Name of a photograph → its file.
        masks: Name → file of its mask, for those that have one.
        longest: Longer side in pixels; larger photographs are made smaller.
    """

    def __init__(
        self,
        cameras: Sequence[Camera],
        paths: Mapping[str, Path],
        masks: Mapping[str, Path] | None = None,
        *,
        longest: int = _LONGEST,
    ) -> None:
        self._cameras = tuple(cameras)
        self._paths = paths
        self._masks = masks or {}
        self._longest = longest
        self._open: OrderedDict[int, View] = OrderedDict()

    def __len__(self) -> int:
        return len(self._cameras)

    @overload
    def __getitem__(self, index: int) -> View: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[View]: ...

    def __getitem__(self, index: int | slice) -> View | Sequence[View]:
        if isinstance(index, slice):
            return Views(self._cameras[index], self._paths, self._masks, longest=self._longest)
        number = range(len(self))[index]
        if number not in self._open:
            camera = self._cameras[number]
            path, mask = self._paths[camera.name], self._masks.get(camera.name)
            view = open_view(camera, path, scale=self._scale(camera), mask=mask)
            self._open[number] = view
            while len(self._open) > 1 and sum(map(_bytes, self._open.values())) > _MOST_BYTES:
                self._open.popitem(last=False)
        self._open.move_to_end(number)
        return self._open[number]

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """The cameras of the photographs as they are opened: without distortion, at their size."""
        return tuple(camera.without_distortion(self._scale(camera)) for camera in self._cameras)

    def _scale(self, camera: Camera) -> float:
        return min(1.0, self._longest / max(camera.size))


def _bytes(view: View) -> int:
    return view.grey.nbytes + (0 if view.mask is None else view.mask.nbytes)
