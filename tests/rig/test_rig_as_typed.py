"""A rig as people type it: from meshes, by name, in order, to a file and to the browser."""

from __future__ import annotations

import copy
import pickle
import urllib.request
import webbrowser
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.model.geometry import moved_extent
from elastomorph.rig import Rig
from elastomorph.viewer import ViewerServer
from small_head import expressions, head, shapes

JAW = shapes()["jawOpen"]
GRIN = expressions()["grinning"]


class TestFromMeshes:
    """Targets become paths by the default method, judged by what all of them move."""

    def test_by_the_default_method(self) -> None:
        rig = em.Rig(head(), {"jawOpen": JAW, "grin": GRIN})
        extent = moved_extent(head().vertices, [JAW.vertices, GRIN.vertices])
        for name, target in (("jawOpen", JAW), ("grin", GRIN)):
            expected = em.interpolate(head(), target, "auto", extent=extent)
            assert rig[name].choice == expected.choice
            np.testing.assert_allclose(rig.pose({name: 0.4}), rig[name].at(0.4), atol=1e-12)
            np.testing.assert_array_equal(rig[name].bends, expected.bends)
        assert rig.names == ("jawOpen", "grin")

    def test_what_morphs_move_counts_too(self) -> None:
        """D of the rig is that of all its targets, whether a path came with them or not."""
        far = head().with_vertices(head().vertices + [0, 0, 1.0])
        rig = em.Rig(head(), {"all": em.interpolate(head(), far, "linear"), "jawOpen": JAW})
        alone = em.Rig(head(), {"jawOpen": JAW})
        assert rig["jawOpen"].choice is not None
        assert alone["jawOpen"].choice is not None
        share = moved_extent(head().vertices, [JAW.vertices]) / head().diameter
        assert rig["jawOpen"].choice.distance == pytest.approx(
            alone["jawOpen"].choice.distance * share
        )

    def test_by_a_method_named(self) -> None:
        rig = em.Rig(head(), {"grin": GRIN}, method="ease:2")
        np.testing.assert_array_equal(
            rig["grin"].at(0.3), em.interpolate(head(), GRIN, "ease:2").at(0.3)
        )
        with pytest.raises(em.ParameterError, match="a method has nothing to make"):
            em.Rig(head(), rig.morphs, method="ease:2")

    def test_of_another_mesh(self) -> None:
        with pytest.raises(em.TopologyError):
            em.Rig(head(), {"a": em.Mesh(np.eye(3))})


class TestByName:
    def test_is_a_mapping_of_paths(self, small: Rig) -> None:
        assert small["b"] is small.morphs["b"]
        assert "b" in small
        assert "d" not in small
        assert list(small) == ["a", "b", "c"]
        assert len(small) == 3

    def test_an_unknown_name_suggests_the_nearest(self, rig: Rig) -> None:
        with pytest.raises(em.ParameterError, match="did you mean 'grinning'"):
            rig["grining"]


class TestWeightsInOrder:
    def test_are_the_weights_by_name(self, small: Rig) -> None:
        by_name = {"a": 0.2, "b": 0.0, "c": 0.9}
        row = [0.2, 0.0, 0.9]
        for weights in (row, tuple(row), np.array(row)):
            np.testing.assert_array_equal(small.pose(weights), small.pose(by_name))
        np.testing.assert_array_equal(small.blend(row, 0.4), small.blend(by_name, 0.4))
        np.testing.assert_array_equal(
            small.velocity(row, [0, 1, 0]), small.velocity(by_name, {"b": 1})
        )
        np.testing.assert_array_equal(small.pose([1, 0, 0]), small.pose([True, False, False]))

    @pytest.mark.parametrize("weights", [[1, 0], [1, 0, 0, 0], 1.0, [[1, 0, 0]], []])
    def test_as_many_as_sliders(self, small: Rig, weights: object) -> None:
        with pytest.raises(em.ParameterError, match=r"the rig has 3 sliders \(a, b, c\), so"):
            small.pose(weights)  # type: ignore[arg-type]

    def test_numbers(self, small: Rig) -> None:
        for weights in ("a", None, ["1", "0", "0"]):
            with pytest.raises(em.ParameterError, match="weights must be numbers"):
                small.pose(weights)  # type: ignore[arg-type]
        with pytest.raises(em.ParameterError, match="the weight of 'b' is nan"):
            small.pose([0, np.nan, 0])


def test_save_is_write(small: Rig, tmp_path: Path) -> None:
    assert small.save(tmp_path / "small.npz") is None
    again = em.read_rig(tmp_path / "small.npz")
    np.testing.assert_array_equal(again.pose([1, 0.5, 0.2]), small.pose([1, 0.5, 0.2]))
    with pytest.raises(em.FormatError, match="unknown suffix"):
        small.save(tmp_path / "small.rig")


def test_view_shows_the_rig_until_the_user_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    opened: list[str] = []
    pages: list[bytes] = []

    def look(server: ViewerServer) -> None:
        with urllib.request.urlopen(server.address, timeout=60) as page:
            pages.append(page.read())

    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr(ViewerServer, "wait", look)
    em.Rig(head(), {"jawOpen": JAW}, method="linear").view(say=said.append)
    assert b"elastomorph-scene" in pages[0]
    assert said[0].startswith(opened[0])
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(opened[0], timeout=60)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda rig: pickle.loads(pickle.dumps(rig))])
def test_a_copy_for_another_process_is_the_same_rig(copied: Callable[[Rig], Rig]) -> None:
    rig = em.Rig(head(), {"jawOpen": JAW, "grin": GRIN}, correctives={"grin": ["jawOpen", "grin"]})
    other = copied(rig)
    assert other.sliders == rig.sliders
    assert other["jawOpen"].choice == rig["jawOpen"].choice
    np.testing.assert_array_equal(other.batch([[0.3, 0.6]]), rig.batch([[0.3, 0.6]]))
