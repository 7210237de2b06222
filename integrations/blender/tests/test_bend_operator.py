"""*Bend Shape Keys* and *Remove Bends*: what Blender shows is what elastomorph computes."""

import bpy
import numpy as np
import pytest
from heads import (
    CLOSE,
    add_head,
    apart,
    bend_keys,
    evaluated,
    frames_apart,
    random_weights,
    select,
    set_keyframes,
    set_weights,
    small_head,
    split,
    with_paths,
)
from mathutils import Matrix

SOME = ("jawOpen", "eyeBlink_L", "mouthSmile_L", "browInnerUp", "cheekPuff")


def test_every_frame_is_the_pose_of_the_rig():
    """All targets of the small head at once, stored as closely as single precision can."""
    rig = small_head()
    head = add_head(rig)
    weights = random_weights(rig.names, 8)
    set_keyframes(head, weights)
    straight = frames_apart([head], rig, weights)
    assert bpy.ops.elastomorph.bend(tolerance=1e-7) == {"FINISHED"}
    assert frames_apart([head], rig, weights) < CLOSE
    assert straight > 100 * CLOSE  # the bends are what makes it so


def test_each_target_is_within_the_tolerance():
    rig = small_head()
    head = add_head(rig)
    bpy.ops.elastomorph.bend()
    for name in {bend.rpartition(".")[0] for bend in bend_keys(head)}.intersection(rig.names):
        for t in (0.2, 0.5, 0.8, 1.0):
            set_weights(head, {name: t})
            assert apart(evaluated(head), rig.pose({name: t}), rig) < 1.1 * CLOSE
        set_weights(head, {name: 0.0})


def test_paths_go_on_straight_beyond_their_ends():
    rig = small_head(*SOME)
    head = add_head(rig)
    weights = random_weights(SOME, 12, -0.5, 1.5)
    set_keyframes(head, weights)
    bpy.ops.elastomorph.bend()
    assert frames_apart([head], rig, weights) < CLOSE


@pytest.mark.parametrize("method", ["arc", "beam:3", "plate:2", "cosine", "ease:3"])
def test_each_method_is_as_elastomorph_computes_it(method):
    known = small_head("jawOpen", "mouthSmile_L")
    targets = {name: known[name].target for name in known.names}
    rig = with_paths(known.neutral, targets, method)
    head = add_head(rig)
    weights = random_weights(known.names, 6)
    set_keyframes(head, weights)
    assert bpy.ops.elastomorph.bend(method=method) == {"FINISHED"}
    assert frames_apart([head], rig, weights) < CLOSE


def test_drivers_need_no_permission_to_run_scripts():
    rig = small_head()
    head = add_head(rig)
    bpy.ops.elastomorph.bend()
    drivers = head.data.shape_keys.animation_data.drivers
    assert len(drivers) == 2 * len(bend_keys(head))  # of the weight, and of being muted
    for followed in drivers:
        driver = followed.driver
        assert driver.type == "MAX" or driver.is_simple_expression
        assert driver.is_valid


def test_bending_again_replaces_bends():
    rig = small_head("jawOpen", "eyeBlink_L")
    head = add_head(rig)
    bpy.ops.elastomorph.bend()
    first = bend_keys(head)
    bpy.ops.elastomorph.bend(method="cosine")
    bpy.ops.elastomorph.bend()
    assert bend_keys(head) == first
    assert len(head.data.shape_keys.animation_data.drivers) == 2 * len(first)
    head.data.shape_keys.key_blocks[first[0]].name = "renamed"
    bpy.ops.elastomorph.bend()
    assert bend_keys(head) == first
    assert "renamed" not in head.data.shape_keys.key_blocks


def test_one_key_leaves_the_others_as_they_are():
    rig = small_head("jawOpen", "eyeBlink_L")
    head = add_head(rig)
    head.active_shape_key_index = 1
    assert head.active_shape_key.name == "jawOpen"
    bpy.ops.elastomorph.bend(keys="ACTIVE")
    assert {name.partition(".")[0] for name in bend_keys(head)} == {"jawOpen"}
    head.active_shape_key_index = 2
    bpy.ops.elastomorph.bend(keys="ACTIVE")
    assert {name.partition(".")[0] for name in bend_keys(head)} == {"jawOpen", "eyeBlink_L"}
    bpy.ops.elastomorph.remove(keys="ACTIVE")
    assert {name.partition(".")[0] for name in bend_keys(head)} == {"jawOpen"}
    set_weights(head, {"jawOpen": 0.5})
    assert apart(evaluated(head), rig.pose({"jawOpen": 0.5}), rig) < CLOSE


