"""What would be found out after minutes of work, looked for beforehand.

Files that are damaged, one photograph twice, some that are blurred against the others, other
cameras or sizes among them.

How sharp a photograph is where it shows something, to compare with others of the same head.

The strength of its finest detail (of about a pixel) against that of coarser detail (of about four),
in the third of the photograph that has most of the latter. It does not depend on brightness and
little on what is shown; blur of a pixel or two halves it. Noise is fine detail too, and would make
the most blurred photograph of a dim room the sharpest: its strength is estimated and taken off.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve, gaussian_filter

from elastomorph.capturing.photographs.comparing import look_of, of_use, shown
from elastomorph.capturing.photographs.photographs import FEWEST, Photograph, Photographs
from elastomorph.capturing.photographs.pixels import opened_photograph, read_mask, read_upright
from elastomorph.errors import CaptureError, ElastomorphError, FormatError

_FINE, _COARSE, _AROUND = 0.8, 3.2, 8.0  # px
_SHOWS_SOMETHING = 70  # percentile
# What is left of white noise of variance 1, and nothing of what is smooth (Immerkær 1996); where
# the skin has pores it holds these too, so that the plainer parts of what is shown tell the noise.
_NOISE = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], dtype=np.float32) / 6
_PLAIN = 20  # percentile


def sharpness(grey: NDArray[np.uint8]) -> float:
    """Strength of fine against coarse detail of a photograph (H, W); 0 where it is uniform."""
    picture = grey.astype(np.float32)
    fine = _strength(picture, _FINE)
    coarse = _strength(picture, _COARSE)
    shows = coarse >= np.percentile(coarse, _SHOWS_SOMETHING)
    shows &= coarse > 1e-3
    if not shows.any():
        return 0.0
    noise = np.percentile(gaussian_filter(convolve(picture, _NOISE) ** 2, _AROUND)[shows], _PLAIN)
    left = fine[shows] - noise * _of_white(_FINE)
    below = np.maximum(coarse[shows] - noise * _of_white(_COARSE), 1e-3)
    return float(np.sqrt(max(np.median(left / below), 0.0)))


def _strength(picture: NDArray[np.float32], width: float) -> NDArray[np.float32]:
    """Mean square, around each pixel, of the detail between a width and twice that, (H, W)."""
    band = gaussian_filter(picture, width) - gaussian_filter(picture, 2 * width)
    strength: NDArray[np.float32] = gaussian_filter(band * band, _AROUND)
    return strength


def _of_white(width: float) -> float:
    """Mean square of the detail of `_strength` in white noise of variance 1.

    Gaussians of widths a and b overlap by 1 / 2π (a² + b²).
    """
    return (1 + 1 / 4 - 4 / 5) / (4 * np.pi * width**2)


_EXAMINED_AT = 1000  # px, longer side


def examine(
    pose: str,
    paths: Sequence[Path],
    *,
    masks: Mapping[Path, Path] | None = None,
    fewest: int = FEWEST,
) -> Photographs:
    """Look at each photograph of a pose, quickly, and say which are of use.

    Args:
        pose: Name of the pose.
        paths: Files of its photographs.
        masks: Files of masks by that of the photograph.
        fewest: Photographs needed.

    Raises:
        FileError: A photograph is not there or the machine has none of the libraries.
        FormatError: A mask is not its photograph's, or HEIC is given.
        CaptureError: Fewer photographs than needed are of use.
    """
    masks = masks or {}
    taken: list[Photograph] = []
    looks: dict[str, NDArray[np.float32]] = {}
    rejected: dict[str, str] = {}
    first_of: dict[str, str] = {}
    for path in paths:
        try:
            photograph = _described(path, masks.get(path))
            if photograph.digest in first_of:
                rejected[path.name] = f"it is the same file as {first_of[photograph.digest]}"
                continue
            grey = read_upright(path, grey=True, longest=_EXAMINED_AT)
        except FormatError as error:
            if _is_heic(error):
                raise
            rejected[path.name] = str(error).removeprefix(f"{path}: ")
            continue
        first_of[photograph.digest] = path.name
        looks[path.name] = look_of(grey)
        taken.append(replace(photograph, sharpness=sharpness(grey)))
    taken = of_use(taken, looks, rejected)
    if len(taken) < fewest:
        raise CaptureError(_too_few(pose, len(paths), len(taken), rejected, fewest))
    for photograph in taken:
        if photograph.mask is not None:
            read_mask(photograph.mask, photograph.size)
    return Photographs(pose, tuple(taken), rejected, tuple(_remarks(taken, bool(masks))))


def _described(path: Path, mask: Path | None) -> Photograph:
    with opened_photograph(path) as (image, exif):
        width, height = image.size
    size = (height, width) if exif.swaps_sides else (width, height)
    parts = [exif.camera, f"{exif.length:g} mm" if exif.length else "", shown(size)]
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    lens = ", ".join(part for part in parts if part)
    return Photograph(path, size, exif.focal, exif.doubt, lens, digest, mask)


def _too_few(pose: str, given: int, left: int, rejected: Mapping[str, str], fewest: int) -> str:
    why = "".join(f"; {name}: {reason}" for name, reason in list(rejected.items())[:3])
    more = f" (and {len(rejected) - 3} more)" if len(rejected) > 3 else ""
    return (
        f"pose '{pose}' has {left} photographs of use out of {given}, at least {fewest} are "
        f"needed and 25 to 30 are good{why}{more}"
    )


def _remarks(taken: Sequence[Photograph], masked: bool) -> Iterable[str]:
    lenses = Counter(photograph.lens for photograph in taken)
    if len(lenses) > 1:
        yield "several cameras or sizes: " + "; ".join(
            f"{number} by {lens}" for lens, number in lenses.most_common()
        )
    doubts = [photograph for photograph in taken if photograph.doubt]
    if doubts:
        yield f"the EXIF of {doubts[0].name} is not used: {doubts[0].doubt}"
    without = sum(photograph.focal is None for photograph in taken)
    if without:
        yield (
            f"{without} of {len(taken)} photographs have no focal length in their EXIF; it is "
            "looked for, which takes longer"
        )
    unmasked = sum(photograph.mask is None for photograph in taken)
    if masked and unmasked:
        yield f"{unmasked} of {len(taken)} photographs have no mask"


def _is_heic(error: ElastomorphError) -> bool:
    return "HEIC" in str(error)
