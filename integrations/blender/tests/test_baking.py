"""*Bake for Export*, and what Blender's exporters write of a bent face."""

import json
import struct

import bpy
import numpy as np
import pytest
from heads import (
    add_head,
    apart,
    bend_keys,
    built_in,
    evaluated,
    set_keyframes,
)
from test_bend_operator import CLOSE, frames_apart, random_weights

NAMES = ("jawOpen", "eyeBlink_L", "mouthSmile_L")


@pytest.fixture
def performed():
    """A bent head that plays random weights for 12 frames."""
    rig = built_in(*NAMES)
    head = add_head(rig)
    weights = random_weights(NAMES)
    set_keyframes(head, weights)
    for curve in curves_of(head):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    bpy.context.scene.frame_end = 12
    bpy.ops.elastomorph.bend()
    return head, rig, weights


def curves_of(head):
    animation = head.data.shape_keys.animation_data
    strip = animation.action.layers[0].strips[0]
    return strip.channelbag(animation.action_slot).fcurves


def test_keyframes_in_place_of_drivers_play_the_same(performed):
    head, rig, weights = performed
    count = len(bend_keys(head))
    assert bpy.ops.elastomorph.bake() == {"FINISHED"}
    assert not len(head.data.shape_keys.animation_data.drivers)
    assert len(bend_keys(head)) == count
    assert frames_apart([head], rig, weights) < CLOSE
    bpy.ops.elastomorph.bend()  # drivers again, and no keyframes beside them
    assert len(bend_keys(head)) == count
    assert not [curve for curve in curves_of(head) if ".bend" in curve.data_path]
    assert frames_apart([head], rig, weights) < CLOSE


def test_what_other_drivers_move_is_baked_too():
    """A slider that a property of an object drives, as rigs have them."""
    rig = built_in("jawOpen")
    head = add_head(rig)
    control = bpy.data.objects.new("Control", None)
    bpy.context.scene.collection.objects.link(control)
    block = head.data.shape_keys.key_blocks["jawOpen"]
    driver = block.driver_add("value").driver
    driver.type = "SUM"
    goal = driver.variables.new().targets[0]
    goal.id, goal.data_path = control, "location.x"
    for frame in (1, 5):
        control.location.x = (frame - 1) / 4
        control.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_end = 5
    bpy.ops.elastomorph.bend()
    for bake in (False, True):
        if bake:
            bpy.ops.elastomorph.bake()
            assert not len(head.data.shape_keys.animation_data.drivers)
        for frame in range(1, 6):
            bpy.context.scene.frame_set(frame)
            shown = rig.pose({"jawOpen": block.value})
            assert apart(evaluated(head), shown, rig) < CLOSE
        assert block.value == 1
    assert frame == 5


def test_clips_in_nla_tracks_stay_apart(performed):
    head, _, _ = performed
    animation = head.data.shape_keys.animation_data
    actions = [animation.action, animation.action.copy()]
    for action in actions:
        strip = animation.nla_tracks.new().strips.new(action.name, 1, action)
        strip.action_slot = action.slots[0]
    animation.action = None
    bpy.ops.elastomorph.bake()
    for action in actions:
        bag = action.layers[0].strips[0].channelbag(action.slots[0])
        paths = [curve.data_path for curve in bag.fcurves]
        assert len([path for path in paths if ".bend" in path]) == len(bend_keys(head))
    assert animation.action is None


@pytest.mark.parametrize("baked", [False, True])
def test_gltf_holds_the_paths_and_their_curves(performed, tmp_path, baked):
    """Blender's glTF, read by elastomorph: the same rig, with the same paths."""
    import elastomorph as em

    head, rig, _ = performed
    if baked:
        bpy.ops.elastomorph.bake()
    path = tmp_path / "head.glb"
    bpy.ops.export_scene.gltf(filepath=str(path), export_yup=False, export_normals=False)
    found = em.read_rig(path)
    assert tuple(found.morphs) == NAMES
    assert found.neutral.vertices.shape == rig.neutral.vertices.shape
    for name in NAMES:
        assert len(found[name].bends) == len(bends_of(head, name))
        for t in (0.25, 0.5, 0.75, 1.0, 1.3):
            assert apart(found.pose({name: t}), rig.pose({name: t}), rig) < CLOSE


