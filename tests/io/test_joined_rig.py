"""Several meshes become one rig that moves each of them as it moved alone."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.io.joined_rig import Placing, RigPart, joined_rig, turned_corners
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh, UVMap
from elastomorph.model.morph import Morph

TRIANGLE = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])
HERE = Placing(np.eye(3), np.zeros(3))
MIRRORED_AND_LARGER = Placing(np.diag([-2.0, 2, 2]), np.array([0.0, 0, 10]))
PARABOLA = BendCurve.polynomial([0.0, -1.0, 1.0])
CUBIC = BendCurve.polynomial([0.0, -1.0, 0.0, 1.0])


def part(
    name: str, place: Placing, curve: BendCurve, error: float = 0.0, width: int = 2
) -> RigPart:
    """A triangle that lifts one vertex and bends on the way."""
    uv = UVMap(np.arange(3.0 * width).reshape(3, width), np.array([0, 1, -1], dtype=np.int32))
    mesh = Mesh(TRIANGLE, [[0, 1, 2]], uv=uv)
    target = mesh.with_vertices(TRIANGLE + [[0, 0, 1], [0, 0, 0], [0, 0, 0]])
    bend = np.zeros((1, 3, 3))
    bend[0, 2] = [1, 2, 3]
    morph = Morph(mesh, target, bend, (curve,), method="beam", bake_error=error)
    return RigPart(name, mesh, {"lift": morph, f"{name} only": morph}, place)


@pytest.mark.parametrize("curve", [PARABOLA, CUBIC])
def test_each_mesh_moves_as_it_did_alone(curve: BendCurve) -> None:
    parts = [part("a", HERE, PARABOLA), part("b", MIRRORED_AND_LARGER, curve)]
    neutral, morphs = joined_rig(parts, "face.fbx")
    assert list(morphs) == ["lift", "a only", "b only"]
    assert len(morphs["lift"].bends) == (1 if curve is PARABOLA else 2)
    assert morphs["lift"].method == "beam"
    for t in (0.0, 0.3, 1.0):
        found = morphs["lift"].at(t)
        for i, own in enumerate(parts):
            alone = own.place.positions(own.morphs["lift"].at(t))
            assert found[3 * i : 3 * i + 3] == pytest.approx(alone, abs=1e-14)
    assert not morphs["a only"].delta[3:].any()
    assert not morphs["a only"].bends[:, 3:].any()
    assert neutral.faces.indices.tolist() == [0, 1, 2, 3, 5, 4]
    assert neutral.groups is not None
    assert neutral.groups.names == ("a", "b")


def test_one_mesh_that_stays_is_left_as_it_is() -> None:
    own = part("a", HERE, PARABOLA)
    neutral, morphs = joined_rig([own], "face.fbx")
    assert neutral is own.mesh
    assert morphs == own.morphs


def test_texture_coordinates_follow_their_corners() -> None:
    """The mirrored triangle is turned around; the narrower table gets a column of zeros."""
    parts = [part("a", HERE, PARABOLA), part("b", MIRRORED_AND_LARGER, PARABOLA, width=3)]
    uv = joined_rig(parts, "face.fbx")[0].uv
    assert uv is not None
    assert uv.corners.tolist() == [0, 1, -1, 3, -1, 4]
    assert uv.coordinates.tolist() == [
        [0, 1, 0], [2, 3, 0], [4, 5, 0], [0, 1, 2], [3, 4, 5], [6, 7, 8],
    ]  # fmt: skip


def test_the_bake_error_is_the_largest_distance() -> None:
    """2 % of the 5 that a triangle is across, at twice the size: 0.2 of the whole."""
    parts = [part("a", HERE, PARABOLA, 0.01), part("b", MIRRORED_AND_LARGER, PARABOLA, 0.02)]
    neutral, morphs = joined_rig(parts, "face.fbx")
    assert morphs["lift"].bake_error * neutral.diameter == pytest.approx(0.02 * 5 * 2)
    assert morphs["a only"].bake_error * neutral.diameter == pytest.approx(0.01 * 5)


def test_polygons_are_turned_around_their_first_corner() -> None:
    assert turned_corners(np.array([0, 3, 7])).tolist() == [0, 2, 1, 3, 6, 5, 4]
