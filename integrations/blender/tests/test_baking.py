"""*Bake for Export*: keyframes in place of drivers."""

import bpy
from heads import (
    CLOSE,
    add_head,
    add_performed,
    apart,
    bend_keys,
    curves_of,
    evaluated,
    fcurves,
    frames_apart,
    small_head,
)


def test_keyframes_in_place_of_drivers_play_the_same():
    head, rig, weights = add_performed()
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
    rig = small_head("jawOpen")
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
    for curve in fcurves(control.animation_data):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    bpy.context.scene.frame_end = 5
    bpy.ops.elastomorph.bend()
    for bake in (False, True):
        if bake:
            bpy.ops.elastomorph.bake()
            assert not len(head.data.shape_keys.animation_data.drivers)
        for frame in range(1, 6):
            bpy.context.scene.frame_set(frame)
            shown = evaluated(head)
            assert apart(shown, rig.pose({"jawOpen": block.value}), rig) < CLOSE
            assert abs(block.value - (frame - 1) / 4) < 1e-6


def test_clips_in_nla_tracks_stay_apart():
    head, _, _ = add_performed()
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
