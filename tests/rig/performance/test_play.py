"""A performance on a rig is the rig, posed frame by frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_rigs import small_rig

import elastomorph as em
from elastomorph.errors import ParameterError
from elastomorph.io.performance.livelink import read_livelink
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance, match, play, slider_weights

RECORDED = ["HeadYaw", "MouthClose", "BrowInnerUp", "TongueOut", "JawOpen"]


def take() -> Performance:
    weights = np.random.default_rng(1).uniform(-0.2, 1.3, (9, len(RECORDED)))
    return Performance(RECORDED, np.arange(9) / 30, weights, 30)


@pytest.mark.parametrize("block", [None, 1, 4])
def test_every_frame_is_the_pose_by_hand(block: int | None) -> None:
    """Also outside 0 and 1, where paths go on along their tangents."""
    rig, performance = small_rig(), take()
    count = 0
    for row, face in zip(
        performance.weights, play(rig, performance, dtype=np.float64, block=block), strict=True
    ):
        recorded = dict(zip(RECORDED, row, strict=True))
        by_hand = rig.pose(
            {
                "jawOpen": recorded["JawOpen"],
                "mouthClose": recorded["MouthClose"],
                "browInnerUp_L": recorded["BrowInnerUp"],
                "browInnerUp_R": recorded["BrowInnerUp"],
            }
        )
        np.testing.assert_allclose(face, by_hand, atol=1e-12)
        count += 1
    assert count == len(performance)


def test_clipped_weights_stay_within_0_and_1() -> None:
    rig, performance = small_rig(), take()
    free = slider_weights(rig, performance)
    kept = slider_weights(rig, performance, clip=True)
    assert free.min() < 0
    assert free.max() > 1
    np.testing.assert_array_equal(kept, np.clip(free, 0, 1))
    faces = [face.copy() for face in play(rig, performance, clip=True, dtype=np.float64)]
    np.testing.assert_allclose(faces, rig.batch(kept, dtype=np.float64), atol=1e-12)


def test_nothing_matched_is_the_neutral() -> None:
    rig = small_rig()
    still = Performance(["HeadYaw", "other"], [0, 1], [[1, 1], [2, 2]], 1)
    for face in play(rig, still):
        np.testing.assert_array_equal(face, rig.neutral.vertices)


def test_the_match_must_be_of_this_rig_and_recording() -> None:
    rig = small_rig()
    other = match(["JawOpen"], rig.names)
    with pytest.raises(ParameterError, match="another recording or rig"):
        slider_weights(rig, take(), other)
    with pytest.raises(ParameterError, match="another recording or rig"):
        next(iter(play(rig, take(), match(RECORDED, ["jawOpen"]))))


@pytest.mark.realdata
def test_a_real_take_on_real_shapes(data_dir: Path) -> None:
    """On straight paths every frame is V₀ + Σ w Δ, with both brows by the one weight recorded."""
    meshes = data_dir / "ict-facekit"
    neutral = em.read(meshes / "generic_neutral_mesh.obj")
    names = ["browInnerUp_L", "browInnerUp_R", "jawOpen", "mouthSmile_R"]
    targets = {name: em.read(meshes / f"{name}.obj") for name in names}
    rig = Rig(neutral, {n: em.interpolate(neutral, t, "linear") for n, t in targets.items()})
    performance = read_livelink(data_dir / "livelink" / "rom_3.csv").part(75.8, 75.9)
    columns = ["BrowInnerUp", "BrowInnerUp", "JawOpen", "MouthSmileRight"]
    recorded = performance.weights[:, [performance.names.index(name) for name in columns]]
    assert recorded[:, 2].max() > 0.9
    deltas = np.stack([target.vertices - neutral.vertices for target in targets.values()])
    for weights, face in zip(recorded, play(rig, performance), strict=True):
        by_hand = neutral.vertices + np.einsum("j,jvk->vk", weights, deltas)
        np.testing.assert_allclose(face, by_hand, atol=1e-5)
