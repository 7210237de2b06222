"""Landmarks of templates that nobody needs to pick: our own head, and ICT FaceKit's."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import is_file, read_bytes
from elastomorph.model.mesh import Mesh

__all__ = ["known_landmarks"]

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


def known_landmarks(template: str | Path, mesh: Mesh) -> dict[str, int]:
    """Landmarks that come with a template, landmark → vertex; empty where none do.

    They are those of our own head for every mesh with its polygons, and for other files those of
    ``vertex_indices.json`` beside them, where that lists the 68 points of ICT FaceKit.

    Args:
        template: The file or rig, or what names our own head.
        mesh: What was read from it.

    Raises:
        FormatError: The list beside the file names vertices that the template does not have.
    """
    from elastomorph.samples import head

    if len(mesh.vertices) == len(head().vertices) and mesh.faces == head().faces:
        return dict(_BUILT_IN)
    file = template if mesh.source is None else mesh.source.path
    lists = Path(file).parent / _LISTS
    return _listed(lists, mesh) if is_file(lists) else {}


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
    return {name: vertices[number] for name, number in _OF_68.items()}
