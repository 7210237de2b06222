"""Named points of a face, and distances that were measured on it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Camera, Similarity, fit_similarity, nearest_to_lines
from elastomorph.errors import CaptureError, FileError, FormatError, ParameterError
from elastomorph.io.atomic import is_file, read_bytes, replacing
from elastomorph.model.mesh import Mesh

# Named points of a face, on a template, in photographs and on scans, and their file.
#
# The file is JSON:
#
#     {"version": 1,
#      "vertices": {"nose_tip": 2010, …},                                 of the template, from 0
#      "photographs": {"neutral": {"IMG_01.jpg": {"nose_tip": [x, y], …}, …}},
#      "points": {"scan.ply": {"nose_tip": [x, y, z], …}},
#      "distances": [["ruler_start", "ruler_end", 10.0], …]}              in the template's unit
#
# Photographs stand under the pose that they are of. Pixels are those of the photograph held
# upright as its EXIF data says, pixel centres at integers. Distances are optional, and between
# landmarks or any other names that are clicked in photographs. Photographs alone have no scale:
# without a distance a subject is as large as the template by its landmarks; with distances l
# between points that are d apart in the unit of the photographs, the factor is that of least
# squares, f = Σ d l / Σ d². `left` and `right` are the subject's own.

_DISAGREE = 0.05
_FARTHEST_FROM_TEMPLATE = 2.0

Points = NDArray[np.float64]

Distance = tuple[str, str, float]
"""Two points by their names, and how far they are from each other."""

# The points that are asked for, in the order in which they are easiest to place.
LANDMARKS: Mapping[str, str] = {
    "nose_tip": "the tip of the nose",
    "right_eye_outer": "the outer corner of the right eye",
    "right_eye_inner": "the inner corner of the right eye, beside the nose",
    "left_eye_inner": "the inner corner of the left eye, beside the nose",
    "left_eye_outer": "the outer corner of the left eye",
    "nose_bridge": "the deepest point of the bridge of the nose, between the eyes",
    "right_nostril": "where the right wing of the nose meets the lip",
    "left_nostril": "where the left wing of the nose meets the lip",
    "mouth_right": "the right corner of the mouth",
    "mouth_left": "the left corner of the mouth",
    "upper_lip": "the middle of the upper edge of the upper lip",
    "lower_lip": "the middle of the lower edge of the lower lip",
    "chin": "the lowest point of the chin, in the middle",
    "right_jaw": "the corner of the jaw below the right ear",
    "left_jaw": "the corner of the jaw below the left ear",
}

# A landmark this much farther off than the middle one, and than this part of the face, is wrong.
_OUTLIER, _OFF = 6.0, 0.12
# Those that nothing on the skin tells, and that people place differently, may be twice as far off.
_VAGUE = ("right_jaw", "left_jaw")


@dataclass(frozen=True, eq=False)
class Landmarks:
    """What one file holds; any of it may be empty.

    Attributes:
        vertices: landmark → vertex of the template.
        photographs: pose → photograph → landmark → (x, y) in pixels.
        points: scan → landmark → (x, y, z) in its units.
        distances: that were measured, in the units of the template.
    """

    vertices: Mapping[str, int] = field(default_factory=dict)
    photographs: Mapping[str, Mapping[str, Mapping[str, tuple[float, float]]]] = field(
        default_factory=dict
    )
    points: Mapping[str, Mapping[str, tuple[float, float, float]]] = field(default_factory=dict)
    distances: tuple[Distance, ...] = ()


def read_landmarks(path: str | Path) -> Landmarks:
    """Read a file of landmarks.

    Raises:
        FileError: it cannot be read.
        FormatError: it is not of the form above.
    """
    return parse_landmarks(path, read_bytes(path))


def parse_landmarks(path: str | Path, content: bytes) -> Landmarks:
    """What the content of a file of landmarks says; errors name the file as `path`."""
    try:
        found = json.loads(content)
    except (ValueError, RecursionError) as problem:
        raise FormatError(path, f"it is not JSON: {problem}") from problem
    if not isinstance(found, dict) or found.get("version") != 1:
        raise FormatError(path, 'it is no file of landmarks: expected {"version": 1, …}')
    vertices = _table(path, "vertices", found.get("vertices", {}))
    for name, vertex in vertices.items():
        if type(vertex) is not int or vertex < 0:
            raise FormatError(path, f"vertices: {name} is {vertex!r}, expected a vertex, 0 or more")
    photographs = _table(path, "photographs", found.get("photographs", {}))
    points = _table(path, "points", found.get("points", {}))
    return Landmarks(
        vertices,
        {
            pose: {
                photograph: _places(path, f"{pose}, {photograph}", places, 2)
                for photograph, places in _table(path, pose, seen).items()
            }
            for pose, seen in photographs.items()
        },
        {scan: _places(path, scan, places, 3) for scan, places in points.items()},
        _distances(path, found.get("distances", [])),
    )


def write_landmarks(path: str | Path, landmarks: Landmarks) -> None:
    """Write a file of landmarks, whole or not at all.

    Raises:
        FileError: it cannot be written.
    """
    content = {
        "version": 1,
        "vertices": dict(landmarks.vertices),
        "photographs": landmarks.photographs,
        "points": landmarks.points,
        **({"distances": landmarks.distances} if landmarks.distances else {}),
    }
    with replacing(path) as file:
        file.write(json.dumps(content, indent=1).encode() + b"\n")


def triangulated(
    clicks: Mapping[str, Mapping[str, tuple[float, float]]], cameras: Mapping[str, Camera]
) -> tuple[dict[str, Points], dict[str, float]]:
    """Points in space from clicks in photographs.

    Args:
        clicks: photograph → landmark → (x, y) in pixels of the photograph as taken.
        cameras: of the photographs; those without one are passed over.

    Returns:
        Landmark → (3,) the point nearest to its rays, and landmark → the root mean square distance
        of its clicks from it in pixels. Landmarks of a single photograph are left out.
    """
    rays: dict[str, list[tuple[Camera, Points]]] = {}
    for photograph, places in clicks.items():
        if (camera := cameras.get(photograph)) is not None:
            for name, place in places.items():
                pixel = camera.undistorted(np.array(place, dtype=np.float64))
                rays.setdefault(name, []).append((camera, pixel))
    points: dict[str, Points] = {}
    residuals: dict[str, float] = {}
    for name, seen in rays.items():
        if len(seen) < 2:
            continue
        ways = np.array([camera.through(pixel) for camera, pixel in seen])
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        points[name] = nearest_to_lines(np.array([camera.position for camera, _ in seen]), ways)
        squares = [((camera.project(points[name])[0] - pixel) ** 2).sum() for camera, pixel in seen]
        residuals[name] = float(np.sqrt(np.mean(squares)))
    return points, residuals


def fit_landmarks(
    template: Mapping[str, Points], found: Mapping[str, Points], where: str
) -> Similarity:
    """The similarity from landmarks of a template to the same ones elsewhere, told apart by name.

    Args:
        template: landmark → (3,) on the template.
        found: landmark → (3,) on a scan or from photographs.
        where: they were found, for messages.

    Raises:
        CaptureError: fewer than four in common, left and right exchanged, or one far off.
    """
    names = [name for name in template if name in found]
    if len(names) < 4:
        raise CaptureError(
            f"{where}: {len(names)} landmarks are also on the template, expected at least 4;"
            " place more with 'elastomorph landmarks'"
        )
    source = np.array([template[name] for name in names])
    goal = np.array([found[name] for name in names])
    similarity = fit_similarity(source, goal)
    errors = np.linalg.norm(similarity(source) - goal, axis=1)
    free = fit_similarity(source, goal, mirrored=True)
    mirrored = np.linalg.norm(free(source) - goal, axis=1)
    if np.square(mirrored).sum() < 0.25 * np.square(errors).sum():
        raise CaptureError(
            f"{where}: the landmarks fit the template only when mirrored: left and right are the"
            " subject's own, and a mirrored scan has to be mirrored back first"
        )
    if len(names) >= 6:
        _require_no_outlier(names, source, goal, int(errors.argmax()), where)
    return similarity


def _require_no_outlier(
    names: list[str], source: Points, goal: Points, doubted: int, where: str
) -> None:
    """Refuse a landmark that is far from where all the others put it."""
    rest = np.arange(len(names)) != doubted
    off = np.linalg.norm(fit_similarity(source[rest], goal[rest])(source) - goal, axis=1)
    size = np.linalg.norm(np.ptp(goal, axis=0))
    most = 2 * _OFF if names[doubted] in _VAGUE else _OFF
    if off[doubted] > max(_OUTLIER * np.median(off[rest]), most * size):
        raise CaptureError(
            f"{where}: landmark {names[doubted]} is {off[doubted] / size:.0%} of the face away"
            " from where the others put it: place it again"
        )


def _table(path: str | Path, where: str, found: object) -> dict[str, Any]:
    if not isinstance(found, dict):
        raise FormatError(path, f"{where} is {type(found).__name__}, expected names and places")
    return found


def _distances(path: str | Path, found: object) -> tuple[Distance, ...]:
    if not isinstance(found, list):
        raise FormatError(path, "distances are [name, name, length] each")
    distances = []
    for each in found:
        whole = isinstance(each, list) and [type(part) for part in each[:2]] == [str, str]
        if not whole or len(each) != 3 or type(each[2]) not in (int, float):
            raise FormatError(path, f"distances: {each!r}, expected [name, name, length]")
        one, other, length = each
        if one == other or not 0 < length < np.inf:
            raise FormatError(
                path, f"distances: {one} to {other} is {length}, expected a length above 0"
            )
        distances.append((one, other, float(length)))
    return tuple(distances)


def _places(path: str | Path, where: str, found: object, size: int) -> dict[str, Any]:
    places = _table(path, where, found)
    for name, place in places.items():
        whole = isinstance(place, list) and len(place) == size
        if not whole or not all(type(x) in (int, float) and np.isfinite(x) for x in place):
            raise FormatError(path, f"{where}: {name} is {place!r}, expected {size} numbers")
    return {name: tuple(map(float, place)) for name, place in places.items()}


def factor_of(points: Mapping[str, Points], distances: Sequence[Distance], where: str) -> float:
    """Units of the measured distances in one unit of the photographs.

    Args:
        points: Name → (3,) in the unit of the photographs.
        distances: Names of two points and how far they are from each other.
        where: The photographs are from, for messages.

    Raises:
        CaptureError: None of the distances is between points that are known, or they contradict
            each other.
    """
    known = [(one, other, length) for one, other, length in distances if {one, other} <= {*points}]
    if not known:
        one, other, _ = distances[0]
        raise CaptureError(
            f"{where}: the distance from {one} to {other} is given, but not both are clicked in "
            "two photographs, or cameras that were found; place them, or take the distance out of "
            "the landmarks"
        )
    found = np.array([float(np.linalg.norm(points[a] - points[b])) for a, b, _ in known])
    given = np.array([length for _, _, length in known])
    if (found <= 0).any():
        raise CaptureError(f"{where}: two points a distance apart are clicked at the same place")
    factor = float(found @ given / (found @ found))
    off = np.abs(factor * found / given - 1)
    worst = int(off.argmax())
    if off[worst] > _DISAGREE:
        one, other, length = known[worst]
        raise CaptureError(
            f"{where}: by the other distances {one} and {other} are {factor * found[worst]:.3g} "
            f"apart and not {length:g}; measure or click them again"
        )
    return factor


def fit_to_scale(
    template: Mapping[str, Points],
    found: Mapping[str, Points],
    distances: Sequence[Distance],
    where: str,
) -> Similarity:
    """The similarity that brings photographs to a template; its scale by distances if there are.

    Args:
        template: Landmark → (3,) on the template.
        found: Landmark, end of a ruler or camera → (3,) in the unit of the photographs.
        distances: In the unit of the template.
        where: The photographs are from, for messages.

    Raises:
        CaptureError: The landmarks or the distances cannot be right.
    """
    similarity = fit_landmarks(template, found, where).inverse()
    if not distances:
        return similarity
    factor = factor_of(found, distances, where)
    larger = factor / similarity.scale
    if not 1 / _FARTHEST_FROM_TEMPLATE < larger < _FARTHEST_FROM_TEMPLATE:
        raise CaptureError(
            f"{where}: by the distances given, the face is {larger:.3g} times as large as the "
            "template; give them in the template's unit"
        )
    names = [name for name in template if name in found]
    source = factor * np.array([found[name] for name in names])
    rigid = fit_similarity(source, np.array([template[name] for name in names]), rigid=True)
    return Similarity(factor, rigid.rotation, rigid.shift)


# Landmarks of templates that nobody needs to pick: our own head, and ICT FaceKit's.
#
# Three sets of points: the few that people click on, the 68 of face trackers, and MediaPipe's
# 478. Our own head is ICT FaceKit's, so both have the same.

# Of the 68 points that face trackers number: the jaw from the subject's right ear to the left,
# brows, nose, eyes, lips.
_OF_68: Mapping[str, int] = {
    "nose_tip": 30,
    "right_eye_outer": 36,
    "right_eye_inner": 39,
    "left_eye_inner": 42,
    "left_eye_outer": 45,
    "nose_bridge": 27,
    "right_nostril": 31,
    "left_nostril": 35,
    "mouth_right": 48,
    "mouth_left": 54,
    "upper_lip": 51,
    "lower_lip": 57,
    "chin": 8,
    "right_jaw": 3,
    "left_jaw": 13,
}
_OF_ICT = 26_719  # vertices of the whole neutral
_LISTS, _LIST = "vertex_indices.json", "idx_to_landmark_verts"

POINT_SETS = ("clicks", "68", "mediapipe")
"""Sets of points by name."""


def known_landmarks(template: str | Path, mesh: Mesh, points: str = "clicks") -> dict[str, int]:
    """Landmarks that come with a template, landmark → vertex; empty where none do.

    They are those of our own head for every mesh with its polygons, and for other files those of
    ``vertex_indices.json`` beside them, where that lists the 68 points of ICT FaceKit.

    Args:
        template: The file or rig, or what names our own head.
        mesh: What was read from it.
        points: ``clicks``, by names; ``68``, of face trackers, or ``mediapipe``, by numbers.

    Raises:
        ParameterError: There is no such set.
        FormatError: The list beside the file names vertices that the template does not have.
    """
    from elastomorph.samples import head, landmarks

    if points not in POINT_SETS:
        raise ParameterError(f"points are {', '.join(POINT_SETS)}, found {points!r}")
    ours = len(mesh.vertices) == len(head().vertices) and mesh.faces == head().faces
    if ours:
        listed = {str(number): vertex for number, vertex in enumerate(landmarks())}
    else:
        file = template if mesh.source is None else mesh.source.path
        lists = Path(file).parent / _LISTS
        listed = _listed(lists, mesh) if is_file(lists) else {}
    if points == "68" or not listed:
        return listed
    if points == "mediapipe":
        dense = _mediapipe() if ours or len(mesh.vertices) == _OF_ICT else ()
        return {str(number): vertex for number, vertex in enumerate(dense)}
    return {name: listed[str(number)] for name, number in _OF_68.items()}


def _listed(lists: Path, mesh: Mesh) -> dict[str, int]:
    try:
        found = json.loads(read_bytes(lists))
    except (ValueError, RecursionError, FileError):
        return {}
    vertices = found.get(_LIST) if isinstance(found, dict) else None
    if not isinstance(vertices, list) or len(vertices) != 68:
        return {}
    for vertex in vertices:
        if type(vertex) is not int or not 0 <= vertex < len(mesh.vertices):
            raise FormatError(
                lists,
                f"{_LIST} names vertex {vertex!r} of a template with {len(mesh.vertices):,}; move "
                "the list away from a template that it is not of",
            )
    return {str(number): vertex for number, vertex in enumerate(vertices)}


@cache
def _mediapipe() -> tuple[int, ...]:
    """The vertices of MediaPipe's points on our own head, which ICT FaceKit numbers alike.

    Found on its pictures by the model itself, see ``tools/find_landmark_sets.py``.
    """
    content = (files("elastomorph.capturing") / "landmark_sets.json").read_text(encoding="utf-8")
    return tuple(json.loads(content))


# Where landmarks are on a face, roughly: which way it looks, how large it is, if it is one.


# Towards the subject's left, up and out of the face; their root mean square is 1.
_TYPICAL: Mapping[str, tuple[float, float, float]] = {
    "nose_tip": (0.0, 0.15, 0.68),
    "right_eye_outer": (-0.85, 0.79, -0.13),
    "right_eye_inner": (-0.33, 0.76, -0.06),
    "left_eye_inner": (0.33, 0.76, -0.06),
    "left_eye_outer": (0.85, 0.79, -0.13),
    "nose_bridge": (0.0, 0.85, 0.23),
    "right_nostril": (-0.25, -0.11, 0.26),
    "left_nostril": (0.25, -0.11, 0.26),
    "mouth_right": (-0.48, -0.51, 0.14),
    "mouth_left": (0.48, -0.51, 0.14),
    "upper_lip": (0.0, -0.37, 0.43),
    "lower_lip": (0.0, -0.69, 0.36),
    "chin": (0.0, -1.28, 0.16),
    "right_jaw": (-1.18, -0.25, -1.13),
    "left_jaw": (1.18, -0.25, -1.13),
}
_FEWEST, _FEWEST_IN_PHOTOGRAPH = 4, 6
# Root mean square distance from the typical face, of one, above which landmarks are on no face.
# Two heads that differ much are 0.15 from it; the landmarks in any other order 0.5 and more.
_NO_FACE = 0.35
# Cosine to the front from which on it is certain which side of a face is seen.
_SIDEWAYS = 0.3


def typical_face(points: Mapping[str, Points], where: str) -> Similarity:
    """The similarity from a typical face to landmarks.

    The typical face has its middle at the origin and a size of 1; x points to the subject's left,
    y up and z out of the face.

    Args:
        points: landmark → (3,).
        where: they are, for messages.

    Raises:
        CaptureError: Fewer than four landmarks, left and right exchanged, or no face.
    """
    names = [name for name in _TYPICAL if name in points]
    if len(names) < _FEWEST:
        raise CaptureError(
            f"{where}: {len(names)} landmarks, expected at least {_FEWEST}; place more with "
            "'elastomorph landmarks'"
        )
    typical = np.array([_TYPICAL[name] for name in names])
    goal = np.array([points[name] for name in names])
    found = fit_similarity(typical, goal)
    off = _distance(found, typical, goal)
    mirrored = _distance(fit_similarity(typical, goal, mirrored=True), typical, goal)
    if mirrored < off / 2:
        raise CaptureError(
            f"{where}: the landmarks are those of a mirrored face: left and right are the "
            "subject's own"
        )
    if off > _NO_FACE:
        raise CaptureError(
            f"{where}: the landmarks do not lie as on a face (they are {off:.0%} of its size from "
            "where they should be): check their names, and that this is a face"
        )
    return found


def require_sides(places: Mapping[str, tuple[float, float]], where: str) -> None:
    """Refuse landmarks of a photograph in which left and right are exchanged.

    A camera far away takes points X to A X + b. Whether it stands before the face or, as it seems
    where sides are exchanged, within the head is the sign of the rows of A, crossed.

    Args:
        places: landmark → (x, y) in pixels.
        where: they are, for messages.

    Raises:
        CaptureError: They are exchanged.
    """
    names = [name for name in _TYPICAL if name in places]
    if len(names) < _FEWEST_IN_PHOTOGRAPH:
        return
    typical = np.array([_TYPICAL[name] for name in names])
    seen = np.array([places[name] for name in names], dtype=np.float64)
    matrix = np.linalg.lstsq(typical - typical.mean(axis=0), seen - seen.mean(axis=0))[0]
    towards = np.cross(matrix[:, 0], matrix[:, 1])
    if towards[2] > _SIDEWAYS * np.linalg.norm(towards) > 0:
        raise CaptureError(
            f"{where}: left and right of the landmarks are exchanged: they are the subject's own, "
            "so that the left eye is on the right of a photograph; place them again"
        )


def _distance(found: Similarity, typical: Points, goal: Points) -> float:
    """Root mean square distance in sizes of the typical face."""
    return float(np.sqrt(((found(typical) - goal) ** 2).sum(axis=1).mean()) / found.scale)
