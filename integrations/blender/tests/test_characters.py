"""Faces as characters have them: modifiers, armatures, teeth on a bone."""

import bpy
import numpy as np
from heads import (
    CLOSE,
    add_head,
    apart,
    bend_keys,
    evaluated,
    select,
    set_weights,
    small_head,
    split,
    stored,
)

WEIGHTS = ({"jawOpen": 0.5}, {"jawOpen": 0.3, "eyeBlink_L": 0.6})


def add_armature(rig):
    """A bone 'head' in a pose, from the middle of the face upward."""
    data = bpy.data.armatures.new("Armature")
    armature = bpy.data.objects.new("Armature", data)
    bpy.context.scene.collection.objects.link(armature)
    select(armature)
    bpy.ops.object.mode_set(mode="EDIT")
    bone = data.edit_bones.new("head")
    bone.head = rig.neutral.vertices.mean(axis=0)
    bone.tail = bone.head + type(bone.head)((0.0, 2.0, 1.0))
    bpy.ops.object.mode_set(mode="OBJECT")
    posed = armature.pose.bones["head"]
    posed.rotation_mode = "XYZ"
    posed.rotation_euler, posed.location = (0.5, 0.2, -0.3), (1, 2, 3)
    armature.location = (5, 0, 0)
    bpy.context.view_layer.update()
    return armature


def hang(thing, armature, height):
    """Parent an object to an armature, by weights that rise with its height."""
    thing.parent = armature
    group = thing.vertex_groups.new(name="head")
    for vertex, weight in enumerate(height):
        group.add([vertex], float(weight), "REPLACE")
    modifier = thing.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    thing.modifiers.new("Subdivision", "SUBSURF").levels = 1


def test_modifiers_follow_the_bent_shape():
    """The same modifiers on the pose of the rig, as a mesh without shape keys, give the same."""
    rig = small_head("jawOpen", "eyeBlink_L")
    up = rig.neutral.vertices[:, 2]
    height = np.clip((up - up.min()) / np.ptp(up), 0, 1)
    armature = add_armature(rig)
    plain = add_head(rig, "Plain")
    plain.shape_key_clear()
    head = add_head(rig)
    for thing in (plain, head):
        hang(thing, armature, height)
    select(head)
    assert bpy.ops.elastomorph.bend() == {"FINISHED"}
    for weights in WEIGHTS:
        set_weights(head, weights)
        plain.data.vertices.foreach_set("co", rig.pose(weights).astype(np.float32).ravel())
        plain.data.update()
        found, expected = evaluated(head), evaluated(plain)
        assert len(found) > 3 * len(rig.neutral.vertices)
        assert apart(found, expected, rig) < 2 * CLOSE  # weights of the posed bone turn errors too


def test_teeth_on_a_bone_count_where_they_are_at_rest():
    """While the bone that carries them is in a pose, they stand elsewhere in the world."""
    rig = small_head("jawOpen")
    moves = np.linalg.norm(rig["jawOpen"].delta, axis=1)
    lower = moves > 0.5 * moves.max()
    armature = add_armature(rig)
    head, teeth = add_head(rig, kept=~lower), add_head(rig, "Teeth", lower)
    bone = armature.pose.bones["head"]
    pose = bone.matrix_basis.copy()
    bone.matrix_basis.identity()
    bpy.context.view_layer.update()
    for thing in (head, teeth):
        at_rest = thing.matrix_world.copy()
        thing.parent, thing.parent_type, thing.parent_bone = armature, "BONE", "head"
        bpy.context.view_layer.update()
        thing.matrix_world = at_rest
    head.parent_type, head.parent_bone = "OBJECT", ""
    bpy.context.view_layer.update()
    head.matrix_world.identity()
    bpy.context.view_layer.update()
    bone.matrix_basis = pose
    bpy.context.view_layer.update()
    select(head, teeth)
    assert bpy.ops.elastomorph.bend() == {"FINISHED"}
    assert bend_keys(teeth)
    bone.matrix_basis.identity()
    bpy.context.view_layer.update()
    cut = split(rig, lower)
    for t in (0.4, 0.8):
        for thing in (head, teeth):
            set_weights(thing, {"jawOpen": t})
        assert apart(evaluated(head, teeth), cut.pose({"jawOpen": t}), cut) < CLOSE


def test_the_built_in_head_bends():
    """With eyes, teeth and lashes in its 23,979 vertices."""
    import elastomorph as em

    names = ("jawOpen", "mouthClose", "eyeBlinkLeft", "mouthPucker", "cheekPuff")
    rig = stored(em.read_rig("built-in"), *names)
    head = add_head(rig)
    assert bpy.ops.elastomorph.bend() == {"FINISHED"}
    assert len(bend_keys(head)) > 3
    assert "jawOpen_mouthClose.bend1" in bend_keys(head)
    several = {"jawOpen": 0.4, "eyeBlinkLeft": 0.5, "mouthPucker": 0.7}
    for weights in ({"jawOpen": 0.5}, several, {"jawOpen": 0.6, "mouthClose": 0.5}):
        set_weights(head, {name: weights.get(name, 0.0) for name in names})
        assert apart(evaluated(head), rig.pose(weights), rig) < CLOSE
