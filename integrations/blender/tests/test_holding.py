"""*Hold Lids*: the correctives of `elastomorph.hold`, driven."""

import bpy
import numpy as np
import pytest
from heads import CLOSE, add_head, apart, bend_keys, evaluated, set_weights, small_head

NAMES = ("eyeBlink_L", "eyeBlink_R", "eyeSquint_L", "eyeSquint_R", "eyeLookDown_L", "mouthSmile_L")
POSES = (
    {"eyeBlink_L": 1.0, "eyeSquint_L": 0.75, "eyeLookDown_L": 0.5},
    {"eyeBlink_L": 0.75, "eyeBlink_R": 1.0, "eyeSquint_R": 1.0, "mouthSmile_L": 1.0},
    {"eyeBlink_L": 0.5, "eyeSquint_L": 0.25},
)


@pytest.fixture
def head():
    return add_head(small_head(*NAMES))


def held_rig():
    """The rig as it is with its paths, held."""
    import elastomorph as em

    rig = em.hold(small_head(*NAMES)).rig
    assert len(rig) >= len(NAMES) + 2
    return rig


def poses_apart(thing, rig) -> float:
    worst = 0.0
    for weights in POSES:
        set_weights(thing, {name: weights.get(name, 0.0) for name in NAMES})
        worst = max(worst, apart(evaluated(thing), rig.pose(weights), rig))
    return worst


def test_a_bent_face_is_held(head):
    """As the rig is; and as before where bends are made anew or the lids are held again."""
    rig = held_rig()
    bpy.ops.elastomorph.bend()
    bends = bend_keys(head)
    assert poses_apart(head, rig) > 10 * CLOSE
    assert bpy.ops.elastomorph.hold() == {"FINISHED"}
    added = {block.name for block in head.data.shape_keys.key_blocks if "hold" in block.name}
    assert added == set(rig.morphs) - set(NAMES)
    assert poses_apart(head, rig) < CLOSE
    bpy.ops.elastomorph.bend()
    assert bend_keys(head) == bends
    assert poses_apart(head, rig) < CLOSE
    count = len(head.data.shape_keys.key_blocks)
    bpy.ops.elastomorph.hold()
    assert len(head.data.shape_keys.key_blocks) == count


def test_a_straight_face_is_held(head):
    """Lids lie no farther past each other than before, and an open eye is as it was."""
    before = {n: evaluated_at(head, weights) for n, weights in enumerate(POSES)}
    bpy.ops.elastomorph.hold()
    after = {n: evaluated_at(head, weights) for n, weights in enumerate(POSES)}
    assert np.array_equal(before[2], after[2])
    assert not np.array_equal(before[0], after[0])


def evaluated_at(thing, weights):
    set_weights(thing, {name: weights.get(name, 0.0) for name in NAMES})
    return evaluated(thing)


def test_a_face_without_lids_is_refused():
    head = add_head(small_head("jawOpen"))
    count = len(head.data.shape_keys.key_blocks)
    with pytest.raises(RuntimeError, match="no slider that shuts an eye"):
        bpy.ops.elastomorph.hold()
    assert len(head.data.shape_keys.key_blocks) == count
