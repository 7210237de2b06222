"""Paths for a whole rig: the default where none was chosen, a method where one is named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController, threadpool_limits

import elastomorph as em
from elastomorph import blas_threads
from elastomorph.paths.rotation import Turning
from elastomorph.rig.build import bare_rig, extent_of, with_paths
from small_meshes import grid

SIDE = 5


def sheet(scale: float = 1.0) -> em.Mesh:
    """A bent sheet, and far below it a body of one triangle that nothing moves."""
    face = grid(SIDE, SIDE, lambda x, y: 0.1 * x * y)
    body = np.array([[0.0, -100, 0], [1, -100, 0], [0, -101, 0]])
    count = len(face.vertices)
    points = scale * np.vstack([face.vertices, body])
    return em.Mesh(points, [*face.faces, [count, count + 1, count + 2]])


def turned(angle: float, scale: float = 1.0) -> em.Mesh:
    """The sheet turned about its first edge; the body stays."""
    mesh = sheet(scale)
    points = mesh.vertices.copy()
    y, z = points[: SIDE**2, 1].copy(), points[: SIDE**2, 2].copy()
    points[: SIDE**2, 1] = y * np.cos(angle) - z * np.sin(angle)
    points[: SIDE**2, 2] = y * np.sin(angle) + z * np.cos(angle)
    return mesh.with_vertices(points)


def moved() -> em.Mesh:
    """The sheet moved along, which turns nothing."""
    points = sheet().vertices.copy()
    points[: SIDE**2, 0] += 0.5
    return sheet().with_vertices(points)


@pytest.fixture
def bare() -> em.Rig:
    return bare_rig(sheet(), {"turn": turned(1.0), "slide": moved()})


def test_the_extent_is_that_of_what_moves(bare: em.Rig) -> None:
    """The body below the sheet does not count."""
    moving = (turned(1.0).vertices != sheet().vertices).any(axis=1)
    moving |= (moved().vertices != sheet().vertices).any(axis=1)
    points = sheet().vertices[moving]
    far = np.linalg.norm(points[:, None] - points[None], axis=2).max()
    assert extent_of(bare) == pytest.approx(far)
    assert extent_of(bare) < 10 < bare.neutral.diameter


def test_what_nobody_chose_gets_the_default(bare: em.Rig) -> None:
    rig = with_paths(bare)
    assert len(rig.morphs["turn"].bends) > 0
    assert not len(rig.morphs["slide"].bends)
    for name, morph in rig.morphs.items():
        expected = em.interpolate(bare.neutral, bare.morphs[name].target, extent=extent_of(bare))
        np.testing.assert_allclose(morph.at(0.4), expected.at(0.4), atol=1e-12)
        assert morph.choice == expected.choice
        assert not morph.bare


def test_the_choice_is_made_by_the_extent_of_the_rig(bare: em.Rig) -> None:
    """Off by 5 % of what moves is off by 0.3 % of a mesh with a body below."""
    off = with_paths(bare).morphs["turn"].choice
    assert off is not None
    whole = em.interpolate(bare.neutral, turned(1.0)).choice
    assert whole is not None
    ratio = bare.neutral.diameter / extent_of(bare)
    assert off.distance == pytest.approx(whole.distance * ratio)
    between = (off.distance + whole.distance) / 2
    assert with_paths(bare, f"auto:{between}").morphs["turn"].bends.size
    assert not em.interpolate(bare.neutral, turned(1.0), f"auto:{between}").bends.size


def test_paths_that_are_there_stay_unless_a_method_is_named(bare: em.Rig) -> None:
    eased = em.interpolate(bare.neutral, turned(1.0), "ease:2")
    rig = em.Rig(
        bare.neutral,
        {"turn": eased, "slide": bare.morphs["slide"]},
        correctives={"slide": ["turn", "slide"]},
        groups={"both": ["turn", "slide"]},
    )
    kept = with_paths(rig)
    assert kept.morphs["turn"] is eased
    assert kept.morphs["slide"].choice is not None
    anew = with_paths(rig, "cosine")
    assert {morph.method for morph in anew.morphs.values()} == {"cosine"}
    for other in (kept, anew):
        assert other.sliders == rig.sliders
    assert with_paths(kept) is kept


def test_a_setting_of_the_method_makes_all_anew(bare: em.Rig) -> None:
    straight = with_paths(with_paths(bare, "ease:2"), straight_within=1.0)
    assert not any(len(morph.bends) for morph in straight.morphs.values())
    with pytest.raises(em.ElastomorphError, match="auto has no straightness"):
        with_paths(bare, straightness=1.0)


def test_only_the_morphs_named_are_given_paths(bare: em.Rig) -> None:
    part = with_paths(bare, "beam:2", names=["turn"])
    assert part.morphs["slide"] is bare.morphs["slide"]
    assert part.morphs["turn"].method == "beam R=2"


def test_threads_make_the_paths_that_one_makes(
    bare: em.Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the order of the rig, to the last bit, whoever comes first."""
    monkeypatch.setattr(blas_threads, "usable_cores", lambda: 3)
    shapes = {f"turn {n}": turned(0.1 + 0.2 * n) for n in range(8)}
    with threadpool_limits(3, user_api="blas"):
        rig = with_paths(bare_rig(sheet(), shapes), "rotation")
    to = em.prepare(sheet(), "rotation")
    assert list(rig.morphs) == list(shapes)
    for name, morph in rig.morphs.items():
        np.testing.assert_array_equal(morph.bends, to(shapes[name]).bends)


def test_a_path_is_made_with_one_thread_of_blas(
    bare: em.Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Many small products: threads of BLAS would wait for each other in every one of them."""
    seen: list[int] = []
    blas = ThreadpoolController().select(user_api="blas").lib_controllers

    class Watched(Turning):
        @classmethod
        def of(cls, *given: Any) -> Turning:
            seen.extend(library.get_num_threads() for library in blas)
            return Turning.of(*given)

    monkeypatch.setattr("elastomorph.paths.rotation.Turning", Watched)
    with threadpool_limits(2, user_api="blas"):
        em.interpolate(sheet(), turned(1.0), "rotation")
    assert seen == [1] * len(blas)


def test_another_extent_may_be_given_where_it_has_an_effect(bare: em.Rig, tmp_path: Path) -> None:
    whole = em.interpolate(bare.neutral, turned(1.0)).choice
    rig = with_paths(bare, extent=bare.neutral.diameter)
    assert rig["turn"].choice == whole
    em.write(tmp_path / "bare.npz", bare)
    assert em.read_rig(tmp_path / "bare.npz", extent=bare.neutral.diameter)["turn"].choice == whole
    with pytest.raises(em.ParameterError, match="only auto takes extent, not ease"):
        with_paths(bare, "ease:2", extent=1.0)
