"""What tests start ends with them, and hears what they send."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator

import pytest

from children import started

HEARS = "import signal; print(signal.getsignal(signal.SIGINT) is not signal.SIG_IGN)"
SLEEPS = "import time; time.sleep(600)"


@pytest.fixture
def deaf() -> Iterator[None]:
    """This process ignores Ctrl-C, as one does that a shell started in the background."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("deaf")
def test_a_child_of_a_deaf_process_hears() -> None:
    with started("-c", HEARS, stdout=subprocess.PIPE) as process:
        assert process.communicate()[0].strip() == "True"
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_a_process_that_hears_goes_on_hearing() -> None:
    before = signal.getsignal(signal.SIGINT)
    with started("-c", ""):
        assert signal.getsignal(signal.SIGINT) is before


def test_a_child_ends_with_a_test_that_fails() -> None:
    with pytest.raises(ZeroDivisionError), started("-c", SLEEPS) as process:
        _ = 1 / 0
    assert process.returncode not in (None, 0)
