"""The sections on the jaw and the eyelid: what turns, how far off its arc, and who keeps to it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from parsed_page import Element, shown
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.draw.hinge import hinge_faces, hinge_graph, looks_of
from elastomorph.draw.sheet import text_size_for
from elastomorph.evaluation.rigid_bodies import (
    Eyelid,
    Hinge,
    find_hinge,
    find_rigid_parts,
    hinge_errors,
)
from elastomorph.model.mesh import FaceLabels
from elastomorph.model.morph import Morph
from elastomorph.report.walkthrough import Jaw, eyelid_section, hinge_section

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


@pytest.fixture(scope="module")
def hinge() -> tuple[Hinge, dict[str, Morph]]:
    """A cube of teeth that turns by 40°, and one of skin that rests."""
    corners = np.concatenate([CUBE + [0, 0, 3], CUBE + [4, 0, 3]])
    faces = [[v + 8 * i for v in quad] for i in range(2) for quad in QUADS]
    labels = FaceLabels(("lower_teeth", "face"), np.repeat([0, 1], 6).astype(np.int32))
    neutral = em.Mesh(corners, faces, materials=labels)
    moved = corners.copy()
    moved[:8] = Rotation.from_rotvec([np.radians(40), 0, 0]).apply(moved[:8])
    target = neutral.with_vertices(moved)
    parts = find_rigid_parts(neutral, target)
    assert parts is not None
    morphs = {name: em.interpolate(neutral, target, name) for name in ("linear", "rotation")}
    return find_hinge(neutral, target, parts), morphs


@pytest.fixture(scope="module")
def section(hinge: tuple[Hinge, dict[str, Morph]]) -> Element:
    found, morphs = hinge
    grey = np.full((4, 4, 3), 128, dtype=np.uint8)
    errors = hinge_errors(found, morphs)
    return shown(hinge_section(Jaw(found, morphs, errors, grey), "jawOpen", "cm"))


def test_it_says_what_turns(section: Element) -> None:
    assert "With jawOpen, teeth (8 vertices) turn as one rigid body by 40.0°." in section.text


def test_the_winner_keeps_to_the_arc(
    section: Element, hinge: tuple[Hinge, dict[str, Morph]]
) -> None:
    """The farthest corner is √17 from the axis; halfway its chord is off by the sagitta."""
    found, morphs = hinge
    errors = {error.label: error for error in hinge_errors(found, morphs)}
    sagitta = np.sqrt(17) * (1 - np.cos(np.radians(20)))
    assert errors["linear"].parts == pytest.approx(sagitta / found.neutral.diameter, rel=1e-6)
    headline = section.all("p")[0].text
    assert headline.startswith("rotation keeps the jaw within ")
    assert f"a straight line leaves it by {sagitta:#.3g}\u00a0cm" in headline
    rows = {row.all("th")[0].text: row.all("td") for row in section.one("tbody").all("tr")}
    assert rows["linear"][0].text == f"{100 * errors['linear'].parts:.3f}"
    assert rows["linear"][1].text == f"{sagitta:#.3g}\u00a0cm"


def test_what_vanishes_has_a_length_too(hinge: tuple[Hinge, dict[str, Morph]]) -> None:
    """It is less than that of the last digit, in the unit of the column."""
    found, morphs = hinge
    errors = [replace(error, parts=0.0, along=0.0) for error in hinge_errors(found, morphs)]
    grey = np.full((4, 4, 3), 128, dtype=np.uint8)
    page = shown(hinge_section(Jaw(found, morphs, errors, grey), "jawOpen", "cm"))
    least = f"<\u00a0{1e-5 * found.neutral.diameter:#.3g}\u00a0cm"
    for row in page.one("tbody").all("tr"):
        assert [cell.text for cell in row.all("td")] == ["0.000", least]


def test_the_graph_says_in_which_unit_the_jaw_goes(
    hinge: tuple[Hinge, dict[str, Morph]], tmp_path: Path
) -> None:
    for unit, words in (("cm", ">cm<"), ("", ">units of the rig<")):
        hinge_graph(*hinge, tmp_path / "way.svg", unit)
        assert words in (tmp_path / "way.svg").read_text(encoding="utf-8")


def test_parts_are_known_by_their_names(hinge: tuple[Hinge, dict[str, Morph]]) -> None:
    neutral = hinge[0].neutral
    assert looks_of(neutral, np.arange(8)) == ["teeth"]
    assert looks_of(neutral, np.arange(8, 16)) == []


def test_what_is_on_the_arc_is_pale(hinge: tuple[Hinge, dict[str, Morph]]) -> None:
    """The straight line is the darker of the two pictures, and each has its method above it."""
    found, morphs = hinge
    image = hinge_faces(found, morphs, face=(120, 100))
    top = round(1.3 * text_size_for(120)) + text_size_for(120) // 2
    left, right = np.array_split(image[top : top + 100].astype(float), 2, axis=1)
    assert left.min() < right.min() - 40


def test_the_way_of_a_lid_is_shown_with_what_it_sinks_by(
    hinge: tuple[Hinge, dict[str, Morph]],
) -> None:
    """Fig. 2: an edge at √17 from the axis, turned by 40°, sinks by the sagitta of its chord."""
    found, morphs = hinge
    lid = Eyelid(3, np.zeros(3), 4.0, np.array([1.0, 0.0, 0.0]))
    dips = {label: lid.dip(morph) for label, morph in morphs.items()}
    sagitta = np.sqrt(17) * (1 - np.cos(np.radians(20)))
    assert dips["linear"] == pytest.approx(sagitta / found.neutral.diameter, rel=1e-3)
    page = shown(eyelid_section(lid, morphs, dips, "eyeBlink_L", "cm"))
    headline = page.all("p")[0].text
    assert headline.startswith("With eyeBlink_L the edge of the lid sinks towards the eye by ")
    assert f"{sagitta:#.3g}\u00a0cm" in headline
    assert " on linear, by " in headline
    assert headline.endswith(" on rotation.")
    drawn = {each.text for each in page.all("text")}
    assert {"eyeball", "linear", "rotation"} <= drawn
