"""What other programs have left out of a bent file is said once, in a sentence."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import chunks_of, glb, seamed_mesh

from elastomorph.errors import ElastomorphWarning
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig


def bent_rig() -> Rig:
    """Two targets of one bend each."""
    mesh = replace(seamed_mesh(), materials=None)
    up = mesh.with_vertices(mesh.vertices + [0, 0, 0.3])
    side = np.zeros((1, *mesh.vertices.shape))
    side[0, :, 0] = 0.1
    arch = BendCurve.polynomial([0, 1, -1])
    bends = {"jaw": side, "brow": 2 * side}
    return Rig(mesh, {name: Morph(mesh, up, own, (arch,)) for name, own in bends.items()})


def read_changed(folder: Path, change: Callable[[dict[str, Any]], object]) -> tuple[Rig, list[str]]:
    """The rig of a file that another program has changed, and the warnings on the way."""
    path = folder / "a.glb"
    write_glb(path, bent_rig(), sparse=False)
    document, content = chunks_of(path)
    change(document)
    path.write_bytes(glb(document, content))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rig = read_glb(path)
    assert all(own.category is ElastomorphWarning for own in caught)
    return rig, [str(own.message) for own in caught]


def test_of_a_file_that_is_whole_nothing_is_said(tmp_path: Path) -> None:
    rig, said = read_changed(tmp_path, lambda _: None)
    assert rig.names == ("jaw", "brow")
    assert said == []


def test_bends_without_their_description_are_told_from_sliders(tmp_path: Path) -> None:
    rig, said = read_changed(tmp_path, lambda own: own["meshes"][0]["extras"].pop("elastomorph"))
    assert rig.names == ("jaw", "jaw.bend1", "brow", "brow.bend1")
    (message,) = said
    assert "2 of its morph targets have names of bends, such as 'jaw.bend1'" in message
    assert "each is read as a slider of its own" in message


def test_a_target_named_like_a_bend_of_none_is_a_slider(tmp_path: Path) -> None:
    def foreign(document: dict[str, Any]) -> None:
        document["meshes"][0]["extras"] = {"targetNames": ["a", "knee.bend1", "b", "a.bend"]}

    assert read_changed(tmp_path, foreign)[1] == []


def test_bends_that_were_emptied_are_counted(tmp_path: Path) -> None:
    def emptied(document: dict[str, Any]) -> None:
        target = document["meshes"][0]["primitives"][0]["targets"][1]
        accessor = document["accessors"][target["POSITION"]]
        del accessor["bufferView"]  # zeros, as sparse arrays of fractions become
        accessor |= {"min": [0, 0, 0], "max": [0, 0, 0]}

    rig, said = read_changed(tmp_path, emptied)
    assert not rig.morphs["jaw"].bends.any()
    (message,) = said
    assert "1 of 2 bends, such as 'jaw.bend1', move nothing" in message


def test_a_bend_that_moves_one_material_of_several_is_not_lost(tmp_path: Path) -> None:
    """As three.js writes them: a mesh of each material, with all targets and all extras."""

    def parted(still: tuple[int, ...]) -> Callable[[dict[str, Any]], None]:
        def change(document: dict[str, Any]) -> None:
            (mesh,), (node,) = document["meshes"], document["nodes"]
            document["meshes"] = [copy.deepcopy(mesh) for _ in range(2)]
            document["nodes"] = [{**node, "mesh": k, "name": f"skin{k}"} for k in range(2)]
            document["scenes"] = [{"nodes": [0, 1]}]
            bend = mesh["primitives"][0]["targets"][1]["POSITION"]
            zeros = {"componentType": 5126, "type": "VEC3", "min": [0] * 3, "max": [0] * 3}
            document["accessors"].append(zeros | {"count": document["accessors"][bend]["count"]})
            for k in still:
                target = document["meshes"][k]["primitives"][0]["targets"][1]
                target["POSITION"] = len(document["accessors"]) - 1

        return change

    assert read_changed(tmp_path, parted((0,)))[1] == []
    (message,) = read_changed(tmp_path, parted((0, 1)))[1]
    assert "1 of 2 bends, such as 'jaw.bend1', move nothing" in message


@pytest.mark.parametrize("meshes", [2, 4])
def test_many_meshes_say_it_once(tmp_path: Path, meshes: int) -> None:
    def copied(document: dict[str, Any]) -> None:
        document["meshes"][0]["extras"].pop("elastomorph")
        node = document["nodes"][0]
        document["nodes"] = [{**node, "name": f"n{k}"} for k in range(meshes)]
        document["scenes"] = [{"nodes": [*range(meshes)]}]

    assert len(read_changed(tmp_path, copied)[1]) == 1
