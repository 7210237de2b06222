"""Pair bends and correctives: keys that follow several sliders."""

import bpy
import numpy as np
import pytest
from heads import (
    CLOSE,
    add_head,
    apart,
    bend_keys,
    evaluated,
    fcurves,
    frames_apart,
    select,
    set_keyframes,
    set_weights,
    small_head,
    split,
)

PAIR = ("jawOpen", "mouthClose")
GRID = [(0.5, 0.5), (1.0, 1.0), (0.7, 0.3), (0.2, 0.9), (0.6, 0.0), (0.5, -0.3), (1.3, 1.2)]


@pytest.fixture
def head():
    """A bent head with the two and a third."""
    thing = add_head(small_head(*PAIR, "eyeBlink_L"))
    bpy.ops.elastomorph.bend()
    return thing


def pair_keys(thing):
    return [name for name in bend_keys(thing) if name.startswith("jawOpen_mouthClose.")]


def posed_apart(thing, weights) -> float:
    """How far what Blender shows is from the rig."""
    rig = small_head(*PAIR, "eyeBlink_L")
    set_weights(thing, weights)
    return apart(evaluated(thing), rig.pose(weights), rig)


def test_two_that_meet_follow_the_path_of_both(head):
    for weights in GRID:
        assert posed_apart(head, dict(zip(PAIR, weights, strict=True))) < CLOSE
    assert pair_keys(head)
    for name in pair_keys(head):
        head.data.shape_keys.key_blocks[name].mute = True
        head.data.shape_keys.driver_remove(f'key_blocks["{name}"].mute')
    assert posed_apart(head, dict.fromkeys(PAIR, 1.0)) < CLOSE  # both targets, whatever their bends
    assert posed_apart(head, dict.fromkeys(PAIR, 0.5)) > 100 * CLOSE


def test_a_pair_bend_is_muted_with_either_key(head):
    rig = small_head(*PAIR, "eyeBlink_L")
    blocks = head.data.shape_keys.key_blocks
    set_weights(head, dict.fromkeys(PAIR, 0.5))
    for one, other in (PAIR, PAIR[::-1]):
        blocks[one].mute = True
        assert apart(evaluated(head), rig.pose({other: 0.5}), rig) < CLOSE
        blocks[one].mute = False
    assert posed_apart(head, dict.fromkeys(PAIR, 0.5)) < CLOSE


@pytest.mark.parametrize("name", PAIR)
def test_one_key_anew_is_still_one_of_a_pair(head, name):
    first, pair = bend_keys(head), pair_keys(head)
    head.active_shape_key_index = head.data.shape_keys.key_blocks.find(name)
    bpy.ops.elastomorph.bend(keys="ACTIVE")
    assert sorted(bend_keys(head)) == sorted(first)
    assert posed_apart(head, dict.fromkeys(PAIR, 0.5)) < CLOSE
    bpy.ops.elastomorph.remove(keys="ACTIVE")
    kept = [bend for bend in first if bend not in pair and not bend.startswith(f"{name}.")]
    assert bend_keys(head) == kept
    assert len(head.data.shape_keys.animation_data.drivers) == 2 * len(kept)


def test_a_pair_bend_stands_for_both_keys(head):
    rig = small_head(*PAIR, "eyeBlink_L")
    names, pair = bend_keys(head), pair_keys(head)
    head.active_shape_key_index = head.data.shape_keys.key_blocks.find(pair[0])
    bpy.ops.elastomorph.preview(t=0.4)
    assert apart(evaluated(head), rig.pose(dict.fromkeys(PAIR, 0.4)), rig) < CLOSE
    head.elastomorph_preview = 0.6  # the slider of the panel
    assert head.elastomorph_preview == pytest.approx(0.6)
    assert apart(evaluated(head), rig.pose(dict.fromkeys(PAIR, 0.6)), rig) < CLOSE
    bpy.ops.elastomorph.bend(keys="ACTIVE")
    assert sorted(bend_keys(head)) == sorted(names)
    head.active_shape_key_index = head.data.shape_keys.key_blocks.find(pair[0])
    bpy.ops.elastomorph.remove(keys="ACTIVE")
    assert {name.partition(".")[0] for name in bend_keys(head)} == {"eyeBlink_L"}


