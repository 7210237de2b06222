"""Photographs of poses: which there are, how each was taken, and which of them are of use.

Poses are folders (``photos/smile/IMG_0412.jpg``), or all lie in one and are named by pose and
number (``smile_01.jpg``). One folder of photographs as cameras name them (``IMG_0412.jpg``) is one
pose, named by the folder. Masks lie in a folder of their own with the same names (``smile_01.png``
for ``smile_01.jpg``, in folders a pose where the photographs are), white where the face is.

What would be found out after minutes of work is looked for beforehand: files that are damaged, one
photograph twice, some that are blurred against the others, other cameras or sizes among them.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from elastomorph.capturing.photographs.pixels import opened_photograph, read_mask, read_upright
from elastomorph.capturing.photographs.sharpness import sharpness
from elastomorph.errors import CaptureError, ElastomorphError, FileError, FormatError

__all__ = ["FEWEST", "Photograph", "Photographs", "examine", "find_masks", "find_poses"]

FEWEST = 6  # photographs of a pose; fewer leave most of a face seen by less than three cameras

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
_EXAMINED_AT = 1000  # px, longer side
_BLURRED = 0.6  # sharpness against that of sharp ones; photographs of one head range by .75-1.2
_SHARP = 0.8  # quantile that is sharp, also where most of a pose is blurred
_SHARE_OF_GROUP = 0.25


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
    """

    path: Path
    size: tuple[int, int]
    focal: float | None
    doubt: str
    lens: str
    digest: str
    mask: Path | None = None

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
    sharp: dict[str, float] = {}
    rejected: dict[str, str] = {}
    first_of: dict[str, str] = {}
    for path in paths:
        try:
            photograph = _described(path, masks.get(path))
            if photograph.digest in first_of:
                rejected[path.name] = f"it is the same file as {first_of[photograph.digest]}"
                continue
            sharp[path.name] = sharpness(read_upright(path, grey=True, longest=_EXAMINED_AT))
        except FormatError as error:
            if _is_heic(error):
                raise
            rejected[path.name] = str(error).removeprefix(f"{path}: ")
            continue
        first_of[photograph.digest] = path.name
        taken.append(photograph)
    taken = _without_strangers(_with_lost_exif(taken), rejected)
    taken = _without_blurred(taken, sharp, rejected)
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
    parts = [exif.camera, f"{exif.length:g} mm" if exif.length else "", _shown(size)]
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    lens = ", ".join(part for part in parts if part)
    return Photograph(path, size, exif.focal, exif.doubt, lens, digest, mask)


def _shown(size: tuple[int, int]) -> str:
    return f"{size[0]} × {size[1]}"


def _with_lost_exif(taken: list[Photograph]) -> list[Photograph]:
    """Photographs that lost their EXIF are of the one camera that took others of their size."""
    lenses: dict[tuple[int, int], set[str]] = {}
    for photograph in taken:
        if photograph.lens != _shown(photograph.size):
            lenses.setdefault(photograph.size, set()).add(photograph.lens)
    return [
        replace(photograph, lens=next(iter(lenses[photograph.size])))
        if photograph.lens == _shown(photograph.size) and len(lenses.get(photograph.size, ())) == 1
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
            rejected[photograph.name] = (
                f"taken with another camera, lens or size ({photograph.lens}) than {most[1]} of "
                f"the others ({most[0]})"
            )
    return kept


def _without_blurred(
    taken: list[Photograph], sharp: Mapping[str, float], rejected: dict[str, str]
) -> list[Photograph]:
    """Without photographs that are blurred against the others of the same camera."""
    best = {}
    for lens in {photograph.lens for photograph in taken}:
        values = sorted(sharp[photograph.name] for photograph in taken if photograph.lens == lens)
        best[lens] = values[int(_SHARP * len(values))]
    kept = []
    for photograph in taken:
        relative = sharp[photograph.name] / (best[photograph.lens] or 1.0)
        if relative >= _BLURRED:
            kept.append(photograph)
        else:
            rejected[photograph.name] = f"blurred: {relative:.0%} of the sharpness that others have"
    return kept


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