def bends_of(head, name: str) -> list[str]:
    return [bend for bend in bend_keys(head) if bend.startswith(f"{name}.")]


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


@pytest.mark.parametrize("how", ["baked", "driven, on an armature"])
def test_gltf_clips_play_bent_without_us(performed, tmp_path, how):
    """Targets and weight keys alone, as any player has them: the poses of the rig, each frame."""
    import elastomorph as em

    head, rig, weights = performed
    if how == "baked":
        bpy.ops.elastomorph.bake()
    else:
        armature = bpy.data.objects.new("Armature", bpy.data.armatures.new("Armature"))
        bpy.context.scene.collection.objects.link(armature)
        head.parent = armature
        head.modifiers.new("Armature", "ARMATURE").object = armature
    path = tmp_path / "head.glb"
    bpy.ops.export_scene.gltf(
        filepath=str(path), export_yup=False, export_normals=False, export_skins=False
    )
    plain, document, binary = curves_left_out(path)
    found = em.read_rig(plain)
    names = document["meshes"][0]["extras"]["targetNames"]
    times, table = animated_weights(document, binary)
    fps = bpy.context.scene.render.fps
    assert len(times) == 12
    for time, row in zip(times, table, strict=True):
        frame = round(time * fps) - 1
        now = {name: float(values[frame]) for name, values in weights.items()}
        posed = found.neutral.vertices + sum(
            w * found[name].delta for name, w in zip(names, row, strict=True)
        )
        assert apart(posed, rig.pose(now), rig) < CLOSE


@pytest.mark.parametrize("baked", [False, True])
def test_fbx_holds_the_targets_and_plays_bent(performed, tmp_path, baked):
    """Blender's FBX: targets as elastomorph reads them, frames as Blender imports them again."""
    import elastomorph as em

    head, rig, weights = performed
    if baked:
        bpy.ops.elastomorph.bake()
    names = [block.name for block in head.data.shape_keys.key_blocks][1:]
    offsets = {name: key_offsets(head, name) for name in names}
    path = tmp_path / "head.fbx"
    # With these two the exporter writes the animation of shape keys only beside one of the object.
    options = {"bake_anim_use_nla_strips": False, "bake_anim_use_all_actions": False}
    upright = {"axis_forward": "Y", "axis_up": "Z"}
    bpy.ops.export_scene.fbx(
        filepath=str(path), bake_anim_simplify_factor=0.0, **options, **upright
    )
    found = em.read_rig(path)
    to_blender = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # Y is up in what elastomorph reads
    assert apart(found.neutral.vertices @ to_blender, rig.neutral.vertices, rig) < CLOSE
    assert {name.rpartition(":")[2] for name in found.morphs} == set(names)
    for name in names:
        assert apart(found[name].delta @ to_blender, offsets[name], rig) < CLOSE
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.import_scene.fbx(filepath=str(path), anim_offset=0, **upright)
    (again,) = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    assert frames_apart([again], rig, weights) < CLOSE


def key_offsets(head, name: str) -> np.ndarray:
    """(V, 3) what a key adds to the basis."""
    blocks = head.data.shape_keys.key_blocks
    both = np.empty((2, 3 * len(head.data.vertices)), dtype=np.float32)
    for row, block in zip(both, (blocks[name], blocks[0]), strict=True):
        block.data.foreach_get("co", row)
    return np.subtract(*both.astype(float)).reshape(-1, 3)


@pytest.mark.parametrize("what", ["abc", "usdc"])
def test_alembic_and_usd_play_bent(performed, tmp_path, what):
    """As Blender imports them again; drivers need no baking there."""
    _, rig, weights = performed
    path = str(tmp_path / f"head.{what}")
    if what == "abc":
        bpy.ops.wm.alembic_export(filepath=path, start=1, end=12)
    else:
        bpy.ops.wm.usd_export(filepath=path, export_animation=True, export_shapekeys=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    load = bpy.ops.wm.alembic_import if what == "abc" else bpy.ops.wm.usd_import
    load(filepath=path)
    (again,) = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    assert frames_apart([again], rig, weights) < CLOSE
