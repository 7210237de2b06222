"""Landmarks of templates that nobody needs to pick: our own head, and ICT FaceKit's.

Three sets of points: the few that people click on, the 68 of face trackers, and MediaPipe's 478.
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

_BUILT_IN: Mapping[str, int] = {
    "nose_tip": 476,
    "right_eye_outer": 3617,
    "right_eye_inner": 3630,
    "left_eye_inner": 1575,
    "left_eye_outer": 1562,
    "nose_bridge": 318,
    "right_nostril": 2684,
    "left_nostril": 574,
    "mouth_right": 4016,
    "mouth_left": 1968,
    "upper_lip": 1959,
    "lower_lip": 1977,
    "chin": 912,
    "right_jaw": 2864,
    "left_jaw": 763,
}

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
_LISTS, _LIST = "vertex_indices.json", "idx_to_landmark_verts"

# The same 68 points among MediaPipe's 478.
_68_OF_478 = (
    162, 234, 93, 58, 172, 136, 149, 148, 152, 377, 378, 365, 397, 288, 323, 454, 389,
    71, 63, 105, 66, 107, 336, 296, 334, 293, 301,
    168, 197, 5, 4, 75, 97, 2, 326, 305,
    33, 160, 158, 133, 153, 144, 362, 385, 387, 263, 373, 380,
    61, 39, 37, 0, 267, 269, 291, 405, 314, 17, 84, 181,
    78, 82, 13, 312, 308, 317, 14, 87,
)  # fmt: skip
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
    from elastomorph.samples import head

    if points not in POINT_SETS:
        raise ParameterError(f"points are {', '.join(POINT_SETS)}, found {points!r}")
    ours = len(mesh.vertices) == len(head().vertices) and mesh.faces == head().faces
    if ours and points == "clicks":
        return dict(_BUILT_IN)
    file = template if mesh.source is None else mesh.source.path
    lists = Path(file).parent / _LISTS
    listed = _listed(lists, mesh) if not ours and is_file(lists) else {}
    dense = _mediapipe(len(mesh.vertices)) if ours or listed else ()
    if points == "mediapipe":
        return {str(number): vertex for number, vertex in enumerate(dense)}
    if ours:
        return {str(number): dense[place] for number, place in enumerate(_68_OF_478)}
    if points == "68":
        return listed
    return {name: listed[str(number)] for name, number in _OF_68.items() if listed}


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
def _mediapipe(vertices: int) -> tuple[int, ...]:
    """MediaPipe's points on the neutral of a known head with so many vertices, else none.

    Found on its pictures by the model itself, see ``tools/find_landmark_sets.py``.
    """
    content = (files("elastomorph.capturing.landmarks") / "sets.json").read_text(encoding="utf-8")
    return tuple(json.loads(content).get(str(vertices), ()))
