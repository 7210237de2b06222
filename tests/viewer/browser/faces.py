"""Faces to look at: the small head with a few of its expressions, by three methods."""

from __future__ import annotations

import copy
import io
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.io.gltf import write_glb
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance, slider_weights
from elastomorph.viewer import Scene, SceneModel, comparison_scene, rig_scene
from small_head import head, shapes

METHODS = ("linear", "beam:2", "rotation")
SHAPES = (
    *("eyeBlink_L", "eyeBlink_R", "browInnerUp", "jawOpen", "mouthFunnel"),
    *("mouthSmile_L", "mouthSmile_R"),
)
# On top of the jaw, as artists do it: once driven by sliders of others, once with its own as well.
CORRECTIVES = {"squash": ("mouthSmile_L", "jawOpen"), "pursed": ("jawOpen", "pursed")}
RATE = 30.0


@dataclass(frozen=True)
class Faces:
    """The same expressions by every method."""

    rigs: dict[str, Rig]

    @property
    def neutral(self) -> em.Mesh:
        return next(iter(self.rigs.values())).neutral

    @property
    def diameter(self) -> float:
        return self.neutral.diameter

    @cached_property
    def alone(self) -> Scene:
        """One face."""
        return rig_scene(self.rigs["beam:2"], name="beam:2", title="Built-in head", unit="cm")

    @cached_property
    def together(self) -> Scene:
        """All of them side by side, with a take."""
        scene = comparison_scene(dict(self.rigs), title="Three methods", unit="cm")
        models = [
            SceneModel(name, "method", glb(rig, self.take)) for name, rig in self.rigs.items()
        ]
        return Scene(
            tuple(models), scene.title, scene.unit, scene.diameter, scene.curves, scene.start
        )

    @cached_property
    def performed(self) -> Scene:
        """One face with a take."""
        model = SceneModel("head", "rig", glb(self.rigs["beam:2"], self.take))
        return Scene((model,), "A take", "cm", self.diameter)

    @property
    def take(self) -> Performance:
        """Two sliders for a second, all the time on the way to somewhere."""
        times = np.arange(31) / RATE
        jaw, lid = np.sin(np.pi * times) ** 2, np.abs(np.sin(7 * times))
        table = np.column_stack([jaw, lid])
        return Performance(("jawOpen", "eyeBlink_L"), times, table, RATE)

    @cached_property
    def chin(self) -> int:
        """The vertex that the jaw moves farthest, of those at the front of the face."""
        rig = self.rigs["linear"]
        moved = np.linalg.norm(rig.pose({"jawOpen": 1.0}) - self.neutral.vertices, axis=1)
        z = self.neutral.vertices[:, 2]
        middle = np.abs(self.neutral.vertices[:, 0]) < 0.02 * self.diameter
        inside = z < np.quantile(z[middle & (moved > 0.5 * moved.max())], 0.8)
        return int(np.argmax(np.where(inside | ~middle, -1.0, moved)))


def make_faces() -> Faces:
    neutral, found = head(), shapes()
    targets = {name: found[name] for name in SHAPES}
    targets["squash"] = _offset(neutral, found["cheekPuff"], 0.4)
    targets["pursed"] = _offset(neutral, found["mouthPucker"], 0.6)
    rigs = {}
    for method in METHODS:
        to = em.prepare(neutral, method)
        morphs = {name: to(target) for name, target in targets.items()}
        rigs[method] = Rig(
            neutral, morphs, correctives=CORRECTIVES, groups={"Lids": ["eyeBlink_L", "eyeBlink_R"]}
        )
    return Faces(rigs)


def glb(rig: Rig, take: Performance | None = None, *, clips: bool = False) -> bytes:
    """The bytes of a GLB file of a rig, and of a take on it or a clip for each slider."""
    file = io.BytesIO()
    played = None if take is None else (take.times, slider_weights(rig, take), "a take")
    write_glb(file, rig, normals="none", animation=played, clips=clips)
    return file.getvalue()


def twice(document: dict[str, Any]) -> None:
    """Show the mesh of a document by two, each of which describes the whole, in another order."""
    mesh = document["meshes"][0]
    del mesh["extras"]["elastomorph"]["surface"]
    other = copy.deepcopy(mesh)
    other["extras"]["elastomorph"]["morphs"].reverse()
    document["meshes"].append(other)
    document["nodes"].append({"mesh": 1, "name": "other"})
    document["scenes"][0]["nodes"].append(1)


def distances(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    found: NDArray[np.float64] = np.linalg.norm(one - other, axis=1)
    return found


def _offset(neutral: em.Mesh, target: em.Mesh, share: float) -> em.Mesh:
    moved = neutral.vertices + share * (target.vertices - neutral.vertices)
    return neutral.with_vertices(moved)
