"""Vertices split at seams are one again while paths are made, and what hangs on them is there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.evaluation import target_paths
from elastomorph.model.mesh import Mesh, Source
from elastomorph.model.polygons import Polygons
from elastomorph.paths.welding import Welding
from elastomorph.rig.build import with_paths
from small_head import head, shapes
from small_meshes import cut_open


def strip(x: float, y: float = 0.0) -> np.ndarray:
    """Six vertices of two quads side by side, from a place to the right."""
    return np.array([[x + i, y + j, 0.0] for i in range(3) for j in range(2)])


QUADS = np.array([[0, 2, 3, 1], [2, 4, 5, 3]])


def sheet(*strips: np.ndarray) -> Mesh:
    """Strips that share no vertex, as a format that splits vertices has them."""
    quads = np.concatenate([QUADS + 6 * k for k in range(len(strips))])
    source = Source("sheet.glb", split=True)
    return Mesh(np.concatenate(strips), Polygons.of(quads), source=source)


def test_an_island_at_rest_hangs_on_one_that_moves_by_their_seam() -> None:
    """It holds the others: without it, a path would end at the seam as at a border."""
    mesh = sheet(strip(0), strip(2), strip(50))
    target = mesh.vertices.copy()
    target[:2] += [0, 0, 1]
    welding = Welding.of(mesh, [target])
    assert (welding.place[:12] >= 0).all()
    assert (welding.place[12:] == -1).all()  # far away, and at rest
    assert welding.place[[4, 5]].tolist() == welding.place[[6, 7]].tolist()
    assert len(welding.first) == 10
    assert welding.joins
    assert len(welding.neutral.faces) == 4


def test_what_only_touches_in_the_neutral_is_not_one() -> None:
    """Closed lids touch, and open: a seam is at one place in every shape."""
    mesh = sheet(strip(0), strip(2))
    target = mesh.vertices.copy()
    target[:6] += [0, 0, 1]
    welding = Welding.of(mesh, [target])
    assert not welding.joins
    assert (welding.place[:6] >= 0).all()
    assert (welding.place[6:] == -1).all()


def test_fields_are_those_of_the_vertex_that_each_is() -> None:
    mesh = sheet(strip(0), strip(2), strip(50))
    target = mesh.vertices.copy()
    target[[4, 5, 6, 7]] += [0, 1, 0]
    target[3] += [0, 0, 2]
    welding = Welding.of(mesh, [target])
    whole = mesh.with_vertices(target)
    moved = welding.mesh(whole).vertices - welding.neutral.vertices
    assert np.array_equal(welding.fields(moved), target - mesh.vertices)


def cut_head() -> tuple[Mesh, dict[str, Mesh], np.ndarray]:
    """Our head cut open across both lips, as a file may have it, and which vertex each was."""
    face = head()
    middle = face.vertices[:, 0].mean()
    left = np.add.reduceat(face.vertices[face.faces.indices, 0], face.faces.offsets[:-1])
    cut, origin = cut_open(face, left > middle * face.faces.sizes)
    names = ("jawOpen", "mouthClose", "mouthPucker")
    targets = {name: cut.with_vertices(shapes()[name].vertices[origin]) for name in names}
    return cut, targets, origin


def parted(cut: Mesh, origin: np.ndarray, morph: em.Morph) -> float:
    """The largest distance between a vertex and its copy on the way, as a fraction of D."""
    copies = np.arange(len(head().vertices), len(origin))
    ways = morph.at([0.25, 0.5, 0.75])
    return float(np.abs(ways[:, copies] - ways[:, origin[copies]]).max()) / cut.diameter


@pytest.mark.parametrize("suffix", [".obj", ".glb", ".npz", "arrays"])
def test_a_head_that_was_cut_open_moves_as_the_whole_one(suffix: str, tmp_path: Path) -> None:
    """Whatever file it is from; the same paths as before the cut."""
    cut, targets, origin = cut_head()
    if suffix == ".obj":
        for name, mesh in {"neutral": cut, **targets}.items():
            em.write(tmp_path / f"{name}.obj", mesh)
        rig = em.read_rig(tmp_path, cache=None)
    elif suffix == "arrays":
        rig = em.Rig(cut, targets)
    else:
        em.write(tmp_path / f"face{suffix}", em.Rig(cut, targets, method="linear"))
        rig = em.read_rig(tmp_path / f"face{suffix}", method="auto")
    whole = em.Rig(head(), {name: shapes()[name] for name in targets})
    for name, morph in rig.morphs.items():
        assert parted(rig.neutral, origin, morph) < 1e-6, name
        gap = np.abs(morph.at(0.5) - whole[name].at(0.5)[origin]).max()
        assert gap < 2e-6 * rig.neutral.diameter, name
    assert len(rig["jawOpen"].bends)
    assert len(rig.neutral.vertices) == len(origin)


@pytest.mark.parametrize("method", ["auto", "rotation", "arc", "plate:2", "beam:2"])
def test_one_target_welds_unless_it_is_asked_not_to(method: str) -> None:
    cut, targets, origin = cut_head()
    target = targets["jawOpen"]
    for morph in (
        em.interpolate(cut, target, method),
        em.prepare(cut, method)(target),
        em.prepare(cut, method, targets=list(targets.values()))(target),
        em.interpolate(cut, target, method, region=np.arange(len(origin)) % 3000 < 2500),
    ):
        assert parted(cut, origin, morph) == 0.0
        np.testing.assert_array_equal(morph.at(1.0), target.vertices)
    torn = em.interpolate(cut, target, method, weld=False)
    # On this head stiff curves keep to one law at all their ends.
    assert parted(cut, origin, torn) > 1e-6 or method == "beam:2"


def test_what_another_target_parts_is_one_only_where_that_is_not_known() -> None:
    """A single target says less than a rig, on whose faces lids open again."""
    mesh = sheet(strip(0), strip(2))
    turned = mesh.vertices @ Rotation.from_rotvec([0.0, 0.9, 0.0]).as_matrix().T
    turned[6:] = turned[6:] * [1.0, 1.3, 1.0]
    turned[[6, 7]] = turned[[4, 5]]
    both, opened = mesh.with_vertices(turned), mesh.vertices.copy()
    opened[6:] += [1.0, 0.0, 0.0]

    def gap(path: em.Morph) -> float:
        return float(np.abs(path.at(0.5)[[6, 7]] - path.at(0.5)[[4, 5]]).max())

    ends = [both, mesh.with_vertices(opened)]
    assert gap(em.interpolate(mesh, both, "rotation")) == 0.0
    assert gap(em.prepare(mesh, "rotation", targets=ends)(both)) > 1e-3
    assert gap(em.Rig(mesh, dict(zip("ab", ends, strict=True)), method="rotation")["a"]) > 1e-3


def test_the_page_and_the_report_see_all_targets() -> None:
    """A path made for one target of a rig is that of the rig."""
    cut, targets, origin = cut_head()
    rig = em.Rig(cut, targets)
    kept: dict[str, em.Morph] = {}
    target_paths(cut, targets, seen=lambda name, morph, _: kept.update({name: morph}))
    one = with_paths(rig, "auto", names=["jawOpen"])["jawOpen"]
    for morph in (kept["jawOpen"], one):
        np.testing.assert_array_equal(morph.bends, rig["jawOpen"].bends)
        assert parted(cut, origin, morph) == 0.0
