"""The plate: known modes, the equation of motion itself, and all routes to one result."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_array, eye_array, kron

from elastomorph.errors import ParameterError, ResonanceError
from elastomorph.physics import CLOSURES, Load, Material, mean_response, modal_response
from elastomorph.physics.plate import PlateModes

SOFT = Material(0.3, 20, 1)


def ring(count: int) -> csc_array:
    rows = np.zeros((count, count))
    here = np.arange(count)
    rows[here, here] = 2
    rows[here, (here + 1) % count] -= 1
    rows[here, (here - 1) % count] -= 1
    return csc_array(rows)


def torus(count: int) -> tuple[csc_array, np.ndarray, np.ndarray, np.ndarray]:
    """L (five-point, which the cotangents of squares are), M, pieces and (x, y) of a flat torus."""
    line, one = ring(count), eye_array(count)
    laplacian = csc_array(kron(line, one) + kron(one, line))
    x, y = np.meshgrid(np.arange(count) / count, np.arange(count) / count, indexing="ij")
    size = count**2
    return (
        laplacian,
        np.full(size, 1 / size),
        np.zeros(size, dtype=int),
        np.stack([x.ravel(), y.ravel()], axis=1),
    )


@pytest.fixture(scope="module")
def surface() -> tuple[csc_array, np.ndarray, np.ndarray]:
    """Two pieces with random positive weights and masses, and a vertex on its own."""
    random = np.random.default_rng(5)

    def piece(count: int) -> csc_array:
        rows = np.where(random.uniform(size=(count, count)) < 5 / count, random.uniform(1, 3), 0)
        rows += np.diag(np.ones(count - 1), 1)
        rows = np.triu(rows, 1) + np.triu(rows, 1).T
        return csc_array(np.diag(rows.sum(axis=1)) - rows)

    laplacian = csc_array(block_diag([piece(60), piece(25), np.zeros((1, 1))]))
    mass = random.uniform(0.5, 1.5, 86)
    return laplacian, mass / mass.sum(), np.repeat([0, 1, 2], [60, 25, 1])


@pytest.fixture(scope="module")
def delta() -> np.ndarray:
    return np.random.default_rng(6).standard_normal((86, 3))


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("closure", CLOSURES)
def test_a_cosine_follows_the_law_of_its_eigenvalue(order, closure):
    """D_r of a single wave is φ_r(kμ²) times the wave, with the discrete μ; its mean has φ₀."""
    laplacian, mass, pieces, place = torus(12)
    material, load = Material(0.2, 3, 0.7), Load.power(order)
    wave = np.cos(2 * np.pi * (2 * place[:, 0] + place[:, 1]))[:, None] * [1.0, 2.0, -1.0]
    mu = 12**2 * (4 - 2 * np.cos(2 * np.pi * 2 / 12) - 2 * np.cos(2 * np.pi / 12))
    law = np.append(modal_response(0.7 * mu**2, load, material), 0)
    mean = mean_response(closure, load, material)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        plate = PlateModes.prepare(laplacian, mass, pieces, material, load, closure=closure)
    bends = plate.bends(wave + [3.0, 0, 1])
    for power, bend in enumerate(bends, start=1):
        assert bend == pytest.approx(law[power] * wave + mean[power] * np.array([3.0, 0, 1]))


def test_a_cosine_approaches_the_law_of_the_beam_at_second_order():
    """B → 16π⁴k of Eq. 19 for one wave around the torus."""
    load, errors = Load.power(2), []
    for count in (12, 24, 48):
        laplacian, mass, pieces, place = torus(count)
        wave = np.cos(2 * np.pi * place[:, :1]) * [1.0, 0, 0]
        bends = PlateModes.prepare(laplacian, mass, pieces, SOFT, load).bends(wave)
        expected = modal_response(16 * np.pi**4, load, SOFT)[1]
        errors.append(abs(bends[0, 0, 0] - expected))
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2, 2], abs=0.1)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("closure", CLOSURES)
@pytest.mark.parametrize("painted", [False, True])
@pytest.mark.parametrize("some_pinned", [False, True])
def test_solves_and_modes_agree(surface, delta, order, closure, painted, some_pinned):
    """All modes one by one, from a dense eigenvalue problem of this test's own."""
    laplacian, mass, pieces = surface
    rigidity = np.random.default_rng(7).uniform(0.2, 5, 86) if painted else np.ones(86)
    pinned = np.zeros(86, dtype=bool)
    pinned[[3, 17]] = some_pinned
    load = Load.power(order)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        plate = PlateModes.prepare(
            laplacian, mass, pieces, SOFT, load, closure=closure, rigidity=rigidity, pinned=pinned
        )
    bends = plate.bends(delta)

    pinned[85] = True  # on no triangle
    free = ~pinned
    dense = laplacian.toarray()
    bending = dense @ np.diag(rigidity / mass) @ dense
    root = np.sqrt(mass[free])
    values, modes = np.linalg.eigh(bending[np.ix_(free, free)] / np.outer(root, root))
    kernel = 1 if some_pinned else 2
    limit = np.append(load.limit_law, 0)
    laws = np.empty((len(values), order + 1))
    laws[:kernel] = mean_response(closure, load, SOFT)
    laws[kernel:, :order] = modal_response(values[kernel:], load, SOFT)
    laws[kernel:, order] = 0
    expected = limit[:, None, None] * delta
    amplitudes = modes.T @ (root[:, None] * delta[free])
    for power in range(order + 1):
        expected[power, free] = modes @ (laws[:, power, None] * amplitudes) / root[:, None]
    assert np.abs(expected[len(bends) + 1 :]).max(initial=0) < 1e-8
    assert np.abs(bends - expected[1 : len(bends) + 1]).max(initial=0) < 1e-8


