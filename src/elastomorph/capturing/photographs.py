"""Photographs: which there are, how they were taken, and their pixels."""

from __future__ import annotations

import hashlib
import math
import re
import warnings
from collections import Counter, OrderedDict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Camera, View, open_view
from elastomorph.errors import (
    CaptureError,
    ElastomorphError,
    FileError,
    FormatError,
    MissingExtraError,
)

if TYPE_CHECKING:
    from PIL.Image import Image


# What a camera wrote into a photograph: how it was held, its lens, and what that is in pixels.
#
# A focal length in pixels follows from its length on 35-mm film, f_px = f_35 · diagonal / 43.27,
# or from the sensor's pixels per unit of length, f_px = f · resolution, reduced as the photograph
# was since. Neither is more than a start: cameras are solved from the photographs themselves, and
# what EXIF says is compared with the result. What cannot be true is not used, and the reason is
# said.

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


# Pixels of a photograph, upright: every stage reads them here, so all speak of the same ones.
#
# EXIF says how a camera was held, and viewers turn photographs by it; so do we, everywhere, and a
# pixel (x, y) is the one that is seen at that place. A file that ends early is an error, not a
# face with a grey chin.


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


# The photographs of a pose, as what was found out of each before any work.

FEWEST = 6  # photographs of a pose; fewer leave most of a face seen by less than three cameras


@dataclass(frozen=True)
class Photograph:
    """A photograph as its header describes it.

    Attributes:
        path: The file.
        size: Width and height in pixels, upright.
        focal: Focal length in pixels by EXIF, or None.
        doubt: Why a focal length that EXIF gives is not used, or empty.
        lens: What took it: camera, focal length in mm and size; photographs with the same share
            one set of lens parameters.
        digest: Hash of the content.
        mask: File of its mask, or None.
        sharpness: Of `sharpness`, at the size that is looked at; 0 where it was not.
    """

    path: Path
    size: tuple[int, int]
    focal: float | None
    doubt: str
    lens: str
    digest: str
    mask: Path | None = None
    sharpness: float = 0.0

    @property
    def name(self) -> str:
        """File name without its folder."""
        return self.path.name


@dataclass(frozen=True)
class Photographs:
    """The photographs of one pose that are of use.

    Attributes:
        pose: Name of the pose.
        taken: Those to work with, in the order of their names.
        rejected: File name of each other one, and why.
        remarks: Sentences about what is unusual without being an error.
    """

    pose: str
    taken: tuple[Photograph, ...]
    rejected: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


# The photographs of a pose, opened when they are looked at.

_LONGEST_SIDE = 2400  # px; what is finer costs memory and time, and skin shows no more
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
        longest: int = _LONGEST_SIDE,
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


# Which photographs of which poses there are, and which masks.
#
# Poses are folders (``photos/smile/IMG_0412.jpg``), or all lie in one and are named by pose and
# number (``smile_01.jpg``). One folder of photographs as cameras name them (``IMG_0412.jpg``) is
# one pose, named by the folder. Masks lie in a folder of their own with the same names
# (``smile_01.png`` for ``smile_01.jpg``, in folders a pose where the photographs are), white
# where the face is.

_READ = (".jpg", ".jpeg", ".png", ".tif", ".tiff")
_PHONES = (".heic", ".heif", ".avif")  # opened, so that the refusal says what to do
_NOT_READ = {
    "raw": (".cr2", ".cr3", ".nef", ".arw", ".dng", ".raf", ".orf", ".rw2", ".pef"),
    "film": (".mov", ".mp4", ".avi", ".mkv", ".webm"),
}
_NUMBERED = re.compile(r"^(?P<pose>.*?)[ _.\-]*\(?(?P<number>\d+)\)?$")
_NAMED_BY_CAMERAS = re.compile(
    r"^(_?img|_mg|dsc|_?dsc[fn]?|dscf|dscn|p|pxl|dji|gopr|sam|cimg|hpim|photo|image|frame|mvimg)?$",
    re.IGNORECASE,
)


