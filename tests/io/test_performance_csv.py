"""Performances as plain columns."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from elastomorph.errors import ElastomorphWarning, FormatError, ParameterError
from elastomorph.io.performance import (
    read_performance,
    read_performance_csv,
    write_performance_csv,
)
from elastomorph.rig.performance import Performance


def write(folder: Path, *lines: str) -> Path:
    path = folder / "take.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_by_hand(tmp_path: Path) -> None:
    path = write(tmp_path, "jawOpen,Time,x", "0.5,1,0.7", "1,1.04,0.8", "0,1.08,1.9")
    take = read_performance_csv(path)
    assert take.names == ("jawOpen", "x")
    assert take.times.tolist() == [1, 1.04, 1.08]
    assert take.weights.tolist() == [[0.5, 0.7], [1, 0.8], [0, 1.9]]
    assert take.rate == 25
    assert read_performance(path).weights.tolist() == take.weights.tolist()


PERCENT = ("jawOpen", "smile", "blink", "headYaw")


@pytest.mark.parametrize("column", ["time", "Milliseconds", "ms", "Time (ms)"])
def test_milliseconds_and_percent_are_recognised_and_said(tmp_path: Path, column: str) -> None:
    """Thirty frames a second; turns of the head are no weights."""
    steps = np.arange(12)
    rows = [f"{1000 * i / 30!r},{8 * i},{50},{0.5 * i},{-i}" for i in range(12)]
    path = write(tmp_path, ",".join((column, *PERCENT)), *rows)
    words = rf"take\.csv: the times in '{re.escape(column)}' .* milliseconds; .* percent"
    with pytest.warns(ElastomorphWarning, match=words) as said:
        take = read_performance(path)
    assert len(said) == 1
    assert take.rate == 30
    assert take.times == pytest.approx(steps / 30)
    expected = np.stack([0.08 * steps, np.full(12, 0.5), 0.005 * steps, -1.0 * steps], axis=1)
    assert take.weights == pytest.approx(expected)


def test_a_column_of_seconds_has_all_numbers_taken_as_they_are(tmp_path: Path) -> None:
    rows = [f"{20 * i},{8 * i}" for i in range(12)]
    take = read_performance(write(tmp_path, "seconds,jawOpen", *rows))
    assert take.times.tolist() == [20 * i for i in range(12)]
    assert take.weights[:, 0].tolist() == [8 * i for i in range(12)]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["time,x", "0,0", "33,1", "66,0"], "33 apart, which could be seconds or milliseconds"),
        (["time,x", "0,0", "0.1,7"], "up to 7, which could be percent or not"),
        (["time,a,b,c,d,e", "0,1,1,1,1,0", "0.1,0,0,0,0,30"], "up to 30, which could be"),
    ],
)
def test_what_could_be_either_is_refused(tmp_path: Path, lines: list[str], words: str) -> None:
    """And read as soon as the column says 'seconds'."""
    with pytest.raises(FormatError, match=words) as caught:
        read_performance(write(tmp_path, *lines))
    assert "'seconds'" in str(caught.value)
    header = lines[0].replace("time", "seconds")
    assert len(read_performance(write(tmp_path, header, *lines[1:])).times) == len(lines) - 1


@pytest.mark.parametrize("separator", [";", "\t"])
def test_semicolons_tabs_and_decimal_commas_are_said(tmp_path: Path, separator: str) -> None:
    lines = ["time,jaw", "0,0", "0.5,0.25"]
    path = write(tmp_path, *(line.replace(",", separator).replace(".", ",") for line in lines))
    with pytest.warns(ElastomorphWarning, match=r"separated by .* and decimals by commas"):
        take = read_performance(path)
    assert take.times.tolist() == [0, 0.5]
    assert take.weights.tolist() == [[0], [0.25]]


def test_takes_of_live_link_face_may_have_been_saved_with_semicolons(tmp_path: Path) -> None:
    path = write(tmp_path, "Timecode;BlendShapeCount;JawOpen", "01:00:00:00;1;0,5")
    with pytest.warns(ElastomorphWarning, match="semicolons and decimals by commas"):
        assert read_performance(path).weights.tolist() == [[0.5]]


@given(
    arrays(float, (5, 3), elements=st.floats(-1e6, 1e6)),
    st.lists(st.floats(1e-3, 10), min_size=4, max_size=4),
    st.lists(st.text(st.characters(categories=("L", "N", "P")), min_size=1), min_size=3,
             max_size=3, unique=True),
)  # fmt: skip
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_is_written_comes_back_bit_for_bit(
    tmp_path: Path, weights: np.ndarray, gaps: list[float], names: list[str]
) -> None:
    """Whatever the names: commas, quotes and letters of any script."""
    names = [f"w{name}" for name in names]
    before = Performance(names, np.cumsum([0.1, *gaps]), weights, 30)
    write_performance_csv(tmp_path / "take.csv", before)
    after = read_performance_csv(tmp_path / "take.csv")
    assert after.names == before.names
    assert after.times.tobytes() == before.times.tobytes()
    assert after.weights.tolist() == before.weights.tolist()


@pytest.mark.parametrize("rate", [24000 / 1001, 24, 25, 30000 / 1001, 30, 48, 60000 / 1001, 60])
@pytest.mark.parametrize("digits", [3, 6])
def test_the_rate_is_found_also_from_rounded_times(
    tmp_path: Path, rate: float, digits: int
) -> None:
    rows = [f"{i / rate:.{digits}f},0" for i in range(200)]
    assert read_performance(write(tmp_path, "time,x", *rows)).rate == rate


def test_a_rate_of_its_own_and_gaps(tmp_path: Path) -> None:
    even = read_performance(write(tmp_path, "time,x", *(f"{i / 7!r},0" for i in range(9))))
    assert even.rate == pytest.approx(7)
    rows = [f"{i / 30!r},0" for i in range(60) if not 10 < i < 40]
    assert read_performance(write(tmp_path, "time,x", *rows)).rate == pytest.approx(30)
    assert read_performance(write(tmp_path, "seconds,x", "3,1")).rate == 30


def test_a_timecode_makes_it_a_take_of_live_link_face(tmp_path: Path) -> None:
    path = write(tmp_path, "Timecode,BlendShapeCount,JawOpen", "01:00:00:00,1,0.5")
    assert read_performance(path).timecodes == ("01:00:00:00",)
    with pytest.raises(FormatError, match="expected one column 'time'"):
        read_performance_csv(path)


@pytest.mark.parametrize(
    ("lines", "line", "message"),
    [
        (["frame,x", "0,1"], 1, "one column 'time' in seconds"),
        (["time,seconds,x", "0,0,1"], 1, "found 2"),
        (["time", "0"], 1, "no columns of weights"),
        (["time,x"], 1, "no frames"),
        (["time,x", "0,1", "0,1"], 3, "does not come after"),
        (["time,x", "1,1", "0.5,1"], 3, "0.5 s does not come after 1 s"),
        (["time,x", "0,1", "0.1"], 3, "expected 2 columns"),
        (["time,x", "0,1", "0.1,"], 3, "x is ''"),
    ],
)
def test_mistakes(tmp_path: Path, lines: list[str], line: int, message: str) -> None:
    path = write(tmp_path, *lines)
    with pytest.raises(FormatError) as caught:
        read_performance(path)
    assert message in str(caught.value)
    assert caught.value.line == line


@pytest.mark.parametrize("name", ["time", "Seconds", "", " jaw", "a\nb"])
def test_names_that_no_column_can_have(tmp_path: Path, name: str) -> None:
    with pytest.raises(ParameterError, match="cannot be called"):
        write_performance_csv(tmp_path / "x.csv", Performance([name], [0], [[1]], 30))
    assert not list(tmp_path.iterdir())
