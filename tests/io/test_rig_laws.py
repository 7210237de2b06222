"""Laws of correctives, and pair bends, come back from every format of rigs and play the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mesh_samples import house

import elastomorph as em
from elastomorph.doctor import as_document, examine_rig
from elastomorph.io.gltf.container import open_gltf
from elastomorph.model.mesh import FaceLabels
from elastomorph.report.subject import rig_subject
from elastomorph.rig.laws import LAWS
from needs import extra
from small_meshes import grid, meeting

NAMES = ("a", "b", "c", "a_b", "shape")
NUMBERS = st.floats(-4, 4).filter(lambda number: abs(number) > 1e-6)


@st.composite
def laws(draw: st.DrawFn) -> em.Corrective:
    """Any law of some of the three sliders, in any order."""
    drivers = tuple(draw(st.permutations(NAMES[:3]))[: draw(st.integers(1, 3))])
    law = draw(st.sampled_from([*LAWS]))
    numbers: tuple[float, ...] = ()
    if law == "hinge":
        numbers = tuple(draw(st.lists(NUMBERS, min_size=len(drivers), max_size=len(drivers))))
    elif law == "softmin":
        numbers = (draw(st.floats(0.1, 12)),)
    return em.Corrective(drivers, law, numbers)


@st.composite
def rigs(draw: st.DrawFn) -> em.Rig:
    """Three sliders, a pair bend of one or two bends, and a shape that others drive."""
    neutral = house()
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    curves = (em.BendCurve.power(2), em.BendCurve.power(3))
    morphs = {}
    for name in NAMES:
        moved = random.normal(size=neutral.vertices.shape) * (name != "a_b")
        count = draw(st.integers(int(name == "a_b"), 2))
        bends = random.normal(size=(count, *moved.shape))
        target = neutral.with_vertices(neutral.vertices + moved)
        morphs[name] = em.Morph(neutral, target, bends, curves[:count])
    return em.Rig(neutral, morphs, correctives={"a_b": draw(laws()), "shape": draw(laws())})


@pytest.mark.parametrize("suffix", [".npz", ".glb", ".usdc"])
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(rig=rigs(), row=st.lists(st.floats(-0.5, 1.5), min_size=3, max_size=3))
def test_any_law_comes_back(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, rig: em.Rig, row: list[float]
) -> None:
    if suffix == ".usdc":
        extra("pxr", "usd")
    path = tmp_path_factory.getbasetemp() / f"laws{suffix}"
    em.write(path, rig)
    found = em.read_rig(path)
    assert found.sliders == rig.sliders
    assert found.names == ("a", "b", "c")
    assert list(found.pair_bends()) == ["a_b"]
    size = rig.neutral.diameter * max(1.0, float(np.abs(rig.sliders.drive(np.array([row]))).max()))
    away = np.linalg.norm(found.pose(row) - rig.pose(row), axis=1).max()
    assert away <= 1e-4 * size**3


def test_a_pair_bend_by_a_product_is_refused_by_older_programs(tmp_path: Path) -> None:
    """It has no target, which files of version 1 and 2 always have."""
    neutral = house()
    to = em.prepare(neutral, "linear")
    bends = np.ones((1, *neutral.vertices.shape))
    morphs = {
        "a": to(neutral.with_vertices(neutral.vertices + 1.0)),
        "b": to(neutral.with_vertices(neutral.vertices - 0.5)),
        "a_b": em.Morph(neutral, neutral, bends, (em.BendCurve.power(2),)),
    }
    rig = em.Rig(neutral, morphs, correctives={"a_b": ("a", "b")})
    em.write(tmp_path / "rig.glb", rig)
    meshes = open_gltf(tmp_path / "rig.glb").document["meshes"]
    assert {mesh["extras"]["elastomorph"]["version"] for mesh in meshes} == {3}
    assert em.read_rig(tmp_path / "rig.glb").sliders == rig.sliders


def test_looks_of_a_folder_leave_pair_bends_and_laws(tmp_path: Path) -> None:
    sheet = grid(7, 7, lambda x, _: 0.05 * x * x)
    labels = FaceLabels(("skin",), np.zeros(len(sheet.faces), dtype=np.int32))
    neutral = replace(sheet, materials=labels, material_library="skin.mtl")
    em.write(tmp_path / "neutral.obj", neutral)
    for name, target in meeting(neutral).items():
        em.write(tmp_path / f"{name}.obj", target)
    (tmp_path / "skin.mtl").write_text("newmtl skin\nKd 0.9 0.2 0.1\n")
    found = em.read_rig(tmp_path, cache=None)
    assert found.neutral.appearance is not None
    assert found.names == ("jawOpen", "mouthClose")
    assert found.sliders.correctives == {
        "jawOpen_mouthClose": em.Corrective(("jawOpen", "mouthClose"), "min")
    }


def test_a_pair_bend_is_no_target_of_anybody() -> None:
    """The doctor does not find it empty, nor does a walkthrough show it."""
    neutral = grid(7, 7, lambda x, _: 0.05 * x * x)
    rig = em.Rig(neutral, meeting(neutral))
    assert list(rig.pair_bends()) == ["jawOpen_mouthClose"]
    found = as_document(examine_rig(rig, file="face"))
    assert found["targets"] == ["jawOpen", "mouthClose"]
    assert list(rig_subject("face.glb", rig).targets) == ["jawOpen", "mouthClose"]


def test_the_report_of_a_glb_counts_bends_of_pairs(tmp_path: Path) -> None:
    neutral = grid(7, 7, lambda x, _: 0.05 * x * x)
    rig = em.Rig(neutral, meeting(neutral))
    report = em.write(tmp_path / "face.glb", rig)
    assert report.targets == 2 + report.bends
    assert report.bends == sum(len(morph.bends) for morph in rig.morphs.values())
