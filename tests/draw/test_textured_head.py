"""The camera finds the head of a whole character by what its targets move."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from cards import character
from elastomorph.draw.camera import Camera, Turntable, camera_for
from elastomorph.draw.head import head_of
from elastomorph.draw.pictures import Image
from elastomorph.draw.posed import PosedRig, compare, pose_picture
from elastomorph.draw.strips import closure_comparison
from elastomorph.model.mesh import Mesh
from elastomorph.rig.build import extent_of
from scenes import ball, seen_at
from small_head import head, shapes


def test_the_head_is_what_targets_move_and_what_is_around() -> None:
    rig = character()
    found = head_of(rig.neutral, rig.morphs.values())
    assert found is not None
    heights = rig.neutral.vertices[found, 1]
    assert heights.max() == rig.neutral.vertices[:, 1].max()
    assert 4 < heights.min() < 5


def test_the_picture_is_of_the_head_unless_the_whole_is_asked_for() -> None:
    rig = character()
    head = head_of(rig.neutral, rig.morphs.values())
    size = (200, 300)
    middle = np.array([0.0, 6.0, 0.0])
    feet = np.array([0.0, -5.0, 0.0])
    near = camera_for(rig.neutral, head=head, size=size)
    assert 0 < seen_at(near, middle, size)[0][1] < 300
    assert seen_at(near, feet, size)[0][1] > 300
    whole = camera_for(rig.neutral, "whole", head=head, size=size)
    assert 0 < seen_at(whole, feet, size)[0][1] < 300
    turned = Turntable.around(rig.neutral, [0.0, 90.0], head=head, size=size).camera
    assert seen_at(turned, feet, size)[0][1] > 300
    turned = Turntable.around(rig.neutral, [0.0, 90.0], "whole", head=head, size=size).camera
    assert 0 < seen_at(turned, feet, size)[0][1] < 300


def test_pictures_of_a_rig_are_of_its_head() -> None:
    """Most of the picture is the head, where the whole figure would be a narrow strip."""
    rig = character()
    covered = [
        (pose_picture(PosedRig("", rig, {}), 1.0, size=(90, 120), view=view) < 200).any(axis=2)
        for view in ("front", "whole")
    ]
    assert covered[0].mean() > 2 * covered[1].mean()


def test_closures_are_shown_on_the_face_of_a_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    """Above the head, below its mouth; of the whole figure the second would be the hips."""
    cameras: list[tuple[Camera, tuple[int, int]]] = []

    def seen(mesh: Mesh, rows: object, camera: Camera, size: tuple[int, int], **_: object) -> Image:
        cameras.append((camera, size))
        return np.zeros((*size[::-1], 3), dtype=np.uint8)

    monkeypatch.setattr("elastomorph.draw.strips.face_sheet", seen)
    rig = character()
    closure_comparison(rig.neutral, rig["open"].target, closures=["limit"], width=60)
    for camera, size in cameras:
        assert 0 < seen_at(camera, np.array([0.0, 5.5, 0.8]), size)[0][1] < size[1]
        assert seen_at(camera, np.array([0.0, 0.0, 0.0]), size)[0][1] > size[1]
    assert len(cameras) == 2


def test_what_is_no_more_than_a_head_is_framed_as_ever() -> None:
    """So is a mesh that says nothing but its shape, one that does not move, and a small body."""
    bare = character(dressed=False)
    assert head_of(bare.neutral, bare.morphs.values()) is None
    still = character().neutral
    assert head_of(still, []) is None
    face = Mesh(ball().vertices, ball().faces, appearance={})
    wide = em.Rig(face, {"wide": face.with_vertices(face.vertices * 1.1)}, method="linear")
    assert head_of(face, wide.morphs.values()) is None


def test_a_part_of_the_face_that_moves_stands_for_the_head() -> None:
    """Of a tall figure whose targets move no more than the lips, all of the head is shown."""
    mesh = character().neutral
    moved = mesh.vertices.copy()
    moved[np.linalg.norm(mesh.vertices - [0, 5.7, 0.9], axis=1) < 0.3] += [0, 0, 0.1]
    rig = em.Rig(mesh, {"pout": mesh.with_vertices(moved)}, method="linear")
    found = head_of(mesh, rig.morphs.values())
    assert found is not None
    heights = mesh.vertices[found, 1]
    assert heights.max() > 6.4
    assert heights.min() < 5.2


def test_the_groups_of_a_head_make_it_no_body() -> None:
    """A bare head of several groups with one target is framed as it is with all of them."""
    mesh = head()
    rig = em.Rig(mesh, {"jawOpen": shapes()["jawOpen"]}, method="linear")
    assert head_of(mesh, rig.morphs.values()) is None
    looks = Mesh(mesh.vertices, mesh.faces, groups=mesh.groups, appearance={})
    assert head_of(looks, rig.morphs.values()) is None


def test_distances_of_a_character_are_told_in_the_size_of_its_face() -> None:
    for dressed in (True, False):
        rig = character(dressed=dressed)
        posed = PosedRig("", rig, {"open": 1.0})
        found = compare([posed], [1.0], "rest", lambda _, mesh=rig.neutral: mesh.vertices)
        expected = extent_of(rig) if dressed else rig.neutral.diameter
        assert found.diameter == expected
    assert extent_of(rig) < rig.neutral.diameter / 3
