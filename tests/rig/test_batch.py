"""The fast path of many faces is the slow, obvious one; threads change nothing but the time."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from elastomorph import blas_threads
from elastomorph.rig import Rig, fields

FACES = 700
ROWS = np.random.default_rng(3).uniform(0.1, 1.0, (FACES, 5))


@pytest.fixture
def threads(monkeypatch: pytest.MonkeyPatch) -> Iterator[set[int]]:
    """Three threads whatever machine this is, and which threads multiplied."""
    seen: set[int] = set()
    multiply = fields._multiply_piece

    def watched(*arguments: object) -> None:
        seen.add(threading.get_ident())
        multiply(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(fields, "_multiply_piece", watched)
    monkeypatch.setattr(blas_threads, "usable_cores", lambda: 3)
    with threadpool_limits(3, user_api="blas"):
        yield seen


TIMES = [None, 0.5, np.linspace(0, 1, ROWS.size).reshape(ROWS.shape)]


@pytest.mark.parametrize("times", TIMES, ids=["pose", "one time", "a time for each"])
def test_every_face_is_that_of_pose_or_blend(
    rig: Rig, threads: set[int], times: float | np.ndarray | None
) -> None:
    faces = rig.batch(ROWS, times)
    assert threading.get_ident() not in threads
    for i in (0, 1, 255, 256, 300, FACES - 2, FACES - 1):
        named = dict(zip(rig.names, ROWS[i].tolist(), strict=True))
        if times is None:
            expected = rig.pose(named)
        else:
            own = np.broadcast_to(times, ROWS.shape)[i].tolist()
            expected = rig.blend(named, dict(zip(rig.names, own, strict=True)))
        assert np.abs(faces[i] - expected).max() < 1e-6 * rig.neutral.diameter


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_same_bits_whatever_the_threads(rig: Rig, threads: set[int], dtype: type) -> None:
    many = rig.batch(ROWS, 0.5, dtype=dtype)
    assert threading.get_ident() not in threads
    threads.clear()
    with threadpool_limits(1, user_api="blas"):
        one = rig.batch(ROWS, 0.5, dtype=dtype)
    assert threads == {threading.get_ident()} or not blas_threads._libraries()
    np.testing.assert_array_equal(many, one)


def test_the_same_bits_whatever_the_place(rig: Rig) -> None:
    """Alone, in another order, at the end of a piece or in the middle of one, in a stream."""
    faces = rig.batch(ROWS[:100], 0.5)
    for some in (slice(0, 1), slice(3, 36), slice(99, 100), slice(None, None, -1)):
        np.testing.assert_array_equal(rig.batch(ROWS[:100][some], 0.5), faces[some])
    streamed = [block.copy() for block in rig.stream(ROWS[:100], 0.5, block=7)]
    np.testing.assert_array_equal(np.concatenate(streamed), faces)


def test_batches_from_several_threads_at_once(rig: Rig, threads: set[int]) -> None:
    alone = rig.batch(ROWS, 0.5)
    found: dict[int, np.ndarray] = {}

    def batch(number: int) -> None:
        found[number] = rig.batch(ROWS, 0.5)

    users = [threading.Thread(target=batch, args=(n,)) for n in range(3)]
    for user in users:
        user.start()
    for user in users:
        user.join(60)
    assert len(found) == 3
    for faces in found.values():
        np.testing.assert_array_equal(faces, alone)
    assert all(library.get_num_threads() == 3 for library in blas_threads._libraries())


def test_a_failure_in_a_thread_is_that_of_the_batch(
    rig: Rig, threads: set[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise MemoryError("no room for a piece")

    monkeypatch.setattr(fields, "_multiply_piece", fail)
    before = set(threading.enumerate())
    with pytest.raises(MemoryError, match="no room for a piece"):
        rig.batch(ROWS, 0.5)
    assert set(threading.enumerate()) <= before  # of others some may have ended
    assert all(library.get_num_threads() == 3 for library in blas_threads._libraries())


def test_no_faces_are_no_faces(rig: Rig) -> None:
    assert rig.batch(np.zeros((0, 5)), 0.5).shape == (0, *rig.neutral.vertices.shape)
