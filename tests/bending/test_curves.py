"""The curves of a bent character apart from its file: given back, and kept beside it."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_characters import SmallFile, flap_character

import elastomorph as em
from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import open_gltf
from foreign_files import chunks_of, glb

POSE = {"open": 0.5, "slide": 0.3}
Change = Callable[[dict[str, Any]], None]


@pytest.fixture(params=["plain", "folded", "one name"])
def bent(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A bent character, also with folds and with targets that share their name."""
    file, options = flap_character(), dict[str, Any]()
    if request.param == "folded":
        options = {"method": "ease:2", "fold": True}
    if request.param == "one name":
        file.json["meshes"][0]["extras"]["targetNames"] = ["open", "open"]
    em.bend(file.write(tmp_path / "a.glb"), tmp_path / "bent.glb", **options)
    return tmp_path / "bent.glb"


def packed(bent: Path, change: Change = lambda _: None) -> Path:
    """What a pipeline that drops the extras makes of a file, and changes otherwise."""
    document, blob = chunks_of(bent)
    document.pop("extras", None)
    for mesh in document["meshes"]:
        mesh.get("extras", {}).pop("elastomorph", None)
    change(document)
    out = bent.with_name("packed.glb")
    out.write_bytes(glb(document, blob))
    return out


def nameless(document: dict[str, Any]) -> None:
    for mesh in document["meshes"]:
        mesh.pop("extras", None)


def turned(document: dict[str, Any]) -> None:
    """Targets in the opposite order, without names."""
    nameless(document)
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            primitive.get("targets", []).reverse()


def renamed(document: dict[str, Any]) -> None:
    turned(document)
    for number, mesh in enumerate(document["meshes"][:2]):
        count = len(mesh["primitives"][0]["targets"])
        mesh["extras"] = {"targetNames": [f"shape {number} {i}" for i in range(count)]}


def posed(path: Path) -> Any:
    rig = em.read_rig(path)
    return rig.pose({name: value for name, value in POSE.items() if name in rig.sliders.names})


def curves_of(path: Path) -> list[Any]:
    """What each mesh says of its paths, by numbers of targets in the order of their shapes."""
    file = open_gltf(path)
    found = []
    for mesh in file.document["meshes"]:
        stored = mesh.get("extras", {}).get("elastomorph")
        if stored is None:
            continue
        names, targets = mesh["extras"]["targetNames"], mesh["primitives"][0]["targets"]

        def shape(
            entry: dict[str, Any], names: Sequence[str] = names, targets: Sequence[Any] = targets
        ) -> bytes:
            place = entry.get("index", names.index(entry["target"]))
            return bytes(read_floats(file, targets[place]["POSITION"], 3, "a test").tobytes())

        said = [
            (m["name"], shape(m), m.get("fold"), [(shape(b), b["curve"]) for b in m["bends"]])
            for m in stored["morphs"]
        ]
        found.append(said)
    return found


@pytest.mark.parametrize("change", [lambda _: None, nameless, turned, renamed])
def test_curves_are_given_back_by_name_number_or_shape(bent: Path, change: Change) -> None:
    out = bent.with_name("back.glb")
    report = em.bend(packed(bent, change), out, source=bent)
    assert isinstance(report, em.BendReport)
    assert curves_of(out) == curves_of(bent)
    np.testing.assert_array_equal(posed(out), posed(bent))
    count = sum(len(m["primitives"][0].get("targets", [])) for m in chunks_of(bent)[0]["meshes"])
    assert sum(report.matched.values()) == count
    if change is turned or change is renamed:
        assert report.matched["shape"] > 0.5 * count
    elif change is nameless:
        assert report.matched["index"] == count
    with pytest.raises(em.FormatError):
        em.bend(out, bent.with_name("again.glb"))