@pytest.mark.parametrize("order", [2, 3, 5])
@pytest.mark.parametrize("some_pinned", [False, True])
def test_the_path_solves_the_equation_of_motion(surface, delta, order, some_pinned):
    """M(m ẅ + c ẇ) + K w is e₀ + e₁tᴿ at every free vertex: no other power of t is left."""
    laplacian, mass, pieces = surface
    rigidity = np.random.default_rng(8).uniform(0.5, 2, 86)
    pinned = np.zeros(86, dtype=bool)
    pinned[:2] = some_pinned
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        plate = PlateModes.prepare(
            laplacian, mass, pieces, SOFT, Load.power(order), closure="rest",
            rigidity=rigidity, pinned=pinned,
        )  # fmt: skip
    bends = plate.bends(delta)
    powers = np.concatenate([np.zeros((1, 86, 3)), (delta - bends.sum(axis=0))[None], bends])
    dense = laplacian.toarray()
    operator = dense @ np.diag(rigidity / mass) @ dense
    force = np.einsum("ij,pjk->pik", operator, powers)
    number = np.arange(len(powers))[:, None, None]
    velocity, acceleration = (number * powers)[1:], (number * (number - 1) * powers)[2:]
    force[: len(velocity)] += SOFT.damping * mass[:, None] * velocity
    force[: len(acceleration)] += SOFT.mass * mass[:, None] * acceleration
    free = ~pinned
    free[85] = False
    others = [power for power in range(1, len(powers)) if power != order]
    assert np.abs(force[others][:, free]).max() < 1e-9 * np.abs(force[order]).max()


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
def test_a_soft_wave_keeps_its_digits_in_a_stiff_operator():
    """Close to its resonance, with eigenvalues 10⁷ times its own beside it, by the exact law."""
    count = 48
    (laplacian, mass, pieces, place), (other, weights, ones, _) = torus(count), torus(4)
    mu = (2 * count * np.sin(np.pi / count)) ** 2
    material, load = Material(0.3, 0.45 * mu**2, 1), Load.power(2)
    plate = PlateModes.prepare(
        csc_array(block_diag([laplacian, other])),
        np.concatenate([mass, weights]),
        np.concatenate([pieces, ones + 1]),
        material,
        load,
        rigidity=np.repeat([1.0, 2.0], [count**2, 16]),
    )
    wave = np.cos(2 * np.pi * place[:, :1]) * [1.0, 0, 0]
    bend = plate.bends(np.concatenate([wave, np.zeros((16, 3))]))[0]
    law = modal_response(mu**2, load, material)
    assert np.abs(bend[: count**2] - law[1] * wave).max() < 2e-11


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
@pytest.mark.parametrize("painted", [False, True])
def test_how_far_a_face_moves_as_a_whole_does_not_show(surface, delta, painted):
    """Not even for heavy materials, in which the law of a mode of no stiffness is huge."""
    laplacian, mass, pieces = surface
    rigidity = np.linspace(1, 2, 86) if painted else None
    load, far = Load.power(5), 1000.0
    plate = PlateModes.prepare(
        laplacian, mass, pieces, Material(2e4, 20, 1), load, rigidity=rigidity
    )
    expected = plate.bends(delta) + far * load.limit_law[1:, None, None]
    assert np.abs(plate.bends(delta + far) - expected).max() < 1e-8


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
@pytest.mark.parametrize("painted", [False, True])
def test_pieces_keep_their_means_in_nearly_singular_solves(surface, delta, painted):
    """Roots of the laws close to 0, where the rounding of a solve is constant on each piece."""
    laplacian, mass, pieces = surface
    rigidity = np.linspace(1, 2, 86) if painted else None
    load = Load.power(6)
    plate = PlateModes.prepare(
        laplacian, mass, pieces, Material(1e-5, 1e-8, 1), load, rigidity=rigidity
    )
    bends = plate.bends(delta + 1000)
    for piece in (0, 1):
        inside = pieces == piece
        means = np.average(bends[:, inside], axis=1, weights=mass[inside])
        whole = np.average(delta[inside] + 1000, axis=0, weights=mass[inside])
        assert np.abs(means - np.multiply.outer(load.limit_law[1:], whole)).max() < 1e-9


