"""The files that the documentation speaks of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io.sample_files import write_samples
from elastomorph.samples import head


def test_samples_are_read_again_and_nothing_is_written_over(tmp_path: Path) -> None:
    written = write_samples(tmp_path / "try")
    assert all(path.exists() for path in written)
    neutral = em.read(tmp_path / "try" / "neutral.obj")
    np.testing.assert_allclose(neutral.vertices, head().vertices, atol=1e-6)
    assert len(em.read_sequence(tmp_path / "try" / "scan.####.obj")) == 11
    for rig in ("head.glb", "avatar.glb", "face", "ada"):
        assert set(em.read_rig(tmp_path / "try" / rig).names) >= {"jawOpen", "cheekPuff"}
    straight = em.read_rig(tmp_path / "try" / "avatar.glb")
    assert not any(len(morph.bends) for morph in straight.morphs.values())
    assert em.read_performance(tmp_path / "try" / "take.csv").names == ("jawOpen", "eyeBlinkLeft")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "try").rglob("*")}
    with pytest.raises(em.FileError):
        write_samples(tmp_path / "try")
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "try").rglob("*")} == before
