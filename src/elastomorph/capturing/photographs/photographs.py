"""The photographs of a pose, as what was found out of each before any work."""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import overload

from elastomorph.capturing.geometry.camera import Camera, View, open_view
from elastomorph.errors import FileError

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
