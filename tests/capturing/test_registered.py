"""Registered poses are meshes that also know how far each vertex is to be trusted."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from small_captures import template

import elastomorph as em

TEMPLATE = template()
CONFIDENCE = np.linspace(0, 1, 144)


def test_it_is_the_template_elsewhere(tmp_path: Path) -> None:
    found = em.Registered.of(TEMPLATE, TEMPLATE.vertices * 2, CONFIDENCE, {"rms": 0.1})
    assert isinstance(found, em.Mesh)
    np.testing.assert_array_equal(found.vertices, TEMPLATE.vertices * 2)
    assert found.faces is TEMPLATE.faces
    assert found.figures == {"rms": 0.1}
    assert found.confidence.dtype == np.float32
    assert not found.confidence.flags.writeable
    assert found.flagged.sum() == 72  # those below a half
    assert found.diameter == pytest.approx(2 * TEMPLATE.diameter)
    em.write(tmp_path / "pose.obj", found)
    np.testing.assert_array_equal(em.read(tmp_path / "pose.obj").vertices, found.vertices)


def test_moved_on_it_is_a_mesh_of_which_nothing_is_said() -> None:
    found = em.Registered.of(TEMPLATE, TEMPLATE.vertices, CONFIDENCE)
    assert type(found.with_vertices(found.vertices)) is em.Mesh


def test_made_of_arrays_or_copied_it_is_the_same() -> None:
    found = em.Registered(TEMPLATE.vertices, TEMPLATE.faces, confidence=CONFIDENCE)
    for other in (copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        np.testing.assert_array_equal(other.confidence, found.confidence)
        np.testing.assert_array_equal(other.vertices, found.vertices)
    assert repr(found) == "Registered(144 vertices, 121 polygons, 50.0% flagged)"
