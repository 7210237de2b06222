"""Landmarks of templates that nobody needs to pick: our own head, and ICT FaceKit's.

Three sets of points: the few that people click on, the 68 of face trackers, and MediaPipe's 478.
Our own head is ICT FaceKit's, so both have the same.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io.atomic import is_file, read_bytes
from elastomorph.model.mesh import Mesh

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
    content = (files("elastomorph.capturing.landmarks") / "sets.json").read_text(encoding="utf-8")
    return tuple(json.loads(content))
