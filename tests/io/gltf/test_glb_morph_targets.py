"""Bends are stored so that programs that clamp weights to [0, 1] play them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from glb_samples import chunks_of

import elastomorph as em
from elastomorph.io.gltf.writer import write_glb
from elastomorph.model.bend_curve import BendCurve
from elastomorph.rig.positive import with_positive_weights

FACE = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
TARGET = FACE.with_vertices(FACE.vertices + [0, 0.5, 0.25])
TIMES = np.linspace(-0.5, 1.5, 21)


def rig_with(*curves: BendCurve) -> em.Rig:
    bends = np.arange(9.0 * len(curves)).reshape(-1, 3, 3) / 9
    return em.Rig(FACE, {"m": em.Morph(FACE, TARGET, bends, curves)})


def test_a_turned_bend_is_the_same_path() -> None:
    rig = rig_with(BendCurve.power(2), BendCurve.power(3), BendCurve.polynomial([0, 1, -1]))
    turned = with_positive_weights(rig).morphs["m"]
    np.testing.assert_allclose(turned.at(TIMES), rig.morphs["m"].at(TIMES), atol=1e-15)
    inside = np.linspace(0, 1, 50)
    assert all((curve(inside) >= 0).all() for curve in turned.bend_curves)


def test_what_is_positive_already_stays_itself() -> None:
    rig = rig_with(BendCurve.polynomial([0, 1, -1]))
    assert with_positive_weights(rig) is rig


def test_a_curve_of_both_signs_keeps_the_smaller_part_below() -> None:
    """-t (t - 0.3)(1 - t) is below 0 for t > 0.3, and farther than it is above before."""
    curve = BendCurve.polynomial(np.polynomial.polynomial.polyfromroots([0, 0.3, 1]))
    (turned,) = with_positive_weights(rig_with(curve)).morphs["m"].bend_curves
    values = turned(np.linspace(0, 1, 200))
    assert 0 < -values.min() < values.max()


@pytest.mark.parametrize("method", ["ease:3", "beam:2", "beam:3", "arc", "rotation"])
def test_no_key_of_a_clip_is_clamped(tmp_path: Path, method: str) -> None:
    """Blender holds the weights of imported morph targets between 0 and 1."""
    from small_head import head, shapes

    neutral = head()
    morph = em.prepare(neutral, method)(shapes()["jawOpen"])
    write_glb(tmp_path / "a.glb", em.Rig(neutral, {"jawOpen": morph}), clips=True)
    document, blob = chunks_of(tmp_path / "a.glb")
    accessor = document["accessors"][document["animations"][0]["samplers"][0]["output"]]
    start = document["bufferViews"][accessor["bufferView"]].get("byteOffset", 0)
    weights = np.frombuffer(blob, "<f4", accessor["count"], start)
    assert len(weights) > 4
    assert weights.min() >= 0
    assert weights.max() <= 1
