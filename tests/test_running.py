"""How the tests themselves run: what hangs fails, and what is skipped is told in few words."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
CONFIGURATION = HERE.parent / "pyproject.toml"
HANGS = "import time\ndef test_hangs():\n    time.sleep(500)\ndef test_goes_on():\n    pass\n"
SKIPS = """
import pytest
@pytest.mark.parametrize("number", range(3))
def test_browser(number):
    pytest.skip("needs a browser")
@pytest.mark.skipif(True, reason="needs real data")
def test_data():
    pass
"""


def told(folder: Path, program: str, *words: str) -> str:
    """What pytest prints about some tests, with the settings of these."""
    for name in ("conftest.py", "needs.py"):
        shutil.copy(HERE / name, folder)
    (folder / "test_some.py").write_text(program)
    options = ["-c", str(CONFIGURATION), "--rootdir", str(folder), "-p", "no:cacheprovider"]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, *words, str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout + done.stderr


def test_every_test_has_a_limit(pytestconfig: pytest.Config) -> None:
    assert pytestconfig.getini("timeout") == "300"
    assert pytestconfig.getini("faulthandler_exit_on_timeout")


@pytest.mark.slow
def test_one_that_is_marked_slow_has_a_longer_limit(request: pytest.FixtureRequest) -> None:
    marker = request.node.get_closest_marker("timeout")
    assert marker.args == (1200,)


@pytest.mark.parametrize(
    ("limit", "word"),
    [("timeout=5", "Failed: Timeout"), ("faulthandler_timeout=5", "crashed while running")],
)
def test_what_hangs_fails_with_a_traceback_and_the_others_go_on(
    tmp_path: Path, limit: str, word: str
) -> None:
    """In Python the test fails; in code that is not Python its process ends, and another begins."""
    said = told(tmp_path, HANGS, "-n", "1", "-o", "timeout=0", "-o", limit, "-v")
    assert word in said
    assert "test_some.py" in said
    assert "time.sleep(500)" in said or "line 3 in test_hangs" in said
    assert "1 failed, 1 passed" in said


def test_each_reason_to_skip_is_told_once(tmp_path: Path) -> None:
    told_once = "    3  needs a browser\n    1  needs real data\n"
    assert told_once in told(tmp_path, SKIPS)
