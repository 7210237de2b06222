"""Each setting of each method changes the path, or is refused in one sentence."""

from __future__ import annotations

import copy
import inspect
import pickle
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph import paths
from elastomorph.paths.options import option_rows

pytestmark = pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")

VALUES: dict[str, object] = {
    "order": 3,
    "load": em.Load([1.0, 1.0, 0.5]),
    "material": em.Material(1, 20, 0.05),
    "closure": "unforced",
    "basis": "fourier",
    "stiffness": "length",
    "harmonics": 1,
    "tolerance": 1e-2,
    "straight_within": 10,
}
"""One value of each setting that differs from its default."""


def sheet() -> em.Mesh:
    side = np.linspace(0, 1, 5)
    points = [[x, y, 0.1 * x * y] for y in side for x in side]
    quads = [[5 * j + i, 5 * j + i + 1, 5 * j + i + 6, 5 * j + i + 5]
             for j in range(4) for i in range(4)]  # fmt: skip
    return em.Mesh(points, quads)


SHEET = sheet()
X, Y, Z = SHEET.vertices.T
# Bent about its first edge, so that the far edge turns by two radians.
TURN = 2 * X
BENT = SHEET.with_vertices(np.stack([np.sin(TURN) / 2, Y**2, (1 - np.cos(TURN)) / 2 + Z], axis=1))
# Rows of vertices as open curves of two lengths.
ROWS = [em.Curve(np.arange(5 * j, 5 * j + 5), False) for j in range(4)]
CURVES = em.CurveNetwork([*ROWS, em.Curve([20, 21, 22], False)], 25)


def test_every_option_is_tried() -> None:
    assert set(VALUES) == set(em.Method.every_option())


@pytest.mark.parametrize("setting", VALUES)
@pytest.mark.parametrize("kind", em.Method.known)
def test_has_an_effect_or_is_refused(kind: type[em.Method], setting: str) -> None:
    given = {setting: VALUES[setting]}
    method = kind.name
    if not kind.has(setting):
        with pytest.raises(em.ParameterError, match=f"{method} has no {setting}; it has"):
            em.interpolate(SHEET, BENT, method, curves=CURVES, **given)
        return
    usual = em.interpolate(SHEET, BENT, method, curves=CURVES)
    other = em.interpolate(SHEET, BENT, method, curves=CURVES, **given)
    times = np.linspace(0, 1, 9)
    assert np.abs(usual.at(times) - other.at(times)).max() > 1e-9


@pytest.mark.parametrize("setting", VALUES)
@pytest.mark.parametrize("kind", em.Method.known)
def test_a_method_made_directly_has_the_same_options(kind: type[em.Method], setting: str) -> None:
    """By its class and by its name."""
    given = {setting: VALUES[setting]}
    for made in (kind, lambda **options: em.Method(kind.name, **options)):
        if kind.has(setting):
            assert made(**given) == replace(kind(), **given)  # type: ignore[call-arg]
            assert getattr(made(**given), setting) == VALUES[setting]
        else:
            refusal = f"method '{kind.name}': {kind.name} has no {setting}; it has"
            with pytest.raises(em.ParameterError, match=refusal):
                made(**given)


@pytest.mark.parametrize("kind", em.Method.known)
def test_a_name_and_a_class_are_the_same_method(kind: type[em.Method]) -> None:
    method = em.Method(kind.name)
    assert type(method) is kind
    assert method == kind() == em.Method.parse(kind.name) == em.Method.of(kind.name)
    assert method != next(other() for other in em.Method.known if other is not kind)
    assert pickle.loads(pickle.dumps(method)) == copy.deepcopy(method) == method
    assert {method: 1}[kind()] == 1
    assert list(inspect.signature(kind).parameters) == [own.name for own in fields(kind)]  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", [*em.Method.known, paths.Through])
def test_methods_are_values(kind: type[em.Method]) -> None:
    """Copied, replaced, compared, hashed and shown as what they are made of."""
    given = {name: value for name, value in VALUES.items() if kind.has(name)}
    given |= {"inbetweens": {0.5: BENT}, "law": "spline"} if kind is paths.Through else {}
    method = kind(**given)
    for same in (copy.copy(method), replace(method), kind(**given)):  # type: ignore[type-var]
        assert same == method
        assert hash(same) == hash(method)
    if given:
        assert method != (kind({0.5: BENT}) if kind is paths.Through else kind())
    assert repr(method).startswith(f"{kind.__name__}(" + "".join(f"{n}=" for n in [*given][:1]))
    loaded = pickle.loads(pickle.dumps(method))
    assert type(loaded) is kind
    assert loaded.label == method.label
    np.testing.assert_array_equal(
        loaded.prepare(SHEET, CURVES)(BENT).bends, method.prepare(SHEET, CURVES)(BENT).bends
    )


