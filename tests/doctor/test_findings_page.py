"""Every finding leads to its section, and every section to a finding."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from elastomorph.doctor import KINDS, SEVERITIES, Thresholds
from elastomorph.doctor.findings import finding

PAGE = (Path(__file__).parents[2] / "docs" / "findings.md").read_text()
SECTIONS = re.split(r"^## ", PAGE, flags=re.MULTILINE)


def test_each_kind_has_one_section_under_its_severity() -> None:
    named: dict[str, list[str]] = {}
    for section in SECTIONS:
        named[section.split(":")[0].lower()] = re.findall(r"^### (\S+)$", section, re.MULTILINE)
    for severity in SEVERITIES:
        kinds = [name for name, kind in KINDS.items() if kind.severity == severity]
        assert sorted(named[f"{severity}s"]) == sorted(kinds)


@pytest.mark.parametrize("name", KINDS)
def test_a_link_leads_to_its_heading(name: str) -> None:
    page, _, heading = finding(name, "a.obj", "").link.partition("#")
    assert page == "docs/findings.md"
    assert PAGE.count(f"\n### {heading}\n") == 1
    text = PAGE.split(f"\n### {heading}\n")[1].split("\n### ")[0]
    assert "**Repair:**" in text


def test_the_page_names_the_thresholds_in_use() -> None:
    limits = Thresholds()
    assert f"({100 * limits.nothing:g} % of D)" in PAGE
    assert f"more than {100 * limits.head:g} % of D" in PAGE
    assert f"more than {100 * limits.bend:g} % of D" in PAGE
    assert f"more than {100 * limits.noise:g} % of an edge" in PAGE
    share, of_d = f"{100 * limits.asymmetry:g} %", f"{100 * limits.asymmetry_of_d:g} %"
    assert f"{share} of\nthe motion and {of_d} of D" in PAGE
