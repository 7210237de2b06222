"""The text of an exact path gives every number back, and no text breaks it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from usd_rigs import curved, grid, sample_rig

from elastomorph.io.usd.exact import checksum, path_from_json, path_to_json
from elastomorph.model.bend_curve import BendCurve


@pytest.mark.parametrize("name", sample_rig().names)
def test_a_path_comes_back_to_the_last_bit(name: str) -> None:
    morph = sample_rig().morphs[name]
    found = path_from_json(path_to_json(morph, 17))
    assert found is not None
    assert found.checksum == 17
    assert (found.more["method"], found.more["bake_error"]) == (morph.method, morph.bake_error)
    own, theirs = (morph.limit_law, *morph.bend_curves), (found.more["limit_law"], *found.curves)
    for one, other in zip(own, theirs, strict=True):
        assert one.breaks.tobytes() == other.breaks.tobytes()
        assert one.coefficients.tobytes() == other.coefficients.tobytes()


@given(value=st.floats(allow_nan=False, allow_infinity=False, width=64))
def test_coefficients_of_any_size(value: float) -> None:
    morph = curved(grid(), 0, slice(0, 3), powers=1)
    curve = BendCurve(np.array([0.0, 1.0]), np.array([[0.0, value, -value]]))
    object.__setattr__(morph, "bend_curves", (curve,))
    found = path_from_json(path_to_json(morph, 0))
    assert found is not None
    np.testing.assert_array_equal(found.curves[0].coefficients, curve.coefficients)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5) | st.just(1),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                [
                    "version",
                    "method",
                    "bakeError",
                    "bendCurves",
                    "limitLaw",
                    "breaks",
                    "coefficients",
                ]
            ),
            inner,
        )
    ),
)


@given(text=st.text() | JSON.map(json.dumps))
def test_any_other_text_is_no_path(text: str) -> None:
    assert path_from_json(text) is None


def test_text_nested_without_end_is_no_path() -> None:
    assert path_from_json("[" * 100_000) is None


def test_a_path_of_a_later_version_is_passed_over() -> None:
    content = json.loads(path_to_json(curved(grid(), 0, slice(0, 3)), 0))
    assert path_from_json(json.dumps(content | {"version": 2})) is None


def test_the_checksum_notices_values_and_shapes() -> None:
    one = np.arange(6.0)
    assert checksum([one]) == checksum([np.arange(6.0)])
    assert checksum([one]) != checksum([one.reshape(2, 3)])
    assert checksum([one]) != checksum([one + 1e-15])
    assert checksum([one, one]) != checksum([one])
