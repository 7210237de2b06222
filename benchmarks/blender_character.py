"""A character as Blender exports it: the built-in head on an armature, in several objects.

Run:  python benchmarks/blender_character.py parts FILE.npz          writes the parts of the head
      PYTHON-WITH-BPY benchmarks/blender_character.py FILE.npz FOLDER   writes characters

The second needs Blender as a module (package ``bpy``), and nothing of this package.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

VARIANTS: dict[str, dict[str, Any]] = {
    "blender.glb": {"export_format": "GLB"},
    "blender.gltf": {"export_format": "GLTF_SEPARATE", "export_try_sparse_sk": False},
    "blender-tangents.glb": {"export_format": "GLB", "export_tangents": True},
    "blender-draco.glb": {"export_format": "GLB", "export_draco_mesh_compression_enable": True},
    "blender-yup.glb": {"export_format": "GLB", "export_yup": False, "export_morph_normal": False},
}


def write_parts(path: Path) -> None:
    """The quads, shapes and texture coordinates of each part, for `make`."""
    from elastomorph.samples import head, shapes

    mesh = head()
    assert mesh.groups is not None
    groups = {
        "Head": ("skin", "lips", "head", "mouth", "lashes"),
        "Eyes": ("eye_L", "eye_R"),
        "Teeth": ("gums", "teeth", "tongue"),
    }
    arrays: dict[str, Any] = {}
    named = shapes()
    for part, members in groups.items():
        labels = [mesh.groups.names.index(name) for name in members]
        own = np.isin(mesh.groups.of_face, labels) & (mesh.faces.sizes == 4)
        quads = mesh.faces.indices.reshape(-1)[
            (mesh.faces.offsets[:-1][own, None] + np.arange(4)).reshape(-1)
        ]
        used, at = np.unique(quads, return_inverse=True)
        arrays[f"{part}/quads"] = at.reshape(-1, 4)
        arrays[f"{part}/vertices"] = mesh.vertices[used]
        for name, shape in named.items():
            moved = shape.vertices[used]
            if (moved != mesh.vertices[used]).any():
                arrays[f"{part}/shapes/{name}"] = moved
    np.savez_compressed(path, **arrays)


def make(parts: Path, folder: Path) -> None:
    """Build the character in Blender and export it in several ways."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    arrays = np.load(parts)
    armature = _armature(bpy)
    image = bpy.data.images.new("skin", 64, 64)
    image.generated_type = "UV_GRID"
    image.pack()
    for part in ("Head", "Eyes", "Teeth"):
        _object(bpy, part, arrays, armature, image)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT"))
    for thing in (camera, light):
        bpy.context.collection.objects.link(thing)
        thing.location = (0.2, -1.0, 1.7)
    shown: dict[str, Any] = {
        "export_cameras": True,
        "export_lights": True,
        "export_extras": True,
        "export_morph_animation": True,
        "export_animation_mode": "ACTIONS",
        "export_morph_normal": True,
    }
    for name, options in VARIANTS.items():
        bpy.ops.export_scene.gltf(filepath=str(folder / name), **{**shown, **options})


def _armature(bpy: Any) -> Any:
    armature = bpy.data.objects.new("Armature", bpy.data.armatures.new("Armature"))
    bpy.context.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    last = None
    for name, low, high in (("Spine", 1.1, 1.45), ("Neck", 1.45, 1.55), ("HeadBone", 1.55, 1.75)):
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, low), (0, 0, high)
        bone.parent = last
        last = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    armature.scale = (1.0, 1.0, 1.0)
    return armature


def _object(bpy: Any, part: str, arrays: Any, armature: Any, image: Any) -> None:
    def placed(points: Any) -> Any:  # centimetres, +Y up, into metres, +Z up
        return np.stack([points[:, 0], -points[:, 2], points[:, 1] + 162.0], axis=1) / 100

    vertices, quads = placed(arrays[f"{part}/vertices"]), arrays[f"{part}/quads"]
    mesh = bpy.data.meshes.new(part)
    mesh.from_pydata(vertices.tolist(), [], quads.tolist())
    thing = bpy.data.objects.new(part, mesh)
    bpy.context.collection.objects.link(thing)
    thing["rigger"] = "somebody"
    mesh.shade_smooth()
    texture = mesh.uv_layers.new(name="UVMap")
    flat = vertices[quads.reshape(-1)]
    island = 0.02 * (vertices[quads].mean(axis=1)[:, 0] > 0)
    coordinates = np.stack([flat[:, 0] * 3 + 0.5 + np.repeat(island, 4), flat[:, 2] - 1.3], axis=1)
    texture.data.foreach_set("uv", coordinates.astype(np.float32).reshape(-1))
    for name in ("skin", "wet"):
        material = bpy.data.materials.new(f"{part} {name}")
        material.use_nodes = True
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        shader = material.node_tree.nodes["Principled BSDF"]
        material.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
        mesh.materials.append(material)
    low = vertices[quads].mean(axis=1)[:, 2] < np.median(vertices[:, 2])
    mesh.polygons.foreach_set("material_index", low.astype(np.int32))
    _shapes(part, thing, arrays, placed)
    for name, share in (("HeadBone", 1.0), ("Neck", 0.0)):
        group = thing.vertex_groups.new(name=name)
        for number, vertex in enumerate(vertices):
            of_neck = float(np.clip((1.5 - vertex[2]) / 0.08, 0, 1))
            weight = 1 - of_neck if share else of_neck
            if weight:
                group.add([number], weight, "REPLACE")
    thing.parent = armature
    modifier = thing.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature


def _shapes(part: str, thing: Any, arrays: Any, placed: Any) -> None:
    """Shape keys, a few of them animated; all objects have the keys of the head."""
    thing.shape_key_add(name="Basis", from_mix=False)
    names = [key.split("/")[-1] for key in arrays.files if key.startswith("Head/shapes/")]
    for name in names:
        key = thing.shape_key_add(name=name, from_mix=False)
        if f"{part}/shapes/{name}" in arrays.files:
            moved = placed(arrays[f"{part}/shapes/{name}"])
            key.data.foreach_set("co", moved.astype(np.float32).reshape(-1))
    blocks = thing.data.shape_keys.key_blocks
    for name, frames in {
        "jawOpen": (1, 0.0, 12, 1.0, 24, 0.3),
        "mouthSmileLeft": (1, 0.5, 20, 1.0),
    }.items():
        for frame, value in zip(frames[::2], frames[1::2], strict=True):
            blocks[name].value = value
            blocks[name].keyframe_insert("value", frame=frame)
    blocks["browInnerUp"].value = 0.25


if __name__ == "__main__":
    if sys.argv[1] == "parts":
        write_parts(Path(sys.argv[2]))
    else:
        make(Path(sys.argv[1]), Path(sys.argv[2]))
