"""A machine that cannot draw is told so, instead of crashing."""

from __future__ import annotations

import ctypes

import pytest

from elastomorph.draw.pictures import _require_opengl
from elastomorph.errors import ElastomorphError


def _no_library(name: str) -> None:
    raise OSError(name)


def test_without_egl_and_osmesa_the_message_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ctypes, "CDLL", _no_library)
    with pytest.raises(ElastomorphError, match="libegl1"):
        _require_opengl("vtkOSOpenGLRenderWindow")


def test_osmesa_will_do(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[str] = []

    def only_the_plain_name(name: str) -> None:
        tried.append(name)
        if name != "libOSMesa.so":
            raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", only_the_plain_name)
    _require_opengl("vtkOSOpenGLRenderWindow")
    assert tried[-1] == "libOSMesa.so"


@pytest.mark.parametrize("name", ["vtkEGLRenderWindow", "vtkWin32OpenGLRenderWindow"])
def test_other_windows_need_no_osmesa(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setattr(ctypes, "CDLL", _no_library)
    _require_opengl(name)
