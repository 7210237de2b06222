"""Modules are found under the names they had, with a warning."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module

import pytest

from elastomorph import _renamed

DRAWN = ("render", "face_strip", "write_picture")


def test_each_old_name_is_the_module_of_today() -> None:
    """In a process of its own, where nothing was imported by any name."""
    code = """
import importlib, sys, warnings
from elastomorph._renamed import _NEW_NAMES
for old, new in _NEW_NAMES.items():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert importlib.import_module(old) is importlib.import_module(new), old
    assert any(f"{old} is now {new}" in str(each.message) for each in caught), old
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_what_is_inside_a_renamed_package_has_its_old_name_too() -> None:
    code = """
import warnings
warnings.simplefilter("ignore")
from elastomorph.rotations.least_distortion import *
import elastomorph.rotations.least_distortion as old
import elastomorph.paths.rotations.least_distortion as new
assert old is new and new.__spec__.name == "elastomorph.paths.rotations.least_distortion"
"""
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


@pytest.mark.parametrize("name", DRAWN)
def test_what_reports_drew_is_found_where_it_was(name: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"now elastomorph.draw.{name}"):
        assert getattr(import_module("elastomorph.report"), name) is getattr(
            import_module("elastomorph.draw"), name
        )


def test_a_module_that_never_was_is_still_not_found() -> None:
    for name in ("elastomorph.nothing", "elastomorph.report.nothing", "elastomorphic"):
        assert _renamed._new_name(name) is None
        with pytest.raises(ModuleNotFoundError):
            import_module(name)
