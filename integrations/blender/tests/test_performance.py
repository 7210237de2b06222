"""*Import Performance (CSV)* and *Preview Path*."""

import bpy
import numpy as np
import pytest
from heads import CLOSE, add_head, apart, bend_keys, evaluated, select, small_head

NAMES = ("jawOpen", "mouthSmile_L", "mouthSmile_R")


@pytest.fixture
def recording(tmp_path):
    """Two seconds at 60 frames a second, named as ARKit does; the jaw opens beyond its target."""
    times = np.arange(121) / 60
    weights = {
        "jawOpen": 0.6 + 0.6 * np.sin(5 * times),
        "mouthSmileLeft": 0.5 - 0.5 * np.cos(3 * times),
        "mouthSmileRight": np.linspace(0, 1, 121),
        "tongueOut": np.zeros(121),
    }
    path = tmp_path / "take.csv"
    rows = [",".join(["time", *weights])]
    for frame, time in enumerate(times):
        rows.append(",".join(f"{x:.9g}" for x in (time, *(w[frame] for w in weights.values()))))
    path.write_text("\n".join(rows))
    return path


def expected_weights(time: float) -> dict[str, float]:
    """Weights at a time that the recording has a frame for."""
    return {
        "jawOpen": 0.6 + 0.6 * np.sin(5 * time),
        "mouthSmile_L": 0.5 - 0.5 * np.cos(3 * time),
        "mouthSmile_R": time / 2,
    }


def test_a_recording_plays_on_the_frames_of_the_scene(recording):
    """At 30 frames a second every second frame of the recording; names are matched by shape."""
    rig = small_head(*NAMES)
    head = add_head(rig)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_end = 30, 10
    bpy.ops.elastomorph.bend()
    done = bpy.ops.elastomorph.import_performance(filepath=str(recording), start=11)
    assert done == {"FINISHED"}
    assert scene.frame_end == 71
    for frame in (0, 7, 19, 33, 60):
        scene.frame_set(11 + frame)
        weights = expected_weights(frame / 30)
        blocks = head.data.shape_keys.key_blocks
        assert blocks["jawOpen"].value == pytest.approx(weights["jawOpen"], abs=1e-6)
        assert apart(evaluated(head), rig.pose(weights), rig) < CLOSE


def test_bending_after_importing_plays_the_same(recording):
    rig = small_head(*NAMES)
    head = add_head(rig)
    bpy.context.scene.render.fps = 60
    bpy.ops.elastomorph.import_performance(filepath=str(recording), start=0)
    bpy.ops.elastomorph.bend()
    for frame in (0, 20, 77, 120):
        bpy.context.scene.frame_set(frame)
        assert apart(evaluated(head), rig.pose(expected_weights(frame / 60)), rig) < CLOSE


def test_all_selected_objects_play(recording):
    rig = small_head(*NAMES)
    heads = [add_head(rig, name) for name in ("Head", "Lashes")]
    select(*heads)
    bpy.context.scene.render.fps = 30
    bpy.ops.elastomorph.import_performance(filepath=str(recording))
    bpy.context.scene.frame_set(31)
    for head in heads:
        value = head.data.shape_keys.key_blocks["mouthSmile_R"].value
        assert value == pytest.approx(0.5, abs=1e-6)


def test_what_cannot_be_played_is_refused(recording, tmp_path):
    head = add_head(small_head("jawOpen"))
    broken = tmp_path / "broken.csv"
    broken.write_text("time,jawOpen\n0,nothing\n")
    with pytest.raises(RuntimeError, match=r"broken\.csv"):
        bpy.ops.elastomorph.import_performance(filepath=str(broken))
    with pytest.raises(RuntimeError, match=r"missing\.csv"):
        bpy.ops.elastomorph.import_performance(filepath=str(tmp_path / "missing.csv"))
    strange = tmp_path / "strange.csv"
    strange.write_text("time,alpha\n0,0\n1,1\n")
    with pytest.raises(RuntimeError, match="none of its weights"):
        bpy.ops.elastomorph.import_performance(filepath=str(strange))
    head.data.shape_keys.key_blocks["jawOpen"].driver_add("value")
    with pytest.raises(RuntimeError, match="jawOpen of Head has a driver"):
        bpy.ops.elastomorph.import_performance(filepath=str(recording))
    assert head.data.shape_keys.animation_data.action is None


def test_the_preview_moves_the_active_key_of_all_selected_objects():
    rig = small_head("jawOpen", "browInnerUp")
    heads = [add_head(rig, name) for name in ("Head", "Lashes")]
    select(*heads)
    bpy.ops.elastomorph.bend()
    heads[0].active_shape_key_index = 1
    assert bpy.ops.elastomorph.preview(t=0.4) == {"FINISHED"}
    for head in heads:
        assert apart(evaluated(head), rig.pose({"jawOpen": 0.4}), rig) < CLOSE
    heads[0].elastomorph_preview = 1.25  # the slider of the panel
    for head in heads:
        assert apart(evaluated(head), rig.pose({"jawOpen": 1.25}), rig) < CLOSE
    assert heads[0].elastomorph_preview == 1.25
    bends = bend_keys(heads[0])
    heads[0].active_shape_key_index = heads[0].data.shape_keys.key_blocks.find(bends[0])
    bpy.ops.elastomorph.preview(t=0.75)  # a bend stands for the key it belongs to
    assert apart(evaluated(heads[0]), rig.pose({"jawOpen": 0.75}), rig) < CLOSE


def test_a_driven_key_is_not_previewed():
    head = add_head(small_head("jawOpen"))
    head.active_shape_key_index = 1
    head.active_shape_key.driver_add("value")
    with pytest.raises(RuntimeError, match="is moved by a driver"):
        bpy.ops.elastomorph.preview(t=0.5)
