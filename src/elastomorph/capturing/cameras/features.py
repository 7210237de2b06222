"""Features of photographs (SIFT): places that are found again in others, and how they look.

Photographs smaller than the features need are looked at enlarged, larger ones reduced; what is
found is told in pixels of the photograph itself, upright, their centres at integers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.table import Table
from elastomorph.capturing.photographs.photographs import Photograph
from elastomorph.capturing.photographs.pixels import read_mask, read_upright
from elastomorph.errors import MissingExtraError

_MOST = 8192
_PEAK = 0.003  # half of what pycolmap asks for: skin has little contrast
_ENLARGED_BELOW = 1400  # px, longer side
_LONGEST = 2400
_AT_ONCE = 2


@dataclass(frozen=True, eq=False)
class Features(Table):
    """What was found in one photograph.

    Attributes:
        places: (N, 2) float64 pixels.
        shapes: (N, 4) float32 affine shape of each, row by row, in pixels.
        descriptors: (N, 128) uint8, of length about 512.
    """

    places: NDArray[np.float64]
    shapes: NDArray[np.float32]
    descriptors: NDArray[np.uint8]

    @property
    def sizes(self) -> NDArray[np.float64]:
        """(N,) of each, in pixels."""
        a, b, c, d = self.shapes.T.astype(np.float64)
        found: NDArray[np.float64] = np.sqrt(np.abs(a * d - b * c))
        return found

    @property
    def unit(self) -> NDArray[np.float32]:
        """(N, 128) descriptors of length 1."""
        found = self.descriptors.astype(np.float32)
        length = np.linalg.norm(found, axis=1, keepdims=True)
        return np.asarray(found / np.maximum(length, 1e-9), dtype=np.float32)


@contextmanager
def quiet_pycolmap() -> Iterator[Any]:
    """Pycolmap, which says nothing meanwhile.

    Raises:
        MissingExtraError: It is not installed.
    """
    try:
        import pycolmap
    except ModuleNotFoundError as error:
        raise MissingExtraError("pycolmap", "capture") from error
    level = pycolmap.logging.minloglevel
    pycolmap.logging.minloglevel = 3
    try:
        yield pycolmap
    finally:
        pycolmap.logging.minloglevel = level


def find_features(
    photographs: Sequence[Photograph],
    *,
    fine: bool = False,
    done: Callable[[int], None] = lambda count: None,
) -> list[Features]:
    """Features of photographs, in their order; the same each time.

    Args:
        photographs: Where a mask is given, only its features are kept.
        fine: Look at them enlarged twice, for what is smaller than two pixels.
        done: Called with how many are done.
    """
    found: list[Features] = []
    with quiet_pycolmap(), ThreadPoolExecutor(_AT_ONCE) as pool:
        try:
            for features in pool.map(lambda photograph: _of(photograph, fine), photographs):
                found.append(features)
                done(len(found))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return found


def seen_enlarged(photograph: Photograph) -> bool:
    """Whether it is looked at enlarged in any case, being small."""
    return max(photograph.size) < _ENLARGED_BELOW


def _of(photograph: Photograph, fine: bool) -> Features:
    with quiet_pycolmap() as pycolmap:
        options = pycolmap.FeatureExtractionOptions()
        options.num_threads = 1
        options.use_gpu = False
        options.sift.peak_threshold = _PEAK
        options.sift.max_num_features = _MOST
        options.sift.first_octave = -1 if fine or seen_enlarged(photograph) else 0
        extractor = pycolmap.FeatureExtractor.create(options, pycolmap.Device.cpu)
        pixels = read_upright(photograph.path, grey=True)
        factor = min(1.0, _LONGEST / max(photograph.size))
        if factor < 1.0:
            pixels = _reduced(pixels, factor)
        keypoints, descriptors = extractor.extract_from_uint8_array(pixels)
        values = np.array(
            [(k.x, k.y, k.a11, k.a12, k.a21, k.a22) for k in keypoints], dtype=np.float64
        ).reshape(-1, 6)
        looks = np.array(descriptors.data, dtype=np.uint8).reshape(-1, 128)
    # Pycolmap has the centre of the first pixel at one half.
    places = values[:, :2] / factor - 0.5
    found = Features(places, (values[:, 2:] / factor).astype(np.float32), looks)
    if photograph.mask is None:
        return found
    mask = read_mask(photograph.mask, photograph.size)
    last = np.array(photograph.size) - 1
    columns, rows = np.clip(np.rint(places).astype(np.int64), 0, last).T
    return found.chosen(mask[rows, columns])


def _reduced(pixels: NDArray[np.uint8], factor: float) -> NDArray[np.uint8]:
    import cv2

    height, width = pixels.shape
    size = (round(width * factor), round(height * factor))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
