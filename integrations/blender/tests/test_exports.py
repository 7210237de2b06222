"""What Blender's own exporters write of a bent face, baked and driven.

Once in some ten thousand evaluations Blender 5.0 reads a driven weight one moment late (`settle`),
and an exporter writes what it reads: of drivers three files are written, and one must be right.
"""

import json
import struct
from pathlib import Path

import bpy
import numpy as np
import pytest
from heads import CLOSE, add_performed, apart, bend_keys, frames_apart

UPRIGHT = {"axis_forward": "Y", "axis_up": "Z"}
# With these the exporter writes the animation of shape keys only beside one of their object.
SCENE_ONLY = {"bake_anim_use_nla_strips": False, "bake_anim_use_all_actions": False}


def write(path: Path) -> None:
    """Export the scene as the suffix says."""
    name = str(path)
    if path.suffix == ".glb":
        options = {"export_yup": False, "export_normals": False, "export_skins": False}
        bpy.ops.export_scene.gltf(filepath=name, **options)
    elif path.suffix == ".fbx":
        exact = {"bake_anim_simplify_factor": 0.0, **SCENE_ONLY, **UPRIGHT}
        bpy.ops.export_scene.fbx(filepath=name, **exact)
    elif path.suffix == ".abc":
        bpy.ops.wm.alembic_export(filepath=name, start=1, end=12)
    else:
        bpy.ops.wm.usd_export(filepath=name, export_animation=True, export_shapekeys=True)


def imported(path: Path) -> bpy.types.Object:
    """The only mesh of a file, alone in the scene."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    name = str(path)
    if path.suffix == ".fbx":
        bpy.ops.import_scene.fbx(filepath=name, anim_offset=0, **UPRIGHT)
    elif path.suffix == ".abc":
        bpy.ops.wm.alembic_import(filepath=name)
    else:
        bpy.ops.wm.usd_import(filepath=name)
    (mesh,) = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    return mesh


@pytest.mark.parametrize("baked", [False, True])
def test_gltf_holds_the_paths_and_their_curves(tmp_path, baked):
    """Blender's glTF, read by elastomorph: the same rig, with the same paths."""
    import elastomorph as em

    head, rig, _ = add_performed()
    if baked:
        bpy.ops.elastomorph.bake()
    write(tmp_path / "head.glb")
    found = em.read_rig(tmp_path / "head.glb")
    assert tuple(found.morphs) == tuple(rig.morphs)
    assert found.neutral.vertices.shape == rig.neutral.vertices.shape
    for name in rig.morphs:
        bends = [bend for bend in bend_keys(head) if bend.startswith(f"{name}.")]
        assert len(found[name].bends) == len(bends)
        for t in (0.25, 0.5, 0.75, 1.0, 1.3):
            assert apart(found.pose({name: t}), rig.pose({name: t}), rig) < CLOSE


@pytest.mark.parametrize("how", ["baked", "driven, on an armature"])
def test_gltf_clips_play_bent_without_us(tmp_path, how):
    """Targets and weight keys alone, as any player has them: the poses of the rig, each frame."""
    head, rig, weights = add_performed()
    paths = [tmp_path / "head.glb"]
    if how == "baked":
        bpy.ops.elastomorph.bake()
    else:
        armature = bpy.data.objects.new("Armature", bpy.data.armatures.new("Armature"))
        bpy.context.scene.collection.objects.link(armature)
        head.parent = armature
        head.modifiers.new("Armature", "ARMATURE").object = armature
        paths = [tmp_path / f"head{number}.glb" for number in range(3)]
    for path in paths:
        write(path)
    assert min(clip_apart(path, rig, weights) for path in paths) < CLOSE


def clip_apart(path: Path, rig, weights) -> float:
    """The largest distance between the faces that a GLB plays and the rig."""
    import elastomorph as em

    plain, document, binary = curves_left_out(path)
    found = em.read_rig(plain)
    names = document["meshes"][0]["extras"]["targetNames"]
    times, table = animated_weights(document, binary)
    assert len(times) == 12
    worst = 0.0
    for time, row in zip(times, table, strict=True):
        frame = round(time * bpy.context.scene.render.fps) - 1
        now = {name: float(values[frame]) for name, values in weights.items()}
        offsets = (w * found[name].delta for name, w in zip(names, row, strict=True))
        posed = found.neutral.vertices + sum(offsets)
        worst = max(worst, apart(posed, rig.pose(now), rig))
    return worst


def curves_left_out(path):
    """A GLB whose targets are known by their names only, and its JSON and binary data."""
    content = path.read_bytes()
    length = struct.unpack("<I", content[12:16])[0]
    document = json.loads(content[20 : 20 + length])
    binary = content[28 + length :]
    for mesh in document["meshes"]:
        mesh["extras"].pop("elastomorph")
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    plain = path.with_name("plain.glb")
    plain.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    return plain, document, binary


def animated_weights(document, binary):
    """(T,) times and (T, targets) weights of the only animation of weights."""
    (animation,) = document["animations"]
    (channel,) = [c for c in animation["channels"] if c["target"]["path"] == "weights"]
    sampler = animation["samplers"][channel["sampler"]]

    def numbers(index):
        accessor = document["accessors"][index]
        assert accessor["componentType"] == 5126
        view = document["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(binary, "<f4", accessor["count"], start).astype(float)

    times = numbers(sampler["input"])
    return times, numbers(sampler["output"]).reshape(len(times), -1)


def test_fbx_holds_the_targets(tmp_path):
    """Blender's FBX, read by elastomorph: each key as Blender has it."""
    import elastomorph as em

    head, rig, _ = add_performed()
    names = [block.name for block in head.data.shape_keys.key_blocks][1:]
    offsets = {name: key_offsets(head, name) for name in names}
    write(tmp_path / "head.fbx")
    found = em.read_rig(tmp_path / "head.fbx")
    to_blender = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # Y is up in what elastomorph reads
    assert apart(found.neutral.vertices @ to_blender, rig.neutral.vertices, rig) < CLOSE
    assert {name.rpartition(":")[2] for name in found.morphs} == set(names)
    for name in names:
        assert apart(found[name].delta @ to_blender, offsets[name], rig) < CLOSE


def key_offsets(head, name: str) -> np.ndarray:
    """(V, 3) what a key adds to the basis."""
    blocks = head.data.shape_keys.key_blocks
    both = np.empty((2, 3 * len(head.data.vertices)), dtype=np.float32)
    for row, block in zip(both, (blocks[name], blocks[0]), strict=True):
        block.data.foreach_get("co", row)
    return np.subtract(*both.astype(float)).reshape(-1, 3)


@pytest.mark.parametrize("how", ["baked", "driven"])
@pytest.mark.parametrize("suffix", ["fbx", "abc", "usdc"])
def test_other_formats_play_bent(tmp_path, suffix, how):
    """As Blender imports them again."""
    _, rig, weights = add_performed()
    if how == "baked":
        bpy.ops.elastomorph.bake()
    paths = [tmp_path / f"head{n}.{suffix}" for n in range(1 if how == "baked" else 3)]
    for path in paths:
        write(path)
    assert min(frames_apart([imported(path)], rig, weights) for path in paths) < CLOSE
