"""Cameras of photographs that mapping passed over, from the points that the others see.

Mapping goes from photograph to photograph by their strongest features. One of which only weaker
ones are found again, at the end of a ring or a little blurred, has all of its features compared
with the points themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.exact import cloud, well_seen
from elastomorph.capturing.cameras.features import Features, quiet_pycolmap
from elastomorph.capturing.cameras.matching import compared
from elastomorph.capturing.cameras.reconstruction import pycolmap_camera
from elastomorph.capturing.cameras.sparse import Lens, Shots, Sparse
from elastomorph.capturing.geometry.camera import Camera

_FEWEST, _LEAST_SHARE = 20, 0.25
_OFF = 0.003  # focal lengths


def found_late(
    sparse: Sparse, chosen: Sequence[Features], features: Sequence[Features], shots: Shots
) -> Sparse:
    """With the cameras of photographs that were passed over, where points say where they are.

    Args:
        sparse: Cameras and points.
        chosen: The features of each photograph that were mapped.
        features: All of them.
        shots: The photographs.
    """
    missing = [k for k, camera in enumerate(sparse.cameras) if camera is None]
    if not missing or not len(sparse.points):
        return sparse
    numbers = np.flatnonzero(well_seen(sparse))
    points, looks = cloud(sparse, chosen)
    cameras = list(sparse.cameras)
    owners, seen = [sparse.owners], [sparse.seen]
    for k in missing:
        lens = _lens(sparse, shots, k)
        pairs = compared(features[k].unit, looks)
        if lens is None or len(pairs) < _FEWEST:
            continue
        places = features[k].places[pairs[:, 0]]
        camera, agree = _placed(shots.names[k], lens, places, points[pairs[:, 1]])
        if camera is None or np.count_nonzero(agree) < max(_FEWEST, _LEAST_SHARE * len(pairs)):
            continue
        cameras[k] = camera
        mine = pairs[agree].astype(np.int64)
        owners.append(numbers[mine[:, 1]])
        seen.append(np.stack([np.full(len(mine), k), mine[:, 0]], axis=1))
    return replace(
        sparse, cameras=tuple(cameras), owners=np.concatenate(owners), seen=np.concatenate(seen)
    )


def _lens(sparse: Sparse, shots: Shots, photograph: int) -> Lens | None:
    for k, camera in enumerate(sparse.cameras):
        if camera is not None and shots.lens_of[k] == shots.lens_of[photograph]:
            return Lens.of(camera)
    return None


def _placed(
    name: str, lens: Lens, places: NDArray[np.float64], points: NDArray[np.float64]
) -> tuple[Camera | None, NDArray[np.bool_]]:
    """A camera that sees points at places, and which of them agree."""
    with quiet_pycolmap() as pycolmap:
        options = pycolmap.AbsolutePoseEstimationOptions()
        options.ransac.random_seed = 1
        options.ransac.max_error = _OFF * lens.focal
        camera = pycolmap_camera(pycolmap, 0, lens, known=True)
        found = pycolmap.estimate_and_refine_absolute_pose(places + 0.5, points, camera, options)
    if found is None:
        return None, np.zeros(len(places), dtype=bool)
    matrix = found["cam_from_world"].matrix()
    turn, shift = np.array(matrix[:, :3]), np.array(matrix[:, 3])
    camera_of = Camera(name, lens.size, lens.focal, lens.centre, lens.radial, turn, shift)
    return camera_of, np.asarray(found["inlier_mask"], dtype=bool)
