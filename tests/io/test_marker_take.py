"""Takes of named markers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elastomorph.errors import FormatError
from elastomorph.io.npz.mesh import holds_markers, read_marker_take

FRAMES = np.random.default_rng(0).normal(size=(5, 4, 3))
NAMES = np.array(["chin", "lip", "brow", "nose"])


@pytest.mark.parametrize("called", ["positions", "markers", "stab"])
def test_markers_and_their_names_are_read(called: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "take.npz", names=NAMES, **{called: FRAMES})
    assert holds_markers(tmp_path / "take.npz")
    take = read_marker_take(tmp_path / "take.npz")
    np.testing.assert_array_equal(take.motion.frames, FRAMES)
    assert take.names == tuple(NAMES)
    assert len(take.motion.mesh.faces) == 0


def test_other_archives_are_none(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", frames=FRAMES)
    assert not holds_markers(tmp_path / "other.npz")
    assert not holds_markers(tmp_path / "missing.npz")
    assert not holds_markers("scan.####.obj")
    with pytest.raises(FormatError, match="positions or markers or stab"):
        read_marker_take(tmp_path / "other.npz")


def test_names_must_fit_and_numbers_be_finite(tmp_path: Path) -> None:
    np.savez(tmp_path / "few.npz", names=NAMES[:3], stab=FRAMES)
    with pytest.raises(FormatError, match="names"):
        read_marker_take(tmp_path / "few.npz")
    np.savez(tmp_path / "bad.npz", names=NAMES, stab=FRAMES * np.nan)
    with pytest.raises(FormatError, match="finite"):
        read_marker_take(tmp_path / "bad.npz")
