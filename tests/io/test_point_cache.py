"""Point caches hold what was written byte for byte, and no header is believed."""

from __future__ import annotations

import os
import struct
import tracemalloc
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io import sequences
from elastomorph.io.sequences import PointCache, read_mdd, read_pc2, write_mdd, write_pc2
from elastomorph.model.mesh import Mesh
from elastomorph.paths import interpolate
from elastomorph.rig import Rig

FORMATS: dict[str, tuple[Callable[..., None], Callable[[Path], PointCache]]] = {
    "mdd": (write_mdd, read_mdd),
    "pc2": (write_pc2, read_pc2),
}
HEADER = {"mdd": 8, "pc2": 32}

# two frames of one point, (1, 2, 3) and (-1, 0.5, 0), by hand: IEEE 754 singles
ONE, TWO, THREE, HALF, MINUS = "3f800000", "40000000", "40400000", "3f000000", "bf800000"
POSITIONS = [ONE, TWO, THREE, MINUS, HALF, "00000000"]
MDD_BYTES = bytes.fromhex("00000002 00000001 3f000000 3f800000" + "".join(POSITIONS))
PC2_BYTES = (
    b"POINTCACHE2\0"
    + bytes.fromhex("01000000 01000000")
    + bytes.fromhex(ONE)[::-1]
    + bytes.fromhex(HALF)[::-1]
    + bytes.fromhex("02000000")
    + b"".join(bytes.fromhex(number)[::-1] for number in POSITIONS)
)
HAND_WRITTEN = {"mdd": MDD_BYTES, "pc2": PC2_BYTES}
FRAMES = np.array([[[1, 2, 3]], [[-1, 0.5, 0]]])

both = pytest.mark.parametrize("kind", FORMATS)