def test_renamed_keys_are_told_apart(head):
    names = bend_keys(head)
    blocks = head.data.shape_keys.key_blocks
    blocks[pair_keys(head)[0]].name = "mouthClose_jawOpen"
    bpy.ops.elastomorph.bend()
    assert bend_keys(head) == names
    assert "mouthClose_jawOpen" not in blocks
    blocks["mouthClose"].name = "lipsTogether"
    bpy.ops.elastomorph.bend()
    renamed = [name.replace("mouthClose", "lipsTogether") for name in names]
    assert bend_keys(head) == renamed
    bpy.ops.elastomorph.remove()
    assert not bend_keys(head)
    assert not len(head.data.shape_keys.animation_data.drivers)


def test_an_object_without_one_of_the_keys_has_no_pair_bend():
    """Cut off a part and take a key from it: its other key bends as alone."""
    rig = small_head(*PAIR)
    moves = np.linalg.norm(rig["jawOpen"].delta, axis=1)
    lower = moves > 0.5 * moves.max()
    head, jaw = add_head(rig, kept=~lower), add_head(rig, "Jaw", lower)
    select(head, jaw)
    bpy.ops.elastomorph.bend()
    assert pair_keys(head)
    assert pair_keys(jaw)
    cut = split(rig, lower)
    weights = dict.fromkeys(PAIR, 0.5)
    for thing in (head, jaw):
        set_weights(thing, weights)
    assert apart(evaluated(head, jaw), cut.pose(weights), cut) < CLOSE
    jaw.shape_key_remove(jaw.data.shape_keys.key_blocks["mouthClose"])
    bpy.ops.elastomorph.bend()
    assert not pair_keys(jaw)


def test_baked_pairs_play_the_same():
    """Of two sliders one moves, and the other stands still without keyframes."""
    rig = small_head(*PAIR)
    head = add_head(rig)
    bpy.ops.elastomorph.bend()
    frames = np.linspace(0, 1, 9).astype(np.float32)
    set_keyframes(head, {"jawOpen": frames})
    bpy.context.scene.frame_end = 9
    set_weights(head, {"mouthClose": 0.5})
    weights = {"jawOpen": frames, "mouthClose": np.full(9, 0.5)}
    for curve in fcurves(head.data.shape_keys.animation_data):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    assert frames_apart([head], rig, weights) < CLOSE
    bpy.ops.elastomorph.bake()
    assert not len(head.data.shape_keys.animation_data.drivers)
    assert frames_apart([head], rig, weights) < CLOSE
    moving = [curve.data_path for curve in fcurves(head.data.shape_keys.animation_data)]
    assert all(f'key_blocks["{name}"].value' in moving for name in pair_keys(head))


@pytest.fixture
def rig():
    """A rig with two correctives by laws, one of which bends, and the pair bend."""
    import elastomorph as em

    known = small_head(*PAIR, "eyeBlink_L", "mouthSmile_L", "browInnerUp")
    ends = {name: known[name].target for name in known.names[:-1]}
    half = known.neutral.vertices + 0.3 * known["jawOpen"].delta
    ends["wide"] = known.neutral.with_vertices(half)
    ends["shut"] = known["browInnerUp"].target
    laws = {
        "wide": em.Corrective(("eyeBlink_L", "mouthSmile_L")),
        "shut": em.Corrective(("eyeBlink_L", "mouthSmile_L"), "hinge", (0.9, 0.7)),
    }
    made = em.Rig(known.neutral, ends, correctives=laws)
    assert len(made["wide"].bends)
    return made


WEIGHTS = (
    {"eyeBlink_L": 0.5, "mouthSmile_L": 0.25},
    {"eyeBlink_L": 1.0, "mouthSmile_L": 0.75, "jawOpen": 0.25},
    {"eyeBlink_L": 0.75, "mouthSmile_L": 1.25, "jawOpen": 0.5, "mouthClose": 0.75},
)


@pytest.fixture
def came(rig, tmp_path):
    """The head of a file that elastomorph wrote, as Blender imports it."""
    import elastomorph as em

    em.write(tmp_path / "rig.glb", rig)
    bpy.ops.import_scene.gltf(filepath=str(tmp_path / "rig.glb"))
    (thing,) = bpy.context.selected_objects
    thing.active_shape_key_index = thing.data.shape_keys.key_blocks.find("mouthSmile_L")
    return thing