def find_poses(folder: str | Path) -> dict[str, tuple[Path, ...]]:
    """The poses in a folder and the photographs of each, both in natural order.

    Args:
        folder: Holds one folder a pose, or all photographs.

    Raises:
        FileError: There is no such folder, there are no photographs, or both kinds of order.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileError(folder, "there is no such folder of photographs")
    here = _photographs_in(folder)
    below = {
        path.name: found
        for path in _sorted(p for p in folder.iterdir() if _is_folder_of_a_pose(p))
        if (found := _photographs_in(path))
    }
    if here and below:
        raise FileError(
            folder,
            f"photographs lie in it ({here[0].name}) and in folders below "
            f"({next(iter(below))}); give each pose its folder, or put all into one",
        )
    if below:
        return below
    if not here:
        raise FileError(folder, f"no JPEG, PNG or TIFF photographs in it{_what_else(folder)}")
    return _poses_by_name(here, folder.resolve().name)


def find_masks(folder: str | Path, poses: Mapping[str, Sequence[Path]]) -> dict[Path, Path]:
    """The mask of each photograph that has one.

    Args:
        folder: Holds masks named as the photographs, in folders a pose or all in one.
        poses: Poses and their photographs.

    Raises:
        FileError: There is no such folder, or nothing in it is named as a photograph.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileError(folder, "there is no such folder of masks")
    found = {}
    for pose, paths in poses.items():
        place = folder / pose if (folder / pose).is_dir() else folder
        masks = {}
        for path in _photographs_in(place):
            masks[path.stem] = path
            masks[path.name] = path
        for path in paths:
            mask = masks.get(path.stem) or masks.get(path.name)
            mask = mask or masks.get(f"{path.name}.png") or masks.get(f"{path.stem}_mask")
            if mask is not None and mask.resolve() != path.resolve():
                found[path] = mask
    if not found:
        first = next(path for paths in poses.values() for path in paths)
        raise FileError(folder, f"no mask in it is named as a photograph, such as {first.stem}.png")
    return found


def _photographs_in(folder: Path) -> tuple[Path, ...]:
    """Photographs in a folder; phones that store HEIC beside JPEG mean the same picture."""
    files = [p for p in folder.iterdir() if p.is_file() and not p.name.startswith(".")]
    read = [p for p in files if p.suffix.lower() in _READ]
    stems = {p.stem for p in read}
    read += [p for p in files if p.suffix.lower() in _PHONES and p.stem not in stems]
    return tuple(_sorted(read))


def _is_folder_of_a_pose(path: Path) -> bool:
    return path.is_dir() and not path.name.startswith((".", "_")) and path.name.lower() != "masks"


def _poses_by_name(paths: Sequence[Path], folder: str) -> dict[str, tuple[Path, ...]]:
    """Photographs of one folder by the pose in their names."""
    poses: dict[str, list[Path]] = {}
    for path in paths:
        parts = _NUMBERED.match(path.stem)
        pose = parts["pose"] if parts else path.stem
        poses.setdefault(folder if _NAMED_BY_CAMERAS.match(pose) else pose, []).append(path)
    return {pose: tuple(found) for pose, found in poses.items()}


def _what_else(folder: Path) -> str:
    suffixes = {path.suffix.lower() for path in folder.rglob("*") if path.is_file()}
    if suffixes.intersection(_NOT_READ["raw"]):
        return "; raw files of a camera are there: develop them to JPEG or TIFF first"
    if suffixes.intersection(_NOT_READ["film"]):
        return "; a film is there: take photographs, frames of a film are too blurred"
    return ""


def _sorted(paths: Iterable[Path]) -> list[Path]:
    """In natural order: 2 before 10."""
    return sorted(
        paths,
        key=lambda path: [
            (0, int(part), "") if part.isdigit() else (1, 0, part.lower())
            for part in re.split(r"(\d+)", path.name)
            if part
        ],
    )


# What would be found out after minutes of work, looked for beforehand.
#
# Files that are damaged, one photograph twice, some that are blurred against the others, other
# cameras or sizes among them.

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


# What only shows when photographs are held against each other, within a pose and between poses.


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
# How sharp a photograph is where it shows something, to compare with others of the same head.
#
# The strength of its finest detail (of about a pixel) against that of coarser detail (of about
# four), in the third of the photograph that has most of the latter. It does not depend on
# brightness and little on what is shown; blur of a pixel or two halves it. Noise is fine detail
# too, and would make the most blurred photograph of a dim room the sharpest: its strength is
# estimated and taken off.

# What is left of white noise of variance 1, and nothing of what is smooth (Immerkær 1996); where
# the skin has pores it holds these too, so that the plainer parts of what is shown tell the noise.
_NOISE = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], dtype=np.float32) / 6
_PLAIN = 20  # percentile


def sharpness(grey: NDArray[np.uint8]) -> float:
    """Strength of fine against coarse detail of a photograph (H, W); 0 where it is uniform."""
    from scipy.ndimage import convolve, gaussian_filter

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
    from scipy.ndimage import gaussian_filter

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
