"""Every method: exact ends, known formulas, and indifference to how the face is described."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.evaluation import ShapeProbe
from elastomorph.physics import CLOSURES
from small_head import expressions, head, shapes

METHODS = ["linear", "cosine", "ease:2", "ease:3", "beam:1", "beam:2", "beam:3", "beam:5"]
FACE = head()
GRIN = expressions()["grinning"]
CURVES = em.extract_curves(FACE)
pytestmark = pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")


@pytest.mark.parametrize("method", METHODS + [f"beam:2:{closure}" for closure in CLOSURES])
def test_end_shapes_are_exact_to_the_last_bit(method: str) -> None:
    path = em.interpolate(FACE, GRIN, method, curves=CURVES)
    assert path.at(0).tobytes() == FACE.vertices.tobytes()
    assert path.at(1).tobytes() == GRIN.vertices.tobytes()


@given(st.floats(-1, 2))
def test_linear_is_the_formula(t: float) -> None:
    path = em.interpolate(FACE, GRIN, "linear")
    expected = FACE.vertices + t * (GRIN.vertices - FACE.vertices)
    np.testing.assert_allclose(path.at(t), expected, atol=1e-12)
    assert len(path.bends) == 0


@given(st.floats(0, 1))
def test_cosine_is_the_formula(t: float) -> None:
    path = em.interpolate(FACE, GRIN, "cosine")
    expected = FACE.vertices + (1 - np.cos(np.pi * t)) / 2 * path.delta
    np.testing.assert_allclose(path.at(t), expected, atol=1e-13 * FACE.diameter)


@given(st.floats(0, 1), st.integers(1, 6))
def test_ease_is_the_formula(t: float, order: int) -> None:
    path = em.interpolate(FACE, GRIN, "ease", order=order)
    expected = FACE.vertices + t**order * path.delta
    np.testing.assert_allclose(path.at(t), expected, atol=1e-13 * FACE.diameter)
    assert len(path.bends) == int(order > 1)


@pytest.mark.parametrize("closure", ["limit", "linear", "compatible"])
def test_a_beam_under_a_linear_load_moves_linearly(closure: str) -> None:
    """R = 1 is linear interpolation in every mode."""
    path = em.interpolate(FACE, GRIN, "beam", order=1, closure=closure, curves=CURVES)
    assert len(path.bends) == 0


@pytest.mark.parametrize("order", [2, 3])
def test_a_stiff_beam_is_the_ease(order: int) -> None:
    """B → ∞ leaves p(t)/p(1)."""
    stiff = em.Material(rigidity=1e12)
    beam = em.interpolate(FACE, GRIN, "beam", order=order, material=stiff, curves=CURVES)
    ease = em.interpolate(FACE, GRIN, "ease", order=order)
    times = np.linspace(0, 1, 7)
    np.testing.assert_allclose(beam.at(times), ease.at(times), atol=1e-9)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_a_soft_beam_is_linear(order: int) -> None:
    """B → 0 leaves t, the mean included with the closure of that name."""
    soft = em.Material(rigidity=1e-20)
    path = em.interpolate(
        FACE, GRIN, "beam", order=order, material=soft, closure="linear", curves=CURVES
    )
    np.testing.assert_allclose(path.at(0.4), FACE.vertices + 0.4 * path.delta, atol=1e-9)


def test_a_load_may_be_any_polynomial() -> None:
    """t + t² without stiffness terms in the way: halfway to the limit law of a stiff beam."""
    load = em.Load([1.0, 1.0])
    stiff = em.Material(rigidity=1e12)
    path = em.interpolate(FACE, GRIN, "beam", load=load, material=stiff, curves=CURVES)
    expected = FACE.vertices + (0.3 + 0.09) / 2 * path.delta
    np.testing.assert_allclose(path.at(0.3), expected, atol=1e-9)


def turn(angle: float) -> np.ndarray:
    axis = np.array([1.0, 2.0, -0.5]) / np.sqrt(5.25)
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


@settings(max_examples=10)
@given(st.floats(0, 6), st.floats(0.01, 100), st.sampled_from(METHODS))
def test_rigid_motion_and_scale_carry_through(angle: float, scale: float, method: str) -> None:
    """Interpolating moved faces is moving the interpolated face."""

    def moved(vertices: np.ndarray) -> np.ndarray:
        return scale * vertices @ turn(angle).T + [3.0, -7.0, 2.0]

    path = em.interpolate(FACE, GRIN, method, curves=CURVES)
    other = em.interpolate(
        FACE.with_vertices(moved(FACE.vertices)),
        FACE.with_vertices(moved(GRIN.vertices)),
        method,
        curves=CURVES,
    )
    np.testing.assert_allclose(
        other.at(0.35), moved(path.at(0.35)), atol=1e-10 * max(1, scale * FACE.diameter)
    )


@settings(max_examples=10)
@given(st.integers(0, 2**31), st.sampled_from(METHODS))
def test_relabelled_vertices_carry_through(seed: int, method: str) -> None:
    """A face whose vertices (and curves) are renumbered moves in the same way."""
    new_index = np.random.default_rng(seed).permutation(len(FACE.vertices))
    old_index = np.argsort(new_index)
    faces = [new_index[face] for face in FACE.faces]
    neutral = em.Mesh(FACE.vertices[old_index], faces)
    target = neutral.with_vertices(GRIN.vertices[old_index])
    path = em.interpolate(FACE, GRIN, method, curves=CURVES)
    other = em.interpolate(neutral, target, method, curves=CURVES.relabelled(new_index))
    np.testing.assert_allclose(other.at(0.6)[new_index], path.at(0.6), atol=1e-11)


def test_one_preparation_serves_many_targets() -> None:
    to = em.prepare(FACE, "beam:3", curves=CURVES)
    for target in expressions().values():
        np.testing.assert_array_equal(
            to(target).bends, em.interpolate(FACE, target, "beam:3", curves=CURVES).bends
        )


def test_short_curves_are_stiffer_by_length() -> None:
    """At equal amplitude a short curve's law is closer to the limit; a tiny one is at it."""
    points = np.zeros((12, 3))
    points[:6, 0] = np.linspace(0, 10, 6)
    points[6:, 0] = np.linspace(0, 0.1, 6)
    points[6:, 1] = 1
    neutral = em.Mesh(points)
    bump = np.zeros((12, 3))
    bump[:, 2] = np.tile(np.cos(np.pi * (np.arange(6) + 0.5) / 6), 2)
    network = em.CurveNetwork(
        [em.Curve(np.arange(6), False), em.Curve(np.arange(6, 12), False)], 12
    )
    path = em.interpolate(
        neutral,
        neutral.with_vertices(points + bump),
        "beam:3",
        curves=network,
        stiffness="length",
        material=em.Material(1, 1, 0.5),
    )
    limit = 0.5**3 * bump
    away = np.abs(path.at(0.5) - points - limit).max(axis=1)
    assert away[6:].max() < 1e-9 < away[:6].max()


