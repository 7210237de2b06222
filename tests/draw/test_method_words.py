"""Faces say by which method they were made, and at what pace."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

import elastomorph as em
from elastomorph.draw.contact_sheet import contact_sheet
from elastomorph.draw.method_words import method_words
from elastomorph.draw.strips import expression_strip
from scenes import ball


@pytest.mark.parametrize(
    ("method", "words"),
    [
        ("linear", "method linear, even timing"),
        ("auto", "method auto, even timing"),
        ("rotation", "method rotation, even timing"),
        ("ease:2", "method ease R=2, uneven timing"),
        ("beam:2", "method beam R=2, uneven timing"),
        ("cosine", "method cosine, uneven timing"),
    ],
)
def test_method_and_pace(method: str, words: str) -> None:
    """At an even pace a straight line is halfway at t = 0.5; an ease is not, a cosine is."""
    neutral = ball()
    target = neutral.with_vertices(neutral.vertices * [1, 1.5, 1])
    assert method_words([em.interpolate(neutral, target, method)] * 2) == words


def test_several_methods_are_all_named() -> None:
    neutral = ball()
    target = neutral.with_vertices(neutral.vertices * 2)
    paths = [em.interpolate(neutral, target, name) for name in ("linear", "ease:3")]
    assert method_words(paths) == "methods linear, ease R=3, uneven timing"


def test_strips_and_sheets_have_a_title_without_being_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    titles: list[str] = []

    def grid(*_: object, title: str, **__: object) -> np.ndarray:
        titles.append(title)
        return np.zeros((1, 1, 3), dtype=np.uint8)

    for module in ("face_strip", "contact_sheet"):
        monkeypatch.setattr(import_module(f"elastomorph.draw.{module}"), "picture_grid", grid)
    neutral = ball()
    grown = em.interpolate(neutral, neutral.with_vertices(neutral.vertices * 2), "ease:2")
    expression_strip({"grow": grown}, times=[0.5], face=(16, 20))
    contact_sheet(em.Rig(neutral, {"grow": grown}), np.ones((1, 1)), face=(16, 20), title="faces")
    words = "method ease R=2, uneven timing"
    assert titles == [words, f"faces ({words})"]
