"""Processes that tests start: they hear Ctrl-C, and end with the test whatever happens to it."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def started(*words: str, **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Python with some words, killed at the end if it still runs.

    Args:
        words: Such as "-c" and a program, or "-m" and a module.
        **options: Of `subprocess.Popen`.
    """
    with _heard(signal.SIGINT):
        process = subprocess.Popen([sys.executable, *words], text=True, **options)
    with process:
        try:
            yield process
        finally:
            process.kill()


@contextmanager
def _heard(number: signal.Signals) -> Iterator[None]:
    """Children started inside hear a signal that this process may have been told to ignore.

    A shell that starts a command in the background has it ignore Ctrl-C, and children inherit that.
    """
    ignored = signal.getsignal(number) is signal.SIG_IGN
    if ignored:
        signal.signal(number, signal.SIG_DFL)
    try:
        yield
    finally:
        if ignored:
            signal.signal(number, signal.SIG_IGN)
