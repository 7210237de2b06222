"""The page that is shipped is what its source builds."""

from __future__ import annotations

import re
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path

import pytest

from needs import NO_NODE, WEB, node

LIMITS = {"page": 900_000, "landmarks_page": 120_000}
SCRIPTS = {"page": "build", "landmarks_page": "build:landmarks"}


def npm_script(name: str, *words: str) -> subprocess.CompletedProcess[str]:
    """A script of web/package.json; skips where the tools to build are not there."""
    program, npm = node("vite"), shutil.which("npm")
    if npm is None:
        pytest.skip(NO_NODE)
    version = subprocess.run([program, "--version"], capture_output=True, text=True).stdout
    numbers = [int(n) for n in re.findall(r"\d+", version)[:2]]
    if numbers < [20, 19]:
        pytest.skip(f"building the page needs node 20.19 or later, found {version.strip()}")
    return subprocess.run(
        [npm, "run", "--silent", "--prefix", str(WEB), name, "--", *words],
        capture_output=True,
        text=True,
    )


def shipped(page: str) -> str:
    return (files("elastomorph.viewer") / page / "index.html").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("page", LIMITS)
def test_the_shipped_page_is_what_the_source_builds(tmp_path: Path, page: str) -> None:
    done = npm_script(SCRIPTS[page], "--outDir", str(tmp_path / "page"), "--emptyOutDir")
    assert done.returncode == 0, done.stdout + done.stderr
    built = (tmp_path / "page" / "index.html").read_text(encoding="utf-8")
    assert built == shipped(page), "the source has changed: run make page and commit what it builds"


@pytest.mark.slow
def test_the_script_of_reports_is_what_the_source_builds(tmp_path: Path) -> None:
    done = npm_script("build:report", "--outDir", str(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr
    kept = (files("elastomorph.report") / "templates" / "copy.js").read_text(encoding="utf-8")
    assert (tmp_path / "copy.js").read_text(encoding="utf-8") == kept, "run make page"


@pytest.mark.slow
def test_the_source_is_sound_typescript() -> None:
    done = npm_script("types")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("page", LIMITS)
def test_the_page_is_small_and_stands_alone(page: str) -> None:
    text = shipped(page)
    assert len(text.encode()) <= LIMITS[page]
    # A report that holds the page replaces them, and then its script is not the one that may run.
    assert not re.findall("[\x00-\x08\x0b-\x1f\x7f-\x9f]", text)
    assert text.count("<!-- elastomorph scene -->") == 1
    assert not re.findall(r"<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=[\"'](?!data:)", text)
