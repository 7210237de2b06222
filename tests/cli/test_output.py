"""What a long run says while it runs, on a terminal or not."""

from __future__ import annotations

import re
import warnings

import pytest

from elastomorph.cli import output
from elastomorph.cli.output import progress, steps
from elastomorph.errors import ElastomorphWarning


def test_every_step_is_a_line_with_the_time(capsys: pytest.CaptureFixture[str]) -> None:
    """Standard error is no terminal here; the file of a log reads the same."""
    with steps() as say:
        say("reading [a]")
        say("drawing")
    said = capsys.readouterr()
    assert not said.out
    lines = said.err.splitlines()
    assert [re.sub(r"^ *\d+\.\d s  ", "", line) for line in lines] == ["reading [a]", "drawing"]
    assert all(re.match(r" *\d+\.\d s  ", line) for line in lines)


def test_of_what_is_counted_only_some_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    """A hundred targets in a moment are one line, and what comes after is not lost."""
    with steps() as say:
        for number in range(1, 101):
            say(f"reading, {number} of 100")
        say("done")
    assert [line[10:] for line in capsys.readouterr().err.splitlines()] == [
        "reading, 1 of 100",
        "done",
    ]


def test_a_log_gets_a_line_a_minute(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 0.1, 59.0, 61.0, 100.0, 122.0])
    monkeypatch.setattr(output.time, "monotonic", lambda: next(clock))
    with progress() as say:
        for number in range(5):
            say(f"neutral [{number}] · about 3 min left")
    assert capsys.readouterr().err.splitlines() == [
        "   1 min  neutral [2] · about 3 min left",
        "   2 min  neutral [4] · about 3 min left",
    ]
    with progress(quiet=True) as say:
        say("neutral")
    assert not capsys.readouterr().err


def test_a_quiet_run_says_its_warnings_once(capsys: pytest.CaptureFixture[str]) -> None:
    with steps(quiet=True) as say:
        say("reading")
        for _ in range(2):
            warnings.warn("a vertex is loose", ElastomorphWarning, stacklevel=1)
    assert capsys.readouterr().err == "warning: a vertex is loose\n"
