"""Where an in-between would pay, and what a material does on the curves of a face."""

from __future__ import annotations

import numpy as np
import pytest
from planted_faults import grid, only, turn

from elastomorph.doctor import BeamSettings, Thresholds
from elastomorph.doctor.checks.targets import examine_material, in_between_pays
from elastomorph.doctor.neutral import Neutral
from elastomorph.model.mesh import Mesh
from elastomorph.physics import Load, Material, modal_response

LIMITS = Thresholds(bend=1e-3)


@pytest.mark.parametrize("degrees", [30.0, 60.0])
def test_a_turning_piece_is_off_the_chord_by_the_height_of_its_arc(degrees: float) -> None:
    """At radius r the chord is r(1 - cos θ/2) from the arc; halved, about a quarter is left."""
    mesh = grid(6, 6)
    target = mesh.with_vertices(turn(mesh.vertices, degrees))
    found = only(in_between_pays(Neutral(mesh, LIMITS), target, "t"))
    height = 6.0 * (1 - np.cos(np.radians(degrees) / 2)) / mesh.diameter
    left = 6.0 * (1 - np.cos(np.radians(degrees) / 4)) / mesh.diameter
    words = found.message.split()
    assert float(words[words.index("by") + 1]) == pytest.approx(100 * height, rel=0.01)
    assert float(words[words.index("leaves") + 1]) == pytest.approx(100 * left, rel=0.02)
    assert "in-between at t = 0.5" in found.message


def test_a_shift_needs_no_in_between(face: Mesh) -> None:
    shifted = face.with_vertices(face.vertices + [5.0, 0, 0])
    assert in_between_pays(Neutral(face, LIMITS), shifted, "t") == []


def test_a_material_is_at_resonance_where_its_law_is_singular() -> None:
    """R = 2 is singular at B = 2c; the grid has an open curve with B₁ = kπ⁴."""
    mesh = grid(5, 4)
    damping = np.pi**4 / 2
    law = modal_response(np.array([np.pi**4]), Load.power(2), Material(damping=damping))
    assert not np.isfinite(law).all() or np.abs(law).max() > 1e3
    found = only(examine_material(mesh, "n", BeamSettings(Material(damping=damping))))
    assert found.name == "resonant-material"
    assert "mode 1" in found.message
    assert examine_material(mesh, "n", BeamSettings(Material())) == []


def test_a_law_that_runs_backwards_is_a_warning() -> None:
    """At B = 4c the law of R = 2 is 2t² - t, which first runs back by 1/8."""
    beam = BeamSettings(Material(damping=np.pi**4 / 4))
    found = only(examine_material(grid(5, 4), "n", beam))
    assert (found.name, found.severity) == ("overshooting-material", "warning")
    assert "12.5%" in found.message
