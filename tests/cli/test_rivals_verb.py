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
from elastomorph.rivals.process import run

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


def test_movements_have_no_rivals(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status_of("evaluate", tmp_path / "t.npz", "--movements", "--rivals") == 1
    assert "leave --rigid, --rivals" in capsys.readouterr().err
