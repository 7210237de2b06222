"""A recorded motion."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence

FRAMES = np.random.default_rng(0).normal(size=(5, 4, 3))
MESH = Mesh(FRAMES[0])


def test_times_are_spread_from_zero_to_one_by_default() -> None:
    sequence = MeshSequence(MESH, FRAMES)
    np.testing.assert_array_equal(sequence.times, [0, 0.25, 0.5, 0.75, 1])
    np.testing.assert_array_equal(sequence.neutral.vertices, FRAMES[0])
    np.testing.assert_array_equal(sequence.target.vertices, FRAMES[-1])
    assert len(list(sequence)) == 5


def test_given_times_are_scaled_to_the_unit_interval() -> None:
    sequence = MeshSequence(MESH, FRAMES, times=[10, 11, 12, 16, 20])
    np.testing.assert_allclose(sequence.times, [0, 0.1, 0.2, 0.6, 1])


def test_a_part_runs_forwards_or_backwards() -> None:
    sequence = MeshSequence(MESH, FRAMES, names=list("abcde"))
    back = sequence.part(3, 1)
    np.testing.assert_array_equal(back.frames, FRAMES[[3, 2, 1]])
    np.testing.assert_allclose(back.times, [0, 0.5, 1])
    assert back.names == ("d", "c", "b")


@pytest.mark.parametrize("times", [[0, 1, 1, 2, 3], [0, 1, 2, 3], [0, 1, 2, 3, np.nan]])
def test_times_must_rise(times: list[float]) -> None:
    with pytest.raises(ParameterError, match="rise"):
        MeshSequence(MESH, FRAMES, times=times)


@pytest.mark.parametrize("number", [np.nan, np.inf, -1e300])
def test_a_frame_beyond_all_lengths_is_named(number: float) -> None:
    frames = np.zeros((3, 3, 3))
    frames[1, 2, 0] = number
    with pytest.raises(MeshError, match=r"frame 1 has coordinates that are not finite .* 1e\+75"):
        MeshSequence(Mesh(np.eye(3)), frames)


def test_frames_must_fit_the_mesh() -> None:
    with pytest.raises(MeshError, match="shape"):
        MeshSequence(MESH, FRAMES[:, :3])
    with pytest.raises(MeshError, match="T ≥ 2"):
        MeshSequence(MESH, FRAMES[:1])
    bad = FRAMES.copy()
    bad[2, 0, 0] = np.nan
    with pytest.raises(MeshError, match="frame 2"):
        MeshSequence(MESH, bad)
    with pytest.raises(ParameterError, match="5 frame names"):
        MeshSequence(MESH, FRAMES, names=["a"])
