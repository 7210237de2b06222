"""What is asked for, looked at before any long work: each thing that cannot be is one sentence.

Where results go, looked at before any work; nothing is made there until all else is known.

A distance on the subject as it is given with a command.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from os import PathLike
from pathlib import Path

from elastomorph.capturing.cameras.models import Given, given_cameras
from elastomorph.capturing.landmarks import (
    LANDMARKS,
    Distance,
    Landmarks,
    read_landmarks,
    require_sides,
    typical_face,
)
from elastomorph.capturing.photographs import find_masks, find_poses, upright_size
from elastomorph.capturing.work import RIGS, TO
from elastomorph.capturing.work.captured import CAMERAS, CONFIDENCE, FIGURES
from elastomorph.capturing.work.template import Template
from elastomorph.errors import (
    CaptureError,
    FileError,
    FormatError,
    MissingExtraError,
    ParameterError,
)
from elastomorph.io.atomic import require_folder, same_file
from elastomorph.model.mesh import Mesh
from elastomorph.numbers import as_number

_FORM = "expected two points that were clicked and how far they are apart: a,b=8.9"


def distance_of(given: object) -> Distance:
    """A distance from ``("a", "b", 8.9)`` or the text ``a,b=8.9``.

    Raises:
        ParameterError: It is neither.
    """
    if isinstance(given, str):
        names, _, number = given.rpartition("=")
        try:
            given = (*(name.strip() for name in names.split(",")), float(number))
        except ValueError:
            raise ParameterError(f"distance {given!r}: {_FORM}") from None
    if not (
        isinstance(given, tuple | list)
        and len(given) == 3
        and all(isinstance(name, str) and name for name in given[:2])
        and given[0] != given[1]
    ):
        raise ParameterError(f"distance {given!r}: {_FORM}")
    return given[0], given[1], as_number(given[2], "the length of a distance", above=0.0)


def require_known(
    distance: Distance,
    clicks: Mapping[str, Mapping[str, tuple[float, float]]],
    photographs: Sequence[Path],
    file: str,
) -> None:
    """Refuse points that no two photographs have and that are no camera.

    Args:
        distance: Between them.
        clicks: Photograph → point → pixel.
        photographs: Whose cameras are points too, by the names of their files.
        file: Of the landmarks, for the message.
    """
    cameras = {path.name for path in photographs}
    for name in (own for own in distance[:2] if own not in cameras):
        count = sum(name in places for places in clicks.values())
        if count < 2:
            raise CaptureError(
                f"{file}: {name}, from which a distance is known, is in {count} photographs of the "
                "neutral; it is needed in two or more"
            )


WORKING = ".capture"

_BYTES_BEFORE, _BYTES_A_POSE = 100 << 20, 40 << 20


def folder_named(named: object, what: str) -> Path:
    """A folder that is named by an argument.

    Raises:
        ParameterError: It names none.
    """
    if not isinstance(named, str | PathLike) or str(named) == "":
        raise ParameterError(f"{what} must name a folder, found {named!r}")
    return Path(named)


def require_place(
    output: Path, working: Path, poses: Mapping[str, object], template: Template | None
) -> None:
    """Refuse folders that cannot be written in, hold something else, or have too little room.

    Args:
        output: Of the result.
        working: Of what stages leave.
        poses: What is written of each.
        template: That is not written over.

    Raises:
        FileError: And what to do.
    """
    source = None if template is None else template.mesh.source
    for file in () if source is None else _meshes(output, poses):
        if source is not None and same_file(file, source.path):
            raise FileError(
                file,
                "it is the template, over which the pose would be written; name another output",
            )
    require_folder(output)
    _require_own(output, working, poses)
    needed = _BYTES_BEFORE + _BYTES_A_POSE * len(poses)
    free = shutil.disk_usage(require_folder(working)).free
    if free < needed:
        raise FileError(
            working,
            f"{free >> 20:,} MiB are free on its disk, about {needed >> 20:,} are needed: make "
            "room, or name another working folder",
        )


def _require_own(output: Path, working: Path, poses: Mapping[str, object]) -> None:
    """Refuse an output in which files of something else are, or would be written over."""
    there = (file for file in output.glob("*.obj") if not file.name.startswith("."))
    strange = sorted(file.name for file in there if file.stem not in poses)
    if strange:
        raise FileError(
            output,
            f"{strange[0]} is already there and is none of the poses; delete it, or name another "
            "output",
        )
    if working.exists() or (output / FIGURES).exists():  # of an earlier run
        return
    for file in (*_meshes(output, poses), output / CONFIDENCE, output / CAMERAS):
        if file.exists():
            raise FileError(
                file,
                "it is already there and not from a capture; move it away, or name another output",
            )


def _meshes(output: Path, poses: Mapping[str, object]) -> list[Path]:
    return [output / f"{pose}{suffix}" for suffix in (".obj", ".glb", ".mtl") for pose in poses]


LANDMARKS_FILE = "landmarks.json"

_LIBRARIES = (
    ("pycolmap", "pycolmap"),
    ("cv2", "opencv-python-headless"),
    ("embreex", "embreex"),
    ("PIL", "pillow"),
)
_FEWEST_LANDMARKS = 6


@dataclass(frozen=True, eq=False)
class Request:
    """What is to be made, of what.

    Attributes:
        poses: Pose → files of its photographs, in the order of the movement.
        masks: Photograph → file of its mask.
        neutral: Name of the pose that is the neutral.
        template: Whose vertices the poses get; None for cameras alone.
        landmarks: On the template and in photographs of the neutral.
        output: Folder of the result.
        working: Folder of what stages leave.
        rig: Of ``RIGS``: whether cameras stand elsewhere for each pose or stay.
        to: Of ``TO``: what is made.
        cameras: Pose → the cameras of its photographs, where they are given.
    """

    poses: Mapping[str, tuple[Path, ...]]
    masks: Mapping[Path, Path]
    neutral: str
    template: Template | None
    landmarks: Landmarks
    output: Path
    working: Path
    rig: str
    to: str
    cameras: Mapping[str, Given] = field(default_factory=dict)

    @property
    def chain(self) -> dict[str, str]:
        """Pose → the pose from which it is reached: its neighbour on the side of the neutral."""
        names = list(self.poses)
        middle = names.index(self.neutral)
        after = {names[k]: names[k - 1] for k in range(middle + 1, len(names))}
        return after | {names[k]: names[k + 1] for k in range(middle - 1, -1, -1)}


def requested(
    photos: object,
    template: object,
    *,
    output: object,
    neutral: str | None,
    landmarks: object,
    distance: object,
    rig: str,
    masks: object,
    to: str,
    working: object,
    cameras: object = None,
) -> Request:
    """What is asked for, where all of it can be.

    Raises:
        ElastomorphError: Something cannot be; each is one sentence that says what to do.
    """
    if to not in TO:
        raise ParameterError(f"to must be cameras, neutral or poses, found {to!r}")
    if rig not in RIGS:
        raise ParameterError(f"rig must be walking or fixed, found {rig!r}")
    _require_libraries()
    poses = _poses(photos)
    name = _neutral(neutral, poses)
    if neutral is None and not isinstance(photos, Mapping):
        poses = {name: poses[name], **poses}  # where its name stands in the alphabet means nothing
    if to == "poses" and len(poses) < 2:
        raise CaptureError(
            f"there are photographs of one pose only, {name}: put each pose into a folder of its "
            "own, or ask for this one alone with to='neutral' (--to neutral)"
        )
    shape, points = None, Landmarks()
    known = _distance(distance, to)
    if to != "cameras":
        shape = _template(template)
        if landmarks is None and isinstance(photos, str | PathLike):
            beside = Path(photos) / LANDMARKS_FILE
            landmarks = beside if beside.is_file() else None
        points = _landmarks(landmarks, name, poses[name], shape)
        if known is not None:
            require_known(known, points.photographs[name], poses[name], "the landmarks")
            points = replace(points, distances=(known,))
        face = {mark: shape.work.vertices[own] for mark, own in points.vertices.items()}
        shape = shape.facing(typical_face(face, "the template"))
    place = folder_named(output, "output")
    own = place / WORKING if working is None else folder_named(working, "working")
    of_masks = {} if masks is None else find_masks(folder_named(masks, "masks"), poses)
    given = {} if cameras is None else _cameras(cameras, place, poses, name, rig)
    require_place(place, own, poses, shape)
    return Request(
        poses=poses,
        masks=of_masks,
        neutral=name,
        template=shape,
        landmarks=points,
        output=place,
        working=own,
        rig=rig,
        to=to,
        cameras=given,
    )


def _cameras(
    named: object, output: Path, poses: Mapping[str, tuple[Path, ...]], neutral: str, rig: str
) -> dict[str, Given]:
    place = folder_named(named, "cameras")
    if not place.exists():
        raise FileError(place, "there is no such folder or file of cameras")
    if (output / CAMERAS).resolve() in (place.resolve(), *place.resolve().parents):
        raise FileError(place, "cameras of this capture are written there; name another output")
    return given_cameras(place, poses, neutral, fixed=rig == "fixed")


def _distance(given: object, to: str) -> Distance | None:
    if given is not None and to == "cameras":
        raise ParameterError(
            "a distance is known between landmarks, which cameras alone do without; leave it out, "
            "or ask for the neutral or the poses"
        )
    return None if given is None else distance_of(given)


def _require_libraries() -> None:
    for module, package in _LIBRARIES:
        if find_spec(module) is None:
            raise MissingExtraError(package, "capture")


def _poses(photos: object) -> dict[str, tuple[Path, ...]]:
    """Pose → files, from a folder or a mapping of poses to files or folders."""
    if isinstance(photos, str | PathLike):
        poses = find_poses(Path(photos))
    elif isinstance(photos, Mapping):
        poses = {str(pose): _files(str(pose), given) for pose, given in photos.items()}
    else:
        raise ParameterError(
            "photos must be a folder of photographs, or pose → photographs; found "
            f"{type(photos).__name__}"
        )
    if not poses:
        raise CaptureError("there are no poses: name for each the photographs of it")
    seen: dict[str, str] = {}
    for pose, files in poses.items():
        if not pose or pose != Path(pose).name or pose.startswith("."):
            raise ParameterError(f"pose {pose!r}: it names a file, so it may hold no slash or dot")
        if pose.casefold() in seen:
            raise CaptureError(
                f"poses {seen[pose.casefold()]!r} and {pose!r} would be one file: name one of them "
                "otherwise"
            )
        seen[pose.casefold()] = pose
        _require_names_apart(pose, files)
    return poses


def _files(pose: str, given: object) -> tuple[Path, ...]:
    if isinstance(given, str | PathLike):
        found = find_poses(Path(given))
        return tuple(file for files in found.values() for file in files)
    if not isinstance(given, Sequence) or not all(isinstance(x, str | PathLike) for x in given):
        raise ParameterError(f"pose {pose!r}: expected files of photographs, found {given!r}")
    files = tuple(Path(file) for file in given)
    for file in files:
        if not file.is_file():
            raise FileError(file, f"there is no such photograph of pose {pose!r}")
    return files


def _require_names_apart(pose: str, files: Sequence[Path]) -> None:
    names: dict[str, Path] = {}
    for file in files:
        if file.name in names:
            raise CaptureError(
                f"pose {pose!r}: {names[file.name]} and {file} are both called {file.name}; each "
                "photograph of a pose needs a name of its own"
            )
        names[file.name] = file


def _neutral(asked: str | None, poses: Mapping[str, object]) -> str:
    """The neutral: the pose that is named, else the one named so, else the first."""
    if asked is not None:
        if asked not in poses:
            raise ParameterError(
                f"there is no pose {asked!r} to be the neutral: there are {', '.join(poses)}"
            )
        return asked
    named = [pose for pose in poses if "neutral" in pose.lower()]
    if len(named) > 1:
        raise CaptureError(
            f"{' and '.join(named)} are both named as the neutral: say which with neutral="
            f"{named[0]!r} (--neutral)"
        )
    return named[0] if named else next(iter(poses))


def _template(named: object) -> Template:
    if named is None:
        raise CaptureError(
            "a template is needed, whose vertices the poses get: name a mesh, a rig or 'built-in' "
            "as template (--template), or ask for cameras alone with to='cameras' (--to cameras)"
        )
    if not isinstance(named, Mesh | str | PathLike):
        raise ParameterError(f"template must be a mesh or a file, found {type(named).__name__}")
    return Template.named(named if isinstance(named, Mesh | str) else Path(named))


def _landmarks(
    named: object, neutral: str, photographs: Sequence[Path], template: Template
) -> Landmarks:
    """Landmarks on the template and in the neutral's photographs, enough of them in common."""
    if named is None:
        raise CaptureError(
            "landmarks are needed to bring the template to the photographs: place them with "
            "'elastomorph landmarks' and name their file as landmarks (--landmarks)"
        )
    file = "the landmarks"
    if isinstance(named, str | PathLike):
        file, named = str(named), read_landmarks(Path(named))
    if not isinstance(named, Landmarks):
        raise ParameterError(f"landmarks must be a file of them, found {type(named).__name__}")
    vertices = {**template.known, **template.vertices_of(named.vertices, file)}
    clicks = named.photographs.get(neutral, {})
    if not clicks:
        found = ", ".join(named.photographs) or "no pose"
        raise CaptureError(
            f"{file}: there are no landmarks in photographs of the neutral {neutral!r}, only of "
            f"{found}; place them with 'elastomorph landmarks'"
        )
    there = {path.name for path in photographs}
    if strange := sorted(set(clicks) - there):
        raise CaptureError(
            f"{file}: {strange[0]} of pose {neutral!r} has landmarks, but there is no such "
            "photograph; rename it back, or place them again with 'elastomorph landmarks'"
        )
    for path in (path for path in photographs if path.name in clicks):
        where = f"{file}: {path.name} of pose {neutral!r}"
        _require_inside(clicks[path.name], path, where)
        require_sides(clicks[path.name], where)
    counts = {name: sum(name in places for places in clicks.values()) for name in LANDMARKS}
    good = [name for name in LANDMARKS if counts[name] >= 2 and name in vertices]
    if len(good) < _FEWEST_LANDMARKS:
        lacking = [name for name in LANDMARKS if name not in good]
        raise CaptureError(
            f"{file}: {len(good)} of {len(LANDMARKS)} landmarks are on the template and in two "
            f"photographs of {neutral!r} or more, at least {_FEWEST_LANDMARKS} are needed; place "
            f"{', '.join(lacking[:4])} and others with 'elastomorph landmarks'"
        )
    return replace(named, vertices=vertices)


def _require_inside(
    places: Mapping[str, tuple[float, float]], photograph: Path, where: str
) -> None:
    """Refuse points that were placed on a photograph of another size, or on its side."""
    try:
        size, _ = upright_size(photograph)
    except FormatError:
        return  # it is left out by its name when photographs are looked at
    for name, place in places.items():
        if not all(-0.5 <= x <= side - 0.5 for x, side in zip(place, size, strict=True)):
            raise CaptureError(
                f"{where}: {name} is at {place[0]:.0f}, {place[1]:.0f}, outside the photograph's "
                f"{size[0]} × {size[1]} pixels; it was reduced, cropped or turned since: place the "
                "landmarks again with 'elastomorph landmarks', or put the original back"
            )