def test_pinned_vertices_follow_the_limit_law(surface, delta):
    laplacian, mass, pieces = surface
    pinned = np.zeros(86, dtype=bool)
    pinned[[0, 70]] = True
    load = Load([0.5, 0, 1.0])
    bends = PlateModes.prepare(laplacian, mass, pieces, SOFT, load, pinned=pinned).bends(delta)
    for power, bend in enumerate(bends, start=1):
        assert np.array_equal(bend[[0, 70, 85]], load.limit_law[power] * delta[[0, 70, 85]])
    everywhere = PlateModes.prepare(
        laplacian, mass, pieces, SOFT, load, closure="rest", pinned=np.ones(86, dtype=bool)
    )
    assert np.array_equal(everywhere.bends(delta)[:2], load.limit_law[1:, None, None] * delta)


def test_a_rigidity_alike_everywhere_is_that_of_the_material(surface, delta):
    """Both through K itself and through its Laplacian factors, which take different routes."""
    laplacian, mass, pieces = surface
    load = Load.power(3)
    stiffer = Material(SOFT.mass, SOFT.damping, 2.5)
    expected = PlateModes.prepare(laplacian, mass, pieces, stiffer, load).bends(delta)
    alike = np.full(86, 2.5)
    nearly = alike * (1 + 1e-13 * np.arange(86))
    for rigidity in (alike, nearly):
        plate = PlateModes.prepare(laplacian, mass, pieces, SOFT, load, rigidity=rigidity)
        assert plate.bends(delta) == pytest.approx(expected, abs=1e-9)


def test_paint_on_one_piece_leaves_the_others_alone(surface, delta):
    laplacian, mass, pieces = surface
    plain = PlateModes.prepare(laplacian, mass, pieces, SOFT, Load.power(2)).bends(delta)
    rigidity = np.where(pieces == 1, 30.0, 1.0)
    painted = PlateModes.prepare(
        laplacian, mass, pieces, SOFT, Load.power(2), rigidity=rigidity
    ).bends(delta)
    change = np.abs(painted - plain).max(axis=(0, 2))
    assert change[pieces == 1].max() > 1e-4
    assert change[pieces != 1].max() < 1e-11


def test_a_region_painted_stiff_bends_less_there_and_the_change_is_there():
    """What is left of the limit law has its curvature divided by the rigidity, inside only."""
    laplacian, mass, pieces, place = torus(32)
    load = Load.power(2)
    motion = np.exp(-40 * ((place - 0.5) ** 2).sum(axis=1))[:, None] * [0.0, 0, 1]
    inside = (np.abs(place - 0.5) < 0.13).all(axis=1)
    curvature = []
    rigidities = (np.ones(32**2), np.where(inside, 50.0, 1.0))
    for rigidity in rigidities:
        plate = PlateModes.prepare(laplacian, mass, pieces, SOFT, load, rigidity=rigidity)
        correction = (plate.bends(motion)[0] - motion)[:, 2]
        curvature.append((laplacian @ correction) / mass)
    before, after = (np.abs(values) for values in curvature)
    assert after[inside].mean() < before[inside].mean() / 20
    changed = np.abs(curvature[1] - curvature[0])
    far = (np.abs(place - 0.5) > 0.3).any(axis=1)
    assert changed[far].mean() < 0.2 * changed[inside].mean()


