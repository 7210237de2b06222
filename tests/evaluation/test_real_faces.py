"""Evaluation at full size: a production rig and recorded takes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from elastomorph.evaluation import evaluate
from elastomorph.io import read
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import interpolate

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "real_capture.py"


@pytest.mark.realdata
def test_a_production_rig(data_dir: Path) -> None:
    """26,719 vertices: what ease gains over linear on an ease is timing, and told so."""
    neutral = read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")
    target = read(data_dir / "ict-facekit" / "jawOpen.obj")
    times = np.linspace(0, 1, 11)
    truth = MeshSequence(neutral, interpolate(neutral, target, "ease:2").at(times), times)
    evaluation = evaluate(truth, ["linear", "ease:2", "beam:2", "beam:2:unforced"])
    linear, ease, beam, unforced = evaluation.results
    largest = np.linalg.norm(target.vertices - neutral.vertices, axis=1).max() / neutral.diameter
    assert linear.lme == pytest.approx(largest * (times - times**2).max())
    assert linear.path_lme < 1e-9
    assert ease.lme < 1e-12
    assert beam.lme < 0.01 * linear.lme
    assert linear.seam == ease.seam == 0 < beam.seam < 0.02 * unforced.seam
    assert unforced.flips > 0 == ease.flips
    assert "by timing alone" in " ".join(str(evaluation).split())


@pytest.mark.slow
@pytest.mark.realdata
def test_the_benchmark_of_real_captures(data_dir: Path) -> None:
    """It finds movements in both takes, prints every table and draws its conclusions."""
    ran = subprocess.run(
        [
            *(sys.executable, str(BENCHMARK), "--data", str(data_dir)),
            *("--inbetweens", "1", "--cuts", "0.05", "0.2"),
        ],
        capture_output=True,
        text=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        timeout=1100,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stderr == ""
    page = " ".join(ran.stdout.split())
    assert ran.stdout.count("Warning:") == 1
    for words in ("jaw 96-126", "Mean over 9 onsets", "Mean over 9 offsets", "free timing"):
        assert words in page
    laws = next(line for line in ran.stdout.splitlines() if "1 │   2.05" in line)
    smooth, spline, _, better = (float(cell) for cell in laws.split("│")[2:6])
    assert better >= smooth > spline > 1.7
    assert "Path error, LME with free timing" in page
    assert "has the smallest mean LME" in page


def test_the_benchmark_says_which_data_it_lacks(tmp_path: Path) -> None:
    """Without a traceback."""
    ran = subprocess.run(
        [sys.executable, str(BENCHMARK), "--data", str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ran.returncode == 1
    assert "has no animface/jaw.npz" in ran.stderr
    assert "Traceback" not in ran.stderr