def test_removed_bends_leave_nothing():
    rig = small_head("jawOpen", "eyeBlink_L")
    head = add_head(rig)
    before = [block.name for block in head.data.shape_keys.key_blocks]
    bpy.ops.elastomorph.bend()
    bpy.ops.elastomorph.remove()
    keys = head.data.shape_keys
    assert [block.name for block in keys.key_blocks] == before
    assert not len(keys.animation_data.drivers)
    assert not [*keys.keys()]
    set_weights(head, {"jawOpen": 0.5})
    straight = rig.neutral.vertices + 0.5 * rig["jawOpen"].delta
    assert apart(evaluated(head), straight, rig) < 1e-6


def test_two_objects_are_one_face():
    """Cut off the lower jaw: it still follows the joint it shares with the rest."""
    rig = small_head("jawOpen", "mouthSmile_L")
    moves = np.linalg.norm(rig["jawOpen"].delta, axis=1)
    lower = moves > 0.5 * moves.max()
    head, jaw = add_head(rig, kept=~lower), add_head(rig, "Jaw", lower)
    # Objects of their own place, turn and scale: what counts is where they are in the world.
    placing = (
        Matrix.Translation((1, 2, 3))
        @ Matrix.Rotation(0.7, 4, "X")
        @ Matrix.Diagonal((2, 1, 0.5, 1))
    )
    jaw.data.transform(placing.inverted(), shape_keys=True)
    jaw.matrix_world = placing
    select(head, jaw)
    assert bpy.ops.elastomorph.bend() == {"FINISHED"}
    assert bend_keys(head)
    assert bend_keys(jaw)
    cut = split(rig, lower)
    for t in (0.3, 0.6, 1.0):
        weights = {"jawOpen": t, "mouthSmile_L": 1 - t}
        set_weights(head, weights)
        set_weights(jaw, weights)
        assert apart(evaluated(head, jaw), cut.pose(weights), cut) < CLOSE


def test_saved_and_loaded_it_is_the_same(tmp_path):
    rig = small_head("jawOpen", "mouthClose")
    head = add_head(rig)
    weights = random_weights(rig.names, 5)
    set_keyframes(head, weights)
    bpy.ops.elastomorph.bend()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "head.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "head.blend"), use_scripts=False)
    loaded = bpy.data.objects["Head"]
    assert frames_apart([loaded], rig, weights) < CLOSE
    select(loaded)
    count = len(bend_keys(loaded))
    bpy.ops.elastomorph.bend()
    assert len(bend_keys(loaded)) == count


def test_each_operator_is_one_step_of_undo():
    """Called as a user does, with undo: bend, bake and remove, and the three of them undone."""
    rig = small_head("jawOpen", "mouthClose")
    add_head(rig)
    bpy.ops.ed.undo_push(message="before")
    states = [state()]
    for operator in ("bend", "bake", "remove"):
        getattr(bpy.ops.elastomorph, operator)("EXEC_DEFAULT", True)
        states.append(state())
    bent, _ = states[1]
    assert bent
    assert states == [([], 0), (bent, 2 * len(bent)), (bent, 0), ([], 0)]
    for expected in states[-2::-1]:
        bpy.ops.ed.undo()
        assert state() == expected
    bpy.ops.ed.redo()
    head = bpy.data.objects["Head"]
    weights = {"jawOpen": 0.5, "mouthClose": 0.5}
    set_weights(head, weights)
    assert apart(evaluated(head), rig.pose(weights), rig) < CLOSE


def state() -> tuple[list[str], int]:
    """The bends of the head, and how many drivers it has."""
    head = bpy.data.objects["Head"]
    animation = head.data.shape_keys.animation_data
    return bend_keys(head), len(animation.drivers) if animation else 0


def test_a_copy_follows_its_own_sliders():
    rig = small_head("jawOpen")
    head = add_head(rig)
    bpy.ops.elastomorph.bend()
    bpy.ops.object.duplicate()
    copy = bpy.context.active_object
    assert copy != head
    set_weights(head, {"jawOpen": 0.2})
    set_weights(copy, {"jawOpen": 0.7})
    assert apart(evaluated(head), rig.pose({"jawOpen": 0.2}), rig) < CLOSE
    assert apart(evaluated(copy), rig.pose({"jawOpen": 0.7}), rig) < CLOSE
    bpy.ops.elastomorph.bend()
    assert bend_keys(copy) == bend_keys(head)


