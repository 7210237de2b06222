"""Cameras as other programs have them: text models of COLMAP and files of Bundler.

COLMAP has cameras.txt (lenses), images.txt (where each photograph was taken from) and points3D.txt
in one folder; the centre of the first pixel is at one half. Bundler has one file, in which cameras
look along −z, y points up from the middle of the photograph, and photographs have no names: they
stand in a list beside it.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path, PureWindowsPath

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.photographs import FEWEST, upright_size
from elastomorph.errors import CaptureError, FileError, FormatError
from elastomorph.io.atomic import made_folder, read_bytes, replacing

Points = NDArray[np.float64]
Given = tuple[tuple[Camera, ...], ...]
"""Cameras of the photographs of a pose, or two sets of them of which one is right."""

IMAGES, LENSES, POINTS = "images.txt", "cameras.txt", "points3D.txt"
BUNDLER = ".out"

# Of COLMAP's models, which of OPENCV's parameters fx, fy, cx, cy, k1, k2, p1, p2 each of theirs is.
_MODELS: Mapping[str, Sequence[Sequence[int]]] = {
    "SIMPLE_PINHOLE": ((0, 1), (2,), (3,)),
    "PINHOLE": ((0,), (1,), (2,), (3,)),
    "SIMPLE_RADIAL": ((0, 1), (2,), (3,), (4,)),
    "RADIAL": ((0, 1), (2,), (3,), (4,), (5,)),
    "OPENCV": tuple((k,) for k in range(8)),
}
# How far, in pixels of a photograph of this longer side, one radial term may be from a lens.
_HELD, _AT_SIZE = 0.5, 2000
_ROUNDED = 1e-3  # that a rotation in a file may be from one
_TURN = np.array([1.0, -1.0, -1.0])  # from Bundler's axes of a camera to ours
# From pixels as they are stored to those of the photograph upright, by EXIF orientation.
_TURNS: Mapping[int, Sequence[Sequence[int]]] = {
    3: ((-1, 0), (0, -1)),
    6: ((0, -1), (1, 0)),
    8: ((0, 1), (-1, 0)),
}
_LISTED = re.compile(r"^(?P<name>.+?\.\w+)(\s+0\s+[-+.\deE]+)?$")


@dataclass(frozen=True, eq=False)
class Stored:
    """A photograph's camera as it stands in a file.

    Attributes:
        file: That holds it.
        name: Of the photograph, with folders where they are given.
        size: Width and height, None where the file has none.
        lens: (8,) fx, fy, cx, cy, k1, k2, p1, p2, pixel centres at integers; cx and cy are NaN
            where they are the middle of the photograph.
        rotation: (3, 3) of `Camera`.
        translation: (3,) of `Camera`.
    """

    file: Path
    name: str
    size: tuple[int, int] | None
    lens: Points
    rotation: Points
    translation: Points

    @property
    def parts(self) -> tuple[str, ...]:
        """The folders of the photograph and its file name, whichever slashes they are told by."""
        return PureWindowsPath(self.name).parts

    def camera(self, name: str, size: tuple[int, int]) -> Camera:
        """The camera of a photograph of a size, upright.

        Raises:
            CaptureError: It is of another size, or one radial term does not hold its lens.
        """
        if self.size not in (None, size):
            raise CaptureError(
                f"{self.file}: {self.name} has {self.size[0]} × {self.size[1]} pixels there and "
                f"{size[0]} × {size[1]} here, upright; give the photographs it was solved from"
            )
        middle = (np.array(size) - 1.0) / 2
        fx, fy, cx, cy, k1, k2, p1, p2 = self.lens
        centre = np.where(np.isnan([cx, cy]), middle, [cx, cy])
        # The lens of one focal length and radial term that is nearest all over the photograph.
        across = [np.linspace(0, side - 1, 25) for side in size]
        local = (np.stack(np.meshgrid(*across), axis=-1).reshape(-1, 2) - centre) / [fx, fy]
        far = (local**2).sum(axis=1, keepdims=True)
        product = 2 * local.prod(axis=1, keepdims=True)
        true = local * (1 + k1 * far + k2 * far**2)
        true += product * [p1, p2] + (far + 2 * local**2) * [p2, p1]
        goal = (true * [fx, fy]).ravel()
        terms = np.stack([local.ravel(), (local * far).ravel()], axis=1)
        held = np.linalg.lstsq(terms, goal, rcond=None)[0]
        off = float(np.linalg.norm((terms @ held - goal).reshape(-1, 2), axis=1).max())
        if not off <= _HELD * max(1.0, max(size) / _AT_SIZE):
            raise CaptureError(
                f"{self.file}: one radial term is {off:.1f} px off the distortion of {self.name}; "
                "undistort the photographs with the program that solved them, or solve them there "
                "with one (in COLMAP with the camera model SIMPLE_RADIAL)"
            )
        if fx == fy and not np.any([k2, p1, p2]):
            held = np.array([fx, fx * k1])  # without rounding
        focal, radial = float(held[0]), float(held[1] / held[0])
        return Camera(name, size, focal, centre, radial, self.rotation, self.translation)


def read_model(path: Path) -> list[Stored]:
    """The cameras in a folder with a text model of COLMAP, or in a file of Bundler.

    Raises:
        FileError: A file of it cannot be read.
        FormatError: It is not what its format allows, or a lens is of a model that is not read.
    """
    return list(_bundler(path) if path.suffix.lower() == BUNDLER else _colmap(path))


def _colmap(folder: Path) -> Iterator[Stored]:
    lenses = {}
    for number, line in _lines(folder / LENSES):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        with _refusing(folder / LENSES, number, "CAMERA_ID MODEL WIDTH HEIGHT PARAMS"):
            own, model, *values = words
            if model not in _MODELS:
                raise FormatError(
                    folder / LENSES,
                    f"lenses of the model {model} are not held; undistort the photographs, or "
                    f"solve them with one of {', '.join(_MODELS)}",
                    line=number,
                )
            size = int(values[0]), int(values[1])
            lenses[own] = size, _lens(_MODELS[model], _finite(values[2:]))
    from scipy.spatial.transform import Rotation

    lines = _lines(folder / IMAGES)
    for number, line in lines:
        if not line.strip() or line.startswith("#"):
            continue
        with _refusing(folder / IMAGES, number, "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME"):
            _, *values, own, name = line.split(None, 9)
            w, x, y, z, *shift = _finite(values)
            rotation = Rotation.from_quat([x, y, z, w]).as_matrix()
            size, lens = lenses[own]
        yield Stored(folder / IMAGES, name.strip(), size, lens, rotation, np.array(shift))
        next(lines, None)  # what is seen in it


def _lens(order: Sequence[Sequence[int]], values: Sequence[float]) -> Points:
    lens = np.zeros(8)
    for places, value in zip(order, values, strict=True):
        lens[list(places)] = value
    if min(lens[:2]) <= 0:
        raise ValueError
    lens[2:4] -= 0.5
    return lens


def _bundler(path: Path) -> Iterator[Stored]:
    lines = [line for _, line in _lines(path) if not line.startswith("#")]
    with _refusing(path, None, "'# Bundle file v0.3', numbers of cameras and points, and these"):
        count = int(lines[0].split()[0])
        words = " ".join(lines[1 : 1 + 5 * count]).split()
        cameras = np.reshape(_finite(words), (count, 15))
        turns = cameras[:, 3:12].reshape(-1, 3, 3)
        if (abs(turns @ turns.mT - np.eye(3))[cameras[:, 0] > 0] > _ROUNDED).any():
            raise ValueError
    for name, (focal, k1, k2, *rest) in zip(_listed(path, count), cameras, strict=True):
        if focal > 0:  # others were not found
            lens = np.array([focal, focal, np.nan, np.nan, k1, k2, 0, 0])
            turn, shift = np.reshape(rest[:9], (3, 3)), np.array(rest[9:])
            yield Stored(path, name, None, lens, _TURN[:, None] * turn, _TURN * shift)


def _listed(path: Path, count: int) -> list[str]:
    """The photographs of a file of Bundler, by the one list beside it that names as many."""
    found = {}
    for file in sorted(path.parent.glob("*.txt")):
        names = [line.strip() for _, line in _lines(file) if line.strip()]
        names = names[1:] if names[:1] == [str(count)] else names
        matches = [_LISTED.match(name) for name in names]
        if len(names) == count and all(matches):
            found[file] = [match["name"] for match in matches if match]
    own = {file: names for file, names in found.items() if file.stem.startswith(path.stem)}
    if len(found) != 1 and len(own) != 1:
        raise FormatError(
            path,
            f"{len(found)} lists beside it name {count} photographs; put the one that belongs to "
            f"it there as {path.stem}.list.txt, one name a line",
        )
    return next(iter((own or found).values()))


def given_cameras(
    place: Path, poses: Mapping[str, Sequence[Path]], neutral: str, *, fixed: bool
) -> dict[str, Given]:
    """Pose → the cameras of its photographs that are given; poses without any are left out.

    There are two where it is not known if they are those of photographs as stored or upright.

    Args:
        place: A folder with a model of COLMAP or a file of Bundler, for all poses; or a folder with
            one of these for each pose, named as it.
        poses: Pose → files of its photographs.
        neutral: Name of the pose whose cameras are taken where they stay.
        fixed: Whether cameras stay where they are for all poses.

    Raises:
        CaptureError: Cameras are of other photographs, or cannot be held.
        FileError: There are none.
        FormatError: A file is not what its format allows.
    """
    if place.suffix.lower() == BUNDLER or (place / IMAGES).exists():
        whole = read_model(place)
        stored = {pose: [own for own in whole if own.parts[-2:-1] == (pose,)] for pose in poses}
        bare = [own for own in whole if own.parts[-2:-1] not in [(pose,) for pose in poses]]
        names = Counter(file.name for files in poses.values() for file in files)
        twice = next((own for own in bare if names[own.parts[-1]] > 1), None)
        if twice is not None and not fixed:
            raise CaptureError(
                f"{twice.file}: {twice.parts[-1]} is a photograph of several poses; give a model "
                "for each in a folder named as the pose, or say that cameras stay with --rig fixed"
            )
        stored = {pose: [*own, *bare] for pose, own in stored.items()}
    else:
        found = {pose: [place / pose, place / f"{pose}{BUNDLER}"] for pose in poses}
        stored = {
            pose: read_model(files[not (files[0] / IMAGES).exists()])
            for pose, files in found.items()
            if (files[0] / IMAGES).exists() or files[1].exists()
        }
    cameras: dict[str, Given] = {}
    for pose in [neutral] if fixed else poses:
        files = {file.name: file for file in poses[pose]}
        own = {each.parts[-1]: each for each in stored.get(pose, ()) if each.parts[-1] in files}
        if 0 < len(own) < FEWEST:
            raise CaptureError(
                f"{place}: of the {len(files)} photographs of pose {pose!r} it has the cameras of "
                f"{len(own)}, at least {FEWEST} are needed"
            )
        if own:
            cameras[pose] = _cameras(own, files)
    if not cameras:
        named = next((each.name for own in stored.values() for each in own), None)
        raise FileError(
            place,
            "there are no cameras in it: expected cameras.txt and images.txt of COLMAP, a file of "
            f"Bundler ({BUNDLER}), or one of these for each pose and named as it"
            if named is None
            else f"it has cameras of other photographs, such as {named}, and none of {neutral!r}",
        )
    return cameras


def _cameras(stored: Mapping[str, Stored], files: Mapping[str, Path]) -> Given:
    """The cameras of photographs as they are seen upright: twice where a file may mean either.

    Other programs mostly solve the pixels as they are stored, whatever EXIF says of how they were
    turned. Where sizes do not tell, the photographs will.
    """
    sizes = {}
    for name in (name for name in files if name in stored):
        with suppress(FormatError):  # left out by its name when photographs are looked at
            sizes[name] = upright_size(files[name])
    ways: list[tuple[Camera, ...]] = []
    problems: list[CaptureError] = []
    turned = any(orientation in _TURNS for _, orientation in sizes.values())
    for turns in ([_TURNS] if turned else []) + [{}]:
        try:
            ways.append(
                tuple(
                    _turned(stored[name], name, size, turns.get(orientation))
                    for name, (size, orientation) in sizes.items()
                )
            )
        except CaptureError as error:
            problems.append(error)
    if not ways:
        raise problems[-1]
    return tuple(ways)


def _turned(
    stored: Stored, name: str, size: tuple[int, int], turn: Sequence[Sequence[int]] | None
) -> Camera:
    """The camera of a photograph upright, from that of pixels that are turned by (2, 2) to it."""
    if turn is None:
        return stored.camera(name, size)
    camera = stored.camera(name, size if turn[0][0] else size[::-1])
    middle, goal = ((np.array(each) - 1) / 2 for each in (camera.size, size))
    whole = np.eye(3)
    whole[:2, :2] = turn
    return replace(
        camera,
        size=size,
        centre=whole[:2, :2] @ (camera.centre - middle) + goal,
        rotation=whole @ camera.rotation,
        translation=whole @ camera.translation,
    )


def write_colmap(folder: Path, cameras: Sequence[Camera], points: Points) -> None:
    """Write a text model of COLMAP into a folder, which is made.

    Raises:
        FileError: A file cannot be written.
    """
    from scipy.spatial.transform import Rotation

    made_folder(folder)
    lenses: dict[str, int] = {}
    images = ["# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then what is seen in it"]
    for number, camera in enumerate(cameras, start=1):
        lens = _text(*camera.size, camera.focal, *(camera.centre + 0.5), camera.radial)
        own = lenses.setdefault(f"SIMPLE_RADIAL {lens}", len(lenses) + 1)
        x, y, z, w = Rotation.from_matrix(camera.rotation).as_quat()
        images += [f"{number} {_text(w, x, y, z, *camera.translation)} {own} {camera.name}", ""]
    _write(folder / IMAGES, images)
    _write(folder / LENSES, ["# CAMERA_ID MODEL WIDTH HEIGHT PARAMS", *_numbered(lenses)])
    grey = [f"{_text(*point)} 128 128 128 0" for point in points]
    _write(folder / POINTS, ["# POINT3D_ID X Y Z R G B ERROR TRACK", *_numbered(grey)])


def write_bundler(file: Path, cameras: Sequence[Camera], points: Points) -> None:
    """Write a file of Bundler v0.3, and the list of its photographs beside it.

    Raises:
        CaptureError: The centre of a lens is not the middle of its photograph, as it is there.
        FileError: A file cannot be written.
    """
    lines = ["# Bundle file v0.3", f"{len(cameras)} {len(points)}"]
    for camera in cameras:
        off = abs(camera.centre - (np.array(camera.size) - 1) / 2).max()
        if off > 1e-6:
            raise CaptureError(
                f"{file}: the axis of {camera.name} is {off:.1f} px off the middle of the "
                "photograph, which Bundler's files cannot say; write a model of COLMAP"
            )
        rotation = _TURN[:, None] * camera.rotation
        lines.append(_text(camera.focal, camera.radial, 0))
        lines += [_text(*row) for row in (*rotation, _TURN * camera.translation)]
    for point in points:
        lines += [_text(*point), "128 128 128", "0"]
    _write(file, lines)
    _write(file.with_suffix(".list.txt"), [camera.name for camera in cameras])


def _numbered(rows: Iterable[str]) -> Iterator[str]:
    return (f"{number} {row}" for number, row in enumerate(rows, start=1))


def _text(*values: float) -> str:
    return " ".join(repr(value) if type(value) is int else repr(float(value)) for value in values)


def _write(file: Path, lines: Sequence[str]) -> None:
    with replacing(file) as opened:
        opened.write("".join(f"{line}\n" for line in lines).encode())


def _lines(file: Path) -> Iterator[tuple[int, str]]:
    return iter(enumerate(read_bytes(file).decode("utf-8", "replace").splitlines(), start=1))


def _finite(words: Sequence[str]) -> list[float]:
    values = [float(word) for word in words]
    if not all(map(math.isfinite, values)):
        raise ValueError
    return values


@contextmanager
def _refusing(file: Path, line: int | None, expected: str) -> Iterator[None]:
    """Say what was expected where something else is found."""
    try:
        yield
    except (ValueError, KeyError, IndexError):
        raise FormatError(file, f"expected {expected}", line=line) from None


# The solved cameras of one pose, and what was found of its surface on the way.


@dataclass(frozen=True, eq=False)
class SolvedPose:
    """Cameras and points of one pose, in a frame and a unit of their own.

    Attributes:
        cameras: those found, in the order of the photographs' names.
        points: (N, 3) seen by at least three photographs.
        descriptors: (N, 128) float32 of length 1, mean look of each point.
        reprojection: photograph → mean distance of its features from where their points are
            seen, px.
        rejected: photograph → why it is not used.
        lenses: photograph → what took it; the same text, the same lens.
        remarks: sentences about what is unusual without being an error.
    """

    cameras: tuple[Camera, ...]
    points: NDArray[np.float64]
    descriptors: NDArray[np.float32]
    reprojection: Mapping[str, float]
    rejected: Mapping[str, str] = field(default_factory=dict)
    lenses: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
