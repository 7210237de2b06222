"""Clips of weights in every form that glTF has, beside clips of joints and nodes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gltf_builder import GltfBuilder

TIMES = np.array([0.0, 0.25, 0.5, 1.0, 1.25, 2.0], dtype=np.float32)


def add_clips(
    builder: GltfBuilder,
    kinds: Sequence[str],
    nodes: dict[str, int],
    meshes: dict[str, int],
    names: Sequence[str],
) -> None:
    """Add clips to a document.

    Args:
        builder: The document.
        kinds: "step", "linear", "cubic"; "integers" (normalised 8-bit weights); "shared" (one
            sampler moves two meshes, and another sampler has the same times); "pointer" (weights
            of a node and of a mesh by KHR_animation_pointer), "one weight" (a single one of them).
        nodes: The node of each mesh by its name.
        meshes: Each mesh by its name.
        names: Of the targets, in order.
    """
    for seed, kind in enumerate(kinds):
        clip = _Clip(builder, nodes, meshes, names, np.random.default_rng(seed))
        clip.turn_of_the_camera()
        getattr(clip, kind.replace(" ", "_"))()
        entry = {"name": kind, "channels": clip.channels, "samplers": clip.samplers}
        builder.add("animations", entry | {"extras": {"kind": kind}})


class _Clip:
    def __init__(
        self,
        builder: GltfBuilder,
        nodes: dict[str, int],
        meshes: dict[str, int],
        names: Sequence[str],
        random: np.random.Generator,
    ) -> None:
        self.builder, self.nodes, self.meshes, self.random = builder, nodes, meshes, random
        self.names = names
        self.first = next(iter(nodes))
        self.channels: list[dict[str, Any]] = []
        self.samplers: list[dict[str, Any]] = []

    def count(self, name: str) -> int:
        return len(self.builder.json["meshes"][self.meshes[name]]["primitives"][0]["targets"])

    def sampler(self, values: NDArray[Any], kind: str, **more: Any) -> int:
        times = self.builder.accessor(TIMES, bounds=True)
        output = self.builder.accessor(values.reshape(-1), **more)
        self.samplers.append({"input": times, "output": output, "interpolation": kind})
        return len(self.samplers) - 1

    def weights(self, count: int) -> NDArray[np.float32]:
        """(T, count) from 0 to 1, at rest at the first key, one fully on at another."""
        found = self.random.random((len(TIMES), count)).astype(np.float32) * np.float32(0.9)
        found[0] = 0
        found[3] = 0
        found[3, 0] = 1
        return found

    def channel(self, sampler: int, name: str) -> None:
        target = {"node": self.nodes[name], "path": "weights"}
        self.channels.append({"sampler": sampler, "target": target, "extras": {"of": name}})

    def turn_of_the_camera(self) -> None:
        """A rotation, which bends have nothing to do with."""
        angle = np.linspace(0, 0.4, len(TIMES))
        turns = np.zeros((len(TIMES), 4), np.float32)
        turns[:, 1], turns[:, 3] = np.sin(angle / 2), np.cos(angle / 2)
        times = self.builder.accessor(TIMES, bounds=True)
        self.samplers.append({"input": times, "output": self.builder.accessor(turns)})
        camera = next(n for n, own in enumerate(self.builder.json["nodes"]) if "camera" in own)
        target = {"node": camera, "path": "rotation"}
        self.channels.append({"sampler": len(self.samplers) - 1, "target": target})

    def step(self) -> None:
        self.channel(self.sampler(self.weights(self.count(self.first)), "STEP"), self.first)

    def linear(self) -> None:
        self.channel(self.sampler(self.weights(self.count(self.first)), "LINEAR"), self.first)

    def integers(self) -> None:
        whole = np.round(self.weights(self.count(self.first)) * 255).astype(np.uint8)
        self.channel(self.sampler(whole, "LINEAR", normalized=True), self.first)

    def cubic(self) -> None:
        values = np.zeros((len(TIMES), 3, self.count(self.first)), np.float32)
        values[:, 1] = self.weights(values.shape[2])
        values[:, 0] = values[:, 2] = self.random.normal(0, 0.5, values[:, 0].shape)
        values[0] = 0
        self.channel(self.sampler(values, "CUBICSPLINE"), self.first)

    def shared(self) -> None:
        """One sampler for two meshes; a second one with the same accessor of times."""
        one = self.sampler(self.weights(self.count("head")), "LINEAR")
        self.channel(one, "head")
        self.channel(one, "eyes")
        values = self.builder.accessor(self.weights(self.count("teeth")).reshape(-1))
        times = self.samplers[one]["input"]
        self.samplers.append({"input": times, "output": values, "interpolation": "LINEAR"})
        self.channel(len(self.samplers) - 1, "teeth")

    def pointer(self) -> None:
        node = self.sampler(self.weights(self.count("head")), "LINEAR")
        mesh = self.sampler(self.weights(self.count("teeth")), "STEP")
        self._point(node, f"/nodes/{self.nodes['head']}/weights")
        self._point(mesh, f"/meshes/{self.meshes['teeth']}/weights")
        self.builder.json["meshes"][self.meshes["teeth"]]["weights"] = [0.0] * self.count("teeth")
        self.builder.json["nodes"][self.nodes["head"]]["weights"] = [0.0] * self.count("head")

    def one_weight(self) -> None:
        jaw = self.names.index("jawOpen")
        alone = self.sampler(self.weights(1), "LINEAR")
        self._point(alone, f"/nodes/{self.nodes['head']}/weights/{jaw}")
        self.builder.json["nodes"][self.nodes["head"]]["weights"] = [0.0] * self.count("head")

    def _point(self, sampler: int, pointer: str) -> None:
        self.builder.use("KHR_animation_pointer")
        extension = {"KHR_animation_pointer": {"pointer": pointer}}
        target = {"path": "pointer", "extensions": extension}
        self.channels.append({"sampler": sampler, "target": target})
