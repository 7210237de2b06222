"""What only shows when photographs are held against each other, within a pose and between poses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.photographs.photographs import FEWEST, Photograph, Photographs
from elastomorph.errors import CaptureError

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
