"""Every warning points at the line that called the package."""

from __future__ import annotations

import contextlib
import threading
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import ElastomorphWarning, warn
from elastomorph.io.sequences import read_recording
from elastomorph.physics import Load, Material
from elastomorph.physics.response import guard_laws
from small_meshes import grid

SOURCES = Path(em.__file__).parent


def test_warnings_are_given_by_one_function() -> None:
    """So that what is tested of it here is true of every warning there is."""
    own = [file for file in SOURCES.rglob("*.py") if "warnings.warn" in file.read_text()]
    assert own == [SOURCES / "errors.py"]
    assert not [file for file in SOURCES.rglob("*.py") if "stacklevel" in file.read_text()]


def loose(folder: Path) -> None:
    (folder / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2 3/3\n")
    em.read(folder / "a.obj")


def table(folder: Path) -> None:
    (folder / "a.csv").write_text("time;jawOpen\n0;0,5\n1;0,25\n")
    em.read_performance(folder / "a.csv")


def recording(folder: Path) -> None:
    markers = np.arange(24.0).reshape(4, 2, 3)
    markers[:, 1] = np.nan
    np.savez(folder / "a.npz", names=["chin", "nose"], markers=markers)
    read_recording(folder / "a.npz")


def overshoot(folder: Path) -> None:
    flat = grid(3, 3)
    half = flat.with_vertices(flat.vertices + [0, 0, 0.5])
    em.through(flat, flat.with_vertices(flat.vertices + [0, 0, 1]), {0.02: half}, method="spline")


def paths(folder: Path) -> None:
    bare = em.Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]]), [[0, 1, 2]])
    em.interpolate(bare, bare.with_vertices(bare.vertices + 1.0), "arc")


def law(folder: Path) -> None:
    guard_laws([("curves", np.array([5.0]))], "compatible", Load.power(2), Material(1, 1, 1))


def told(call: Callable[[], object]) -> list[warnings.WarningMessage]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    return [one for one in caught if issubclass(one.category, ElastomorphWarning)]


@pytest.mark.parametrize("call", [loose, table, recording, overshoot, paths, law])
def test_a_warning_points_at_the_line_that_called_us(
    call: Callable[[Path], None], tmp_path: Path
) -> None:
    for one in told(lambda: call(tmp_path)) or [None]:
        assert one is not None, "nothing was warned of"
        first = call.__code__.co_firstlineno
        lines = {line for *_, line in call.__code__.co_lines() if line}
        assert Path(one.filename) == Path(__file__)
        assert first < one.lineno <= max(lines)


def ours(name: str, body: str = "return function(*rest)") -> Callable[..., object]:
    """A function of a module within the package that calls what it is given."""
    place: dict[str, object] = {"__name__": f"elastomorph.{name}"}
    exec(f"def call(function, *rest):\n    {body}", place)
    return place["call"]  # type: ignore[return-value]


def test_what_lies_between_our_own_frames_is_skipped() -> None:
    """Context managers and caches of the standard library, through which we call ourselves."""
    outer, inner = ours("outer"), ours("io.inner")
    managed = contextlib.contextmanager(ours("io.inner", "yield function(*rest)"))
    (one,) = told(lambda: outer(cache(inner), inner, warn, "cached"))
    code = test_what_lies_between_our_own_frames_is_skipped.__code__
    assert (one.filename, one.lineno) == (__file__, code.co_firstlineno + 4)
    (one,) = told(lambda: outer(contextlib.ExitStack().enter_context, managed(warn, "entered")))
    assert (one.filename, one.lineno) == (__file__, code.co_firstlineno + 7)


def test_a_callback_of_the_user_is_the_callers_line() -> None:
    """The nearest line that is not ours, where we call what calls us again."""
    inner, outer = ours("io.inner"), ours("outer")

    def callback() -> None:
        inner(warn, "from a callback")

    (one,) = told(lambda: outer(callback))
    assert (one.filename, one.lineno) == (__file__, callback.__code__.co_firstlineno + 1)


def test_in_a_thread_of_its_own_a_warning_still_comes() -> None:
    inner = ours("worker")
    with ThreadPoolExecutor(1) as threads:
        (one,) = told(lambda: threads.submit(inner, warn, "a").result())
    assert one.filename == threading.__file__


def test_a_warning_is_given_once_a_line_by_default() -> None:
    """The registry is that of the caller's module, as Python's own warnings have it."""
    inner = ours("other")
    with warnings.catch_warnings(record=True) as caught:
        warnings.resetwarnings()
        warnings.simplefilter("default")
        for _ in range(3):
            inner(warn, "the same")
        inner(warn, "the same")
    assert len(caught) == 2
    assert len({one.lineno for one in caught}) == 2
