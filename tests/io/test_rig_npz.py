"""Archives of rigs give back every path to the last bit, and refuse what is no rig."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_samples import assert_same_mesh, house, meshes, same_bits

import elastomorph as em
from elastomorph.errors import FileError, FormatError
from elastomorph.io.npz import write_npz
from elastomorph.io.npz.rig import read_rig_npz, write_rig_npz
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig


def assert_same_rig(one: Rig, other: Rig) -> None:
    """Everything but the source of the neutral is the same, to the last bit."""
    assert_same_mesh(one.neutral, other.neutral)
    assert list(one.morphs) == list(other.morphs)
    assert one.names == other.names
    assert one.sliders.correctives == other.sliders.correctives
    assert one.sliders.groups == other.sliders.groups
    for mine, theirs in zip(one.morphs.values(), other.morphs.values(), strict=True):
        assert same_bits(mine.target.vertices, theirs.target.vertices)
        assert same_bits(mine.delta, theirs.delta)
        assert same_bits(mine.bends, theirs.bends)
        assert mine.method == theirs.method
        assert mine.bake_error == theirs.bake_error
        for a, b in zip(
            (*mine.bend_curves, mine.limit_law),
            (*theirs.bend_curves, theirs.limit_law),
            strict=True,
        ):
            assert same_bits(a.breaks, b.breaks)
            assert same_bits(a.coefficients, b.coefficients)


def tent(top: float) -> BendCurve:
    rows = [[0.0, 1 / top, 0.0], [1.0, -1 / (1 - top), 0.0]]
    return BendCurve(np.array([0.0, top, 1.0]), np.array(rows))


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    """Rigs with any targets and bends, also such as move nothing or only turn 0.0 into -0.0."""
    neutral = draw(meshes())
    count = len(neutral.vertices)
    random = np.random.default_rng(draw(st.integers(0, 2**32)))

    def field() -> np.ndarray:
        moved = random.uniform(size=(count, 1)) < draw(st.sampled_from([0.0, 0.3, 1.0]))
        return np.where(moved, random.normal(size=(count, 3)), draw(st.sampled_from([0.0, -0.0])))

    morphs = {}
    for name in draw(st.lists(st.text("aäB .漢", min_size=1, max_size=5), unique=True, max_size=4)):
        curves = [draw(st.sampled_from([BendCurve.power(2), BendCurve.power(4), tent(0.3)]))]
        curves = curves * draw(st.integers(0, 3))
        # the coordinates of the neutral may be as large as floats are; sums of them need not fit
        with np.errstate(over="ignore"):
            target = neutral.vertices + field()
        target = np.where(np.isfinite(target), target, 0.0)
        with np.errstate(over="ignore"):
            morphs[name] = Morph(
                neutral,
                neutral.with_vertices(target),
                np.array([field() for _ in curves]).reshape(-1, count, 3),
                tuple(curves),
                method=draw(st.sampled_from(["linear", "beam R=2", ""])),
                limit_law=draw(st.sampled_from([BendCurve.power(3), BendCurve.polynomial([0.0])])),
                bake_error=draw(st.floats(0, 1)),
            )
    names = list(morphs)
    groups = {"all": names, "none": []} if draw(st.booleans()) else None
    correctives = {names[0]: names[:2]} if len(names) > 1 and draw(st.booleans()) else None
    return Rig(neutral, morphs, correctives=correctives, groups=groups)


@given(rig=rigs())
@settings(max_examples=120, deadline=None)
def test_any_rig_is_read_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, rig: Rig
) -> None:
    path = tmp_path_factory.getbasetemp() / "rig.npz"
    write_rig_npz(path, rig)
    with np.errstate(over="ignore"):
        assert_same_rig(read_rig_npz(path), rig)


def beam_rig() -> Rig:
    """The house with two paths of beams, a corrective and a group."""
    neutral = house()
    random = np.random.default_rng(5)
    to = em.prepare(neutral, "beam", order=3)
    targets = {
        name: neutral.vertices + random.normal(size=(5, 3)) for name in ("jaw", "smile", "both")
    }
    morphs = {name: to(neutral.with_vertices(target)) for name, target in targets.items()}
    return Rig(neutral, morphs, correctives={"both": ("jaw", "smile")}, groups={"mouth": ("jaw",)})


def test_poses_are_the_same_before_and_after(tmp_path: Path) -> None:
    before = beam_rig()
    write_rig_npz(tmp_path / "rig.npz", before)
    after = read_rig_npz(tmp_path / "rig.npz")
    for weights in ({}, {"jaw": 0.3}, {"jaw": 0.7, "smile": 1.2}):
        assert same_bits(before.pose(weights), after.pose(weights))
    assert after.neutral.name == str(tmp_path / "rig.npz")


def test_writing_twice_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        write_rig_npz(tmp_path / name, beam_rig())
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_only_what_moves_takes_room(tmp_path: Path) -> None:
    """A hundred shapes that move one vertex of ten thousand cost little more than the neutral."""
    neutral = Mesh(np.random.default_rng(1).normal(size=(10_000, 3)))
    morphs = {}
    for i in range(100):
        target = neutral.vertices.copy()
        target[i] += 1
        morphs[str(i)] = Morph(neutral, neutral.with_vertices(target), np.zeros((0, 10_000, 3)), ())
    write_rig_npz(tmp_path / "rig.npz", Rig(neutral, morphs))
    write_npz(tmp_path / "mesh.npz", neutral)
    extra = (tmp_path / "rig.npz").stat().st_size - (tmp_path / "mesh.npz").stat().st_size
    assert extra < 20_000
    assert len(read_rig_npz(tmp_path / "rig.npz")) == 100


def changed(path: Path, **members: Any) -> Path:
    """The archive with some members replaced, or left out where they are None."""
    write_rig_npz(path, beam_rig())
    with np.load(path, allow_pickle=False) as archive:
        arrays = dict(archive)
    arrays |= members
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("rig_version", None, "holds no rig"),
        ("rig_version", np.array(3), "version 3, expected 1"),
        ("slider_group_names", None, "the array 'slider_group_names' is missing"),
        ("uv_corners", None, "the array 'uv_corners' is missing"),
        ("neutral", np.full((5, 3), np.nan), "vertex 0 has the coordinates"),
        ("neutral", np.zeros((4, 3)), "expected 0 to 3"),
        ("morph_names", np.array(["a", "b", "a"]), "two morphs have the same name"),
        ("morph_names", np.array(["a"]), r"shape \(3,\), expected \(1,\)"),
        ("methods", np.zeros(3), "type float64"),
        ("bend_counts", np.array([2, 2, -1]), "goes from -1 to 2, expected 0 and more"),
        ("bend_counts", np.array([2, 2, 10**15]), "expected"),
        ("field_sizes", np.full(9, 4), r"expected \(36,\)"),
        ("field_vertices", np.full(45, 5), "rise and exist"),
        ("field_vertices", np.tile([0, 1, 2, 2, 4], 9), "rise and exist"),
        ("field_vertices", np.tile([-1, 1, 2, 3, 4], 9), "rise and exist"),
        ("field_values", np.full((45, 3), np.inf), "finite"),
        ("curve_shapes", np.array([[1, 0]]), "no pieces or no coefficients"),
        ("curve_shapes", np.array([[10**9, 200]]), "expected"),
        ("curve_breaks", np.zeros(4), "rise from 0 to 1"),
        ("curve_coefficients", np.ones(7), "must be 0 at t = 0"),
        ("curve_of_bend", np.array([0, 1, 0, 1, 0, 3]), "goes from 0 to 3, expected 0 to 1"),
        ("curve_of_limit_law", np.array([0, 0, 9]), "goes from 0 to 9, expected 0 to 1"),
        ("corrective_drivers", np.array(["jaw", "nose"]), "no slider 'nose'"),
        ("corrective_drivers", np.array(["jaw"]), r"expected \(2,\)"),
        ("slider_group_members", np.array(["nose"]), "no slider 'nose'"),
    ],
)
def test_members_that_do_not_form_a_rig_are_refused(
    tmp_path: Path, name: str, value: Any, words: str
) -> None:
    path = changed(tmp_path / "rig.npz", **{name: value})
    with pytest.raises(FormatError, match=words) as caught:
        read_rig_npz(path)
    assert "rig.npz" in str(caught.value)


def test_the_unchanged_archive_is_read(tmp_path: Path) -> None:
    """So that each refusal above is one of the change."""
    assert_same_rig(read_rig_npz(changed(tmp_path / "rig.npz")), beam_rig())


def test_a_small_file_cannot_ask_for_much_memory(tmp_path: Path) -> None:
    """100,000 bends that move nothing, of 100,000 compressed vertices: 240 GB of zeros."""
    count = 100_000
    path = changed(
        tmp_path / "rig.npz",
        neutral=np.zeros((count, 3)),
        morph_names=np.array(["a"]),
        methods=np.array(["linear"]),
        choices=np.array([""]),
        bake_errors=np.zeros(1),
        bend_counts=np.array([count]),
        field_sizes=np.zeros(count + 1, dtype=int),
        field_vertices=np.empty(0, dtype=int),
        field_values=np.empty((0, 3)),
        curve_of_bend=np.zeros(count, dtype=int),
        curve_of_limit_law=np.zeros(1, dtype=int),
    )
    with np.load(path) as archive:
        np.savez_compressed(path.with_name("bomb.npz"), **dict(archive))
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="would take more memory than"):
            read_rig_npz(path.with_name("bomb.npz"))
        assert tracemalloc.get_traced_memory()[1] < 64 << 20
    finally:
        tracemalloc.stop()


def test_a_mesh_is_no_rig_and_a_missing_file_is_missing(tmp_path: Path) -> None:
    write_npz(tmp_path / "mesh.npz", house())
    with pytest.raises(FormatError, match="holds no rig"):
        read_rig_npz(tmp_path / "mesh.npz")
    with pytest.raises(FileError, match="no such file"):
        read_rig_npz(tmp_path / "none.npz")
