"""What the page of landmarks is to do: photographs, a template and scans to place points on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from elastomorph.capturing.cameras.solved import SolvedPose
from elastomorph.capturing.geometry.camera import Camera
from elastomorph.capturing.landmarks.known_landmarks import known_landmarks
from elastomorph.capturing.landmarks.landmarks import LANDMARKS, Landmarks
from elastomorph.capturing.photographs.finding import find_poses
from elastomorph.capturing.photographs.pixels import opened_photograph
from elastomorph.capturing.work.stages import WorkingFolder
from elastomorph.capturing.work.template import read_template
from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io.atomic import is_folder
from elastomorph.io.scan_colours import dressed, vertex_colours
from elastomorph.model.mesh import Mesh
from elastomorph.viewer.surfaces import PackedSurface, pack_surface

__all__ = ["ASKED", "LandmarkPlace", "LandmarkTask", "landmark_task", "solved_cameras"]

ASKED = 3
"""Photographs that each point is asked for in."""

_SHOWN = (".jpg", ".jpeg", ".png", ".tif", ".tiff")

Kind = Literal["photograph", "template", "scan"]


@dataclass(frozen=True, eq=False)
class LandmarkPlace:
    """One thing to place points on.

    Attributes:
        kind: A photograph, the template, or a scan.
        name: Of the file, without its folder.
        pose: What a photograph is of; empty for surfaces.
        content: File of a photograph, or a surface.
        camera: That took a photograph, if it is known.
    """

    kind: Kind
    name: str
    pose: str
    content: Path | PackedSurface
    camera: Camera | None = None


@dataclass(frozen=True, eq=False)
class LandmarkTask:
    """Where points are to be placed, and those that are known already.

    Attributes:
        title: What the page is called.
        places: Photographs and surfaces, in the order of the page.
        known: Points that were placed before, also on what is not shown.
    """

    title: str
    places: tuple[LandmarkPlace, ...]
    known: Landmarks = field(default_factory=Landmarks)

    def document(self, sources: Sequence[str], images: Sequence[Sequence[str]]) -> dict[str, Any]:
        """What the page is told.

        Args:
            sources: Address of each photograph and surface.
            images: Addresses of the images of each surface.
        """
        return {
            "version": 1,
            "title": self.title,
            "names": list(LANDMARKS),
            "words": dict(LANDMARKS),
            "asked": ASKED,
            "places": [
                {
                    "kind": place.kind,
                    "name": place.name,
                    "pose": place.pose,
                    "source": source,
                    "images": list(own),
                    "camera": None if place.camera is None else _described(place.camera),
                }
                for place, source, own in zip(self.places, sources, images, strict=True)
            ],
            "known": {
                "version": 1,
                "vertices": self.known.vertices,
                "photographs": self.known.photographs,
                "points": self.known.points,
            },
        }


def landmark_task(
    files: Sequence[str | Path] = (),
    template: str | Path | None = None,
    *,
    known: Landmarks | None = None,
    cameras: Mapping[str, Sequence[Camera]] | None = None,
) -> LandmarkTask:
    """Photographs, a template and scans to place points on.

    Args:
        files: Folders of photographs, and scans: meshes of any topology.
        template: The mesh whose vertices are to be named: a file, the neutral of a rig, or
            ``built-in`` for our own head. Points that come with it are known.
        known: Points that were placed before.
        cameras: Those of the photographs by pose, where they are known.

    Raises:
        ParameterError: There is nothing to place points on, or two of one name.
        FileError: Something is not there or cannot be read.
    """
    known = known or Landmarks()
    places = [place for file in files for place in _of_file(Path(file), cameras or {})]
    if template is not None:
        mesh = dressed(read_template(template))
        _require_vertices(known.vertices, mesh)
        if not known.vertices:
            found = known_landmarks(template, mesh)
            known = replace(known, vertices=found)
        content = pack_surface(mesh, edges=True)
        places.insert(0, LandmarkPlace("template", Path(template).name, "", content))
    if not places:
        raise ParameterError(
            "there is nothing to place points on; name photographs, a scan or a template"
        )
    keys = [(place.kind, place.pose, place.name) for place in places]
    for key in keys:
        if keys.count(key) > 1:
            raise ParameterError(
                f"{key[1] or 'what is shown'} has two files called {key[2]}; rename one of them"
            )
    return LandmarkTask(_title(files, template), tuple(places), known)


def solved_cameras(working: str | Path) -> dict[str, tuple[Camera, ...]]:
    """The cameras of each pose that are solved in the working folder of a capture.

    Raises:
        FileError: There are none.
    """
    folder = WorkingFolder(Path(working))
    found: dict[str, tuple[Camera, ...]] = {}
    for file in sorted(folder.folder.glob("cameras/*.npz")):
        made = folder.known(f"cameras/{file.stem}")
        solved = None if made is None else made.read()
        if isinstance(solved, SolvedPose):
            found[file.stem] = solved.cameras
    if not found:
        raise FileError(
            working,
            "no cameras are solved in it; name the working folder of 'elastomorph capture', or "
            "place the points without it",
        )
    return found


def _of_file(path: Path, cameras: Mapping[str, Sequence[Camera]]) -> list[LandmarkPlace]:
    if not is_folder(path):
        mesh = dressed(read_template(path))
        content = pack_surface(mesh, edges=False, colours=vertex_colours(mesh))
        return [LandmarkPlace("scan", path.name, "", content)]
    poses = find_poses(path)
    if len(poses) == 1 and next(iter(poses.values()))[0].parent == path:
        # One pose of several, whose folder is its name, whatever its photographs are called.
        poses = {path.resolve().name: next(iter(poses.values()))}
    for file in (file for photographs in poses.values() for file in photographs):
        if file.suffix.lower() not in _SHOWN:
            with opened_photograph(file):
                pass  # phones' own formats are refused, with what to do
    solved = {(pose, camera.name): camera for pose, own in cameras.items() for camera in own}
    return [
        LandmarkPlace("photograph", file.name, pose, file, solved.get((pose, file.name)))
        for pose, photographs in poses.items()
        for file in photographs
    ]


def _require_vertices(vertices: Mapping[str, int], mesh: Mesh) -> None:
    for name, vertex in vertices.items():
        if vertex >= len(mesh.vertices):
            raise FormatError(
                mesh.name,
                f"the landmark {name} is vertex {vertex:,}, and this template has "
                f"{len(mesh.vertices):,} vertices; name the template that the landmarks are of",
            )


def _title(files: Sequence[str | Path], template: str | Path | None) -> str:
    names = [Path(file).resolve().name for file in files]
    names += [] if template is None else [Path(template).name]
    return " and ".join(names) if len(names) < 4 else f"{names[0]} and {len(names) - 1} others"


def _described(camera: Camera) -> dict[str, Any]:
    return {
        "focal": camera.focal,
        "centre": [float(value) for value in camera.centre],
        "radial": camera.radial,
        "rotation": [float(value) for value in camera.rotation.reshape(-1)],
        "translation": [float(value) for value in camera.translation],
    }
