"""Which frames of a take are shown."""

from __future__ import annotations

import numpy as np

from elastomorph.draw.take_strip import telling_frames


def test_the_most_active_frame_then_the_least_alike() -> None:
    """Frame 9 does most; 3 and 4 are alike, so only the farther one of them comes next."""
    weights = np.zeros((10, 2))
    weights[3, 0] = 0.5
    weights[4, 0] = 0.6
    weights[9] = [0, 1]
    assert telling_frames(weights, 1).tolist() == [9]
    assert telling_frames(weights, 2).tolist() == [4, 9]
    assert telling_frames(weights[:1], 5).tolist() == [0]
    assert telling_frames(weights[:4], 9).tolist() == [0, 1, 2, 3]