def test_a_path_through_shapes_is_a_method_like_others() -> None:
    method = paths.Through({0.4: BENT})
    path = em.interpolate(SHEET, BENT, method)
    assert path.method == "through 0.4"
    np.testing.assert_array_equal(path.bends, em.through(SHEET, BENT, {0.4: BENT}).bends)
    inside = em.interpolate(SHEET, BENT, method, region=np.arange(15), falloff=1)
    assert inside.bends[:, :5].any()
    assert not inside.bends[:, 15:].any()
    rig = em.Rig(SHEET, {"bend": BENT}, method=method)
    assert rig.morphs["bend"].method == "through 0.4"
    with pytest.raises(em.ParameterError, match="give law within the Method"):
        em.interpolate(SHEET, BENT, method, law="spline")
    with pytest.raises(em.ParameterError, match="method 'through': through has no order; it has"):
        paths.Through({0.4: BENT}, order=2)


def test_a_name_takes_the_options_of_its_class_alone() -> None:
    with pytest.raises(em.ParameterError, match="linear has no order"):
        em.Method("linear", order=2)
    with pytest.raises(TypeError):
        em.Method("beam", 3)  # type: ignore[arg-type]
    with pytest.raises(AttributeError, match="closure"):
        em.Method().closure  # noqa: B018


def test_what_one_call_takes_is_refused_where_it_has_no_use() -> None:
    for given, takers in (("rigidity", "plate"), ("pinned", "plate"), ("extent", "auto")):
        with pytest.raises(em.ParameterError, match=f"only {takers} takes {given}, not beam"):
            em.prepare(SHEET, "beam:2", **{given: 1})  # type: ignore[arg-type]


@pytest.mark.parametrize("method", [kind.name for kind in em.Method.known])
def test_what_is_no_network_is_refused_by_every_method(method: str) -> None:
    for curves in ("nonsense", [[0, 1, 2]], 3):
        with pytest.raises(em.CurveError, match="curves must be a CurveNetwork, as"):
            em.interpolate(SHEET, BENT, method, curves=curves)  # type: ignore[arg-type]
    with pytest.raises(em.CurveError, match="a mesh of 7 vertices, mesh has 25: extract them"):
        em.interpolate(SHEET, BENT, method, curves=em.CurveNetwork([], 7))
    em.interpolate(SHEET, BENT, method, curves=CURVES)  # tables give every method the same curves


def test_a_setting_is_given_once() -> None:
    with pytest.raises(em.ParameterError, match="the order is given twice"):
        em.interpolate(SHEET, BENT, "beam:3", order=2)
    with pytest.raises(em.ParameterError, match="the closure is given twice"):
        em.interpolate(SHEET, BENT, "beam:3:rest", closure="limit")
    for method, more in (("ease:2", {}), ("beam", {"order": 2})):
        with pytest.raises(em.ParameterError, match="the order R stands for the load"):
            em.interpolate(SHEET, BENT, method, load=em.Load([1, 1]), **more)


def test_whole_numbers_are_numbers() -> None:
    assert em.Method("arc", tolerance=1).tolerance == 1.0
    assert em.Method("auto", straight_within=0).straight_within == 0.0
    for tolerance in (0, -1, True, "1", float("nan")):
        with pytest.raises(em.ParameterError, match="tolerance must be a number above 0"):
            em.Method(tolerance=tolerance)  # type: ignore[arg-type]
    for within in (-1e-9, True, None):
        with pytest.raises(em.ParameterError, match="straight_within must be a number ≥ 0"):
            em.Method(straight_within=within)  # type: ignore[arg-type]
    with pytest.raises(em.ParameterError, match="harmonics must be a whole number"):
        em.Method("beam", harmonics=True)


def test_a_material_is_only_given_to_methods_that_have_one() -> None:
    """So that one material can be given to all rows of a table."""
    steel = em.Material(1, 2, 3)
    assert em.Method("beam").with_material(steel).material == steel
    assert em.Method("linear").with_material(steel) == em.Method("linear")


def test_the_page_on_methods_lists_every_option() -> None:
    page = (Path(__file__).parents[2] / "docs" / "choosing-a-method.md").read_text()
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    table = []
    for row in option_rows(em.Method.known):
        default = f"`{row.default}`" if row.default else ""
        methods = ", ".join(f"`{name}`" for name in row.methods)
        table.append(f"| `{row.name}` | {row.means} | {default} | {methods} |")
    assert rows[-len(table) :] == table
    for kind in em.Method.known:
        pattern = kind.pattern().replace("distance", "straight_within")
        assert f"`{pattern}`" in page, pattern
