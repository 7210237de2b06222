"""Takes of Live Link Face."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io.performance import read_livelink
from elastomorph.io.timecode import TimecodeClock
from elastomorph.rig.naming import ARKIT
from elastomorph.rig.performance import match

HEADER = "Timecode,BlendShapeCount,JawOpen,HeadYaw"


def write(folder: Path, *lines: str) -> Path:
    path = folder / "take.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_three_frames_by_hand(tmp_path: Path) -> None:
    """30 fps counted in sixtieths, with sub-frames; 59.5 is half a frame before the second."""
    path = write(
        tmp_path,
        HEADER,
        "10:00:00:57.500,2,0.25,-0.5",
        "10:00:00:59.500,2,0.5,0",
        "10:00:01:01.500,2,1.0625,0.5",
    )
    take = read_livelink(path)
    assert take.names == ("JawOpen", "HeadYaw")
    assert take.rotations == ("HeadYaw",)
    assert take.rate == 30
    np.testing.assert_allclose(take.times, [0, 1 / 30, 2 / 30])
    assert take.weights.tolist() == [[0.25, -0.5], [0.5, 0], [1.0625, 0.5]]
    assert take.timecodes == ("10:00:00:57.500", "10:00:00:59.500", "10:00:01:01.500")
    assert take.source == str(path)
    assert not take.dropped
    assert not take.duplicates


def test_columns_are_found_by_name_in_any_capitals_and_order(tmp_path: Path) -> None:
    take = read_livelink(
        write(tmp_path, "jawOpen,BLENDSHAPECOUNT,timecode,eyeBlinkLeft", "1,2,00:00:00:00,3")
    )
    assert take.names == ("jawOpen", "eyeBlinkLeft")
    assert take.weights.tolist() == [[1, 3]]


def test_dropped_duplicate_and_empty_frames(tmp_path: Path) -> None:
    """At 24 fps, of ten frames 3 is empty, 5 missing, and 2 there twice."""
    rows = ["00:00:00:22,2,0,0", "00:00:00:23,2,1,0", "00:00:01:00,2,2,0", "00:00:01:00,2,9,9",
            "00:00:01:01,0", "00:00:01:02,2,4,0", "00:00:01:04,2,6,0", "00:00:01:05,2,7,0",
            "00:00:01:06,2,8,0", "00:00:01:07,2,9,0"]  # fmt: skip
    take = read_livelink(write(tmp_path, HEADER, *rows))
    assert take.rate == 24
    assert take.weights[:, 0].tolist() == [0, 1, 2, 4, 6, 7, 8, 9]
    np.testing.assert_allclose(take.times * 24, take.weights[:, 0])
    assert take.dropped == ("00:00:01:01", "00:00:01:03")
    assert take.duplicates == ("00:00:01:00",)
    np.testing.assert_allclose(take.resampled(24).weights[:, 0], np.arange(10), atol=1e-12)


def test_drop_frame_and_the_rate_that_is_told(tmp_path: Path) -> None:
    path = write(tmp_path, HEADER, "00:00:59;29,2,0,0", "00:01:00;02,2,0,0", "00:01:00;03,2,0,0")
    take = read_livelink(path)
    assert take.rate == pytest.approx(30000 / 1001)
    np.testing.assert_allclose(take.times, np.arange(3) * 1001 / 30000)
    assert not take.dropped
    np.testing.assert_allclose(read_livelink(path, 30).times, np.arange(3) / 30)
    with pytest.raises(ParameterError, match="no timecode counts 31"):
        read_livelink(path, 31)


def test_past_midnight(tmp_path: Path) -> None:
    rows = [f"{text},2,0,0" for text in ("23:59:59:49", "00:00:00:00", "00:00:00:01")]
    take = read_livelink(write(tmp_path, HEADER, *rows))
    assert take.rate == 50
    np.testing.assert_allclose(take.times, [0, 0.02, 0.04])


@given(
    st.sampled_from([(24, False), (25, False), (30, False), (30, True), (60, False), (60, True)]),
    st.integers(0, 2_000_000),
    st.sets(st.integers(1, 298), max_size=40),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_missing_frames_are_named_and_keep_their_time(
    tmp_path: Path, kind: tuple[int, bool], start: int, gone: set[int]
) -> None:
    """Any forty of three hundred frames lost: the others stay where they were."""
    base, drop = kind
    clock = TimecodeClock(base, drop, base * 1000 / 1001 if drop else base)
    kept = [i for i in range(300) if i not in gone]
    take = read_livelink(
        write(tmp_path, HEADER, *(f"{clock.text(start + i)},2,{i},0" for i in kept))
    )
    assert take.weights[:, 0].tolist() == kept
    np.testing.assert_allclose(take.times, np.array(kept) / clock.rate, atol=1e-9)
    assert list(take.dropped) == [clock.text(start + i) for i in sorted(gone)]
    np.testing.assert_allclose(take.dropped_times, np.array(sorted(gone)) / clock.rate, atol=1e-9)


@pytest.mark.parametrize(
    ("lines", "line", "message"),
    [
        (["time,JawOpen", "0,1"], 1, "no column Timecode"),
        (["Timecode,JawOpen", "00:00:00:00,1"], 1, "no column BlendShapeCount"),
        (["Timecode,BlendShapeCount", "00:00:00:00,0"], 1, "no columns of weights"),
        ([HEADER], 1, "no frames with weights"),
        ([HEADER, "00:00:00:00,0", "00:00:00:01,0,,"], 1, "no frames with weights"),
        ([HEADER, "00:00:00:00,2,0,0", "00:00:00:01,2,0"], 3, "expected 4 columns"),
        ([HEADER, "00:00:00:00,3,0,0"], 2, "announces 3 weights, but the header names 2"),
        ([HEADER, "00:00:00:00,two,0,0"], 2, "BlendShapeCount is 'two'"),
        ([HEADER, "00:00:00:00"], 2, "BlendShapeCount is ''"),
        ([HEADER, "00:00:00:00,2,0,0", "0.04,2,0,0"], 3, "the timecode is '0.04'"),
        ([HEADER, "00:00:00:00,2,0,0", "", "00:00:00:01,2,nan,0"], 4, "JawOpen is 'nan'"),
        ([HEADER, "00:00:00:00,2,0,0", "00:00:00:01,2,0,?"], 3, "HeadYaw is '?'"),
        ([HEADER, "00:00:01:00,2,0,0", "00:00:00:00,2,0,0"], 3, "goes back"),
        ([HEADER, "00:00:00:33.0,2,0,0", "00:00:00:966.0,2,0,0"], 3, "not milliseconds"),
        ([HEADER, "00:00:00:00,2,0,0", "00:00:00:01,2,0,0", "05:00:00:00,2,0,0"], 4, "two takes"),
    ],
)
def test_mistakes(tmp_path: Path, lines: list[str], line: int, message: str) -> None:
    path = write(tmp_path, *lines)
    with pytest.raises(FormatError, match=r"take\.csv") as caught:
        read_livelink(path)
    assert message in str(caught.value)
    assert caught.value.line == line


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileError):
        read_livelink(tmp_path / "none.csv")


@pytest.mark.realdata
class TestRealTake:
    """4030 frames of a range of motion, 30 fps counted in sixtieths."""

    def test_all_of_it(self, data_dir: Path) -> None:
        take = read_livelink(data_dir / "livelink" / "rom_3.csv")
        assert take.weights.shape == (4030, 61)
        assert take.rate == 30
        assert take.dropped == ("13:13:24:23.492", "13:14:15:23.078", "13:15:05:12.672")
        assert not take.duplicates
        # From 13:13:04:31.652 to 13:15:18:54.561 by hand: 134 s and 22.909 sixtieths
        assert take.duration == pytest.approx(134 + 22.909 / 60, abs=1e-9)
        steps = np.diff(take.times)
        assert (steps > 0.05).sum() == 3
        np.testing.assert_allclose(steps[steps < 0.05], 1 / 30, rtol=1e-3)
        text = (data_dir / "livelink" / "rom_3.csv").read_text().splitlines()
        assert take.weights[-1].tolist() == [float(cell) for cell in text[-1].split(",")[2:]]

    def test_on_the_production_rig(self, data_dir: Path) -> None:
        """All but the tongue drive; the rig's own shapes, which ARKit has not, stay at rest."""
        take = read_livelink(data_dir / "livelink" / "rom_3.csv")
        files = (data_dir / "ict-facekit").glob("*.obj")
        sliders = sorted(file.stem for file in files if "neutral" not in file.stem)
        found = match(take.names, sliders)
        assert {name.casefold() for name in take.names[:52]} == {
            shape.casefold() for shape in ARKIT
        }
        assert found.rotations == take.names[52:]
        assert found.unmatched_weights == ("TongueOut",)
        assert found.unmatched_sliders == (
            "PupilDilate_L", "PupilDilate_R", "cheekRaiser_L", "cheekRaiser_R"
        )  # fmt: skip
        for side in "LR":
            assert found.drives[f"browInnerUp_{side}"] == (("BrowInnerUp",), (1.0,))
            assert found.drives[f"cheekPuff_{side}"] == (("CheekPuff",), (1.0,))
