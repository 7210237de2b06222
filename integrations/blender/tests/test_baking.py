"""*Bake for Export*, and what Blender's exporters write of a bent face."""

import bpy
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
