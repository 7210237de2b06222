"""The motion of the head is told from that of the face, and taken out."""

from __future__ import annotations

import numpy as np
import pytest
from planted_faults import only, turn

from elastomorph.doctor import Thresholds
from elastomorph.doctor.checks.placement import align, steadied
from elastomorph.model.mesh import Mesh

LIMITS = Thresholds()


@pytest.mark.parametrize("degrees", [0.0, 0.5, 3.0, 40.0])
@pytest.mark.parametrize("name", ["mouthSmile_L", "browInnerUp", "mouthLeft"])
def test_the_motion_of_the_head_is_found_and_taken_out(
    face: Mesh, rig: dict[str, Mesh], name: str, degrees: float
) -> None:
    """Not the motion of the face: it comes back within a millionth of D."""
    target = rig[f"{name}.obj"]
    moved = target.with_vertices(turn(target.vertices, degrees) + [0.3, -0.2, 0.5])
    found = steadied(face, moved, "t", LIMITS)
    assert only(found.findings).name == "moves-the-head"
    assert found.mesh is not None
    off = np.abs(found.mesh.vertices - target.vertices).max()
    assert off <= 1e-6 * face.diameter


def test_expressions_do_not_move_the_head(face: Mesh, rig: dict[str, Mesh]) -> None:
    for mesh in rig.values():
        found = steadied(face, mesh, "t", LIMITS)
        assert not found.findings
        assert found.mesh is mesh


def test_a_head_that_moves_in_every_part_differently_is_not_steadied(face: Mesh) -> None:
    """No rigid motion explains a head that grows."""
    grown = face.with_vertices(1.1 * face.vertices)
    assert not steadied(face, grown, "t", LIMITS).findings


def test_alignment_to_chosen_vertices_is_exact(face: Mesh, rig: dict[str, Mesh]) -> None:
    """Vertices that do not move with the smile tell the motion exactly."""
    target = rig["mouthSmile_R.obj"]
    still = np.flatnonzero((target.vertices == face.vertices).all(axis=1))
    moved = target.with_vertices(turn(target.vertices, 12.0, axis=0) - 4.0)
    back = align(face, moved, still)
    np.testing.assert_allclose(back.vertices, target.vertices, atol=1e-12 * face.diameter)