class TestRefusals:
    """Each mistake is one error of ours that says what was expected."""

    @pytest.mark.parametrize(
        ("settings", "message"),
        [
            ({"method": "spline"}, "linear, cosine, ease, beam, plate"),
            ({"method": "beam:0"}, "whole number from 1"),
            ({"method": "beam:2:3"}, "twice"),
            ({"method": "linear:2"}, "no order"),
            ({"method": "ease:2:rest"}, "no closure"),
            ({"method": "beam:fast"}, "neither an order"),
            ({"closure": "free"}, "closure must be one of"),
            ({"basis": "sine"}, "basis must be one of"),
            ({"stiffness": "soft"}, "stiffness must be one of"),
            ({"harmonics": -1}, "harmonics"),
            ({"order": 0}, "order R"),
            ({"ordre": 2}, "beam has no ordre; it has order"),
            ({"method": "auto", "order": 2}, "auto has no order; it has tolerance, straight"),
            ({"method": "auto:near"}, "'near' is no number"),
            ({"method": "auto:-1"}, "straight_within"),
            ({"method": "auto:0.1:0.2"}, "twice"),
            ({"method": em.Method(), "order": 2}, "within the Method"),
            ({"material": 3}, "Material"),
            ({"region": []}, "at least one"),
            ({"region": [1], "falloff": -1}, "falloff"),
            ({"region": [1], "rest": "still"}, "rest must be one of"),
        ],
    )
    def test_settings(self, settings: dict[str, object], message: str) -> None:
        with pytest.raises(em.ParameterError, match=message):
            em.interpolate(FACE, GRIN, **{"curves": CURVES, "method": "beam", **settings})  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("region", "message"), [([1, 10**6], "names vertex 1000000"), ([0.5], "vertex indices")]
    )
    def test_regions(self, region: list[float], message: str) -> None:
        with pytest.raises(em.CurveError, match=message):
            em.interpolate(FACE, GRIN, curves=CURVES, region=region)

    def test_resonance_reaches_the_user(self) -> None:
        soft = em.Material(damping=8 * np.pi**4)
        with pytest.raises(em.ResonanceError, match=r"mode \d+ of the \w+ curves"):
            em.interpolate(FACE, GRIN, "beam:2", material=soft, curves=CURVES)

    def test_another_topology(self) -> None:
        with pytest.raises(em.TopologyError):
            em.interpolate(FACE, em.Mesh(FACE.vertices, list(FACE.faces)[1:]))

    def test_two_vertices(self) -> None:
        pair = em.Mesh([[0, 0, 0], [1, 0, 0]])
        with pytest.raises(em.MeshError, match="2 vertices"):
            em.interpolate(pair, pair)

    def test_curves_of_another_mesh(self) -> None:
        with pytest.raises(em.CurveError, match="extract them"):
            em.interpolate(FACE, GRIN, "beam", curves=em.CurveNetwork([], 7))


def test_labels_say_what_differs_from_the_usual() -> None:
    assert em.Method.parse("linear").label == "linear"
    assert em.Method.parse("ease:3").label == "ease R=3"
    assert em.Method.parse("beam:2:unforced").label == "beam R=2 unforced"
    assert em.Method("beam", load=em.Load([1, 2])).label == "beam load 1,2"
    assert em.Method().label == "auto"
    assert em.Method.parse("auto:0.001").label == "auto 0.001"
    label = em.Method(
        "beam", material=em.Material(2, 1, 0.5), basis="fourier", stiffness="length", harmonics=4
    ).label
    assert label == "beam R=2 fourier by length N=4 m=2 c=1 k=0.5"


@pytest.mark.parametrize("method", ["arc", "rotation"])
def test_shapes_of_the_head_turn_no_polygon_over(method: str) -> None:
    """None that the straight line does not."""
    to = em.prepare(FACE, method)
    for name in ("jawOpen", "eyeBlink_L", "mouthFunnel", "mouthPucker", "mouthSmile_L"):
        target = shapes()[name]
        morph = to(target)
        probe = ShapeProbe.of(FACE, target, np.zeros(len(FACE.vertices), int))
        straight = em.interpolate(FACE, target, "linear")
        for t in (0.25, 0.5, 0.75):
            assert probe.flips(morph.at(t)) <= probe.flips(straight.at(t)), name
