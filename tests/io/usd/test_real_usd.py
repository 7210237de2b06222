"""A production face rig in USD: small errors, exact return."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from usd_rigs import assert_same_paths, posed_by_usd

from elastomorph.curves import extract_curves
from elastomorph.io import read
from elastomorph.io.usd import read_usd, write_usd
from elastomorph.paths import prepare
from elastomorph.rig import Rig
from needs import extra

extra("pxr", "usd")


@pytest.mark.realdata
@pytest.mark.slow
def test_a_production_rig(data_dir: Path, tmp_path: Path) -> None:
    """With n = 3 in-betweens a quadratic beam keeps 1/16 of what straight lines are off."""
    folder = data_dir / "ict-facekit"
    neutral = read(folder / "generic_neutral_mesh.obj")
    prepared = prepare(neutral, "beam", order=2, curves=extract_curves(neutral))
    names = ("jawOpen", "eyeBlink_L")
    rig = Rig(neutral, {name: prepared(read(folder / f"{name}.obj")) for name in names})
    report = write_usd(tmp_path / "face.usdc", rig)
    for shape in report.shapes:
        morph = rig.morphs[shape.name]
        assert shape.inbetweens == (0.25, 0.5, 0.75)
        assert shape.error == pytest.approx(shape.straight_error / 16, rel=0.01)
        posed = posed_by_usd(tmp_path / "face.usdc", {shape.prim_name: 0.6})
        apart = np.linalg.norm(posed - morph.at(0.6), axis=1).max() / neutral.diameter
        assert apart <= shape.error * (1 + 1e-3) + 1e-6
    found = read_usd(tmp_path / "face.usdc")
    assert found.neutral.faces == neutral.faces
    for name in names:
        assert_same_paths(rig.morphs[name], found.morphs[name])
