"""``evaluate`` leaves out vertices of low confidence, and says so everywhere."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calls import printed_by, status_of

import elastomorph as em
from elastomorph.io.npz.confidence import write_confidence


@pytest.fixture(autouse=True)
def poses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Seven poses of a sheet that is lifted, one vertex of the fourth far off and said to be."""
    folder = tmp_path / "poses"
    folder.mkdir()
    y, x = np.mgrid[0.0:5, 0.0:5]
    flat = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    corners = [[i, i + 1, i + 6, i + 5] for r in range(4) for i in range(5 * r, 5 * r + 4)]
    confidence = {}
    for number in range(7):
        lifted = flat + [0, 0, (number / 6) ** 2] * (1 + flat[:, :1])
        confidence[f"lift_{number}"] = np.ones(25)
        if number == 3:
            lifted[12] += 4
            confidence["lift_3"][12] = 0.2
        em.write(folder / f"lift_{number}.obj", em.Mesh(lifted, corners))
    write_confidence(folder / "confidence.npz", confidence)
    monkeypatch.chdir(tmp_path)
    return folder


def facts(*words: object, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert status_of("evaluate", *words, "--method", "linear", "--json") == 0
    return json.loads(capsys.readouterr().out)


def test_a_folder_of_poses_brings_its_own(poses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    masked = facts("poses", capsys=capsys)
    plain = facts("poses", "--least-confidence", "0", capsys=capsys)
    line, expected = masked["methods"][0], plain["methods"][0]
    assert masked["confidence"]["covered"] == pytest.approx(1 - 1 / 125)
    assert masked["confidence"]["covered_by_frame"][3] == pytest.approx(24 / 25)
    assert "confidence" not in plain
    assert line["unmasked_lme"] == expected["lme"] > 0.5 > line["lme"]
    assert facts("poses/lift_#.obj", capsys=capsys) == masked
    assert facts("poses/*.obj", capsys=capsys) == masked
    assert facts("poses", "--least-confidence", "0.1", capsys=capsys)["confidence"]["covered"] == 1


def test_other_recordings_name_it(poses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    motion = em.read_sequence("poses")
    em.write_sequence("take.npz", motion)
    masked = facts("take.npz", "--confidence", "poses/confidence.npz", capsys=capsys)
    assert masked["methods"] == facts("poses", capsys=capsys)["methods"]
    assert "confidence" not in facts("take.npz", capsys=capsys)


def test_the_text_says_how_much_counts() -> None:
    text = printed_by("evaluate", "poses", "--method", "linear", "--method", "ease:2")
    words = " ".join(text.replace("\u00a0", " ").split())
    assert "Confidence: 99.2 % of the vertices count, 99.2 % of those that move" in words
    assert "in the frames between the ends; 96.0 % in frame lift_3.obj" in words
    assert "all: vertices of low confidence too" in words
    every = printed_by("evaluate", "poses", "--method", "linear", "--least-confidence", "0")
    assert "onfidence" not in every


def test_tables_and_the_page_have_both(capsys: pytest.CaptureFixture[str]) -> None:
    assert status_of("evaluate", "poses", "--method", "linear", "--no-pictures", "-o", "out",
                     "--report", "page.html") == 0  # fmt: skip
    with Path("out/table.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert float(row["unmasked_lme"]) > 0.5 > float(row["lme"])
    page = Path("page.html").read_text(encoding="utf-8")
    assert "<dt>Confidence</dt>" in page
    assert "Low confidence too" in page
    assert f"{100 * float(row['unmasked_lme']):.3f}" in page
    assert "confidence</b> is high enough count" in page


def test_movements_of_a_take(capsys: pytest.CaptureFixture[str]) -> None:
    frames = em.read_sequence("poses").frames
    mesh = em.read_sequence("poses").mesh
    parts = [np.repeat(frames[:1], 40, axis=0), np.repeat(frames, 3, axis=0),
             np.repeat(frames[-1:], 40, axis=0)]  # fmt: skip
    take = em.MeshSequence(mesh, np.concatenate(parts))
    em.write_sequence("take.npz", take)
    values = {name: np.ones(25) for name in take.names}
    for name in ("49", "50", "51"):
        values[name][12] = 0
    write_confidence("c.npz", values)
    words = ("take.npz", "--movements", "--confidence", "c.npz")
    found = facts(*words, capsys=capsys)
    (line,) = found["means"]["Mean over 1 movements"]
    assert line["unmasked_lme"] > 0.5 > line["lme"]
    assert 0.9 < found["confidence"]["covered"][0] < 1
    assert status_of("evaluate", *words, "--method", "linear", "--no-pictures",
                     "--report", "page.html") == 0  # fmt: skip
    assert "of the vertices count in the movements" in capsys.readouterr().out
    page = Path("page.html").read_text(encoding="utf-8")
    assert "<dt>Confidence</dt>" in page
    assert "Low confidence too" in page


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["poses", "--confidence", "none.npz"], "none.npz"),
        (["poses", "--confidence", "poses/lift_0.obj"], "not an intact archive"),
        (["poses", "--least-confidence", "1.5"], "from 0 to 1, found 1.5"),
        (["poses", "--least-confidence", "-1"], "≥ 0"),
        (["take.npz", "--least-confidence", "0.3"], "name one with --confidence"),
        (["poses", "--confidence", "other.npz"], "has no confidence for the frame lift_0.obj"),
        (["poses", "--confidence", "short.npz"], "has 24 numbers, but the motion has 25"),
        (["poses", "--confidence", "nothing.npz"], "lower the least confidence"),
    ],
)
def test_what_does_not_fit_is_one_sentence(
    poses: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    names = [f"lift_{number}" for number in range(7)]
    em.write_sequence("take.npz", em.read_sequence("poses"))
    write_confidence("other.npz", {"smile": np.ones(25)})
    write_confidence("short.npz", dict.fromkeys(names, np.ones(24)))
    write_confidence("nothing.npz", dict.fromkeys(names, np.zeros(25)))
    assert status_of("evaluate", *words, "--method", "linear") != 0
    error = " ".join(capsys.readouterr().err.split())
    assert said in error
    assert "Traceback" not in error
