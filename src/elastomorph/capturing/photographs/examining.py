"""What would be found out after minutes of work, looked for beforehand.

Files that are damaged, one photograph twice, some that are blurred against the others, other
cameras or sizes among them.

How sharp a photograph is where it shows something, to compare with others of the same head.

The strength of its finest detail (of about a pixel) against that of coarser detail (of about four),
in the third of the photograph that has most of the latter. It does not depend on brightness and
little on what is shown; blur of a pixel or two halves it. Noise is fine detail too, and would make
the most blurred photograph of a dim room the sharpest: its strength is estimated and taken off.

What only shows when photographs are held against each other, within a pose and between poses.
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

from elastomorph.capturing.photographs.photographs import FEWEST, Photograph, Photographs
from elastomorph.capturing.photographs.pixels import opened_photograph, read_mask, read_upright
from elastomorph.errors import CaptureError, ElastomorphError, FormatError

Look = NDArray[np.float32]

_SHARE_OF_GROUP = 0.25
_BLURRED = 0.6  # sharpness against that of sharp ones; photographs of one head range by .75-1.2
_SHARP = 0.8  # quantile that is sharp, also where most of a pose is blurred
# A pose that is of no use: against others, of which one may be sharp by its noise alone, and as it
# is; out of focus by three pixels of 1000.
_BLURRED_POSE, _SHARP_POSE = 0.35, 0.25
# Fields of a look, and how far they may be apart, of their spread: those of one photograph, stored
# again, are within .01, and of the next one along a ring .4.
_ACROSS, _SAME = 32, 0.04


def look_of(grey: NDArray[np.uint8]) -> Look:
    """A photograph (H, W) so small that only what it shows matters, not how it was stored."""
    from PIL import Image as images  # noqa: N813

    image = images.fromarray(grey.astype(np.float32))
    fields = np.array(image.resize((_ACROSS, _ACROSS), images.Resampling.BOX))
    fields -= fields.mean()
    fields /= max(float(fields.std()), 1e-6)
    return fields


def of_use(
    taken: list[Photograph], looks: Mapping[str, Look], rejected: dict[str, str]
) -> list[Photograph]:
    """Those of a pose that are of use; why others are not is added to what is rejected."""
    taken = _without_copies(taken, looks, rejected)
    taken = _without_strangers(_with_lost_exif(taken), rejected)
    return _without_blurred(taken, rejected)


def compared(poses: Mapping[str, Photographs]) -> dict[str, str]:
    """A remark on each pose that is blurred against the others.

    Raises:
        CaptureError: One is so blurred that nothing can be found of it, or a photograph is of two.
    """
    of: dict[str, tuple[str, str]] = {}
    for pose, photographs in poses.items():
        for photograph in photographs.taken:
            other, name = of.setdefault(photograph.digest, (pose, photograph.name))
            if other != pose:
                raise CaptureError(
                    f"pose '{pose}': {photograph.name} is the same file as {name} of pose "
                    f"'{other}'; a photograph is of one pose, so take it out of the other"
                )
    remarks = {}
    sharp = {pose: _sharp(photographs) for pose, photographs in poses.items()}
    for pose, own in sharp.items():
        relative = max(
            (value / _usual(sharp, lens) for lens, value in own.items() if value), default=1.0
        )
        blurred = (
            f"its photographs are blurred: {relative:.0%} of the sharpness that those of other "
            "poses have"
        )
        if relative < _BLURRED_POSE and max(own.values()) < _SHARP_POSE:
            raise CaptureError(f"pose '{pose}': {blurred}; take it again, or leave it out")
        if relative < _BLURRED:
            remarks[pose] = f"{blurred}; take it again if you can"
    return remarks


def _sharp(photographs: Photographs) -> dict[str, float]:
    """Lens → the median sharpness of what it took."""
    lenses = dict.fromkeys(photograph.lens for photograph in photographs.taken)
    return {
        lens: float(np.median([p.sharpness for p in photographs.taken if p.lens == lens]))
        for lens in lenses
    }


def _usual(sharp: Mapping[str, Mapping[str, float]], lens: str) -> float:
    """What is sharp for a lens: the median of the poses it took, of two the sharper one."""
    values = sorted(own[lens] for own in sharp.values() if lens in own)
    return values[len(values) // 2] or 1.0


def _without_copies(
    taken: list[Photograph], looks: Mapping[str, Look], rejected: dict[str, str]
) -> list[Photograph]:
    """Without photographs that are there again, smaller, stored anew or without their EXIF."""
    kept: list[Photograph] = []
    for photograph in sorted(taken, key=lambda p: (-p.size[0] * p.size[1], p.focal is None)):
        look = looks[photograph.name]
        same = (p for p in kept if np.sqrt(np.mean((looks[p.name] - look) ** 2)) < _SAME)
        if (first := next(same, None)) is None:
            kept.append(photograph)
        else:
            rejected[photograph.name] = f"it is the same photograph as {first.name}, stored again"
    return [photograph for photograph in taken if photograph in kept]


def _with_lost_exif(taken: list[Photograph]) -> list[Photograph]:
    """Photographs that lost their EXIF are of the one camera that took others of their size."""
    lenses: dict[tuple[int, int], set[str]] = {}
    for photograph in taken:
        if photograph.lens != shown(photograph.size):
            lenses.setdefault(photograph.size, set()).add(photograph.lens)
    return [
        replace(photograph, lens=next(iter(lenses[photograph.size])))
        if photograph.lens == shown(photograph.size) and len(lenses.get(photograph.size, ())) == 1
        else photograph
        for photograph in taken
    ]


def _without_strangers(taken: list[Photograph], rejected: dict[str, str]) -> list[Photograph]:
    """Without photographs of cameras that took only a few; a lens needs several to be found."""
    count = Counter(photograph.lens for photograph in taken)
    if len(count) < 2:
        return taken
    most = count.most_common(1)[0]
    kept = []
    for photograph in taken:
        if count[photograph.lens] >= max(FEWEST, _SHARE_OF_GROUP * len(taken)):
            kept.append(photograph)
        else:
            others = {p.lens for p in taken if p.size == photograph.size[::-1]}
            turned = "; turn those upright that lie on their side" if most[0] in others else ""
            rejected[photograph.name] = (
                f"taken with another camera, lens or size ({photograph.lens}) than {most[1]} of "
                f"the others ({most[0]}){turned}"
            )
    return kept


def _without_blurred(taken: list[Photograph], rejected: dict[str, str]) -> list[Photograph]:
    """Without photographs that are blurred against the others of the same camera."""
    best = {}
    for lens in {photograph.lens for photograph in taken}:
        values = sorted(photograph.sharpness for photograph in taken if photograph.lens == lens)
        best[lens] = values[int(_SHARP * len(values))]
    kept = []
    for photograph in taken:
        relative = photograph.sharpness / (best[photograph.lens] or 1.0)
        if relative >= _BLURRED:
            kept.append(photograph)
        else:
            rejected[photograph.name] = f"blurred: {relative:.0%} of the sharpness that others have"
    return kept


def shown(size: tuple[int, int]) -> str:
    """A size in words."""
    return f"{size[0]} × {size[1]}"


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