@both
def test_a_file_made_by_hand_is_read(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"hand.{kind}"
    path.write_bytes(HAND_WRITTEN[kind])
    cache = FORMATS[kind][1](path)
    assert cache.frames.tolist() == FRAMES.tolist()
    assert cache.frames.dtype == np.float32
    assert cache.frames.dtype.isnative
    # MDD: times 0.5 and 1 s, so 2 frames a second from frame 1; PC2: start 1, every half frame
    assert cache.times.tolist() == {"mdd": [0.5, 1.0], "pc2": [1.0, 1.5]}[kind]
    assert (cache.rate, cache.start) == {"mdd": (2.0, 1.0), "pc2": (0.5, 1.0)}[kind]


@both
def test_the_bytes_written_are_those_made_by_hand(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"own.{kind}"
    rate = {"mdd": 2.0, "pc2": 0.5}[kind]
    FORMATS[kind][0](path, FRAMES, rate=rate, start=1)
    assert path.read_bytes() == HAND_WRITTEN[kind]
    FORMATS[kind][0](path, iter(FRAMES), count=2, rate=rate, start=1)
    assert path.read_bytes() == HAND_WRITTEN[kind]


@both
@given(
    frames=st.tuples(st.integers(1, 6), st.integers(1, 7)).flatmap(
        lambda shape: arrays(
            np.float32,
            (*shape, 3),
            elements=st.floats(width=32, allow_nan=False, allow_infinity=False),
        )
    ),
    rate=st.sampled_from([1.0, 0.5, 24.0, 30.0, 120.0]),
    start=st.integers(-100, 1000),
)
@settings(max_examples=60, deadline=None)
def test_positions_come_back_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory,
    kind: str,
    frames: np.ndarray,
    rate: float,
    start: int,
) -> None:
    path = tmp_path_factory.getbasetemp() / f"random.{kind}"
    write, read = FORMATS[kind]
    write(path, frames, rate=rate, start=start)
    cache = read(path)
    assert cache.frames.tobytes() == frames.tobytes()
    assert cache.frames.shape == frames.shape
    numbers = np.arange(len(frames))
    expected = (start + numbers) / rate if kind == "mdd" else start + rate * numbers
    np.testing.assert_allclose(cache.times, expected, rtol=1e-6)
    if kind == "pc2":
        assert (cache.rate, cache.start) == (rate, start)
    elif len(frames) > 1:
        step = float(np.spacing(np.float32(abs(cache.times).max())))
        assert cache.rate == pytest.approx(rate, rel=1e-6 + 2 * step * rate)


@both
def test_a_prolonged_file_is_refused(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"long.{kind}"
    path.write_bytes(HAND_WRITTEN[kind] + b"\0")
    with pytest.raises(FormatError, match="cut off or its header is wrong"):
        FORMATS[kind][1](path)


@pytest.mark.parametrize(
    ("frames", "points"),
    [(2**31 - 1, 2**31 - 1), (2**31 - 1, 1), (1, 2**31 - 1), (0, 1), (1, 0), (-1, -1), (-2, 1)],
)
@both
def test_a_header_that_announces_more_than_the_file_is_refused_before_allocation(
    tmp_path: Path, kind: str, frames: int, points: int
) -> None:
    path = tmp_path / f"bomb.{kind}"
    if kind == "mdd":
        path.write_bytes(struct.pack(">ii", frames, points) + bytes(100))
    else:
        head = struct.pack("<iiffi", 1, points, 0.0, 1.0, frames)
        path.write_bytes(b"POINTCACHE2\0" + head + bytes(100))
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="header announces"):
            FORMATS[kind][1](path)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (0, b"p", "does not begin with POINTCACHE2"),
        (12, b"\2", "version 2"),
        (20, bytes.fromhex("0000c07f"), "start frame is nan"),
        (24, bytes.fromhex("0000807f"), "sample rate inf"),
        (32, bytes.fromhex("0000c07f"), "frame 0 has coordinates that are not finite"),
        (44, bytes.fromhex("000080ff"), "frame 1 has coordinates"),
    ],
)
def test_pc2_that_is_not_what_it_should_be(
    tmp_path: Path, place: int, value: bytes, words: str
) -> None:
    path = tmp_path / "a.pc2"
    path.write_bytes(PC2_BYTES[:place] + value + PC2_BYTES[place + len(value) :])
    with pytest.raises(FormatError, match=words):
        read_pc2(path)


def test_mdd_times_that_are_not_finite(tmp_path: Path) -> None:
    path = tmp_path / "a.mdd"
    path.write_bytes(MDD_BYTES[:8] + bytes.fromhex("7fc00000") + MDD_BYTES[12:])
    with pytest.raises(FormatError, match="times are not all finite"):
        read_mdd(path)


def test_mdd_times_that_do_not_rise_tell_no_rate(tmp_path: Path) -> None:
    path = tmp_path / "a.mdd"
    path.write_bytes(MDD_BYTES[:8] + bytes(8) + MDD_BYTES[16:])
    assert read_mdd(path).rate == 0


@both
@pytest.mark.parametrize(
    ("frames", "count", "words"),
    [
        ([[[0, 0, 0]]] * 2, 3, "only 2 of the 3"),
        ([[[0, 0, 0]]] * 2, 1, "more frames came than the 1"),
        ([[[0, 0, 0]], [[0, 0, 0], [1, 1, 1]]], None, r"frame 1 has the shape \(2, 3\)"),
        ([[[0, 0]]], None, r"frame 0 has the shape \(1, 2\), expected \(V, 3\)"),
        ([5.0], None, r"frame 0 has the shape \(\)"),
        ([np.zeros((0, 3))], None, "V ≥ 1"),
        ([[[0, 0, np.nan]]], None, "not finite"),
        ([[[0, 0, 1e39]]], None, "too large for float32"),
        ([], None, "1 to 2,147,483,647 frames"),
        ([[[0, 0, 0]]], 2**31, "1 to 2,147,483,647 frames"),
        (iter([[[0, 0, 0]]]), None, "count="),
    ],
)
def test_frames_that_do_not_form_a_cache_leave_the_old_file(
    tmp_path: Path, kind: str, frames: Any, count: int | None, words: str
) -> None:
    path = tmp_path / f"old.{kind}"
    path.write_bytes(b"old")
    frames = list(frames) if not isinstance(frames, Iterator) else iter([[[0, 0, 0]]])
    with pytest.raises(ParameterError, match=words):
        FORMATS[kind][0](path, frames, count=count)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@both
