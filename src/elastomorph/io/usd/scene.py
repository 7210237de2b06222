"""What the worker found in a USD file, as meshes and shapes of a rig, all of it checked."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.joined_rig import turned_corners
from elastomorph.io.npz.members import NpzMembers
from elastomorph.io.untrusted import naming_file
from elastomorph.io.usd.exact import checksum
from elastomorph.model.appearance import Material, Texture
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.polygons import Polygons

# Right, up and front of a face, as rows: programs that call z up look along y.
_AXES = {"Y": np.eye(3), "Z": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])}
_OBJECTS_OF_MESH = 11  # so many arrays the worker wrote of it


@dataclass(frozen=True, eq=False)
class FoundShape:
    """One blend shape as it stands in the file."""

    token: str  # Its name to UsdSkel
    prim_name: str  # That of its prim
    name: str | None  # The name that elastomorph gave it, if any
    path: str | None  # JSON of its exact path, if any
    points: NDArray[np.int64]  # (N,) int64 points it moves
    offsets: NDArray[np.float64]  # (1 + n, N, 3) float64, of the shape and its in-betweens
    weights: NDArray[np.float64]  # (n,) of the in-betweens, in any order; NaN for none
    bends: NDArray[np.float64]  # (M, 3) float64 rows of exact bends, if any


def found_meshes(path: str | Path, members: NpzMembers) -> list[FoundMesh]:
    """The meshes of a file, in its order."""
    scene = json.loads(members.array("scene", "u", (None,)).tobytes())
    members.budget.add_size(scene["size_of_others"])
    members.budget.spend_objects(_OBJECTS_OF_MESH * len(scene["meshes"]))
    axes = _AXES.get(scene["up"], _AXES["Y"])
    looks = _appearance(scene["looks"], members)
    return [
        FoundMesh(path, members, f"{i}_", own, axes, looks) for i, own in enumerate(scene["meshes"])
    ]


def _appearance(stored: dict[str, Any], members: NpzMembers) -> dict[str, Material] | None:
    """The looks of materials by name; None where all are plain greys, which say nothing."""
    found: dict[str, Material] = {}
    for name, look in stored.items():
        texture: Texture | None = None
        if shown := look.pop("texture", None):
            number, problem = shown.pop("image"), "it is no file below the folder of the stage"
            content = b""
            if number is not None:
                problem = ""
                content = members.array(f"image_{number}", "u", (None,)).tobytes()
            lists: dict[str, Any] = {
                key: tuple(v) if isinstance(v, list) else v for key, v in shown.items()
            }
            texture = Texture(image=content, problem=problem, **lists)
        # Which side polygons show is said of meshes, and few stages say it.
        own = {**look, "colour": tuple(look["colour"])}
        found[name] = Material(texture=texture, double_sided=True, **own)
    return None if all(material.plain for material in found.values()) else found


class FoundMesh:
    """A mesh and its blend shapes."""

    def __init__(
        self,
        path: str | Path,
        members: NpzMembers,
        prefix: str,
        entry: dict[str, Any],
        axes: NDArray[np.float64],
        looks: dict[str, Material] | None,
    ) -> None:
        self._path = path
        self._looks = looks
        self._members = members
        self._prefix = prefix
        self._entry = entry
        self.name: str = entry["name"]
        self.axes = axes  # (3, 3) right, up and front of the file, as rows
        self.settings: str | None = entry["settings"]  # as JSON, where elastomorph stored them
        self.shape_count = len(entry["shapes"])
        self._shapes: dict[int, FoundShape] = {}

    @cached_property
    def matrix(self) -> NDArray[np.float64]:
        """(4, 3) from points to the world: what x, y and z become, and the origin."""
        return self._array("matrix", (4, 3))

    @cached_property
    def held(self) -> NDArray[np.float64] | None:
        """(N, 4, 3) what joints do to each point before that, None where it is nothing."""
        if not self._has("held"):
            return None
        return self._array("held", (None, 4, 3))

    @cached_property
    def sliders(self) -> dict[str, Any]:
        """What elastomorph stored of the sliders; empty where it did not."""
        try:
            found = json.loads(self._entry["sliders"] or "")
        except (ValueError, RecursionError):
            return {}
        return found if isinstance(found, dict) and found.get("version") == 1 else {}

    @cached_property
    def mesh(self) -> Mesh:
        """The neutral, as it is stored."""
        points = self._array("points", (None, 3))
        counts = self._indices("counts", 0, None)
        indices = self._indices("indices", 0, len(points) - 1)
        if int(counts.sum()) != len(indices):
            raise FormatError(
                self._path,
                f"its polygons have {int(counts.sum()):,} corners (faceVertexCounts), but "
                f"faceVertexIndices has {len(indices):,}; the file is damaged",
            )
        library = self.sliders.get("materialLibrary")
        with naming_file(self._path):
            offsets = np.concatenate([[0], np.cumsum(counts)])
            left = self._entry["left_handed"]
            order = turned_corners(offsets) if left else np.arange(len(indices))
            faces = Polygons(indices[order], offsets)
            return Mesh(
                self._exact_points(points),
                faces,
                uv=self._texture(indices, order, len(points)),
                materials=self._labels(len(faces), material=True),
                groups=self._labels(len(faces), material=False),
                material_library=library if isinstance(library, str) else None,
                # a converter of glTF splits vertices where texture coordinates end
                source=Source(str(self._path), split=True),
                appearance=self._looks,
            )

    def shape(self, i: int, vertices: int) -> FoundShape:
        """One blend shape."""
        if i not in self._shapes:
            self._shapes[i] = self._shape(i, vertices)
        return self._shapes[i]

    def _shape(self, i: int, vertices: int) -> FoundShape:
        found, prefix = self._entry["shapes"][i], f"shape_{i}"
        main = self._array(f"{prefix}_offsets", (None, 3))
        points = np.arange(vertices)
        if self._has(f"{prefix}_points"):
            named = self._indices(f"{prefix}_points", 0, vertices - 1)
            points = named if named.size else points
        if not len(main) and len(points) == vertices:
            main = np.zeros((vertices, 3))  # an empty shape moves nothing
        between = range(len(found["inbetweens"]))
        rows = [main, *(self._array(f"{prefix}_inbetween_{k}", (None, 3)) for k in between)]
        for row in rows:
            if len(row) != len(points):
                raise FormatError(
                    self._path,
                    f"the blend shape '{found['token']}' moves {len(points):,} points, but has "
                    f"{len(row):,} offsets; the file is damaged or was written wrongly",
                )
        weights = found["inbetweens"]
        return FoundShape(
            found["token"],
            found["prim"],
            found["name"],
            found["path"],
            points,
            np.stack(rows),
            np.array([np.nan if w is None else w for w in weights], dtype=np.float64),
            self._array(f"{prefix}_bends", (None, 3)),
        )

    def _has(self, name: str) -> bool:
        return f"{self._prefix}{name}" in self._members.names

    def _array(self, name: str, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
        """An array of finite numbers, empty where there is none."""
        if not self._has(name):
            return np.zeros([length or 0 for length in shape])
        found = self._members.array(f"{self._prefix}{name}", "f", shape)
        if not np.isfinite(found).all():
            raise FormatError(self._path, f"{_said(name)} are not all finite numbers")
        return found.astype(np.float64)

    def _indices(self, name: str, lowest: int, highest: int | None) -> NDArray[np.int64]:
        """A list of whole numbers, empty where there is none."""
        if not self._has(name):
            return np.zeros(0, dtype=np.int64)
        found = self._members.array(f"{self._prefix}{name}", "iu", (None,)).astype(np.int64)
        least, most = (int(found.min()), int(found.max())) if found.size else (lowest, lowest - 1)
        if least < lowest or (highest is not None and most > highest):
            raise FormatError(
                self._path,
                f"{_said(name)} go from {least:,} to {most:,}, expected {lowest:,} to "
                f"{'any' if highest is None else f'{highest:,}'}",
            )
        return found

    def _exact_points(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        if not self._has("exact_points"):
            return points
        exact = self._array("exact_points", (None, 3))
        same = exact.shape == points.shape and self.sliders.get("checksum") == checksum(
            [points.astype(np.float32)]
        )
        return exact if same else points

    def _texture(
        self, indices: NDArray[np.int64], order: NDArray[np.int64], vertices: int
    ) -> UVMap | None:
        found = self._entry["texture"]
        if found is None:
            return None
        uv = self._members.array(f"{self._prefix}uv", "f", (None, None))
        coordinates = uv.astype(np.float64)
        if coordinates.shape[1] not in (2, 3) or not np.isfinite(coordinates).all():
            return None
        corner = found["kind"] == "faceVarying"
        count, of = (len(indices), "corners") if corner else (vertices, "points")
        own = np.arange(count)
        if self._has("uv_indices"):
            own = self._indices("uv_indices", -1, len(coordinates) - 1)
        if len(own) != count:
            raise FormatError(
                self._path, f"there are {len(own):,} texture coordinates for {count:,} {of}"
            )
        if own.size and int(own.max()) >= len(coordinates):
            raise FormatError(
                self._path, f"there are only {len(coordinates):,} texture coordinates"
            )
        corners = (own if corner else own[indices])[order]
        bare = found["unauthored"]
        if bare >= 0:
            corners = np.where(corners == bare, -1, corners)
            if bare == len(coordinates) - 1:
                coordinates = coordinates[:-1]
        return UVMap(coordinates, corners.astype(np.int32))

    def _labels(self, faces: int, *, material: bool) -> FaceLabels | None:
        subsets = [
            (i, subset["name"])
            for i, subset in enumerate(self._entry["subsets"])
            if subset["material"] == material
        ]
        whole = self._entry["material"] if material else None
        if not subsets and whole is None:
            return None
        names = list(dict.fromkeys(name for _, name in subsets))
        of_face = np.full(faces, -1, dtype=np.int32)
        if whole is not None:
            names += [whole] if whole not in names else []
            of_face[:] = names.index(whole)
        for i, name in subsets:
            of_face[self._indices(f"subset_{i}", 0, faces - 1)] = names.index(name)
        return FaceLabels(tuple(names), of_face)


def _said(name: str) -> str:
    return f"the values of '{name.replace('_', ' ')}'"
