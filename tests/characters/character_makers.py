"""Characters as programs write them: a face of several meshes on a skeleton, with clips and notes.

Each is made whole by `make_character` from a `Recipe`, the same on every call; `RECIPES` names
them. Notes, extras and extensions that nobody knows are everywhere, for whoever changes a file has
to leave them as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from character_clips import add_clips
from character_skins import Skeleton, add_skeleton, joints_and_weights, quarter_turn
from character_vrm import add_vrm
from face_parts import LOOK, MATERIALS, NAMES, FacePart, face_parts
from gltf_builder import ARRAY, ELEMENT, GltfBuilder, png

TARGETS = (*NAMES, LOOK)
NOTES = {
    "notes": "näher 微笑",
    "nested": {"list": [1, 2.5, None, True], "tiny": 1e-30, "big": 2**53},
}
UNKNOWN = {"ACME_rig_notes": {"author": "somebody", "values": [0.1, 0.2]}}


@dataclass(frozen=True)
class Recipe:
    """What a character is like."""

    suffix: str = ".glb"
    embedded: bool = False  # of .gltf: data URIs in place of files
    buffers: int = 1
    parts: tuple[str, ...] = ("head", "eyes", "teeth", "lashes")
    one_mesh: bool = False  # all parts are primitives of one mesh
    shared: bool = False  # primitives of one material each, on the same vertices
    interleaved: bool = False
    storage: str = "dense"  # of targets: "dense", or "sparse" with accessors without views
    normals: bool = True  # targets have them
    tangents: bool = False
    quantized: bool = False  # positions and targets are normalised 16-bit, the node has the scale
    own_targets: bool = False  # a mesh has only the targets that move it
    names_at: str = "mesh"  # or "primitive", "target"
    skin: str | None = None  # "bind", "posed", "scaled" or "separate"
    nodes: str = "plain"  # or "placed", "mirrored", "twice"
    defaults: bool = False  # weights of meshes and nodes are not zero
    clips: tuple[str, ...] = ()  # see character_clips
    vrm: int | None = None  # 0 or 1


RECIPES: dict[str, Recipe] = {
    "plain": Recipe(),
    "placed-files": Recipe(
        suffix=".gltf", nodes="placed", buffers=2, storage="sparse", defaults=True, tangents=True
    ),
    "mirrored-embedded": Recipe(
        suffix=".gltf", embedded=True, nodes="mirrored", one_mesh=True, normals=False
    ),
    "twice": Recipe(nodes="twice", defaults=True, clips=("linear",)),
    "skinned": Recipe(skin="bind", clips=("step", "linear", "cubic", "shared"), defaults=True),
    "posed": Recipe(skin="posed", storage="sparse", clips=("shared",)),
    "scaled": Recipe(skin="scaled", interleaved=True, own_targets=True, clips=("linear",)),
    "separate": Recipe(skin="separate", buffers=3, names_at="primitive", clips=("cubic",)),
    "old-names": Recipe(parts=("head", "teeth"), names_at="target", clips=("step",)),
    "pointer": Recipe(skin="bind", clips=("pointer", "one weight")),
    "shared-vertices": Recipe(shared=True, one_mesh=True, skin="bind", storage="sparse"),
    "quantized": Recipe(quantized=True, clips=("integers",)),
    "vrm0": Recipe(suffix=".vrm", skin="bind", one_mesh=True, shared=True, vrm=0),
    "vrm1": Recipe(suffix=".vrm", skin="bind", vrm=1),
}


def make_character(recipe: Recipe, path: Path) -> Path:
    """Write a character.

    Args:
        recipe: What it is like.
        path: The file, whose suffix is that of the recipe.
    """
    made = _Character(recipe)
    made.materials()
    made.body()
    made.scene()
    return made.builder.write(path, embedded=recipe.embedded)


def make(name: str, folder: Path) -> Path:
    """The character of a name in `RECIPES`, in a folder."""
    recipe = RECIPES[name]
    return make_character(recipe, folder / f"{name}{recipe.suffix}")


class _Character:
    def __init__(self, recipe: Recipe) -> None:
        self.recipe = recipe
        self.builder = GltfBuilder(recipe.buffers)
        self.builder.use("KHR_lights_punctual", *UNKNOWN)
        self.meshes: dict[str, int] = {}  # by name of the part, or "face"
        self.scales: dict[str, float] = {}
        self.places: dict[str, NDArray[np.float64]] = {}  # of quantised positions, their origin
        self.shown: dict[str, int] = {}  # the node of each mesh
        self.rest = np.random.default_rng(7)

    @property
    def parts(self) -> list[FacePart]:
        return [face_parts()[name] for name in self.recipe.parts]

    def materials(self) -> None:
        """Images in the file, textures, and a material for each group of each part."""
        builder = self.builder
        for name, colour in {"skin": (224, 172, 140), "eyes": (240, 240, 240)}.items():
            noise = self.rest.integers(-12, 12, (16, 16, 3))
            pixels = np.clip(np.array(colour) + noise, 0, 255).astype(np.uint8)
            view = builder.view(png(pixels), self.recipe.buffers - 1, name=f"{name}.png")
            image = {"bufferView": view, "mimeType": "image/png", "name": name, "extras": NOTES}
            builder.add("images", image)
        builder.add("samplers", {"magFilter": 9729, "minFilter": 9987, "wrapS": 33071})
        for source in range(2):
            builder.add("textures", {"sampler": 0, "source": source, "extras": {"n": source}})
        self.of_material = {}
        for part in self.recipe.parts:
            for material in MATERIALS[part][: None if self.recipe.shared else 1]:
                base = {"baseColorTexture": {"index": int(part == "eyes")}, "roughnessFactor": 0.7}
                entry = {"name": material, "pbrMetallicRoughness": base, "extensions": UNKNOWN}
                self.of_material[material] = builder.add("materials", entry | {"extras": NOTES})

    def body(self) -> None:
        """The meshes: those of the face, and a box of the body that no target moves."""
        if self.recipe.one_mesh:
            self._mesh("face", self.parts)
        else:
            for part in self.parts:
                self._mesh(part.name, [part])
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (0, 1) for z in (-1, 1)])
        box = (corners * [0.2, 1.4, 0.1]).astype(np.float32)
        flat = np.ascontiguousarray((corners[:, :2] + 1) / 2).astype(np.float32)
        sides = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6]
        at: dict[str, Any] = {"POSITION": box, "TEXCOORD_0": flat}
        if self.recipe.skin:
            at |= joints_and_weights(box)
        builder = self.builder
        primitive = {
            "attributes": builder.attributes(at, interleaved=False),
            "indices": builder.accessor(np.array(sides, "<u2"), target=ELEMENT),
            "material": 0,
        }
        self.meshes["body"] = builder.add("meshes", {"name": "body", "primitives": [primitive]})

    def _mesh(self, name: str, parts: list[FacePart]) -> None:
        recipe = self.recipe
        names = list(TARGETS)
        if recipe.own_targets:
            names = [target for target in TARGETS if any(target in p.moved_by for p in parts)]
        primitives = [own for part in parts for own in self._primitives(name, part, names, parts)]
        mesh: dict[str, Any] = {"name": name, "primitives": primitives, "extensions": UNKNOWN}
        mesh["extras"] = {**NOTES, "shown": [0.25, 1]}
        if recipe.names_at == "mesh":
            mesh["extras"]["targetNames"] = names
        if recipe.defaults:
            mesh["weights"] = [0.125 * (k % 3) for k in range(len(names))]
        self.meshes[name] = self.builder.add("meshes", mesh)

    def _primitives(
        self, mesh: str, part: FacePart, names: list[str], all_parts: list[FacePart]
    ) -> list[dict[str, Any]]:
        attributes, targets = self._vertices(mesh, part, names, all_parts)
        groups = MATERIALS[part.name]
        found = []
        wanted = [[k] for k in range(len(groups))] if self.recipe.shared else [range(len(groups))]
        for numbers in wanted:
            own = part.triangles[np.isin(part.of_material, list(numbers))]
            indices = self.builder.accessor(own.reshape(-1).astype("<u2"), target=ELEMENT)
            primitive: dict[str, Any] = {
                "attributes": dict(attributes),
                "indices": indices,
                "material": self.of_material[groups[next(iter(numbers))]],
                "targets": [dict(target) for target in targets],
                "extras": dict(NOTES),
            }
            if self.recipe.names_at == "primitive":
                primitive["extras"]["targetNames"] = names
            if self.recipe.names_at == "target":
                for target, name in zip(primitive["targets"], names, strict=True):
                    target["extras"] = {"name": name}
            found.append(primitive)
        return found

    def _vertices(
        self, mesh: str, part: FacePart, names: list[str], all_parts: list[FacePart]
    ) -> tuple[dict[str, int], list[dict[str, int]]]:
        recipe, builder = self.recipe, self.builder
        columns: dict[str, NDArray[Any]] = {"POSITION": part.positions, "NORMAL": part.normals}
        if recipe.tangents:
            columns["TANGENT"] = _tangents(part.normals)
        columns["TEXCOORD_0"] = part.texture
        columns["COLOR_0"] = np.full((len(part.positions), 4), 255, np.uint8)
        columns["_CURVATURE"] = part.positions[:, :1].copy()
        if recipe.skin:
            columns |= joints_and_weights(part.positions)
        if recipe.skin == "scaled":  # modelled in centimetres
            columns["POSITION"] = part.positions * np.float32(100)
        if recipe.quantized:
            return self._quantized(mesh, part, names, all_parts, columns)
        middle = recipe.buffers // 2
        attributes = builder.attributes(columns, interleaved=recipe.interleaved, buffer=middle)
        targets = []
        for name in names:
            moved = part.moves[name] * np.float32(100 if recipe.skin == "scaled" else 1)
            kind = recipe.storage
            if kind == "sparse" and not moved.any():
                kind = "bare"
            buffer = recipe.buffers - 1
            own = {"POSITION": builder.target(moved, kind, buffer=buffer)}
            if recipe.normals:
                own["NORMAL"] = builder.target(part.turns[name], kind, buffer=buffer)
            if recipe.tangents:
                flat = np.zeros_like(part.turns[name])
                own["TANGENT"] = builder.target(flat, "bare", buffer=buffer)
            targets.append(own)
        return attributes, targets

    def _quantized(
        self,
        mesh: str,
        part: FacePart,
        names: list[str],
        all_parts: list[FacePart],
        columns: dict[str, NDArray[Any]],
    ) -> tuple[dict[str, int], list[dict[str, int]]]:
        """Positions and targets as 16-bit fractions, whose size is the scale of the node."""
        self.builder.use("KHR_mesh_quantization")
        self.builder.json["extensionsRequired"] = ["KHR_mesh_quantization"]
        points = np.concatenate([own.positions for own in all_parts])
        low, high = points.min(axis=0), points.max(axis=0)
        centre, scale = (low + high) / 2, float((high - low).max() / 2)
        self.scales[mesh], self.places[mesh] = scale, np.asarray(centre, float)

        def packed(rows: NDArray[Any]) -> NDArray[np.int16]:
            short = np.round(rows / scale * 32767).astype("<i2")
            return np.concatenate([short, np.zeros((len(short), 1), "<i2")], axis=1)

        def stored(rows: NDArray[Any]) -> int:
            short = packed(rows)
            view = self.builder.view(short.tobytes(), byteStride=8, target=ARRAY)
            bounds = {"min": short[:, :3].min(0).tolist(), "max": short[:, :3].max(0).tolist()}
            shape = {"componentType": 5122, "normalized": True, "type": "VEC3", "count": len(rows)}
            return self.builder.add("accessors", {"bufferView": view} | shape | bounds)

        rest = {name: own for name, own in columns.items() if name != "POSITION"}
        attributes = {"POSITION": stored(part.positions - centre)}
        attributes |= self.builder.attributes(rest, interleaved=False)
        targets = [{"POSITION": stored(part.moves[name])} for name in names]
        return attributes, targets

    def scene(self) -> None:
        """Nodes, a camera, lights, the skeleton, clips and the notes of the root."""
        builder, recipe = self.builder, self.recipe
        skeleton = add_skeleton(builder, recipe.skin) if recipe.skin else Skeleton()
        top = [*skeleton.roots]
        for name, mesh in self.meshes.items():
            node: dict[str, Any] = {"name": f"{name} node", "mesh": mesh, "extras": dict(NOTES)}
            if recipe.skin:
                node["skin"] = skeleton.skin_for(builder, name)
            if recipe.defaults and name == "head":
                node["weights"] = [0.25 if k == 1 else 0.0 for k in range(len(TARGETS))]
            if name in self.scales:
                scale = self.scales[name]
                node |= {"translation": self.places[name].tolist(), "scale": [scale] * 3}
            self.shown[name] = builder.add("nodes", node)
        top.append(self._placed(list(self.shown.values())))
        camera = {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.01}, "name": "c"}
        builder.add("cameras", camera | {"extras": NOTES})
        top.append(builder.add("nodes", {"camera": 0, "translation": [0, 1.6, 1], "name": "view"}))
        lamp = {"light": 0}
        node = {"name": "lamp", "extensions": {"KHR_lights_punctual": lamp}}
        top.append(builder.add("nodes", node | {"translation": [1, 2, 1]}))
        builder.json["extensions"] = {
            "KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 40.0, "name": "key"}]}
        } | UNKNOWN
        scene = {"name": "main", "nodes": top, "extras": NOTES}
        builder.json |= {"scene": 1, "extras": {"from": "by hand", **NOTES}}
        builder.json["scenes"] = [{"name": "empty", "nodes": [top[-1]]}, scene]
        add_clips(builder, recipe.clips, self.shown, self.meshes, TARGETS)
        if recipe.vrm is not None:
            add_vrm(builder, recipe.vrm, self.shown, self.meshes, skeleton, TARGETS)

    def _placed(self, nodes: list[int]) -> int:
        """A node above the meshes, which stand as the recipe says."""
        builder, kind = self.builder, self.recipe.nodes
        above: dict[str, Any] = {"name": "character", "children": nodes, "extensions": UNKNOWN}
        if kind == "placed":
            for k, number in enumerate(nodes):
                shift = [0.0, 0.0, 0.001 * k]
                builder.json["nodes"][number] |= {"translation": shift, "scale": [2.0, 2.0, 2.0]}
            above |= {"rotation": quarter_turn(0), "translation": [0.5, 0, -3], "scale": [0.5] * 3}
        if kind == "mirrored":
            above["matrix"] = [-1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0.1, 0.2, 0.3, 1]
        if kind == "twice":  # one mesh shown by two nodes, each with weights of its own
            again = dict(builder.json["nodes"][nodes[0]], name="double", translation=[0.6, 0, 0])
            nodes.append(builder.add("nodes", again))
        return builder.add("nodes", above)


def _tangents(normals: NDArray[np.float32]) -> NDArray[np.float32]:
    side = np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
    along = np.cross(normals, side)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.concatenate([along, np.ones((len(along), 1))], axis=1).astype(np.float32)


Maker = Callable[[Path], Path]
