"""``evaluate --rivals``: both tables, and who cannot be asked for."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from calls import status_of

import elastomorph as em
from elastomorph.rivals import VertexCubic, with_rivals
from elastomorph.rivals.comparison import run

SHEET = em.Mesh(
    [[x, y, 0.1 * x * y] for x in range(4) for y in range(4)],
    [[4 * i + j, 4 * i + j + 4, 4 * i + j + 5, 4 * i + j + 1] for i in range(3) for j in range(3)],
)


@pytest.fixture
def bent() -> em.MeshSequence:
    """Five frames of a sheet that rises on a parabola."""
    times = np.linspace(0, 1, 5)
    up = np.zeros_like(SHEET.vertices)
    up[4:, 2] = 1.0
    return em.MeshSequence(SHEET, SHEET.vertices + (times**2)[:, None, None] * up, times)


def test_the_verb_prints_both_tables(
    bent: em.MeshSequence,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("elastomorph.rivals.RIVALS", (VertexCubic(),))
    monkeypatch.setattr("elastomorph.rivals.with_rivals", partial(with_rivals, runner=run))
    em.write_sequence(tmp_path / "motion.npz", bent)
    call = ("evaluate", tmp_path / "motion.npz", "--method", "linear", "--rivals")
    assert status_of(*call) == 0
    said = capsys.readouterr().out
    assert "vertex-cubic" in said
    assert "each further" in said
    assert status_of(*call, "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert {"linear", "vertex-cubic"} <= {cost["label"] for cost in facts["rivals"]["costs"]}
    assert [line["label"] for line in facts["methods"]] == ["linear", "vertex-cubic"]


def test_rivals_stand_in_the_means_of_movements(
    bent: em.MeshSequence,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of an onset and an offset; what a face costs is told once."""
    monkeypatch.setattr("elastomorph.rivals.RIVALS", (VertexCubic(),))
    monkeypatch.setattr("elastomorph.rivals.with_rivals", partial(with_rivals, runner=run))
    pick = [0] * 8 + [0, 1, 2, 3, 4, 3, 2, 1, 0] + [0] * 8
    em.write_sequence(tmp_path / "take.npz", em.MeshSequence(SHEET, bent.frames[pick]))
    call = ("evaluate", tmp_path / "take.npz", "--method", "linear", "--movements", "--rivals")
    assert status_of(*call) == 0
    assert "each further" in capsys.readouterr().out
    assert status_of(*call, "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert {cost["label"] for cost in facts["rivals"]["costs"]} >= {"vertex-cubic"}
    for lines in facts["means"].values():
        assert [line["label"] for line in lines] == ["linear", "vertex-cubic"]
