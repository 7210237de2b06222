"""The plate on faces: exact ends, indifference to how a face is described, paint, pins, seams."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.evaluation.shape import ShapeProbe
from elastomorph.model.surface import surface_operators
from elastomorph.paths import Method
from elastomorph.physics import CLOSURES
from small_head import expressions, head

FACE = head()
GRIN = expressions()["grinning"]
SOFT = em.Material(0.3, 30, 1)
pytestmark = pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")


def bends(path: em.Morph) -> np.ndarray:
    """(K, V, 3) the parts that are not the straight line, with none left out as rounding."""
    assert len(path.bends) > 0
    return path.bends


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("closure", CLOSURES)
def test_end_shapes_are_exact_to_the_last_bit(order: int, closure: str) -> None:
    path = Method("plate", order=order, closure=closure, material=SOFT).prepare(FACE)(GRIN)
    assert path.at(0).tobytes() == FACE.vertices.tobytes()
    assert path.at(1).tobytes() == GRIN.vertices.tobytes()
    assert not np.allclose(path.at(0.5), (FACE.vertices + GRIN.vertices) / 2, atol=1e-3)


@pytest.mark.parametrize("closure", ["limit", "linear", "compatible"])
def test_a_linear_load_is_linear_interpolation(closure: str) -> None:
    path = Method("plate", order=1, closure=closure, material=SOFT).prepare(FACE)(GRIN)
    straight = Method("linear").prepare(FACE)(GRIN)
    assert len(path.bends) == 0
    assert np.array_equal(path.at([0.2, 0.7]), straight.at([0.2, 0.7]))


@pytest.mark.parametrize("order", [2, 3, 8])
def test_a_stiff_plate_is_the_ease(order: int) -> None:
    """B → ∞ leaves p(t)/p(1), each further factor of rigidity a factor nearer."""
    eased = Method("ease", order=order).prepare(FACE)(GRIN).at(0.5)
    gaps = []
    for rigidity in (1e2, 1e4):
        method = Method("plate", order=order, material=em.Material(1, 1, rigidity))
        path = method.prepare(FACE)(GRIN)
        gaps.append(np.abs(path.at(0.5) - eased).max() / FACE.diameter)
    assert gaps[0] < 1e-3
    assert gaps[1] == pytest.approx(gaps[0] / 100, rel=0.2)


@pytest.mark.parametrize("order", [2, 3])
def test_nothing_depends_on_place_size_or_numbering(order: int) -> None:
    method = Method("plate", order=order, closure="rest", material=SOFT)
    expected = bends(method.prepare(FACE)(GRIN))
    random = np.random.default_rng(order)
    turn = np.linalg.qr(random.standard_normal((3, 3)))[0]
    neutral = FACE.with_vertices(7 * FACE.vertices @ turn.T + [1, 2, 3])
    target = neutral.with_vertices(7 * GRIN.vertices @ turn.T + [1, 2, 3])
    moved = bends(method.prepare(neutral)(target))
    largest = np.abs(expected).max()
    assert np.abs(moved / 7 @ turn - expected).max() < 1e-9 * largest

    order_of = random.permutation(len(FACE.vertices))
    place = np.argsort(order_of)
    faces = [np.roll(place[face], 1) for face in FACE.faces][::-1]
    renamed = em.Mesh(vertices=FACE.vertices[order_of], faces=faces)
    again = method.prepare(renamed)(renamed.with_vertices(GRIN.vertices[order_of]))
    assert np.abs(bends(again) - expected[:, order_of]).max() < 1e-9 * largest


def test_one_preparation_serves_every_target() -> None:
    to = Method("plate", order=3, material=SOFT).prepare(FACE)
    for target in expressions().values():
        alone = Method("plate", order=3, material=SOFT).prepare(FACE)(target)
        assert np.array_equal(to(target).bends, alone.bends)


def test_rigidity_is_a_factor_of_that_of_the_material() -> None:
    count = len(FACE.vertices)
    stiffer = em.Material(SOFT.mass, SOFT.damping, 3 * SOFT.rigidity)
    expected = bends(Method("plate", material=stiffer).prepare(FACE)(GRIN))
    for rigidity in (3, 3.0, np.full(count, 3.0)):
        path = Method("plate", material=SOFT).prepare(FACE, rigidity=rigidity)(GRIN)
        assert np.array_equal(path.bends, expected)
    nearly = 3 * (1 + 1e-13 * np.arange(count))
    path = Method("plate", material=SOFT).prepare(FACE, rigidity=nearly)(GRIN)
    assert path.bends == pytest.approx(expected, abs=1e-9 * FACE.diameter)


@pytest.mark.parametrize("as_mask", [False, True])
def test_pinned_vertices_follow_the_limit_law(as_mask: bool) -> None:
    chosen = np.arange(0, len(FACE.vertices), 97)
    mask = np.zeros(len(FACE.vertices), dtype=bool)
    mask[chosen] = True
    method = Method("plate", order=2, material=SOFT)
    path = method.prepare(FACE, pinned=mask if as_mask else chosen)(GRIN)
    eased = Method("ease", order=2).prepare(FACE)(GRIN)
    off = np.abs(path.at(0.5) - eased.at(0.5)).max(axis=1)
    assert off[chosen].max() < 1e-13 * FACE.diameter
    assert off.max() > 1e-6 * FACE.diameter


def test_vertices_on_no_polygon_follow_the_limit_law() -> None:
    neutral = em.Mesh(vertices=np.r_[FACE.vertices, [[0, 0, 9.0]]], faces=FACE.faces)
    target = neutral.with_vertices(np.r_[GRIN.vertices, [[0, 8.0, 9]]])
    method = Method("plate", order=2, closure="rest", material=SOFT)
    path = method.prepare(neutral)(target)
    assert path.at(0.5)[-1] == pytest.approx([0, 2, 9])
    without = method.prepare(FACE)(GRIN)
    assert path.at(0.5)[:-1] == pytest.approx(without.at(0.5), abs=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pinned": [-1]}, "between 0 and"),
        ({"pinned": [0.5]}, "vertex indices"),
        ({"pinned": [True, False]}, "as a mask"),
        ({"rigidity": "soft"}, "numbers"),
        ({"rigidity": 0}, "above 0"),
        ({"rigidity": [1.0, 2.0]}, "one for each"),
    ],
)
def test_options_out_of_range_are_named(options: dict[str, object], message: str) -> None:
    with pytest.raises(em.ElastomorphError, match=message):
        Method("plate").prepare(FACE, **options)


def test_a_neutral_without_surface_is_refused() -> None:
    with pytest.raises(em.ElastomorphError, match="no surface"):
        Method("plate").prepare(em.Mesh(vertices=FACE.vertices, faces=[]))


def test_collapsed_polygons_do_no_harm() -> None:
    """A lip sealed by polygons without area, a folded one and one doubled."""
    vertices = FACE.vertices.copy()
    for face in list(FACE.faces)[100:110]:
        vertices[face] = vertices[face[0]]
    faces = [*FACE.faces, FACE.faces[7], FACE.faces[8][[0, 1, 0]]]
    neutral = em.Mesh(vertices=vertices, faces=faces)
    target = neutral.with_vertices(vertices + GRIN.vertices - FACE.vertices)
    path = Method("plate", order=3, material=SOFT).prepare(neutral)(target)
    largest = np.abs(path.delta).max()
    assert np.isfinite(path.bends).all()
    assert np.abs(path.bends).max() < 10 * largest


@pytest.mark.realdata
def test_no_seam_opens_in_a_production_face(data_dir: Path) -> None:
    """The surface knows no curves: whatever the closure, its seam is that of linear, none."""
    rig = data_dir / "ict-facekit"
    neutral, target = em.read(rig / "generic_neutral_mesh.obj"), em.read(rig / "jawOpen.obj")
    each = np.arange(len(neutral.vertices))  # a curve of its own: every edge counts
    probe = ShapeProbe.of(neutral, target, each)
    line = Method("linear").prepare(neutral)(target)
    straight = probe.at(line, 0.25, line.at(0.25))  # where the limit law t² is at t = 0.5
    for closure in CLOSURES:
        path = Method("plate", order=2, closure=closure).prepare(neutral)(target)
        shape = probe.at(path, 0.5, path.at(0.5))
        assert shape.seam < straight.seam + 1e-5
        assert shape.flips <= straight.flips
        assert shape.stretch == pytest.approx(straight.stretch, rel=0.01)


@pytest.mark.realdata
def test_every_piece_of_a_production_face_has_its_own_mean(data_dir: Path) -> None:
    """The mean of a tooth, weighted by its area, follows the closure, as that of the skin does."""
    rig = data_dir / "ict-facekit"
    neutral, target = em.read(rig / "generic_neutral_mesh.obj"), em.read(rig / "jawOpen.obj")
    surface = surface_operators(neutral)
    path = Method("plate", order=2, closure="rest").prepare(neutral)(target)
    law = 1.5 * 0.5**2 - 0.5 * 0.5**3
    weights = surface.mass[:, None]
    for piece in range(surface.component_of.max() + 1):
        inside = surface.component_of == piece
        moved = (weights * (path.at(0.5) - neutral.vertices))[inside].sum(axis=0)
        whole = (weights * path.delta)[inside].sum(axis=0)
        assert moved == pytest.approx(law * whole, abs=1e-9 * weights[inside].sum())