@pytest.mark.parametrize("count", [0, 5, 40])
def test_modes_above_the_harmonics_follow_the_limit_law(surface, delta, count):
    laplacian, mass, pieces = surface
    load = Load.power(3)
    plate = PlateModes.prepare(laplacian, mass, pieces, SOFT, load, harmonics=count)
    root = np.sqrt(mass[:85])
    values, modes = np.linalg.eigh(laplacian.toarray()[:85, :85] / np.outer(root, root))
    modes, values = modes[:, 2 : 2 + count], values[2 : 2 + count]
    laws = modal_response(values**2, load, SOFT) - load.limit_law
    expected = load.limit_law[1:, None, None] * delta
    amplitudes = modes.T @ (root[:, None] * delta[:85])
    for power in (1, 2):
        expected[power - 1, :85] += modes @ (laws[:, power, None] * amplitudes) / root[:, None]
    assert plate.bends(delta) == pytest.approx(expected, abs=1e-9)


def test_loads_of_high_order_use_the_lowest_modes():
    """A wave below the 64th mode follows its law, one above follows the limit law."""
    laplacian, mass, pieces, place = torus(26)
    load, material = Load.power(9), Material()
    plate = PlateModes.prepare(laplacian, mass, pieces, material, load)
    for waves, solved in ((1, True), (9, False)):
        wave = np.cos(2 * np.pi * waves * place[:, :1]) * [1.0, 0, 0]
        mu = 26**2 * (2 - 2 * np.cos(2 * np.pi * waves / 26))
        law = modal_response(mu**2, load, material) if solved else load.limit_law
        expected = law[1:, None, None] * wave
        assert plate.bends(wave) == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("painted", [False, True])
def test_a_resonant_mode_is_named_with_a_damping_that_works(surface, delta, painted):
    """B = 2c of the third mode, which a dense eigenvalue problem of this test's own finds."""
    laplacian, mass, pieces = surface
    rigidity = np.linspace(1, 2, 86) if painted else np.ones(86)
    root = np.sqrt(mass[:85])
    dense = laplacian.toarray()[:85, :85]
    operator = dense @ np.diag(rigidity[:85] / mass[:85]) @ dense
    third = np.linalg.eigvalsh(operator / np.outer(root, root))[4]
    args = (laplacian, mass, pieces)
    with pytest.raises(ResonanceError) as caught:
        PlateModes.prepare(*args, Material(1, third / 2, 1), Load.power(2), rigidity=rigidity)
    assert caught.value.mode == 3
    assert caught.value.stiffness == pytest.approx(third)
    safe = Material(1, caught.value.safe_damping, 1)
    plate = PlateModes.prepare(*args, safe, Load.power(2), rigidity=rigidity)
    assert np.isfinite(plate.bends(delta)).all()


def test_a_resonance_deep_in_the_spectrum_is_numbered_and_its_remedy_works():
    """More modes lie below than are looked at one by one."""
    laplacian, mass, pieces, _ = torus(27)
    wave = 27**2 * (2 - 2 * np.cos(2 * np.pi * np.arange(27) / 27))
    exact = np.sort((wave[:, None] + wave).ravel())[1:]
    resonant = exact[120] ** 2
    with pytest.raises(ResonanceError) as caught:
        PlateModes.prepare(laplacian, mass, pieces, Material(1, resonant / 2, 1), Load.power(2))
    assert exact[caught.value.mode - 1] == pytest.approx(exact[120])
    assert caught.value.stiffness == pytest.approx(resonant)
    PlateModes.prepare(
        laplacian, mass, pieces, Material(1, caught.value.safe_damping, 1), Load.power(2)
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rigidity": np.ones(85)}, "one for each of 86"),
        ({"rigidity": np.r_[np.ones(85), 0.0]}, "above 0, found 0 at vertex 85"),
        ({"rigidity": np.r_[np.nan, np.ones(85)]}, "at vertex 0"),
        ({"rigidity": np.r_[1e7, np.ones(85)]}, "ratio"),
        ({"closure": "free"}, "closure"),
    ],
)
def test_settings_out_of_range_are_named(surface, options, message):
    with pytest.raises(ParameterError, match=message):
        PlateModes.prepare(*surface, Material(), Load.power(2), **options)
