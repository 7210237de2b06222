"""An evaluation as people type it: a motion by the names of its files, results into files."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.samples import recorded_motion

METHODS = ("linear", "ease:2")


@pytest.fixture(scope="module")
def result() -> em.Evaluation:
    return em.evaluate(recorded_motion(), METHODS)


def test_a_motion_may_be_named_by_its_files(tmp_path: Path, result: em.Evaluation) -> None:
    pattern = tmp_path / "scan.##.obj"
    em.write_sequence(pattern, recorded_motion())
    for named in (pattern, str(pattern), tmp_path):
        found = em.evaluate(named, METHODS)
        for own, expected in zip(found.results, result.results, strict=True):
            assert own.lme == pytest.approx(expected.lme, rel=1e-9)
    with pytest.raises(em.FileError, match=r"take\.##\.obj"):
        em.evaluate(tmp_path / "take.##.obj")


def test_text_goes_to_a_file_as_well(tmp_path: Path, result: em.Evaluation) -> None:
    for name, write in (
        ("short.csv", result.to_csv),
        ("long.csv", result.to_long_csv),
        ("all.json", result.to_json),
    ):
        text = write(tmp_path / name)
        assert text == write()
        assert (tmp_path / name).read_bytes() == text.encode()
    with pytest.raises(em.FileError, match="does not exist"):
        result.to_csv(tmp_path / "nowhere" / "short.csv")


def test_without_pandas_one_sentence_says_so(
    monkeypatch: pytest.MonkeyPatch, result: em.Evaluation
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(
        em.MissingExtraError, match=r"'pandas', which is not .* pip install pandas$"
    ):
        result.to_dataframe()


def test_a_table_of_pandas_is_the_csv(result: em.Evaluation) -> None:
    pytest.importorskip("pandas", reason="pandas is not installed; it is optional")
    for long, text in ((False, result.to_csv()), (True, result.to_long_csv())):
        header, *rows = csv.reader(text.splitlines())
        frame = result.to_dataframe(long=long)
        assert list(frame.columns) == header
        assert len(frame) == len(rows)
        last = [float(value) for value in rows[-1][3:]]
        np.testing.assert_array_equal(frame.iloc[-1, 3:].to_numpy(dtype=float), last)
