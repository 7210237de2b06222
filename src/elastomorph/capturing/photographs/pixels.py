"""Pixels of a photograph, upright: every stage reads them here, so all speak of the same ones.

EXIF says how a camera was held, and viewers turn photographs by it; so do we, everywhere, and a
pixel (x, y) is the one that is seen at that place. A file that ends early is an error, not a face
with a grey chin.

What a camera wrote into a photograph: how it was held, its lens, and what that is in pixels.

A focal length in pixels follows from its length on 35-mm film, f_px = f_35 · diagonal / 43.27, or
from the sensor's pixels per unit of length, f_px = f · resolution, reduced as the photograph was
since. Neither is more than a start: cameras are solved from the photographs themselves, and what
EXIF says is compared with the result. What cannot be true is not used, and the reason is said.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError, MissingExtraError

if TYPE_CHECKING:
    from PIL.Image import Image


_ORIENTATION, _MAKE, _MODEL, _EXIF_FOLDER = 274, 271, 272, 0x8769
_FOCAL_LENGTH, _FOCAL_35 = 37386, 41989
_PLANE_X, _PLANE_Y, _PLANE_UNIT = 41486, 41487, 41488
_PIXELS_X, _PIXELS_Y = 40962, 40963
_MILLIMETRES = {1: 25.4, 2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}

_DIAGONAL_35 = math.hypot(36.0, 24.0)
# Of the longer side: wider than any lens that is no fisheye, and longer than faces are taken with.
_SHORTEST, _LONGEST = 0.35, 12.0
_SMALLEST_SENSOR, _LARGEST_SENSOR = 3.0, 70.0  # mm, longer side
_SWAPS_SIDES = (5, 6, 7, 8)


@dataclass(frozen=True)
class Exif:
    """What is used of a photograph's EXIF.

    Attributes:
        orientation: How the stored rows are turned to stand upright, 1 to 8 as EXIF counts.
        camera: Make and model, empty where none is written.
        length: Focal length in mm as written, or None.
        focal: Focal length in pixels of the whole photograph, or None where it does not follow.
        doubt: Why a focal length that was written is not used; empty where there is no doubt.
    """

    orientation: int = 1
    camera: str = ""
    length: float | None = None
    focal: float | None = None
    doubt: str = ""

    @property
    def swaps_sides(self) -> bool:
        """Whether width and height change places when the photograph is turned upright."""
        return self.orientation in _SWAPS_SIDES


def read_exif(tags: Any, size: tuple[int, int]) -> Exif:
    """The EXIF of an image opened by Pillow.

    Args:
        tags: What its ``getexif`` returned.
        size: Width and height in pixels as stored.
    """
    more = tags.get_ifd(_EXIF_FOLDER)
    orientation = tags.get(_ORIENTATION, 1)
    make, model = _text(tags.get(_MAKE)), _text(tags.get(_MODEL))
    camera = model if model.lower().startswith(make.lower()) else f"{make} {model}"
    length = _number(more.get(_FOCAL_LENGTH))
    focal, doubt = _focal(more, length, size)
    return Exif(
        orientation=orientation if orientation in range(1, 9) else 1,
        camera=camera.strip(),
        length=length,
        focal=focal,
        doubt=doubt,
    )


def _focal(tags: Any, length: float | None, size: tuple[int, int]) -> tuple[float | None, str]:
    longer = max(size)
    film = _number(tags.get(_FOCAL_35))
    by_film = None if film is None else film * math.hypot(*size) / _DIAGONAL_35
    by_sensor, doubt = _by_sensor(tags, length, longer)
    for focal, source in ((by_film, "35-mm film"), (by_sensor, "its sensor")):
        if focal is None:
            continue
        if _SHORTEST * longer <= focal <= _LONGEST * longer:
            return focal, ""
        doubt = (
            f"by {source} its focal length would be {focal:,.0f} px for {longer:,} px, "
            f"as no lens has that takes a face"
        )
    return None, doubt


def _by_sensor(tags: Any, length: float | None, longer: int) -> tuple[float | None, str]:
    resolution = _number(tags.get(_PLANE_X))
    if length is None or resolution is None:
        return None, ""
    per_millimetre = resolution / _MILLIMETRES.get(tags.get(_PLANE_UNIT, 2), 25.4)
    taken = [_number(tags.get(key)) for key in (_PIXELS_X, _PIXELS_Y)]
    whole = max((side for side in taken if side is not None), default=float(longer))
    sensor = whole / per_millimetre
    if not _SMALLEST_SENSOR <= sensor <= _LARGEST_SENSOR:
        return None, f"its sensor would be {sensor:,.1f} mm wide"
    return length * per_millimetre * longer / whole, ""


def _number(value: object) -> float | None:
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None
    return number if math.isfinite(number) and number > 0 else None


def _text(value: object) -> str:
    return value.replace("\0", " ").strip() if isinstance(value, str) else ""


_MOST_PIXELS = 200_000_000
_SMALLEST_SIDE = 64
_BRANDS_OF_HEIF = (b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"mif1", b"msf1", b"avif")
_WHITE = 128


@contextmanager
def opened_photograph(path: Path) -> Iterator[tuple[Image, Exif]]:
    """A photograph of which the header was read, and its EXIF.

    Raises:
        FileError: It is not there or may not be read.
        FormatError: It is no photograph that can be read, too large or too small.
        MissingExtraError: Pillow is not installed.
    """
    try:
        import PIL
        from PIL import Image as images  # noqa: N813
    except ModuleNotFoundError as error:
        raise MissingExtraError("pillow", "capture") from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of damaged EXIF, which is then none
            with images.open(path) as image:
                _require_size(path, image.size)
                yield image, _exif(image)
    except FileError:
        raise
    except PIL.UnidentifiedImageError as error:
        raise FormatError(path, _why_unknown(path)) from error
    except images.DecompressionBombError as error:
        raise FormatError(path, f"it has more than {_MOST_PIXELS:,} pixels") from error
    except FileNotFoundError as error:
        raise FileError(path, "there is no such photograph") from error
    except (OSError, SyntaxError, ValueError, EOFError) as error:
        raise FormatError(
            path, f"this photograph is damaged or not whole ({error}); copy it again"
        ) from error


def upright_size(path: Path) -> tuple[tuple[int, int], int]:
    """Width and height of a photograph in pixels as it is seen upright, and its EXIF orientation.

    Raises:
        FileError, FormatError: It is not there, or no photograph.
    """
    with opened_photograph(path) as (image, exif):
        width, height = image.size
    return ((height, width) if exif.swaps_sides else (width, height)), exif.orientation


def read_upright(
    path: str | Path, *, grey: bool = False, longest: int | None = None
) -> NDArray[np.uint8]:
    """The pixels of a photograph as it is seen upright.

    Args:
        path: A JPEG, PNG or TIFF file.
        grey: Brightness alone.
        longest: Longer side to reduce it to about, for a quick look; JPEG is read faster so.

    Returns:
        (H, W, 3) RGB, or (H, W) brightness.

    Raises:
        FileError, FormatError: It is not there, no photograph, damaged or not whole.
    """
    from PIL import Image as images  # noqa: N813

    with opened_photograph(Path(path)) as (image, exif):
        mode = "L" if grey else "RGB"
        if longest is not None:
            image.draft(mode, (longest, longest))
        whole = _eight_bits(image).convert(mode)
        if longest is not None and max(whole.size) > longest:
            whole.thumbnail((longest, longest), images.Resampling.BOX)
        pixels = np.asarray(whole)
    return np.ascontiguousarray(_turned(pixels, exif.orientation))


def read_mask(path: Path, size: tuple[int, int]) -> NDArray[np.bool_]:
    """A mask of a photograph, white where the face is.

    Args:
        path: An image file.
        size: Width and height of the photograph, upright.

    Returns:
        (H, W), True where it is white.

    Raises:
        FormatError: It has another size than its photograph, or is black all over.
    """
    mask = read_upright(path, grey=True) >= _WHITE
    found = mask.shape[::-1]
    if found != size:
        hint = (
            "it lies on its side: masks belong to the photograph as it is seen upright"
            if found == size[::-1]
            else "make it from the photograph itself, in the same size"
        )
        raise FormatError(
            path,
            f"the mask has {found[0]:,} × {found[1]:,} pixels and its photograph "
            f"{size[0]:,} × {size[1]:,}; {hint}",
        )
    if not mask.any():
        raise FormatError(path, "the mask is black all over; white marks the face")
    return mask


def _exif(image: Image) -> Exif:
    if image.format == "TIFF":
        image.load()  # Pillow turns these upright, and takes the orientation out of the EXIF
    try:
        return read_exif(image.getexif(), image.size)
    except (SyntaxError, ValueError, TypeError, OSError, KeyError, AttributeError):
        return Exif()


def _require_size(path: Path, size: tuple[int, int]) -> None:
    width, height = size
    if width * height > _MOST_PIXELS:
        raise FormatError(path, f"it has {width:,} × {height:,} pixels, more than 200 megapixels")
    if min(size) < _SMALLEST_SIDE:
        raise FormatError(
            path,
            f"it has {width:,} × {height:,} pixels: a preview, no photograph; take the original",
        )


def _why_unknown(path: Path) -> str:
    with path.open("rb") as file:
        start = file.read(16)
    if start[4:8] == b"ftyp" and start[8:12] in _BRANDS_OF_HEIF:
        return (
            "this is a HEIC/HEIF photograph, which is not read; convert it to JPEG with its EXIF "
            "kept (macOS: sips -s format jpeg; elsewhere: heif-convert or ImageMagick), or set "
            "the phone to take 'most compatible' photographs"
        )
    if not start:
        return "this file is empty; copy it again"
    return "this is no JPEG, PNG or TIFF photograph, or it is damaged; copy it again"


def _eight_bits(image: Any) -> Any:
    """The image with at most 8 bits a channel; Pillow would cut 16 off instead of reducing them."""
    if not image.mode.startswith(("I", "F")):
        return image
    from PIL import Image as images  # noqa: N813

    values = np.asarray(image).astype(np.float64)
    if image.mode == "F" and values.max(initial=0.0) <= 1.0:
        values *= 255.0
    elif values.max(initial=0.0) > 255.0:
        values /= 257.0
    return images.fromarray(np.clip(np.round(values), 0, 255).astype(np.uint8))


def _turned(pixels: NDArray[np.uint8], orientation: int) -> NDArray[np.uint8]:
    """Pixels turned and mirrored as an EXIF orientation asks for."""
    if orientation in (5, 6, 7, 8):
        pixels = pixels.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return pixels