@pytest.mark.parametrize(
    "wrong", [{"rate": 0}, {"rate": -1}, {"rate": np.nan}, {"start": np.inf}, {"start": "x"}]
)
def test_a_rate_and_start_must_be_numbers(tmp_path: Path, kind: str, wrong: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match="of a point cache must be a number"):
        FORMATS[kind][0](tmp_path / "a", FRAMES, **wrong)


@both
def test_a_missing_file_and_a_missing_folder(tmp_path: Path, kind: str) -> None:
    with pytest.raises(FileError, match="no such file"):
        FORMATS[kind][1](tmp_path / "none")
    with pytest.raises(FileError, match="does not exist"):
        FORMATS[kind][0](tmp_path / "no" / "a", FRAMES)


@both
def test_a_long_stream_is_never_held_in_memory(tmp_path: Path, kind: str) -> None:
    """20,000 frames of 500 points are 120 MB in the file and stay below 2 MB in memory."""
    frame = np.zeros((500, 3), dtype=np.float32)

    def frames() -> Iterator[np.ndarray]:
        for number in range(20_000):
            frame[0, 0] = number
            yield frame

    path = tmp_path / f"long.{kind}"
    tracemalloc.start()
    try:
        FORMATS[kind][0](path, frames(), count=20_000)
        assert tracemalloc.get_traced_memory()[1] < 2 << 20
    finally:
        tracemalloc.stop()
    before = HEADER[kind] + (80_000 if kind == "mdd" else 0)
    assert path.stat().st_size == before + 120_000_000
    cache = FORMATS[kind][1](path)
    np.testing.assert_array_equal(cache.frames[:, 0, 0], np.arange(20_000))
    assert not cache.frames[:, 1:].any()


@both
def test_blocks_that_a_rig_streams_are_written(tmp_path: Path, kind: str) -> None:
    """The cache holds what `batch` gives, though each streamed block overwrites the last."""
    random = np.random.default_rng(3)
    neutral = Mesh(random.normal(size=(9, 3)))
    target = neutral.with_vertices(random.normal(size=(9, 3)))
    rig = Rig(neutral, {"open": interpolate(neutral, target, method="ease", order=2)})
    weights = np.linspace(0, 1, 11)[:, None]
    path = tmp_path / f"rig.{kind}"
    frames = chain.from_iterable(rig.stream(weights, block=3))
    FORMATS[kind][0](path, frames, count=11)
    # Products of three rows and of eleven: they may round differently.
    np.testing.assert_allclose(FORMATS[kind][1](path).frames, rig.batch(weights), atol=1e-6)


def test_a_cache_says_what_it_holds(tmp_path: Path) -> None:
    write_mdd(tmp_path / "a.mdd", np.zeros((3, 2, 3)))
    assert repr(read_mdd(tmp_path / "a.mdd")) == "PointCache(3 frames, 2 points)"


def test_a_file_that_becomes_shorter_while_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another program may write it again at that moment."""
    path = tmp_path / "a.mdd"
    write_mdd(path, np.zeros((100, 50, 3)))
    real = sequences._require_size

    def then_cut(*arguments: Any) -> None:
        real(*arguments)
        os.truncate(path, 30_000)

    monkeypatch.setattr(sequences, "_require_size", then_cut)
    with pytest.raises(FormatError, match=r"a\.mdd: it became shorter while it was read"):
        read_mdd(path)