def test_seams_hold():
    """Vertices that an importer split where a texture ends move as one."""
    import elastomorph as em

    rig = small_head("jawOpen", "mouthSmile_L")
    sides = [rig.neutral.vertices[face, 0].mean() > 0 for face in rig.neutral.faces]
    count = len(rig.neutral.vertices)
    faces = [f + count * side for f, side in zip(rig.neutral.faces, sides, strict=True)]
    used, corners = np.unique(np.concatenate(faces), return_inverse=True)
    cuts = np.cumsum([len(face) for face in faces])[:-1]
    assert count < len(used) < 2 * count
    neutral = em.Mesh(rig.neutral.vertices[used % count], np.split(corners, cuts))
    targets = {n: neutral.with_vertices(rig[n].target.vertices[used % count]) for n in rig}
    head = add_head(em.Rig(neutral, targets, method="linear"))
    bpy.ops.elastomorph.bend()
    weights = {"jawOpen": 0.5, "mouthSmile_L": 0.4}
    set_weights(head, weights)
    assert apart(evaluated(head), rig.pose(weights)[used % count], rig) < CLOSE


def test_a_muted_key_mutes_its_bends():
    rig = small_head("jawOpen")
    head = add_head(rig)
    bpy.ops.elastomorph.bend()
    set_weights(head, {"jawOpen": 0.5})
    head.data.shape_keys.key_blocks["jawOpen"].mute = True
    assert apart(evaluated(head), rig.neutral.vertices, rig) < 1e-7
    head.data.shape_keys.key_blocks["jawOpen"].mute = False
    assert apart(evaluated(head), rig.pose({"jawOpen": 0.5}), rig) < CLOSE


def test_vertex_groups_and_relative_keys_count():
    """The target is what the key adds: from its relative key, within its vertex group."""
    rig = small_head("jawOpen", "browInnerUp")
    head = add_head(rig)
    blocks = head.data.shape_keys.key_blocks
    x = rig.neutral.vertices[:, 0]
    shares = np.clip(0.5 + x / np.ptp(x), 0, 1).astype(np.float32)
    group = head.vertex_groups.new(name="left")
    for vertex, share in enumerate(shares):
        group.add([vertex], float(share), "REPLACE")
    blocks["jawOpen"].vertex_group = "left"
    both = rig["jawOpen"].delta + rig["browInnerUp"].delta + rig.neutral.vertices
    blocks["jawOpen"].data.foreach_set("co", both.astype(np.float32).ravel())
    blocks["jawOpen"].relative_key = blocks["browInnerUp"]
    bpy.ops.elastomorph.bend()
    neutral = rig.neutral
    half = neutral.with_vertices(neutral.vertices + shares[:, None] * rig["jawOpen"].delta)
    shown = with_paths(neutral, {"jawOpen": half, "browInnerUp": rig["browInnerUp"].target})
    for t in (0.25, 0.5, 1.0):
        set_weights(head, {"jawOpen": t, "browInnerUp": 1 - t})
        expected = shown.pose({"jawOpen": t, "browInnerUp": 1 - t})
        assert apart(evaluated(head), expected, shown) < CLOSE


@pytest.mark.parametrize("keys", ["ALL", "ACTIVE"])
def test_bends_that_came_with_a_file_are_replaced(tmp_path, keys):
    """A bent file is not bent twice: its bends are known, and those not made anew are driven."""
    import elastomorph as em

    rig = small_head("jawOpen", "eyeBlink_L")
    em.write(tmp_path / "bent.glb", rig)
    bpy.ops.import_scene.gltf(filepath=str(tmp_path / "bent.glb"))
    (head,) = bpy.context.selected_objects
    names = bend_keys(head)
    assert len(names) == 4
    head.active_shape_key_index = 1
    assert bpy.ops.elastomorph.bend(keys=keys) == {"FINISHED"}
    assert sorted(bend_keys(head)) == sorted(names)
    assert len(head.data.shape_keys.animation_data.drivers) == 2 * len(names)
    assert "elastomorph" not in head.data
    set_weights(head, {"jawOpen": 0.4, "eyeBlink_L": 0.7})
    # The triangles of the file, as Blender turned them: what is above has z.
    to_blender = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    faces = [[*polygon.vertices] for polygon in head.data.polygons]
    neutral = em.Mesh(rig.neutral.vertices @ to_blender, faces)
    ends = {n: neutral.with_vertices(rig[n].target.vertices @ to_blender) for n in rig}
    again = with_paths(neutral, ends)
    kept = rig.pose({"eyeBlink_L": 0.7}) @ to_blender  # bent along the polygons of the writer
    eye = again.pose({"eyeBlink_L": 0.7}) if keys == "ALL" else kept
    expected = again.pose({"jawOpen": 0.4}) + eye - neutral.vertices
    assert apart(evaluated(head), expected, again) < CLOSE
