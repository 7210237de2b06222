"""What single targets do wrong."""

from __future__ import annotations

import numpy as np
import pytest
from planted_faults import only

from elastomorph.doctor.checks.targets import does_nothing, duplicate_targets, jumping_vertices
from elastomorph.doctor.neutral import Neutral
from elastomorph.model.mesh import Mesh


@pytest.mark.parametrize("spikes", [[700], [700, 2100, 4000]])
def test_jumping_vertices_are_found_and_no_others(
    face: Mesh, rig: dict[str, Mesh], spikes: list[int]
) -> None:
    neutral = Neutral(face)
    for mesh in rig.values():
        assert jumping_vertices(neutral, mesh, "t") == []
        points = mesh.vertices.copy()
        points[spikes] += 0.06 * face.diameter
        found = only(jumping_vertices(neutral, mesh.with_vertices(points), "t"))
        assert (found.name, found.vertices) == ("jumping-vertices", tuple(spikes))


def test_a_target_that_does_nothing(face: Mesh, rig: dict[str, Mesh]) -> None:
    assert only(does_nothing(Neutral(face), face, "t")).message == "it is the neutral"
    rounded = face.with_vertices(np.round(face.vertices, 5))
    assert "rounding" in only(does_nothing(Neutral(face), rounded, "t")).message
    for mesh in rig.values():
        assert does_nothing(Neutral(face), mesh, "t") == []


def test_doubles_are_found_once_each(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Every later copy names the first, also where it was rounded."""
    smile = rig["mouthSmile_L.obj"]
    copies = {"again.obj": smile.with_vertices(np.round(smile.vertices, 5)), "more.obj": smile}
    assert duplicate_targets(Neutral(face), rig) == []
    found = duplicate_targets(Neutral(face), {**rig, **copies})
    assert [one.file for one in found] == ["again.obj", "more.obj"]
    assert all("mouthSmile_L.obj" in one.message for one in found)