def poses_apart(thing, rig) -> float:
    """The largest distance between what Blender shows and the rig, in all of the poses."""
    to_blender = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    worst = 0.0
    for weights in WEIGHTS:
        set_weights(thing, {name: weights.get(name, 0.0) for name in rig.names})
        worst = max(worst, apart(evaluated(thing), rig.pose(weights) @ to_blender, rig))
    return worst


def test_correctives_that_came_with_a_file_are_driven(came, rig):
    import elastomorph as em

    bpy.ops.elastomorph.bend(keys="ACTIVE", method="linear")  # adopts what is not made anew
    count = len(bend_keys(came))
    assert len(came.data.shape_keys.animation_data.drivers) == 2 * count + 2
    assert "elastomorph" not in came.data
    straight = em.interpolate(rig.neutral, rig["mouthSmile_L"].target, "linear")
    morphs = {**rig.morphs, "mouthSmile_L": straight}
    expected = em.Rig(rig.neutral, morphs, correctives=rig.sliders.correctives)
    assert poses_apart(came, expected) < CLOSE


def test_correctives_stay_where_bends_are_removed(came, rig):
    import elastomorph as em

    bpy.ops.elastomorph.remove()
    assert not bend_keys(came)
    assert len(came.data.shape_keys.animation_data.drivers) == 2
    ends = {name: m.target for name, m in rig.morphs.items() if m.delta.any()}
    laws = {name: rig.sliders.correctives[name] for name in ("wide", "shut")}
    straight = em.Rig(rig.neutral, ends, correctives=laws, method="linear")
    assert poses_apart(came, straight) < CLOSE


def test_correctives_are_baked_and_driven_again(came, rig):
    bpy.ops.elastomorph.bend()
    before = [evaluated_at(came, weights, rig) for weights in WEIGHTS]
    frames = {n: [w.get(n, 0.0) for w in WEIGHTS] for n in rig.names}
    set_keyframes(came, frames)
    bpy.context.scene.frame_end = len(WEIGHTS)
    bpy.ops.elastomorph.bake()
    assert not len(came.data.shape_keys.animation_data.drivers)
    for driven in (False, True):
        if driven:
            bpy.ops.elastomorph.bend()
        for frame, expected in enumerate(before, start=1):
            bpy.context.scene.frame_set(frame)
            assert apart(evaluated(came), expected, rig) < CLOSE
    count = len(bend_keys(came))
    assert len(came.data.shape_keys.animation_data.drivers) == 2 * count + 2


def evaluated_at(thing, weights, rig):
    set_weights(thing, {name: weights.get(name, 0.0) for name in rig.names})
    return evaluated(thing)


def test_a_recording_leaves_correctives_alone(came, tmp_path):
    bpy.ops.elastomorph.bend()
    take = tmp_path / "take.csv"
    take.write_text("time,wide,eyeBlink_L,mouthSmile_L\n0,1,0.5,0.5\n1,0,1,0.5\n")
    assert bpy.ops.elastomorph.import_performance(filepath=str(take)) == {"FINISHED"}
    bpy.context.scene.frame_set(1)
    evaluated(came)
    assert came.data.shape_keys.key_blocks["wide"].value == pytest.approx(0.25)


def test_gltf_holds_pairs_and_laws(came, rig, tmp_path):
    """Blender's glTF, read by elastomorph."""
    import elastomorph as em

    bpy.ops.elastomorph.bend()
    path = tmp_path / "again.glb"
    bpy.ops.export_scene.gltf(filepath=str(path), export_normals=False, export_skins=False)
    found = em.read_rig(path)
    assert dict(found.sliders.correctives) == dict(rig.sliders.correctives)
    assert {*found.morphs} == {*rig.morphs}
    assert not found["jawOpen_mouthClose"].delta.any()
    for weights in WEIGHTS:
        shown = evaluated_at(came, weights, rig)
        to_file = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        assert apart(shown @ to_file, found.pose(weights), rig) < CLOSE