def test_shapes_are_known_among_other_vertices(tmp_path: Path) -> None:
    """Rounded, in another order, and without names."""
    path = flap_character().write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "bent.glb")
    file = open_gltf(tmp_path / "bent.glb")
    other, rng = SmallFile(), np.random.default_rng(1)
    for mesh in file.document["meshes"][:2]:
        primitives = []
        for own in mesh["primitives"]:
            place = own["attributes"]["POSITION"]
            rows = read_floats(file, place, 3, "a test")
            order = rng.permutation(len(rows))
            moved = [read_floats(file, t["POSITION"], 3, "a test") for t in own["targets"]]
            moved = [moved[i] for i in np.roll(np.arange(len(moved)), 1)]
            primitives.append(
                {
                    "attributes": {"POSITION": other.array(np.round(rows[order], 4))},
                    "targets": [{"POSITION": other.array(np.round(m[order], 4))} for m in moved],
                }
            )
            corners = np.arange(len(rows) // 3 * 3)
            primitives[-1]["indices"] = other.array(corners, "<u2")
        other.node(mesh=other.mesh(primitives))
    out = tmp_path / "back.glb"
    report = em.bend(other.write(tmp_path / "packed.glb"), out, source=tmp_path / "bent.glb")
    assert isinstance(report, em.BendReport)
    assert report.matched["shape"] > 5
    found, expected = em.read_rig(out), em.read_rig(tmp_path / "bent.glb")
    assert len(found.morphs["open"].bends) == len(expected.morphs["open"].bends)
    away = [np.abs(expected.pose(POSE) - row).max(axis=1).min() for row in found.pose(POSE)]
    assert max(away) < 1e-3


@pytest.mark.parametrize("change", [lambda _: None, nameless])
def test_a_file_of_curves_gives_them_back_too(bent: Path, change: Change) -> None:
    """By name and by number: it has no shapes."""
    curves, out = bent.with_name("face.json"), bent.with_name("back.glb")
    em.bend(packed(bent), None, source=bent, curves=curves)
    em.bend(packed(bent, change), out, source=curves)
    assert curves_of(out) == curves_of(bent)


def test_curves_are_written_beside_what_is_bent(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "bent.glb", curves=tmp_path / "face.json")
    written = json.loads((tmp_path / "face.json").read_text(encoding="utf-8"))
    meshes = chunks_of(tmp_path / "bent.glb")[0]["meshes"]
    assert [own["mesh"] for own in written["meshes"]] == [0, 1]
    for own in written["meshes"]:
        extras = meshes[own["mesh"]]["extras"]
        assert own["elastomorph"] == extras["elastomorph"]
        assert own["targetNames"] == extras["targetNames"]
        assert own["names"] == [["flap"], ["teeth"]][own["mesh"]]


def lost(document: dict[str, Any]) -> None:
    """Without the last bend."""
    for mesh in document["meshes"][:2]:
        mesh["extras"]["targetNames"].pop()
        for primitive in mesh["primitives"]:
            primitive["targets"].pop()


def test_what_has_no_curves_to_be_had_is_refused(tmp_path: Path) -> None:
    path, bent = flap_character().write(tmp_path / "a.glb"), tmp_path / "bent.glb"
    em.bend(path, bent)
    plain = packed(bent)
    (tmp_path / "bad.json").write_text('{"version": 1, "meshes": [{}]}')
    (tmp_path / "new.json").write_text('{"version": 2, "meshes": []}')
    (tmp_path / "other.txt").write_text("")
    before = {own: own.read_bytes() for own in tmp_path.iterdir()}
    out = tmp_path / "out.glb"
    for wrong, options in (
        (plain, {"source": path}),
        (plain, {"source": tmp_path / "bad.json"}),
        (plain, {"source": tmp_path / "new.json"}),
        (plain, {"source": tmp_path / "other.txt"}),
        (plain, {"source": tmp_path / "missing.glb"}),
        (plain, {"source": bent, "method": "auto"}),
        (plain, {"source": bent, "curves": tmp_path / "face.txt"}),
        (bent, {"source": bent}),
        (path, {"curves": tmp_path / "no folder" / "face.json"}),
    ):
        with pytest.raises(em.ElastomorphError):
            em.bend(wrong, out, **options)
    with pytest.raises(em.ParameterError):
        em.bend(path, None, curves=tmp_path / "face.json")
    assert {own: own.read_bytes() for own in tmp_path.iterdir()} == before
    with pytest.raises(em.FormatError, match=r"no morph target for the bend"):
        em.bend(packed(bent, lost), out, source=bent)
    assert not out.exists()
