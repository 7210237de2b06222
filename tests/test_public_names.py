"""What users can rely on."""

from __future__ import annotations

import inspect
from importlib.metadata import version

import elastomorph as em
import elastomorph.errors as errors


def test_every_exported_name_exists_and_is_documented() -> None:
    for name in em.__all__:
        assert inspect.getdoc(getattr(em, name)), name


def test_no_public_name_is_left_out() -> None:
    """Whatever the package imports into its top level, other than its own modules, is exported."""
    found = {
        name
        for name, value in vars(em).items()
        if not name.startswith("_") and not inspect.ismodule(value)
    }
    assert found - {"annotations"} == set(em.__all__)


def test_every_error_derives_from_one() -> None:
    for name in errors.__all__:
        kind = getattr(errors, name)
        assert issubclass(kind, errors.ElastomorphError | errors.ElastomorphWarning)
        assert name in errors.__doc__
        assert name in em.__all__


def test_the_package_knows_its_version() -> None:
    assert version("elastomorph")
