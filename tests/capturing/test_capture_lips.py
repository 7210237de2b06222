"""Skin that touches skin, and vertices that passed each other, told by the mesh alone."""

import numpy as np
from painted import grid

from elastomorph.capturing.geometry import Deformation, Surface
from elastomorph.capturing.tracking import folded, touching

COUNT = 21


def slit(gap: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A square cut along y = 0 for |x| < 0.6, its lips turned inwards: and which are the lips.

    The vertices of the upper lip are doubled; both rows are bent back from each other by `gap`.
    """
    vertices, triangles = grid(COUNT, curve=0.0)
    row = np.flatnonzero((np.abs(vertices[:, 1]) < 1e-9) & (np.abs(vertices[:, 0]) < 0.65))
    upper = np.arange(len(vertices), len(vertices) + len(row))
    doubled = np.concatenate([vertices, vertices[row]])
    above = vertices[triangles].mean(axis=1)[:, 1] > 0
    renamed = np.arange(len(doubled))
    renamed[row] = upper
    triangles = np.where(above[:, None], renamed[triangles], triangles)
    # Lips curl inwards, so that they face each other.
    doubled[row] += [0, -gap / 2, -0.2]
    doubled[upper] += [0, gap / 2, -0.2]
    return doubled, triangles, np.concatenate([row, upper])


def test_closed_lips_touch_and_nothing_else_does():
    vertices, triangles, lips = slit(0.01)
    found = touching(Surface(vertices, triangles), 0.03)
    inner = lips[np.abs(vertices[lips, 0]) < 0.45]
    assert found[inner].all()
    assert not found[np.setdiff1d(np.arange(len(vertices)), lips)].any()


def test_open_lips_do_not_touch():
    vertices, triangles, _ = slit(0.1)
    assert not touching(Surface(vertices, triangles), 0.03).any()


def test_vertices_that_passed_each_other_are_found():
    vertices, triangles = grid(COUNT)
    surface = Surface(vertices, triangles)
    deformation = Deformation(vertices, triangles)
    turned = vertices @ np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]]).T
    assert not folded(surface, turned, deformation.rotations(turned)).any()
    middle = COUNT * COUNT // 2
    turned[middle] += 2.5 * (turned[middle + 1] - turned[middle])
    found = folded(surface, turned, deformation.rotations(turned))
    assert found[middle]
    assert found.sum() < 20
