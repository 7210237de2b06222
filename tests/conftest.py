"""Where the tests find the real rig and captures, and a browser."""

from __future__ import annotations

import os
import shutil
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

from needs import extra

if TYPE_CHECKING:
    from playwright.sync_api import Browser

CHROMIUM = os.environ.get("ELASTOMORPH_CHROMIUM") or shutil.which("chromium")
# Draws in software, the same everywhere, and asks nobody for anything by itself.
ARGUMENTS = [
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--force-color-profile=srgb",
]

# The same examples in every run, so that a change is judged by what it changed;
# HYPOTHESIS_PROFILE=explore looks for new ones. No deadline for an example: while a browser draws
# in software beside it, one may wait for longer than it takes.
settings.register_profile("steady", derandomize=True, deadline=None)
settings.register_profile("explore", print_blob=True, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))


# Limit of a test that is known to take long, in seconds; that of others is in pyproject.toml.
LONGER = 1200


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder with the real rig and captures; skips the test where there is none."""
    named = os.environ.get("ELASTOMORPH_DATA")
    folder = Path(named) if named else Path(__file__).parents[2] / "shared" / "data"
    if not (folder / "ict-facekit").is_dir():
        pytest.skip(f"needs real data, not found in {folder}: set ELASTOMORPH_DATA to its folder")
    return folder


@pytest.fixture(scope="session", autouse=True)
def _caches_of_their_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Tests read and write no cache in the home of whoever runs them.

    Processes of one run share theirs, as those of a user do: fonts and rigs are prepared once,
    and where Python is told to keep no bytecode, the package is compiled once for those they start.
    """
    base = tmp_path_factory.getbasetemp()
    cache = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "cache"
    cache.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(cache))
        if sys.dont_write_bytecode:
            patch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
            patch.setenv("PYTHONPYCACHEPREFIX", str(cache / "bytecode"))
        yield


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Debian's Chromium, or the one that ELASTOMORPH_CHROMIUM names.

    One for all tests of a process: two of Playwright's loops cannot run in one thread.
    """
    driver = extra("playwright.sync_api", "dev")
    if CHROMIUM is None:
        pytest.skip(
            "needs a browser: install Debian's package chromium, or name a Chromium in "
            "ELASTOMORPH_CHROMIUM"
        )
    with driver.sync_playwright() as playwright:
        opened = playwright.chromium.launch(
            executable_path=CHROMIUM, args=ARGUMENTS, chromium_sandbox=False
        )
        yield opened
        opened.close()


def pytest_configure(config: pytest.Config) -> None:
    """Processes of one run share the cores: each of them, and what it starts, has one BLAS thread.

    More would wait for a core at the end of every product, all of them at work meanwhile.
    """
    if config.getoption("numprocesses", None):
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests marked slow, and those of real data, have a longer limit; pages need a browser.

    Files with slow tests come first: no process begins one when the others have nothing left.
    """
    long = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in long)
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("browser")
        slow = item.get_closest_marker("slow") or item.get_closest_marker("realdata")
        if slow and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(LONGER))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """One line for each reason why tests were skipped: how many, and what to do about it."""
    skipped = terminalreporter.stats.get("skipped", [])
    reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in skipped)
    if reasons:
        terminalreporter.section("skipped", sep="-")
    for reason, count in reasons.most_common():
        terminalreporter.line(f"{count:5}  {reason}")
