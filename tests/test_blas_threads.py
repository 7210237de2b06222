"""Threads of our own with one BLAS thread each; the number BLAS had comes back whatever happens."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest
from threadpoolctl import ThreadpoolController, threadpool_limits

from elastomorph import blas_threads
from elastomorph.blas_threads import in_own_threads, one_blas_thread, usable_cores

BLAS = ThreadpoolController().select(user_api="blas").lib_controllers
needs_blas = pytest.mark.skipif(not BLAS, reason="no BLAS library whose threads can be counted")


def counts() -> list[int]:
    return [library.get_num_threads() for library in BLAS]


@pytest.fixture
def two(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Two threads for BLAS and two cores, whatever machine this is."""
    monkeypatch.setattr(blas_threads, "usable_cores", lambda: 2)
    with threadpool_limits(2, user_api="blas"):
        yield


@needs_blas
@pytest.mark.usefixtures("two")
class TestTheNumberOfBlasThreads:
    def test_is_one_inside_and_comes_back(self) -> None:
        with one_blas_thread() as allowed:
            assert (allowed, set(counts())) == (2, {1})
            with one_blas_thread() as still:
                assert (still, set(counts())) == (2, {1})
            assert set(counts()) == {1}
        assert set(counts()) == {2}

    def test_comes_back_after_an_error(self) -> None:
        with pytest.raises(KeyboardInterrupt), one_blas_thread():
            raise KeyboardInterrupt
        assert set(counts()) == {2}

    def test_comes_back_when_the_first_inside_leaves_first(self) -> None:
        """Another thread goes in second and out last."""
        second_is_in, first_is_out = threading.Event(), threading.Event()
        seen: list[int] = []

        def second() -> None:
            with one_blas_thread():
                second_is_in.set()
                first_is_out.wait(10)
                seen.extend(counts())

        other = threading.Thread(target=second)
        with one_blas_thread():
            other.start()
            assert second_is_in.wait(10)
        first_is_out.set()
        other.join(10)
        assert set(seen) == {1}
        assert set(counts()) == {2}

    def test_can_still_be_set_by_the_user_in_any_thread(self) -> None:
        def user() -> None:
            with threadpool_limits(1, user_api="blas"):
                seen.extend(counts())

        seen: list[int] = []
        in_own_threads(lambda _: None, range(4))
        # What the fixture holds in this thread is let go of, as it would be by its end.
        other = threading.Thread(target=user)
        other.start()
        other.join(10)
        assert set(seen) == {1}


@pytest.mark.usefixtures("two")
class TestTasks:
    def test_are_all_done_by_more_than_one_thread(self) -> None:
        done: list[int] = []
        threads: set[int] = set()
        both = threading.Barrier(2)

        def work(task: int) -> None:
            if task < 2:
                both.wait(10)  # passes only if two tasks are under way at once
            threads.add(threading.get_ident())
            done.append(task)

        in_own_threads(work, range(9))
        assert sorted(done) == list(range(9))
        assert len(threads) == 2
        assert threading.get_ident() not in threads

    def test_an_error_ends_the_rest(self) -> None:
        begun: list[int] = []
        before = set(threading.enumerate())

        def work(task: int) -> None:
            begun.append(task)
            if task == 0:
                raise ZeroDivisionError("the first task")
            time.sleep(0.005)

        with pytest.raises(ZeroDivisionError, match="the first task"):
            in_own_threads(work, range(500))
        assert len(begun) < 500
        assert set(threading.enumerate()) <= before  # of others some may have ended
        assert all(count == 2 for count in counts())

    def test_one_task_stays_on_the_calling_thread(self) -> None:
        seen: list[int] = []
        in_own_threads(lambda _: seen.append(threading.get_ident()), ["alone"])
        assert seen == [threading.get_ident()]

    @needs_blas
    def test_a_user_who_allows_one_thread_gets_one(self) -> None:
        seen: set[int] = set()
        with threadpool_limits(1, user_api="blas"):
            in_own_threads(lambda _: seen.add(threading.get_ident()), range(9))
        assert seen == {threading.get_ident()}


def test_cores_are_counted() -> None:
    assert usable_cores() >= 1
