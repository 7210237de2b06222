"""Materials and loads from files to text and JSON."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import TopologyError
from material_fit import fit, main
from small_meshes import grid

SIZE = 5


@pytest.fixture
def takes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[em.MeshSequence]:
    """Folders take1 and take2 of a sheet that moves at the pace t²."""
    monkeypatch.chdir(tmp_path)
    neutral = grid(SIZE, SIZE, lambda x, y: np.sin(x))
    found = []
    for number in (1, 2):
        target = neutral.with_vertices(neutral.vertices + np.sin(number * neutral.vertices))
        path = em.interpolate(neutral, target, "ease:2")
        Path(f"take{number}").mkdir()
        found.append(em.MeshSequence(neutral, path.at(np.linspace(0, 1, 7))))
        em.write_sequence(f"take{number}/scan.##.obj", found[-1])
    return found


@pytest.mark.usefixtures("takes")
def test_the_text_names_constants_errors_and_what_they_amount_to(
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(["take1", "take2", "--degree", "2"])
    printed = capsys.readouterr().out
    words = " ".join(printed.split())
    assert "2 motions, 10 frames between their ends" in words
    assert "degree 2, as asked for" in words
    assert "c/k not identified" in words
    assert "beats linear interpolation" in words
    assert max(map(len, printed.splitlines())) <= 100


def test_json_and_file_have_what_the_library_finds(takes: list[em.MeshSequence]) -> None:
    main(["take1", "take2", "--degree", "2", "-o", "fit.json"])
    facts = json.loads(Path("fit.json").read_text())
    assert facts["sources"] == ["take1", "take2"]
    found = fit(takes, degree=2)
    assert facts["load"] == pytest.approx(list(found.load.coefficients), abs=1e-6)
    assert facts["damping"]["value"] is None
    assert facts["beats_linear"] is True
    assert facts["beats_ease"] is False
    assert facts["curves"] == found.curves


@pytest.mark.usefixtures("takes")
def test_one_motion_is_not_left_out_and_curves_are_fitted_alone(
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(["take1", "--degree", "2", "--per-curve"])
    printed = capsys.readouterr().out
    assert "Leave-one-out needs two motions" in printed
    assert "Every curve alone" in printed


@pytest.mark.usefixtures("takes")
def test_other_meshes_are_refused() -> None:
    Path("other").mkdir()
    sheet = em.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    em.write_sequence(
        "other/scan.##.obj",
        em.MeshSequence(sheet, [sheet.vertices, sheet.vertices + 1, sheet.vertices + 2]),
    )
    with pytest.raises(TopologyError, match="motion 2 is of another mesh"):
        main(["take1", "other"])
