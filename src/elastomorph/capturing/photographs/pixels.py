"""Pixels of a photograph, upright: every stage reads them here, so all speak of the same ones.

EXIF says how a camera was held, and viewers turn photographs by it; so do we, everywhere, and a
pixel (x, y) is the one that is seen at that place. A file that ends early is an error, not a face
with a grey chin.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.photographs.exif import Exif, read_exif
from elastomorph.errors import FileError, FormatError, MissingExtraError

if TYPE_CHECKING:
    from PIL.Image import Image

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
