"""The file of the built-in head is what the sculptor makes."""

from __future__ import annotations

import numpy as np
import pytest

import sculptor.motion
import sculptor.shapes
from elastomorph.samples import expressions, head, recorded_motion, shapes
from sculpt_head import FILE, arrays
from sculptor.assembly import build


def assert_agree(stored, sculpted):
    """To 1e-9 of D: processors round differently, and the file holds multiples of a unit."""
    np.testing.assert_allclose(stored, sculpted, rtol=0, atol=1e-9 * head().diameter)


def test_the_file_holds_the_head_that_is_sculpted():
    sculpted = build().mesh
    assert head().faces == sculpted.faces
    assert head().groups.names == sculpted.groups.names
    np.testing.assert_array_equal(head().groups.of_face, sculpted.groups.of_face)
    assert head().uv is head().materials is sculpted.uv is sculpted.materials is None
    assert_agree(head().vertices, sculpted.vertices)


@pytest.mark.parametrize(
    ("stored", "sculpted"),
    [(shapes, sculptor.shapes.shapes), (expressions, sculptor.shapes.expressions)],
)
def test_the_file_holds_the_faces_that_are_sculpted(stored, sculpted):
    assert list(stored()) == list(sculpted())
    for name, face in stored().items():
        assert_agree(face.vertices, sculpted()[name].vertices)


def test_the_file_holds_the_motion_that_is_sculpted():
    sculpted = sculptor.motion.recorded_motion()
    np.testing.assert_array_equal(recorded_motion().times, sculpted.times)
    assert_agree(recorded_motion().frames, sculpted.frames)


def test_the_tool_writes_arrays_of_the_file_and_no_others():
    with np.load(FILE) as file:
        assert {name: file[name].dtype for name in file.files} == {
            name: array.dtype for name, array in arrays().items()
        }
    assert FILE.stat().st_size < 500_000


def test_no_weights_are_the_neutral_bit_for_bit():
    neutral = build().mesh.vertices
    weights = dict.fromkeys(sculptor.shapes.shape_names(), 0.0)
    for none in ({}, weights):
        np.testing.assert_array_equal(sculptor.shapes.pose(none), neutral)
