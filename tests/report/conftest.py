"""The page of a small evaluation, drawn once."""

from __future__ import annotations

import pytest
from parsed_page import Element, parsed
from stand_in import VIEWER

from elastomorph.evaluation import Evaluation, suggest_inbetweens
from elastomorph.report import About, report_page
from scenes import evaluation, rings

__all__ = ["evaluation", "page", "rings", "root", "small_viewer"]


@pytest.fixture
def small_viewer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: VIEWER)


@pytest.fixture(scope="session")
def page(evaluation: Evaluation) -> str:
    """The page with everything in it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("elastomorph.viewer.page.shipped_page", lambda: VIEWER)
        about = About("ball & more", source="A ball grows.", unit="cm", call="elastomorph <this>")
        found = suggest_inbetweens(evaluation.truth, 2, curves=evaluation.curves)
        return report_page(evaluation, about, suggestions=found)


@pytest.fixture(scope="session")
def root(page: str) -> Element:
    return parsed(page)
